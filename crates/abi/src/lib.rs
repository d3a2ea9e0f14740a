//! The C ABI between the host and its plugins.
