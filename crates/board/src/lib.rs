//! Shared variables: typed, stamped, never torn.
