//! The end of an action that carries out goals.

use std::time::Duration;

use serde_json::{Value, json};

use super::{
    Action, CANCEL, GoalId, GoalStatus, HEADER_BYTES, STATUS, decode, encode, id_of, split_id, stamp, uuid,
    with_id,
};
use crate::node::{Node, NodeConfig};
use crate::services::Request;

/// The goals that have ended and are remembered, for clients that ask for their results later.
const MOST_ENDED: usize = 16;
/// The requests for the result of a goal that wait; a later one takes the place of the oldest.
const MAX_RESULT_REQUESTS: usize = 16;
/// Response to a cancellation: a goal of this identifier is not known.
const UNKNOWN_GOAL: u8 = 2;
/// Response to a cancellation: the goal has ended already.
const GOAL_ENDED: u8 = 3;

/// The server of an action.
#[derive(Debug)]
pub struct ActionServer {
    action: Action,
    /// The number of its first service: goals, cancellations, results.
    services: usize,
    /// The number of its first publication: feedback, states.
    publications: usize,
    goals: Vec<Goal>,
}

#[derive(Debug)]
struct Goal {
    id: GoalId,
    accepted_at: Duration,
    status: GoalStatus,
    /// Once it has ended.
    result: Vec<u8>,
    /// Requests for its result.
    waiting: Vec<Request>,
}

/// A request of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ServerEvent {
    /// Carry out a goal.
    Accepted(GoalId, Vec<u8>),
    /// Cancel a goal. It has ended when [`ActionServer::end`] says so.
    Canceled(GoalId),
}

impl ActionServer {
    /// Adds the parts of an action to a node.
    #[must_use]
    pub fn declare(action: Action, config: &mut NodeConfig) -> Self {
        let (services, publications) = (config.services.len(), config.publications.len());
        config.services.extend(action.services.iter().cloned());
        config.publications.extend(action.topics.iter().cloned());
        Self {
            action,
            services,
            publications,
            goals: Vec::new(),
        }
    }

    /// Answers the requests that have come since the last call, and returns what is to be done. `accepts` decides
    /// about each goal. `now` is the time since 1970.
    pub fn poll(
        &mut self,
        node: &Node,
        now: Duration,
        mut accepts: impl FnMut(&[u8]) -> bool,
    ) -> Vec<ServerEvent> {
        let mut events = Vec::new();
        while let Some(request) = node.take_request_of(self.services) {
            events.extend(self.take_goal(node, request, now, &mut accepts));
        }
        while let Some(request) = node.take_request_of(self.services + 1) {
            events.extend(self.take_cancellation(node, request));
        }
        while let Some(request) = node.take_request_of(self.services + 2) {
            self.take_result_request(node, request);
        }
        if !events.is_empty() {
            self.publish_states(node);
        }
        events
    }

    /// Sends the feedback of a goal.
    pub fn feedback(&self, node: &Node, id: GoalId, feedback: &[u8]) {
        if node.has_subscribers(self.publications) {
            node.publish(self.publications, vec![with_id(id, feedback)]);
        }
    }

    /// Ends a goal with a result, whose state of the goal is replaced, or without one.
    pub fn end(&mut self, node: &Node, id: GoalId, status: GoalStatus, result: Option<Vec<u8>>) {
        let mut result = result.unwrap_or_else(|| self.action.no_result.clone());
        if let Some(first) = result.get_mut(HEADER_BYTES) {
            *first = status as u8;
        }
        let Some(goal) = self
            .goals
            .iter_mut()
            .find(|goal| goal.id == id && !goal.status.has_ended())
        else {
            return;
        };
        (goal.status, goal.result) = (status, result);
        let waiting = std::mem::take(&mut goal.waiting);
        let result = goal.result.clone();
        for request in waiting {
            node.reply(request, result.clone());
        }
        let mut surplus = self
            .goals
            .iter()
            .filter(|goal| goal.status.has_ended())
            .count()
            .saturating_sub(MOST_ENDED);
        self.goals.retain(|goal| {
            let is_surplus = goal.status.has_ended() && surplus > 0;
            surplus -= usize::from(is_surplus);
            !is_surplus
        });
        self.publish_states(node);
    }

