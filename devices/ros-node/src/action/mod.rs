//! Actions: a goal that a node accepts, its feedback, and its result; over three services and two topics, as
//! `rcl_action` has them (<https://design.ros2.org/articles/actions.html>). The owner of the node calls both ends in
//! its iterations. Neither waits.

mod client;
mod server;
#[cfg(test)]
mod tests;

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::sync::LazyLock;
use std::time::Duration;

use jde_ros::Type;
use jde_ros::cdr;
use jde_ros::definition;
use serde_json::{Value, json};

use crate::interface::{Interfaces, standard};
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

/// An action: its name, and its type as far as nodes exchange it. Goals are messages of `TYPE_Goal`, feedback of
/// `TYPE_Feedback`, and results of `TYPE_GetResult_Response`, which begins with the state of the goal.
#[derive(Clone, Debug)]
pub struct Action {
    /// Its full name, such as `/navigate_to_pose`.
    name: String,
    /// The services for goals, cancellations and results.
    services: [Service; 3],
    /// The topics of the feedback and of the states.
    topics: [Topic; 2],
    /// The result of a goal that is not known, and of one that has none.
    no_result: Vec<u8>,
}

impl GoalStatus {
    /// The end that a result states; `None` if that is none, as of a goal that is not known.
    #[must_use]
    pub fn of_result(message: &[u8]) -> Option<Self> {
        let stated = message.get(HEADER_BYTES)?;
        let ends = [Self::Succeeded, Self::Canceled, Self::Aborted];
        ends.into_iter().find(|status| *status as u8 == *stated)
    }

    fn has_ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Canceled | Self::Aborted)
    }
}

impl Action {
    /// An action of that name and type; `None` if its type is none of the interfaces.
    #[must_use]
    pub fn of_interface(name: String, type_name: &str, interfaces: &Interfaces) -> Option<Self> {
        let hashes = ["SendGoal", "GetResult", "FeedbackMessage"]
            .map(|part| interfaces.hash(&format!("{type_name}_{part}")));
        let [Some(send), Some(get), Some(feedback)] = hashes else {
            return None;
        };
        let result = format!("{type_name}_GetResult_Response");
        let no_result = interfaces.encode(&result, &json!({})).ok()?;
        Some(Self::new(name, type_name, [send, get, feedback], no_result))
    }

    /// An action of that name, whose goals, results and feedback are values of these types.
    ///
    /// # Errors
    /// If they are not those of one action.
    pub fn of_values(name: String, goal: &Type, result: &Type, feedback: &Type) -> Result<Self, String> {
        let stem = |value_type: &Type, part: &str| {
            let name = definition::name(value_type);
            let stem = name.strip_suffix(part);
            stem.filter(|stem| stem.contains("/action/"))
                .map(str::to_owned)
                .ok_or_else(|| {
                    format!(
                        "`{}` is not the name of a PACKAGE/action/NAME{part}",
                        value_type.name
                    )
                })
        };
        let type_name = stem(goal, "_Goal")?;
        let others = [(result, "_GetResult_Response"), (feedback, "_Feedback")];
        for (value_type, part) in others {
            let other = stem(value_type, part)?;
            if other != type_name {
                return Err(format!(
                    "its goal is one of `{type_name}`, and its {} one of `{other}`",
                    if part == "_Feedback" { "feedback" } else { "result" }
                ));
            }
        }
        let hashes = Interfaces::action_hashes(&type_name, goal, result, feedback).ok_or_else(|| {
            format!(
                "`{}` has other fields than an `int8 status` and a `{type_name}_Result result`",
                result.name
            )
        })?;
        let mut no_result = Vec::new();
        cdr::encode(result, &vec![0; result.bytes], &mut no_result);
        Ok(Self::new(name, &type_name, hashes, no_result))
    }

    /// `hashes` are those of the services for goals and results, and of the messages of the feedback.
    fn new(name: String, type_name: &str, hashes: [String; 3], no_result: Vec<u8>) -> Self {
        let path = |path: &str| format!("{name}/_action/{path}");
        let [send, get, feedback] = hashes;
        let service = |path_of: &str, part: &str, hash| Service {
            name: path(path_of),
            type_name: format!("{type_name}_{part}"),
            hash,
        };
        let known = "the standard interfaces have it";
        let cancel = Service::new(path("cancel_goal"), CANCEL, standard()).expect(known);
        let status = Topic::of_interface(path("status"), STATUS, standard(), Quality::LATCHED).expect(known);
        let feedback = Topic {
            name: path("feedback"),
            type_name: format!("{type_name}_FeedbackMessage"),
            hash: feedback,
            quality: Quality::DEFAULT,
            ..status.clone()
        };
        Self {
            services: [
                service("send_goal", "SendGoal", send),
                cancel,
                service("get_result", "GetResult", get),
            ],
            topics: [feedback, status],
            no_result,
            name,
        }
    }

    /// Its full name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// The type of the service for cancellations.
const CANCEL: &str = "action_msgs/srv/CancelGoal";
/// The type of the topic of the states.
const STATUS: &str = "action_msgs/msg/GoalStatusArray";

/// The action whose envelopes stand for those of all: they differ in their names alone.
const ANY: &str = "action_msgs/action/Any";
static ENVELOPES: LazyLock<Interfaces> = LazyLock::new(|| {
    let mut interfaces = standard().clone();
    interfaces.action(ANY, "---\n---\n").expect("it has no fields");
    interfaces
});

/// Encodes an envelope: the part of an action after `_`, or a standard type.
///
/// # Panics
/// If the value has a field that it does not have.
fn encode(part: &str, value: &Value) -> Vec<u8> {
    match ENVELOPES.encode(&envelope(part), value) {
        Ok(message) => message,
        Err(error) => panic!("a value of {part}: {error}"),
    }
}

fn decode(part: &str, message: &[u8]) -> Result<Value, String> {
    let value = ENVELOPES.decode(&envelope(part), message);
    value.map_err(|error| error.to_string())
}

fn envelope(part: &str) -> String {
    match part.contains('/') {
        true => part.to_owned(),
        false => format!("{ANY}_{part}"),
    }
}

/// The bytes of a message before its first field.
const HEADER_BYTES: usize = 4;

/// Puts an identifier before the contents of a message. It is 16 bytes, so the contents keep their alignment.
fn with_id(id: GoalId, message: &[u8]) -> Vec<u8> {
    let (head, contents) = message.split_at(HEADER_BYTES.min(message.len()));
    [head, &id, contents].concat()
}

/// Returns the identifier and the message without it; `None` if it is too short.
fn split_id(message: &[u8]) -> Option<(GoalId, Vec<u8>)> {
    let (head, contents) = message.split_at_checked(HEADER_BYTES)?;
    let (id, contents) = contents.split_first_chunk()?;
    Some((*id, [head, contents].concat()))
}

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
