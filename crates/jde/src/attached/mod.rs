//! Formats what a running application sends to its clients. `jde-link` does the communication.

pub(crate) mod hierarchy;
pub(crate) mod live;
pub(crate) mod name;
pub(crate) mod panel;
pub(crate) mod part;
pub(crate) mod table;
