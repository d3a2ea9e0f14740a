//! Where the host's calls come in: tables made of constants, functions in C layout, and panics that end here.

mod abilities;
mod calls;
mod guard;
pub(crate) mod table;

pub(crate) use calls::schema_of;
