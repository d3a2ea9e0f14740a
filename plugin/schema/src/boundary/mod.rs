//! The entry points for the host's calls: constant tables and functions in C layout. No panic passes them.

mod abilities;
pub(crate) mod bundles;
mod calls;
mod catch;
mod judgement;
pub(crate) mod lists;
pub(crate) mod table;

pub(crate) use calls::schema_of;
