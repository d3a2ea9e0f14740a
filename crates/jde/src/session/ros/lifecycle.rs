//! The life cycle of the node: active while the roots may be awake, inactive while everything is stopped, and
//! finalized at the end. A change is an operator's request to everything (R14), so it waits for no schema.

use std::time::{SystemTime, UNIX_EPOCH};

use jde_host::Handle;
use jde_link::message::Action;
use jde_link::{Running, Subject as _};
use jde_records::snapshot::SchemaView;
use serde_json::{Value, json};

use super::OPERATOR;

/// A state: its number in `lifecycle_msgs/msg/State`, and its name.
type State = (u8, &'static str);

const INACTIVE: State = (2, "inactive");
const ACTIVE: State = (3, "active");
const FINALIZED: State = (4, "finalized");

/// Number, name, start and goal of each transition. The numbers are those of `lifecycle_msgs/msg/Transition`.
const TRANSITIONS: [(u8, &str, State, State); 4] = [
    (3, "activate", INACTIVE, ACTIVE),
    (4, "deactivate", ACTIVE, INACTIVE),
    (6, "shutdown", INACTIVE, FINALIZED),
    (7, "shutdown", ACTIVE, FINALIZED),
];

/// The state that was published last.
#[derive(Default)]
pub(super) struct Lifecycle(Option<State>);

impl Lifecycle {
    /// Returns the event of a change since the last call.
    pub(super) fn event(&mut self, subject: &Running) -> Option<Value> {
        self.enter(current(subject))
    }

    /// Returns the event of the end of the run.
    pub(super) fn finalize(&mut self) -> Option<Value> {
        self.enter(FINALIZED)
    }

    fn enter(&mut self, goal: State) -> Option<Value> {
        let start = self.0.replace(goal);
        let transition = TRANSITIONS
            .iter()
            .find(|transition| Some(transition.2) == start && transition.3 == goal)?;
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let mut event = description(transition);
        event["timestamp"] = json!(since.as_nanos() as u64);
        Some(event)
    }
}

/// The response to `get_state`.
pub(super) fn state(subject: &Running) -> Value {
    json!({ "current_state": named(current(subject)) })
}

/// The response to `get_available_states`.
pub(super) fn states() -> Value {
    json!({ "available_states": [named(INACTIVE), named(ACTIVE), named(FINALIZED)] })
}

/// The response to `get_available_transitions`.
pub(super) fn available(subject: &Running) -> Value {
    let state = current(subject);
    let transitions = TRANSITIONS.iter().filter(|transition| transition.2 == state);
    json!({ "available_transitions": transitions.map(description).collect::<Vec<_>>() })
}

/// The response to `get_transition_graph`.
pub(super) fn graph() -> Value {
    json!({ "available_transitions": TRANSITIONS.iter().map(description).collect::<Vec<_>>() })
}

/// Carries out a transition, and returns the response to `change_state`.
pub(super) fn change(subject: &Running, handle: &Handle, request: &Value) -> Value {
    let wanted = &request["transition"];
    let state = current(subject);
    // As in ROS 2, a transition without a number is meant by its name.
    let is_wanted = |(number, name, start, _): &&(u8, &str, State, State)| {
        *start == state && (wanted["id"] == *number || (wanted["id"] == 0 && wanted["label"] == *name))
    };
    let success = match TRANSITIONS.iter().find(is_wanted) {
        Some((_, _, _, goal)) if *goal == FINALIZED => {
            handle.stop();
            true
        }
        Some((_, _, _, goal)) => {
            let action = if *goal == ACTIVE {
                Action::ReleaseAll
            } else {
                Action::StopAll
            };
            let done = subject.act(OPERATOR, &action);
            done.inspect_err(|refusal| tracing::warn!("ROS 2: {}", refusal.error))
                .is_ok()
        }
        None => false,
    };
    json!({ "success": success })
}

/// The state of the application.
fn current(subject: &Running) -> State {
    let schemas = subject.snapshot().schemas;
    let is_held = |root: &SchemaView| root.operator.as_ref().is_some_and(|hold| hold.with_everything);
    let roots = schemas
        .iter()
        .filter(|schema| schema.father.is_none() && schema.group.is_some());
    let mut roots = roots.peekable();
    // An operator may have played a root since everything was stopped.
    if roots.peek().is_some() && roots.all(is_held) {
        INACTIVE
    } else {
        ACTIVE
    }
}

fn named((id, label): State) -> Value {
    json!({ "id": id, "label": label })
}

fn description((id, label, start, goal): &(u8, &str, State, State)) -> Value {
    json!({
        "transition": { "id": id, "label": label },
        "start_state": named(*start),
        "goal_state": named(*goal),
    })
}
