//! Formats what a running application sends to its clients. `jde-link` does the communication.

pub(crate) mod application;
pub(crate) mod field;
pub(crate) mod hierarchy;
pub(crate) mod name;
pub(crate) mod panel;
pub(crate) mod table;

use jde_link::message::{Action, Request};

/// Returns the request of this user for an action that lasts until it is released.
pub(crate) fn request(action: Action) -> Request {
    Request {
        by: jde_link::operator(),
        action,
        lease_ms: None,
    }
}
