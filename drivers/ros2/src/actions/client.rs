//! An action of another node: the command in force is its goal, and its feedback and its end are exported.

use jde_ros_node::{Action, ActionClient, GoalEvent, NodeConfig};
use jde_schema::prelude::*;
use jde_schema::{ListedCommand, ListedExport};

use crate::connection::RosConnection;
use crate::described::DescribedCodec;
use crate::services::{Plain, Timed};

/// How much longer than its timeout the request for a goal waits for its response.
const RESPONSE_GRACE: Duration = Duration::from_secs(5);

/// How long a failure is not logged again.
const LOG_PAUSE: Duration = Duration::from_secs(1);

/// A client, and its goal.
pub(super) struct GoalSender {
    client: ActionClient,
    goal: DescribedCodec,
    feedback: DescribedCodec,
    result: DescribedCodec,
    timeout: Duration,
    current: Option<Current>,
    /// Why the last goal had no result, and when that was logged, if it had none.
    failure: Option<(String, Duration)>,
}

/// The newest goal.
struct Current {
    /// Its message without times, which do not make it another goal.
    message: Vec<u8>,
    /// The number of the schema that gives it.
    writer: u32,
    /// The time of the command with which it came into force.
    time: Duration,
    since: Duration,
    phase: Phase,
    /// Whether the command is no longer in force.
    is_withdrawn: bool,
}

enum Phase {
    /// No node offers the action yet, or the goal before has not ended.
    Waiting(Vec<u8>),
    Sent,
    Accepted,
    Ended,
}

/// The exports of an action: its feedback and its result.
type Exports<'e> = (&'e mut ListedExport<Plain>, &'e mut ListedExport<Plain>);

impl GoalSender {
    /// Adds the client to the node.
    pub(super) fn new(
        action: Action,
        goal: &ListedCommand<Timed>,
        [feedback, result]: [&ListedExport<Plain>; 2],
        config: &mut NodeConfig,
    ) -> Self {
        Self {
            // The driver decides first that nobody accepts a goal.
            client: ActionClient::declare(action, goal.settings().timeout() + RESPONSE_GRACE, config),
            goal: DescribedCodec::new(goal.value_type()),
            feedback: DescribedCodec::new(feedback.value_type()),
            result: DescribedCodec::new(result.value_type()),
            timeout: goal.settings().timeout(),
            current: None,
            failure: None,
        }
    }

    /// Sends the command in force as a goal if it is another one, cancels a goal that is no longer in force, and exports what
    /// has happened to it.
    pub(super) fn exchange(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        command: &ListedCommand<Timed>,
        (feedback, result): Exports<'_>,
    ) {
        for event in self.client.poll(&connection.node) {
            self.receive(cx, connection, event, (feedback, result));
        }
        match command.get(cx) {
            Some(command) => self.command(cx, connection, &command, (feedback, result)),
            None => self.withdraw(connection),
        }
        self.go_on(cx, connection, result);
    }

    /// Cancels the goal.
    pub(super) fn give_up(&mut self, connection: &RosConnection) {
        self.client.give_up(&connection.node);
    }

    fn receive(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        event: GoalEvent,
        (feedback, result): Exports<'_>,
    ) {
        let name = self.client.name();
        if event == GoalEvent::NotCanceled {
            connection.warn_once(
                cx,
                format!("{name} refuses to cancel a goal, and goes on with it"),
            );
        }
        let is_under_way = |current: &&mut Current| matches!(current.phase, Phase::Sent | Phase::Accepted);
        let Some(current) = self.current.as_mut().filter(is_under_way) else {
            return;
        };
        match event {
            GoalEvent::Accepted => current.phase = Phase::Accepted,
            GoalEvent::Feedback(message) => {
                if let Err(error) = connection.export(cx, (name, &self.feedback, &message), None, feedback) {
                    connection.warn_once(cx, format!("the feedback of {name} is ignored: {error}"));
                }
            }
            GoalEvent::Ended(_, message) => {
                current.phase = Phase::Ended;
                match connection.export(cx, (name, &self.result, &message), Some(current.time), result) {
                    Ok(()) => self.failure = None,
                    Err(error) => self.fail(cx, result, &error),
                }
            }
            GoalEvent::NotCanceled => {}
            GoalEvent::Rejected => self.fail(cx, result, "it is rejected"),
            GoalEvent::Lost(why) => self.fail(cx, result, &why),
        }
    }

    /// Begins with a goal, unless it is the one that is or was carried out.
    fn command(
        &mut self,
        cx: &Context,
        connection: &RosConnection,
        command: &Sample<'_, [u8]>,
        (feedback, result): Exports<'_>,
    ) {
        let message = self.goal.encode_without_times(command);
        if let Some(current) = &self.current
            && !current.is_withdrawn
            && (current.writer, &current.message) == (command.writer(), &message)
        {
            return;
        }
        self.client.give_up(&connection.node);
        feedback.retract(cx);
        result.retract(cx);
        let sent = self.goal.encode(command, "", command.time(), &connection.clock);
        self.current = Some(Current {
            message,
            writer: command.writer(),
            time: command.time(),
            since: cx.now(),
            phase: Phase::Waiting(sent),
            is_withdrawn: false,
        });
    }

    /// Cancels the goal. Its end is still exported.
    fn withdraw(&mut self, connection: &RosConnection) {
        let Some(current) = &mut self.current else { return };
        current.is_withdrawn = true;
        match current.phase {
            Phase::Waiting(_) | Phase::Ended => self.current = None,
            Phase::Sent | Phase::Accepted => self.client.cancel(&connection.node),
        }
    }

    /// Sends a goal that waits, and gives up one that no node has accepted in time.
    fn go_on(&mut self, cx: &Context, connection: &RosConnection, result: &mut ListedExport<Plain>) {
        let Some(current) = &mut self.current else { return };
        let is_late = cx.now() >= current.since + self.timeout;
        match &mut current.phase {
            Phase::Waiting(message)
                if self.client.has_server(&connection.node) && !self.client.is_canceling() =>
            {
                self.client.send(&connection.node, message);
                (current.phase, current.since) = (Phase::Sent, cx.now());
            }
            Phase::Waiting(_) if is_late => {
                let why = match self.client.has_server(&connection.node) {
                    true => format!("the goal before it has not ended within {:?}", self.timeout),
                    false => format!("no node offers it within {:?}", self.timeout),
                };
                self.fail(cx, result, &why);
            }
            Phase::Sent if is_late => {
                self.client.give_up(&connection.node);
                let why = format!("no node has accepted it within {:?}", self.timeout);
                self.fail(cx, result, &why);
            }
            Phase::Waiting(_) | Phase::Sent | Phase::Accepted | Phase::Ended => {}
        }
    }

    /// Ends the goal without a result: one whose state is 0. Warns, unless it has just warned of the same.
    fn fail(&mut self, cx: &Context, export: &mut ListedExport<Plain>, why: &str) {
        let Some(current) = &mut self.current else { return };
        current.phase = Phase::Ended;
        let zeros = |value: &mut [u8]| {
            value.fill(0);
            Ok::<_, core::convert::Infallible>(())
        };
        let Ok(()) = export.write_with(cx, Some(current.time), zeros);
        let is_repeated = |(last, at): &(String, Duration)| last == why && cx.now() < *at + LOG_PAUSE;
        if !self.failure.as_ref().is_some_and(is_repeated) {
            warn!(cx, "a goal of {} failed: {why}", self.client.name());
            self.failure = Some((why.to_owned(), cx.now()));
        }
    }
}
