//! Formats what a running application sends to its clients. `jde-link` does the communication.

pub(crate) mod application;
pub(crate) mod field;
pub(crate) mod hierarchy;
pub(crate) mod name;
pub(crate) mod panel;
pub(crate) mod table;
