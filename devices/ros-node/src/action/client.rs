//! The end of an action that sends goals: one at a time. A goal that was given up is canceled until its server says that it
//! has ended, or goes on with it, also if that can be reached only later.

use std::time::Duration;

use serde_json::json;

use super::{
    Action, CANCEL, GoalId, GoalStatus, decode, encode, id_of, new_id, split_id, stamp, uuid, with_id,
};
use crate::node::{Node, NodeConfig};
use crate::services::Client;

/// How long a server may take to cancel.
const CANCEL_TIMEOUT: Duration = Duration::from_secs(5);
/// The most goals that are canceled at the same time, besides the newest.
const MOST_CANCELED: usize = 16;
/// Response to a cancellation: the goal goes on.
const CANCEL_REFUSED: u8 = 1;
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
    /// Goals that were given up.
    old: Vec<Goal>,
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
    /// Whether the server goes on with it.
    is_kept: bool,
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

impl Goal {
    /// Requests its result, as the client of that number.
    fn request_result(&mut self, node: &Node, client: usize) {
        let request = encode("GetResult_Request", &json!({ "goal_id": uuid(self.id) }));
        self.requested = Some(node.call(client, request));
    }

    /// Requests that it is canceled, as the client of that number.
    fn cancel(&mut self, node: &Node, client: usize) {
        let info = json!({ "goal_info": { "goal_id": uuid(self.id), "stamp": stamp(Duration::ZERO) } });
        let request = encode(&format!("{CANCEL}_Request"), &info);
        self.canceled = Some(node.call(client, request));
    }
}

