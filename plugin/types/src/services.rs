//! Requests and responses of the services that ROS 2 has as `std_srvs`.

use crate::{Flag, Padding, Text, Value};

/// A request without contents, to do what the name of the service says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "std_srvs/srv/Trigger_Request")]
pub struct TriggerRequest {
    /// Unused bytes.
    pub padding: Padding<1>,
}

/// What became of a request to do something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "std_srvs/srv/Trigger_Response")]
pub struct TriggerResponse {
    /// Whether it was done.
    pub success: Flag,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// What was done, or why it was not.
    pub message: Text<252>,
}

/// A request to switch something on or off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "std_srvs/srv/SetBool_Request")]
pub struct SetBoolRequest {
    /// On or off.
    pub data: Flag,
}

/// What became of a request to switch something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "std_srvs/srv/SetBool_Response")]
pub struct SetBoolResponse {
    /// Whether it was done.
    pub success: Flag,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// What was done, or why it was not.
    pub message: Text<252>,
}

/// A request without contents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "std_srvs/srv/Empty_Request")]
pub struct EmptyRequest {
    /// Unused bytes.
    pub padding: Padding<1>,
}

/// A response without contents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "std_srvs/srv/Empty_Response")]
pub struct EmptyResponse {
    /// Unused bytes.
    pub padding: Padding<1>,
}

macro_rules! outcomes {
    ($($response:ident),*) => { $(
        impl $response {
            /// Returns the response with this success and message, which is cut to its room.
            #[must_use]
            pub fn new(success: bool, message: &str) -> Self {
                Self {
                    success: success.into(),
                    message: Text::truncated(message),
                    ..Self::default()
                }
            }
        }
    )* };
}
outcomes!(TriggerResponse, SetBoolResponse);
