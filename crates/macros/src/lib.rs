//! Derive macros for values and schemas.
