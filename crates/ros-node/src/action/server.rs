//! The end of an action that carries out goals.

use std::time::Duration;

use serde_json::{Value, json};

use super::{Action, CANCEL, GoalId, GoalStatus, STATUS, id_of, stamp, uuid};
use crate::node::{Node, NodeConfig};
use crate::services::Request;

/// The goals that have ended and are remembered, for clients that ask for their results later.
const MOST_ENDED: usize = 16;
/// The requests for the result of a goal that wait; a later one takes the place of the oldest.
const MAX_RESULT_REQUESTS: usize = 16;
/// Response to a cancellation: a goal of this identifier is not known.
const UNKNOWN_GOAL: u8 = 2;
/// Response to a cancellation: the goal has ended already.
const ENDED: u8 = 3;

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
    result: Value,
    /// Requests for its result.
    waiting: Vec<Request>,
}

/// A request of a client.
#[derive(Clone, Debug, PartialEq)]
pub enum ServerEvent {
    /// Carry out a goal.
    Accepted(GoalId, Value),
    /// Cancel a goal. It has ended when [`ActionServer::end`] says so.
    Canceled(GoalId),
}

impl ActionServer {
    /// Adds the parts of an action to a node.
    #[must_use]
    pub fn declare(action: Action, config: &mut NodeConfig) -> Self {
        let (services, publications) = (config.services.len(), config.publications.len());
        config.services.extend(action.services());
        config.publications.extend(action.topics());
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
        mut accepts: impl FnMut(&Value) -> bool,
    ) -> Vec<ServerEvent> {
        let mut events = Vec::new();
        while let Some(request) = node.take_request(Duration::ZERO) {
            match request.service.checked_sub(self.services) {
                Some(0) => events.extend(self.take_goal(node, request, now, &mut accepts)),
                Some(1) => events.extend(self.take_cancellation(node, request)),
                Some(2) => self.take_result_request(node, request),
                // A request that is dropped has no response.
                _ => {}
            }
        }
        if !events.is_empty() {
            self.publish_states(node);
        }
        events
    }

    /// Sends the feedback of a goal.
    ///
    /// # Panics
    /// If the feedback has a field that its type does not have.
    pub fn feedback(&self, node: &Node, id: GoalId, feedback: &Value) {
        if node.has_subscribers(self.publications) {
            let value = json!({ "goal_id": uuid(id), "feedback": feedback });
            let message = self.action.encode(&self.action.feedback(), &value);
            node.publish(self.publications, vec![message]);
        }
    }

    /// Ends a goal with its result.
    ///
    /// # Panics
    /// If the result has a field that its type does not have.
    pub fn end(&mut self, node: &Node, id: GoalId, status: GoalStatus, result: Value) {
        let Some(goal) = self
            .goals
            .iter_mut()
            .find(|goal| goal.id == id && !goal.status.has_ended())
        else {
            return;
        };
        (goal.status, goal.result) = (status, result);
        let waiting = std::mem::take(&mut goal.waiting);
        let (status, result) = (goal.status as u8, goal.result.clone());
        for request in waiting {
            self.reply_result(node, request, status, &result);
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
        accepts: &mut impl FnMut(&Value) -> bool,
    ) -> Option<ServerEvent> {
        let mut value = self.decode("_SendGoal_Request", &request)?;
        let id = id_of(&value);
        let is_new = self.goals.iter().all(|goal| goal.id != id);
        let accepted = is_new && accepts(&value["goal"]);
        let response = json!({ "accepted": accepted, "stamp": stamp(now) });
        self.reply(node, request, "_SendGoal_Response", &response);
        accepted.then(|| {
            self.goals.push(Goal {
                id,
                accepted_at: now,
                status: GoalStatus::Executing,
                result: json!({}),
                waiting: Vec::new(),
            });
            ServerEvent::Accepted(id, value["goal"].take())
        })
    }

    /// Cancels the goal of that identifier, all goals without one, and all that are not younger than the stamp.
    fn take_cancellation(&mut self, node: &Node, request: Request) -> Vec<ServerEvent> {
        let message = self
            .action
            .interfaces
            .decode(&format!("{CANCEL}_Request"), &request.message());
        let Ok(value) = message else { return Vec::new() };
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
                code = if goal.id == id { ENDED } else { code };
                continue;
            }
            goal.status = GoalStatus::Canceling;
            canceled.push((goal.id, goal.accepted_at));
        }
        if canceled.is_empty() && code == 0 && id != GoalId::default() {
            code = UNKNOWN_GOAL;
        }
        let infos: Vec<_> = canceled
            .iter()
            .map(|(id, at)| json!({ "goal_id": uuid(*id), "stamp": stamp(*at) }))
            .collect();
        let response = json!({ "return_code": code, "goals_canceling": infos });
        node.reply(
            request,
            self.action.encode(&format!("{CANCEL}_Response"), &response),
        );
        canceled
            .into_iter()
            .map(|(id, _)| ServerEvent::Canceled(id))
            .collect()
    }

    fn take_result_request(&mut self, node: &Node, request: Request) {
        let Some(value) = self.decode("_GetResult_Request", &request) else {
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
            Some(goal) => {
                let (status, result) = (goal.status as u8, goal.result.clone());
                self.reply_result(node, request, status, &result);
            }
            None => self.reply_result(node, request, 0, &json!({})),
        }
    }

    fn reply_result(&self, node: &Node, request: Request, status: u8, result: &Value) {
        let response = json!({ "status": status, "result": result });
        self.reply(node, request, "_GetResult_Response", &response);
    }

    fn reply(&self, node: &Node, request: Request, part: &str, response: &Value) {
        let type_name = format!("{}{part}", self.action.type_name);
        node.reply(request, self.action.encode(&type_name, response));
    }

    /// The value of a request; `None` for one that is not of the type, which has no response.
    fn decode(&self, part: &str, request: &Request) -> Option<Value> {
        let type_name = format!("{}{part}", self.action.type_name);
        self.action.interfaces.decode(&type_name, &request.message()).ok()
    }

    fn publish_states(&self, node: &Node) {
        let states: Vec<_> = self
            .goals
            .iter()
            .map(|goal| {
                let info = json!({ "goal_id": uuid(goal.id), "stamp": stamp(goal.accepted_at) });
                json!({ "goal_info": info, "status": goal.status as u8 })
            })
            .collect();
        let message = self.action.encode(STATUS, &json!({ "status_list": states }));
        node.publish(self.publications + 1, vec![message]);
    }
}
