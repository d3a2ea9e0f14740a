//! An action of this node: its goal is exported, and the next new value of a variable is how it has ended.

use jde_ros_node::{Action, ActionServer, GoalId, GoalStatus, NodeConfig, ServerEvent};
use jde_schema::prelude::*;
use jde_schema::{ListedExport, ListedImport};

use crate::connection::RosConnection;
use crate::described::DescribedCodec;
use crate::services::Plain;

/// An action, and its goal.
pub(super) struct GoalTaker {
    name: String,
    server: ActionServer,
    goal: DescribedCodec,
    feedback: DescribedCodec,
    result: DescribedCodec,
    /// The goal that is exported.
    current: Option<Current>,
    /// The next goal. It is exported once schemas had an iteration without one.
    next: Option<(GoalId, Vec<u8>)>,
}

struct Current {
    id: GoalId,
    /// The time just before its export.
    since: Duration,
    /// The numbers of the newest feedback that was sent and of the result that was there before.
    feedback: u64,
    result: u64,
}

impl GoalTaker {
    /// Adds the action to those of the node.
    pub(super) fn new(
        action: Action,
        goal: &ListedExport<Plain>,
        [feedback, result]: [&ListedImport<Plain>; 2],
        config: &mut NodeConfig,
    ) -> Self {
        Self {
            name: action.name().to_owned(),
            server: ActionServer::declare(action, config),
            goal: DescribedCodec::new(goal.value_type()),
            feedback: DescribedCodec::new(feedback.value_type()),
            result: DescribedCodec::new(result.value_type()),
            current: None,
            next: None,
        }
    }

    /// Sends new feedback and the end of the goal, and takes goals and cancellations.
    pub(super) fn exchange(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        export: &mut ListedExport<Plain>,
        (feedback, result): (&ListedImport<Plain>, &ListedImport<Plain>),
    ) {
        let (feedback, result) = (feedback.get(cx), result.get(cx));
        let had_goal = self.current.is_some();
        self.send_feedback(connection, feedback.as_ref());
        self.send_result(cx, connection, result.as_ref());
        self.take_requests(cx, connection);
        if had_goal {
            if self.current.is_none() {
                export.retract(cx);
            }
            return;
        }
        let Some((id, message)) = self.next.take() else {
            return;
        };
        let number = |value: Option<Sample<'_, [u8]>>| value.map_or(0, |value| value.sequence());
        let since = cx.now();
        match connection.export(cx, (&self.name, &self.goal, &message), Some(since), export) {
            Ok(()) => {
                self.current = Some(Current {
                    id,
                    since,
                    feedback: number(feedback),
                    result: number(result),
                });
            }
            Err(error) => {
                connection.warn_once(cx, format!("a goal of {} is aborted: {error}", self.name));
                self.server.end(&connection.node, id, GoalStatus::Aborted, None);
            }
        }
    }

    /// Aborts the goals.
    pub(super) fn give_up(&mut self, connection: &RosConnection) {
        let current = self.current.take().map(|current| current.id);
        let next = self.next.take().map(|(id, _)| id);
        for id in current.into_iter().chain(next) {
            self.server.end(&connection.node, id, GoalStatus::Aborted, None);
        }
    }

    fn send_feedback(&mut self, connection: &RosConnection, newest: Option<&Sample<'_, [u8]>>) {
        if let (Some(current), Some(value)) = (&mut self.current, newest)
            && value.sequence() != current.feedback
            && value.time() >= current.since
        {
            current.feedback = value.sequence();
            let message = self.feedback.encode(value, "", value.time(), &connection.clock);
            self.server.feedback(&connection.node, current.id, &message);
        }
    }

    fn send_result(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        newest: Option<&Sample<'_, [u8]>>,
    ) {
        let (Some(current), Some(value)) = (&self.current, newest) else {
            return;
        };
        if value.sequence() == current.result || value.time() < current.since {
            return;
        }
        let message = self.result.encode(value, "", value.time(), &connection.clock);
        let status = GoalStatus::of_result(&message).unwrap_or_else(|| {
            let message = format!(
                "{}: a result states neither 4 (succeeded), 5 (canceled) nor 6 (aborted) as its `status`, so its goal is aborted",
                self.name
            );
            connection.warn_once(cx, message);
            GoalStatus::Aborted
        });
        self.server
            .end(&connection.node, current.id, status, Some(message));
        self.current = None;
    }

    /// Takes goals, each in the place of the one before, and cancellations.
    fn take_requests(&mut self, cx: &Context, connection: &mut RosConnection) {
        let now: Duration = connection.clock.stamp(cx.now()).into();
        let mut refused = None;
        let events = self.server.poll(&connection.node, now, |goal| {
            let checked = self.goal.check(goal);
            checked.map_err(|error| refused = Some(error)).is_ok()
        });
        if let Some(error) = refused {
            connection.warn_once(cx, format!("a goal of {} is rejected: {error}", self.name));
        }
        for event in events {
            match event {
                ServerEvent::Accepted(id, message) => {
                    self.give_up(connection);
                    self.next = Some((id, message));
                }
                ServerEvent::Canceled(id) => {
                    self.current.take_if(|current| current.id == id);
                    self.next.take_if(|(next, _)| *next == id);
                    self.server.end(&connection.node, id, GoalStatus::Canceled, None);
                }
            }
        }
    }
}
