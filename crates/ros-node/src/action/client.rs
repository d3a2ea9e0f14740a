//! The end of an action that sends goals: one at a time.

use std::time::Duration;

use serde_json::json;

use super::{Action, CANCEL, GoalId, GoalStatus, decode, encode, new_id, split_id, stamp, uuid, with_id};
use crate::node::{Node, NodeConfig};
use crate::services::Client;

/// How long a server may take to accept or to cancel.
const RESPONSE_TIMEOUT: Duration = Duration::from_secs(5);
/// Response to a cancellation: the goal goes on.
const REFUSED: u8 = 1;
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GoalEvent {
    /// The server carries it out.
    Accepted,
    /// The server does not carry it out.
    Rejected,
    /// The newest feedback.
    Feedback(Vec<u8>),
    /// It has ended, with its result.
    Ended(GoalStatus, Vec<u8>),
    /// The server goes on with it, although it should cancel it.
    NotCanceled,
    /// Nobody carries it out any more: why.
    Lost(String),
}

impl ActionClient {
    /// Adds the parts of an action to a node.
    #[must_use]
    pub fn declare(action: Action, config: &mut NodeConfig) -> Self {
        let (clients, feedback) = (config.clients.len(), config.subscriptions.len());
        let timeouts = [RESPONSE_TIMEOUT, RESPONSE_TIMEOUT, RESULT_TIMEOUT];
        let services = action.services.iter().cloned().zip(timeouts);
        config
            .clients
            .extend(services.map(|(service, timeout)| Client { service, timeout }));
        config.subscriptions.extend(action.topics.iter().cloned());
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
    pub fn send(&mut self, node: &Node, goal: &[u8]) {
        self.cancel(node);
        let id = new_id();
        let sent = node.call(self.clients, with_id(id, goal));
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
        let request = encode(&format!("{CANCEL}_Request"), &info);
        goal.canceled = Some(node.call(self.clients + 1, request));
    }

    /// Returns what has happened to the goal since the last call.
    pub fn poll(&mut self, node: &Node) -> Vec<GoalEvent> {
        let mut events = Vec::new();
        self.poll_acceptance(node, &mut events);
        while let Some(response) = node.take_response(self.clients + 1) {
            let Some(goal) = self
                .goal
                .as_mut()
                .filter(|goal| goal.canceled == Some(response.sequence))
            else {
                continue;
            };
            match response.outcome {
                // Nobody answered. The owner requests it again.
                Err(_) => goal.canceled = None,
                Ok(message) => {
                    let answer = decode(&format!("{CANCEL}_Response"), &message).unwrap_or_default();
                    if answer["return_code"] == REFUSED {
                        events.push(GoalEvent::NotCanceled);
                    }
                }
            }
        }
        for message in node.take_all(self.feedback) {
            if let Some((id, feedback)) = split_id(&message.message.to_bytes())
                && self.goal.as_ref().is_some_and(|goal| goal.id == id)
            {
                events.push(GoalEvent::Feedback(feedback));
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
            let accepted = response
                .outcome
                .and_then(|message| decode("SendGoal_Response", &message));
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
                    let message = encode("GetResult_Request", &request);
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
            events.push(match response.outcome {
                Err(error) => GoalEvent::Lost(error),
                Ok(message) => match GoalStatus::of_result(&message) {
                    Some(status) => GoalEvent::Ended(status, message),
                    None => {
                        GoalEvent::Lost("the node that had accepted the goal no longer knows it".to_owned())
                    }
                },
            });
        }
    }
}
