//! The life cycle of the node: active while the roots may be awake, inactive while everything is stopped, and
//! finalized at the end. A change is an operator's request to everything (R14), so it waits for no schema.

use std::time::{SystemTime, UNIX_EPOCH};

use jde_host::Handle;
use jde_link::Subject as _;
use jde_link::message::Action;
use jde_link_host::Running;
use jde_records::snapshot::SchemaView;
use serde_json::{Value, json};

use super::{CHANGE_INTERVAL, OPERATOR, reports};

/// A state: its number in `lifecycle_msgs/msg/State`, and its name.
type State = (u8, &'static str);

const UNCONFIGURED: State = (1, "unconfigured");
const INACTIVE: State = (2, "inactive");
const ACTIVE: State = (3, "active");
const FINALIZED: State = (4, "finalized");

/// Number, name, start and goal of a transition. The numbers are those of `lifecycle_msgs/msg/Transition`.
type Transition = (u8, &'static str, State, State);

const TRANSITIONS: [Transition; 7] = [
    (1, "configure", UNCONFIGURED, INACTIVE),
    (2, "cleanup", INACTIVE, UNCONFIGURED),
    (3, "activate", INACTIVE, ACTIVE),
    (4, "deactivate", ACTIVE, INACTIVE),
    (5, "shutdown", UNCONFIGURED, FINALIZED),
    (6, "shutdown", INACTIVE, FINALIZED),
    (7, "shutdown", ACTIVE, FINALIZED),
];

/// The time without a heartbeat after which a bond is broken, s: Nav2's.
const BOND_TIMEOUT_S: f64 = 4.0;

/// The part of the state that only the node knows, and what was published of it.
pub(super) struct Lifecycle {
    /// Whether the node is inactive while everything is stopped, and not unconfigured.
    is_configured: bool,
    is_finalized: bool,
    published: Option<State>,
    /// The name of this run among those that have a bond of the same name.
    instance: String,
    is_bonded: bool,
}

impl Lifecycle {
    /// The node is active at its start, or unconfigured if everything is stopped.
    pub(super) fn new(subject: &Running) -> Self {
        Self {
            is_configured: !is_stopped(subject),
            is_finalized: false,
            published: None,
            instance: format!("{}-{}", std::process::id(), since_epoch_ns()),
            is_bonded: false,
        }
    }

    /// The run ends.
    pub(super) fn finalize(&mut self) {
        self.is_finalized = true;
    }

    /// Returns the events of the changes since the last call. What became active without being configured, by a release
    /// of everything, has the events of both transitions.
    pub(super) fn events(&mut self, subject: &Running) -> Vec<Value> {
        let goal = self.current(subject);
        let Some(start) = self.published.replace(goal) else {
            return Vec::new();
        };
        let steps = match (start, goal) {
            (UNCONFIGURED, ACTIVE) => vec![(UNCONFIGURED, INACTIVE), (INACTIVE, ACTIVE)],
            step => vec![step],
        };
        let is_step = |transition: &&Transition| steps.contains(&(transition.2, transition.3));
        let mut events: Vec<_> = TRANSITIONS.iter().filter(is_step).map(description).collect();
        for event in &mut events {
            event["timestamp"] = json!(since_epoch_ns());
        }
        events
    }

    /// Returns the heartbeat of the node's bond, by which a manager of Nav2 notices its end: while it is active, and
    /// once afterwards.
    pub(super) fn heartbeat(&mut self, subject: &Running, node: &str) -> Option<Value> {
        let is_active = self.current(subject) == ACTIVE;
        let was_bonded = std::mem::replace(&mut self.is_bonded, is_active);
        (is_active || was_bonded).then(|| {
            json!({
                "header": { "stamp": reports::stamp() },
                "id": node,
                "instance_id": self.instance,
                "active": is_active,
                "heartbeat_timeout": BOND_TIMEOUT_S,
                "heartbeat_period": CHANGE_INTERVAL.as_secs_f64(),
            })
        })
    }

    /// The response to `get_state`.
    pub(super) fn state(&mut self, subject: &Running) -> Value {
        json!({ "current_state": named(self.current(subject)) })
    }

    /// The response to `get_available_transitions`.
    pub(super) fn available(&mut self, subject: &Running) -> Value {
        let state = self.current(subject);
        let transitions = TRANSITIONS.iter().filter(|transition| transition.2 == state);
        json!({ "available_transitions": transitions.map(description).collect::<Vec<_>>() })
    }

    /// Carries out a transition, and returns the response to `change_state`.
    pub(super) fn change(&mut self, subject: &Running, handle: &Handle, request: &Value) -> Value {
        let wanted = &request["transition"];
        let state = self.current(subject);
        // As in ROS 2, a transition without a number is meant by its name.
        let is_wanted = |(number, name, start, _): &&Transition| {
            *start == state && (wanted["id"] == *number || (wanted["id"] == 0 && wanted["label"] == *name))
        };
        let transition = TRANSITIONS.iter().find(is_wanted);
        let success = transition.is_some_and(|(_, _, start, goal)| match (*start, *goal) {
            (_, FINALIZED) => {
                self.finalize();
                handle.stop();
                true
            }
            (_, ACTIVE) => act(subject, &Action::ReleaseAll),
            (ACTIVE, _) => act(subject, &Action::StopAll),
            (_, goal) => {
                self.is_configured = goal == INACTIVE;
                true
            }
        });
        json!({ "success": success })
    }

    fn current(&mut self, subject: &Running) -> State {
        if self.is_finalized {
            return FINALIZED;
        }
        if !is_stopped(subject) {
            // Another operator may have released everything.
            self.is_configured = true;
            return ACTIVE;
        }
        if self.is_configured {
            INACTIVE
        } else {
            UNCONFIGURED
        }
    }
}

/// The response to `get_available_states`.
pub(super) fn states() -> Value {
    let states = [UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED].map(named);
    json!({ "available_states": states })
}

/// The response to `get_transition_graph`.
pub(super) fn graph() -> Value {
    json!({ "available_transitions": TRANSITIONS.iter().map(description).collect::<Vec<_>>() })
}

fn act(subject: &Running, action: &Action) -> bool {
    let done = subject.act(OPERATOR, action);
    done.inspect_err(|refusal| tracing::warn!("ROS 2: {}", refusal.error))
        .is_ok()
}

fn since_epoch_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_nanos() as u64
}

/// Whether an operator has stopped everything.
fn is_stopped(subject: &Running) -> bool {
    let schemas = subject.snapshot().schemas;
    let roots = schemas
        .iter()
        .filter(|schema| schema.father.is_none() && schema.group.is_some());
    let mut roots = roots.peekable();
    // An operator may have played a root since everything was stopped.
    roots.peek().is_some() && roots.all(SchemaView::is_stopped_with_everything)
}

fn named((id, label): State) -> Value {
    json!({ "id": id, "label": label })
}

fn description((id, label, start, goal): &Transition) -> Value {
    json!({
        "transition": { "id": id, "label": label },
        "start_state": named(*start),
        "goal_state": named(*goal),
    })
}
