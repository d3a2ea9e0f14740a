//! The end of an action that sends goals: one at a time.

use std::time::Duration;

use serde_json::{Value, json};

use super::{Action, CANCEL, GoalId, GoalStatus, id_of, new_id, stamp, uuid};
use crate::node::{Node, NodeConfig};
use crate::services::Client;

/// How long a server may take to accept or to cancel.
const RESPONSE_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a goal may take.
const RESULT_TIMEOUT: Duration = Duration::from_secs(24 * 3600);

/// The client of an action.
#[derive(Debug)]
pub struct ActionClient {
    action: Action,
    /// The number of its first client: goals, cancellations, results.
    clients: usize,
    /// The number of its subscription to the feedback.
    feedback: usize,
    goal: Option<Goal>,
}

#[derive(Debug)]
struct Goal {
    id: GoalId,
    /// The number of the request for the goal, until it is accepted.
    sent: Option<i64>,
    /// The number of the request for the result.
    requested: Option<i64>,
    /// The number of the request that it is canceled.
    canceled: Option<i64>,
}

/// What happens to a goal.
#[derive(Clone, Debug, PartialEq)]
pub enum GoalEvent {
    /// The server carries it out.
    Accepted,
    /// The server does not carry it out.
    Rejected,
    /// The newest feedback.
    Feedback(Value),
    /// It has ended, with its result.
    Ended(GoalStatus, Value),
    /// Nobody carries it out any more: why.
    Lost(String),
}

impl ActionClient {
    /// Adds the parts of an action to a node.
    #[must_use]
    pub fn declare(action: Action, config: &mut NodeConfig) -> Self {
        let (clients, feedback) = (config.clients.len(), config.subscriptions.len());
        let timeouts = [RESPONSE_TIMEOUT, RESPONSE_TIMEOUT, RESULT_TIMEOUT];
        let services = action.services().into_iter().zip(timeouts);
        config
            .clients
            .extend(services.map(|(service, timeout)| Client { service, timeout }));
        config.subscriptions.extend(action.topics());
        Self {
            action,
            clients,
            feedback,
            goal: None,
        }
    }

    /// The name of the action.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.action.name
    }

    /// Whether a node carries out such goals.
    #[must_use]
    pub fn has_server(&self, node: &Node) -> bool {
        (0..3).all(|part| node.has_server(self.clients + part))
    }

    /// Whether a goal was sent that has not ended.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.goal.is_some()
    }

    /// Sends a goal, after it has canceled an earlier one.
    ///
    /// # Panics
    /// If the goal has a field that its type does not have.
    pub fn send(&mut self, node: &Node, goal: &Value) {
        self.cancel(node);
        let id = new_id();
        let request = json!({ "goal_id": uuid(id), "goal": goal });
        let type_name = format!("{}_SendGoal_Request", self.action.type_name);
        let sent = node.call(self.clients, self.action.encode(&type_name, &request));
        self.goal = Some(Goal {
            id,
            sent: Some(sent),
            requested: None,
            canceled: None,
        });
    }

    /// Requests that the goal is canceled, unless such a request is under way. It has ended when the server says so.
    pub fn cancel(&mut self, node: &Node) {
        let Some(goal) = self.goal.as_mut().filter(|goal| goal.canceled.is_none()) else {
            return;
        };
        let info = json!({ "goal_info": { "goal_id": uuid(goal.id), "stamp": stamp(Duration::ZERO) } });
        let request = self.action.encode(&format!("{CANCEL}_Request"), &info);
        goal.canceled = Some(node.call(self.clients + 1, request));
    }

    /// Returns what has happened to the goal since the last call.
    pub fn poll(&mut self, node: &Node) -> Vec<GoalEvent> {
        let mut events = Vec::new();
        self.poll_acceptance(node, &mut events);
        while let Some(response) = node.take_response(self.clients + 1) {
            if let Some(goal) = &mut self.goal
                && goal.canceled == Some(response.sequence)
                && response.outcome.is_err()
            {
                // Nobody answered. The owner requests it again.
                goal.canceled = None;
            }
        }
        for message in node.take_all(self.feedback) {
            let value = self.decode(&self.action.feedback(), &message.message.to_bytes());
            if let Ok(mut value) = value
                && self.goal.as_ref().is_some_and(|goal| goal.id == id_of(&value))
            {
                events.push(GoalEvent::Feedback(value["feedback"].take()));
            }
        }
        while node.take(self.feedback + 1).is_some() {}
        self.poll_result(node, &mut events);
        if self.goal.as_ref().is_some_and(|goal| goal.sent.is_none()) && !self.has_server(node) {
            self.goal = None;
            events.push(GoalEvent::Lost(format!(
                "no node offers {} any more",
                self.action.name
            )));
        }
        events
    }

    fn poll_acceptance(&mut self, node: &Node, events: &mut Vec<GoalEvent>) {
        while let Some(response) = node.take_response(self.clients) {
            let Some(goal) = self
                .goal
                .as_mut()
                .filter(|goal| goal.sent == Some(response.sequence))
            else {
                continue;
            };
            let type_name = format!("{}_SendGoal_Response", self.action.type_name);
            let accepted = response.outcome.and_then(|message| {
                let value = self.action.interfaces.decode(&type_name, &message);
                value.map_err(|error| error.to_string())
            });
            match accepted {
                Err(error) => {
                    self.goal = None;
                    events.push(GoalEvent::Lost(error));
                }
                Ok(value) if value["accepted"] != true => {
                    self.goal = None;
                    events.push(GoalEvent::Rejected);
                }
                Ok(_) => {
                    goal.sent = None;
                    let request = json!({ "goal_id": uuid(goal.id) });
                    let type_name = format!("{}_GetResult_Request", self.action.type_name);
                    let message = self.action.encode(&type_name, &request);
                    goal.requested = Some(node.call(self.clients + 2, message));
                    events.push(GoalEvent::Accepted);
                    // A cancellation that overtook the acceptance found no goal.
                    if goal.canceled.take().is_some() {
                        self.cancel(node);
                    }
                }
            }
        }
    }

    fn poll_result(&mut self, node: &Node, events: &mut Vec<GoalEvent>) {
        while let Some(response) = node.take_response(self.clients + 2) {
            let is_own = |goal: &&Goal| goal.requested == Some(response.sequence);
            if self.goal.as_ref().filter(is_own).is_none() {
                continue;
            }
            self.goal = None;
            let type_name = format!("{}_GetResult_Response", self.action.type_name);
            let value = response
                .outcome
                .and_then(|message| self.decode(&type_name, &message));
            events.push(match value {
                Err(error) => GoalEvent::Lost(error),
                Ok(mut value) => match value["status"].as_i64().and_then(GoalStatus::end) {
                    Some(status) => GoalEvent::Ended(status, value["result"].take()),
                    None => {
                        GoalEvent::Lost("the node that had accepted the goal no longer knows it".to_owned())
                    }
                },
            });
        }
    }

    fn decode(&self, type_name: &str, message: &[u8]) -> Result<Value, String> {
        let value = self.action.interfaces.decode(type_name, message);
        value.map_err(|error| error.to_string())
    }
}