impl ActionClient {
    /// Adds the parts of an action to a node. A goal that is not accepted `within` this time is lost.
    #[must_use]
    pub fn declare(action: Action, within: Duration, config: &mut NodeConfig) -> Self {
        let (clients, feedback) = (config.clients.len(), config.subscriptions.len());
        let timeouts = [within, CANCEL_TIMEOUT, RESULT_TIMEOUT];
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
            old: Vec::new(),
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

    /// Sends a goal, after it has given up an earlier one.
    pub fn send(&mut self, node: &Node, goal: &[u8]) {
        self.give_up(node);
        let id = new_id();
        let sent = node.call(self.clients, with_id(id, goal));
        self.goal = Some(Goal {
            id,
            sent: Some(sent),
            requested: None,
            canceled: None,
            is_kept: false,
        });
    }

    /// Requests that the goal is canceled, unless such a request is under way. It has ended when the server says so.
    pub fn cancel(&mut self, node: &Node) {
        if let Some(goal) = self.goal.as_mut().filter(|goal| goal.canceled.is_none()) {
            goal.cancel(node, self.clients + 1);
        }
    }

    /// Cancels the goal, of which no event follows any more.
    pub fn give_up(&mut self, node: &Node) {
        self.cancel(node);
        self.lose();
    }

    /// Returns what has happened to the goal since the last call.
    pub fn poll(&mut self, node: &Node) -> Vec<GoalEvent> {
        let mut events = Vec::new();
        self.poll_acceptance(node, &mut events);
        self.poll_cancellations(node, &mut events);
        for message in node.take_all(self.feedback) {
            if let Some((id, feedback)) = split_id(&message.message.to_bytes())
                && self.goal.as_ref().is_some_and(|goal| goal.id == id)
            {
                events.push(GoalEvent::Feedback(feedback));
            }
        }
        while node.take(self.feedback + 1).is_some() {}
        self.poll_result(node, &mut events);
        if self.has_server(node) {
            let idle = self.old.iter_mut().filter(|goal| goal.canceled.is_none());
            idle.for_each(|goal| goal.cancel(node, self.clients + 1));
        } else if self.goal.as_ref().is_some_and(|goal| goal.sent.is_none()) {
            self.lose();
            events.push(GoalEvent::Lost(format!(
                "no node offers {} any more",
                self.action.name
            )));
        }
        events
    }

    /// Whether a goal that was given up has not ended yet, and its server has not said that it goes on with it.
    #[must_use]
    pub fn is_canceling(&self) -> bool {
        !self.old.is_empty()
    }

    /// Counts the goal among those that were given up, unless its server has said that it goes on with it.
    fn lose(&mut self) {
        self.old.extend(self.goal.take().filter(|goal| !goal.is_kept));
        if self.old.len() > MOST_CANCELED {
            self.old.remove(0);
        }
    }

    fn poll_acceptance(&mut self, node: &Node, events: &mut Vec<GoalEvent>) {
        while let Some(response) = node.take_response(self.clients) {
            let is_of = |goal: &&mut Goal| goal.sent == Some(response.sequence);
            let accepted = response
                .outcome
                .and_then(|message| decode("SendGoal_Response", &message));
            if let Some(goal) = self.old.iter_mut().find(is_of) {
                // A cancellation that overtook the acceptance found no goal.
                (goal.sent, goal.canceled) = (None, None);
                let id = goal.id;
                match accepted {
                    Ok(value) if value["accepted"] == true => goal.request_result(node, self.clients + 2),
                    Ok(_) => self.old.retain(|goal| goal.id != id),
                    Err(_) => {}
                }
                continue;
            }
            let Some(goal) = self.goal.as_mut().filter(is_of) else {
                continue;
            };
            goal.sent = None;
            match accepted {
                Err(error) => {
                    self.lose();
                    events.push(GoalEvent::Lost(error));
                }
                Ok(value) if value["accepted"] != true => {
                    self.goal = None;
                    events.push(GoalEvent::Rejected);
                }
                Ok(_) => {
                    goal.request_result(node, self.clients + 2);
                    events.push(GoalEvent::Accepted);
                    // As above.
                    if goal.canceled.take().is_some() {
                        self.cancel(node);
                    }
                }
            }
        }
    }

    fn poll_cancellations(&mut self, node: &Node, events: &mut Vec<GoalEvent>) {
        while let Some(response) = node.take_response(self.clients + 1) {
            let mut goals = self.goal.iter_mut().chain(&mut self.old);
            let Some(goal) = goals.find(|goal| goal.canceled == Some(response.sequence)) else {
                continue;
            };
            let answer = response
                .outcome
                .and_then(|message| decode(&format!("{CANCEL}_Response"), &message));
            let Ok(answer) = answer else {
                // Nobody answered. It is requested again.
                goal.canceled = None;
                continue;
            };
            let id = goal.id;
            let canceled = answer["goals_canceling"].as_array().into_iter().flatten();
            let is_canceled = canceled.into_iter().any(|info| id_of(info) == id);
            // rclpy states that it cancels nothing, and no error.
            let is_refused =
                answer["return_code"] == CANCEL_REFUSED || (answer["return_code"] == 0 && !is_canceled);
            if is_refused {
                goal.is_kept = true;
                events.push(GoalEvent::NotCanceled);
            }
            // One that is canceled ends with its result, and one that is not accepted yet is canceled then.
            let is_open = |goal: &Goal| match is_canceled {
                true => goal.requested.is_some() || goal.sent.is_some(),
                false => goal.sent.is_some(),
            };
            self.old.retain(|goal| goal.id != id || is_open(goal));
        }
    }

    fn poll_result(&mut self, node: &Node, events: &mut Vec<GoalEvent>) {
        while let Some(response) = node.take_response(self.clients + 2) {
            let is_of = |goal: &Goal| goal.requested == Some(response.sequence);
            if response.outcome.is_err() {
                // Nobody knows whether it has ended.
                let requested = self.old.iter_mut().filter(|goal| is_of(goal));
                requested.for_each(|goal| (goal.requested, goal.canceled) = (None, None));
                if self.goal.as_ref().is_some_and(is_of) {
                    self.lose();
                    let why = format!(
                        "the node that had accepted the goal of {} is gone",
                        self.action.name
                    );
                    events.push(GoalEvent::Lost(why));
                }
                continue;
            }
            self.old.retain(|goal| !is_of(goal));
            if self.goal.take_if(|goal| is_of(goal)).is_none() {
                continue;
            }
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