    fn take_goal(
        &mut self,
        node: &Node,
        request: Request,
        now: Duration,
        accepts: &mut impl FnMut(&[u8]) -> bool,
    ) -> Option<ServerEvent> {
        let (id, message) = split_id(&request.message())?;
        let is_new = self.goals.iter().all(|goal| goal.id != id);
        let accepted = is_new && accepts(&message);
        let response = json!({ "accepted": accepted, "stamp": stamp(now) });
        node.reply(request, encode("SendGoal_Response", &response));
        accepted.then(|| {
            self.goals.push(Goal {
                id,
                accepted_at: now,
                status: GoalStatus::Executing,
                result: Vec::new(),
                waiting: Vec::new(),
            });
            ServerEvent::Accepted(id, message)
        })
    }

    /// Cancels the goal of that identifier, all goals without one, and all that are not younger than the stamp. One that is
    /// being canceled already is no event.
    fn take_cancellation(&mut self, node: &Node, request: Request) -> Vec<ServerEvent> {
        let Ok(value) = decode(&format!("{CANCEL}_Request"), &request.message()) else {
            return Vec::new();
        };
        let info = &value["goal_info"];
        let (id, until) = (id_of(info), &info["stamp"]);
        let until = Duration::new(
            until["sec"].as_u64().unwrap_or_default(),
            until["nanosec"]
                .as_u64()
                .and_then(|nanos| u32::try_from(nanos).ok())
                .unwrap_or_default(),
        );
        let is_all = id == GoalId::default() && until.is_zero();
        let (mut canceled, mut code) = (Vec::new(), 0);
        for goal in &mut self.goals {
            let is_older = !until.is_zero() && goal.accepted_at <= until;
            if !(is_all || goal.id == id || is_older) {
                continue;
            }
            if goal.status.has_ended() {
                code = if goal.id == id { GOAL_ENDED } else { code };
                continue;
            }
            let is_new = goal.status != GoalStatus::Canceling;
            goal.status = GoalStatus::Canceling;
            canceled.push((goal.id, goal.accepted_at, is_new));
        }
        if canceled.is_empty() && code == 0 && id != GoalId::default() {
            code = UNKNOWN_GOAL;
        }
        let infos: Vec<_> = canceled
            .iter()
            .map(|(id, at, _)| json!({ "goal_id": uuid(*id), "stamp": stamp(*at) }))
            .collect();
        let response = json!({ "return_code": code, "goals_canceling": infos });
        node.reply(request, encode(&format!("{CANCEL}_Response"), &response));
        let new = canceled.into_iter().filter(|(_, _, is_new)| *is_new);
        new.map(|(id, ..)| ServerEvent::Canceled(id)).collect()
    }

    fn take_result_request(&mut self, node: &Node, request: Request) {
        let Ok(value) = decode("GetResult_Request", &request.message()) else {
            return;
        };
        let id = id_of(&value);
        match self.goals.iter_mut().find(|goal| goal.id == id) {
            Some(goal) if !goal.status.has_ended() => {
                if goal.waiting.len() < MAX_RESULT_REQUESTS {
                    goal.waiting.push(request);
                } else {
                    node.refuse(
                        request,
                        format!("{MAX_RESULT_REQUESTS} requests for this result wait already"),
                    );
                }
            }
            Some(goal) => node.reply(request, goal.result.clone()),
            None => node.reply(request, self.action.no_result.clone()),
        }
    }

    fn publish_states(&self, node: &Node) {
        let states: Vec<Value> = self
            .goals
            .iter()
            .map(|goal| {
                let info = json!({ "goal_id": uuid(goal.id), "stamp": stamp(goal.accepted_at) });
                json!({ "goal_info": info, "status": goal.status as u8 })
            })
            .collect();
        let message = encode(STATUS, &json!({ "status_list": states }));
        node.publish(self.publications + 1, vec![message]);
    }
}
