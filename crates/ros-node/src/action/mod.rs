//! Actions: a goal that a node accepts, its feedback, and its result; over three services and two topics, as
//! `rcl_action` has them (<https://design.ros2.org/articles/actions.html>). The owner of the node calls both ends in
//! its iterations. Neither waits.

mod client;
mod server;
#[cfg(test)]
mod tests;

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::time::Duration;

use jde_ros::interface::Interfaces;
use serde_json::{Value, json};

use crate::keys::{Quality, Service, Topic};

pub use client::{ActionClient, GoalEvent};
pub use server::{ActionServer, ServerEvent};

/// The identifier of a goal.
pub type GoalId = [u8; 16];

/// The state of a goal, with the numbers of `action_msgs/msg/GoalStatus`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalStatus {
    /// It is being carried out.
    Executing = 2,
    /// It is being canceled.
    Canceling = 3,
    /// It was reached.
    Succeeded = 4,
    /// It was canceled.
    Canceled = 5,
    /// The server gave it up.
    Aborted = 6,
}

/// An action of that name and type.
#[derive(Clone, Debug)]
pub struct Action {
    /// Its full name, such as `/navigate_to_pose`.
    pub name: String,
    /// Its type, such as `nav2_msgs/action/NavigateToPose`.
    pub type_name: &'static str,
    /// The interfaces that have its type.
    pub interfaces: &'static Interfaces,
}

impl GoalStatus {
    /// The end that a number states; `None` for a goal that has not ended, or is not known.
    fn end(number: i64) -> Option<Self> {
        [Self::Succeeded, Self::Canceled, Self::Aborted]
            .into_iter()
            .find(|status| *status as i64 == number)
    }

    fn has_ended(self) -> bool {
        Self::end(self as i64).is_some()
    }
}

impl Action {
    /// The services for goals, cancellations and results.
    ///
    /// # Panics
    /// If its interfaces do not have its type.
    fn services(&self) -> [Service; 3] {
        let service = |path: &str, type_name: &str| {
            let name = format!("{}/_action/{path}", self.name);
            Service::new(name, type_name, self.interfaces).expect("the interfaces have the action")
        };
        [
            service("send_goal", &format!("{}_SendGoal", self.type_name)),
            service("cancel_goal", CANCEL),
            service("get_result", &format!("{}_GetResult", self.type_name)),
        ]
    }

    /// The topics of the feedback and of the states.
    fn topics(&self) -> [Topic; 2] {
        let topic = |path: &str, type_name: &str, quality| {
            let name = format!("{}/_action/{path}", self.name);
            Topic::of_interface(name, type_name, self.interfaces, quality)
                .expect("the interfaces have the action")
        };
        [
            topic("feedback", &self.feedback(), Quality::DEFAULT),
            topic("status", STATUS, Quality::LATCHED),
        ]
    }

    /// The type of the feedback's messages.
    fn feedback(&self) -> String {
        format!("{}_FeedbackMessage", self.type_name)
    }

    /// Encodes a message of a type that starts with that of the action, or of a standard one.
    ///
    /// # Panics
    /// If the value has a field that the type does not have.
    fn encode(&self, type_name: &str, value: &Value) -> Vec<u8> {
        match self.interfaces.encode(type_name, value) {
            Ok(message) => message,
            Err(error) => panic!("a value of {type_name}: {error}"),
        }
    }
}

/// The type of the service for cancellations.
const CANCEL: &str = "action_msgs/srv/CancelGoal";
/// The type of the topic of the states.
const STATUS: &str = "action_msgs/msg/GoalStatusArray";

/// Returns a new identifier, which nobody else has.
fn new_id() -> GoalId {
    // Each state has its own random keys.
    let half = || RandomState::new().build_hasher().finish().to_ne_bytes();
    let mut id = [0; 16];
    id[..8].copy_from_slice(&half());
    id[8..].copy_from_slice(&half());
    id
}

fn uuid(id: GoalId) -> Value {
    json!({ "uuid": id })
}

/// The identifier in a field `goal_id`; zeros if there is none.
fn id_of(value: &Value) -> GoalId {
    let mut id = GoalId::default();
    let bytes = value["goal_id"]["uuid"].as_array();
    for (to, from) in id.iter_mut().zip(bytes.into_iter().flatten()) {
        *to = from
            .as_u64()
            .and_then(|byte| u8::try_from(byte).ok())
            .unwrap_or_default();
    }
    id
}

/// A stamp of that time since 1970.
fn stamp(time: Duration) -> Value {
    json!({ "sec": i32::try_from(time.as_secs()).unwrap_or(i32::MAX), "nanosec": time.subsec_nanos() })
}
