//! Actions by the application file: goals to other nodes are commands, and goals of other nodes are variables.

mod client;
mod server;

use std::sync::Arc;

use jde_ros_node::{Action, Settings, names};
use jde_schema::describe::Type;
use jde_schema::prelude::*;
use jde_schema::{ListedCommand, ListedExport};

use crate::clock_source::FollowedClock;
use crate::connection::{RosConnection, arrival};
use crate::goal;
use crate::services::{Plain, Timed, partner};
use crate::settings::node_schema;
use client::GoalSender;
use server::GoalTaker;

node_schema! {
    /// Sends goals to other nodes, and offers actions whose goals schemas carry out. The keys of the lists are names of
    /// actions, relative to the namespace unless they begin with `/`.
    ///
    /// An action has a goal, feedback and a result, each in a list of its own under the same key. Their types are named
    /// `PACKAGE/action/NAME_Goal`, `PACKAGE/action/NAME_Feedback` and `PACKAGE/action/NAME_GetResult_Response`. Each action has one
    /// goal at a time.
    #[schema(driver, period = "20ms", budget = "20ms")]
    pub struct Actions {
        /// The clock of the stamps in goals, feedback and results: `wall`, or `follow` for that of `/clock`.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// The goals of other nodes' actions: one is sent when it comes into force, and canceled when it is no longer in force.
        #[commands(default = Timed::DEFAULT, validity = "500ms")]
        send_goal: Commands<Timed>,
        /// The feedback to these goals.
        #[exports(default = Plain::DEFAULT, lasting)]
        take_feedback: Exports<Plain>,
        /// The results of these goals, each with the time at which the goal came into force.
        #[exports(default = Plain::DEFAULT, lasting)]
        take_result: Exports<Plain>,
        /// The goals of this node's actions, each until its end.
        #[exports(default = Plain::DEFAULT, lasting)]
        take_goal: Exports<Plain>,
        /// The feedback to these goals: each new value is sent.
        #[imports(default = Plain::DEFAULT)]
        send_feedback: Imports<Plain>,
        /// The results of these goals: each new value is the result of the present goal.
        #[imports(default = Plain::DEFAULT)]
        send_result: Imports<Plain>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveActions>,
    }
}

/// The node with its actions, in the order of the lists of goals.
struct ActiveActions {
    connection: RosConnection,
    /// Each with the places of its feedback and its result.
    senders: Vec<(GoalSender, [usize; 2])>,
    takers: Vec<(GoalTaker, [usize; 2])>,
}

impl Schema for Actions {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.active = Some(self.with_settings(cx, |settings| self.start(cx, &settings))?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        let connection = &mut active.connection;
        connection.begin(cx, self.clock.get(cx).into());
        if connection.clock.is_known() {
            for ((sender, [feedback, result]), goal) in active.senders.iter_mut().zip(self.send_goal.iter()) {
                let exports = (&mut self.take_feedback[*feedback], &mut self.take_result[*result]);
                sender.exchange(cx, connection, goal, exports);
            }
            for ((taker, [feedback, result]), goal) in active.takers.iter_mut().zip(self.take_goal.iter_mut())
            {
                let imports = (&self.send_feedback[*feedback], &self.send_result[*result]);
                taker.exchange(cx, connection, goal, imports);
            }
        }
        connection.export_connection(cx, &mut self.connection, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(mut active) = self.active.take() {
            for (sender, _) in &mut active.senders {
                sender.give_up(&active.connection);
            }
            for (taker, _) in &mut active.takers {
                taker.give_up(&active.connection);
            }
            active.connection.close(cx, &mut self.connection);
            for list in [
                &mut self.take_feedback,
                &mut self.take_result,
                &mut self.take_goal,
            ] {
                list.iter_mut().for_each(|export| export.retract(cx));
            }
        }
    }
}

impl Inspect for Actions {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let namespace = self.inspect_node(cx, &[], problems);
        problems.expect(
            &self.connect,
            self.with_settings(cx, |settings| goal::refuse_bridge(&settings)),
        );
        for goal in self.send_goal.iter() {
            problems.expect(goal, self.sent(&namespace, goal));
        }
        for goal in self.take_goal.iter() {
            problems.expect(goal, self.taken(&namespace, goal));
        }
        for export in self.take_feedback.iter().chain(self.take_result.iter()) {
            let goals = self.send_goal.iter().map(ListedCommand::label);
            problems.expect(export, partner(goals, export.label(), "send_goal", ACTION_PARTS));
        }
        for import in self.send_feedback.iter().chain(self.send_result.iter()) {
            let goals = self.take_goal.iter().map(ListedExport::label);
            problems.expect(import, partner(goals, import.label(), "take_goal", ACTION_PARTS));
        }
    }
}

/// The entries of a list.
macro_rules! entries {
    ($list:expr) => {
        $list
            .iter()
            .map(|entry| (entry.label(), entry.value_type()))
            .collect::<Entries<'_>>()
    };
}

/// What an action consists of.
const ACTION_PARTS: &str = "an action has a goal, feedback and a result";

impl Actions {
    fn start(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveActions> {
        goal::refuse_bridge(settings)?;
        let mut config = settings.node_config()?;
        config.arrival = arrival(cx);
        let namespace = config.name.namespace.clone();
        let (mut senders, mut takers) = (Vec::new(), Vec::new());
        for goal in self.send_goal.iter() {
            let entry = |error| format!("`{}` in `send_goal`: {error}", goal.label());
            let (action, places) = self.sent(&namespace, goal).map_err(entry)?;
            let [feedback, result] = [&self.take_feedback[places[0]], &self.take_result[places[1]]];
            senders.push((
                GoalSender::new(action, goal, [feedback, result], &mut config),
                places,
            ));
        }
        for goal in self.take_goal.iter() {
            let entry = |error| format!("`{}` in `take_goal`: {error}", goal.label());
            let (action, places) = self.taken(&namespace, goal).map_err(entry)?;
            let [feedback, result] = [&self.send_feedback[places[0]], &self.send_result[places[1]]];
            takers.push((
                GoalTaker::new(action, goal, [feedback, result], &mut config),
                places,
            ));
        }
        Ok(ActiveActions {
            connection: RosConnection::start(config, self.clock.get(cx).into())?,
            senders,
            takers,
        })
    }

    /// Returns the action of an entry of `send_goal`, and the places of its feedback and its result.
    fn sent(&self, namespace: &str, goal: &ListedCommand<Timed>) -> Result<(Action, [usize; 2]), String> {
        goal.settings().check()?;
        let others = [
            ("take_feedback", entries!(self.take_feedback)),
            ("take_result", entries!(self.take_result)),
        ];
        action(
            namespace,
            (goal.label(), goal.value_type()),
            &entries!(self.send_goal),
            others,
        )
    }

    /// Returns the action of an entry of `take_goal`, and the places of its feedback and its result.
    fn taken(&self, namespace: &str, goal: &ListedExport<Plain>) -> Result<(Action, [usize; 2]), String> {
        let others = [
            ("send_feedback", entries!(self.send_feedback)),
            ("send_result", entries!(self.send_result)),
        ];
        action(
            namespace,
            (goal.label(), goal.value_type()),
            &entries!(self.take_goal),
            others,
        )
    }
}

/// Entries of a list: their keys, and the types of their values.
type Entries<'l> = Vec<(&'static str, &'l Arc<Type>)>;

/// Returns the action of a goal, and the places of its feedback and its result in their lists. `goals` are those of the
/// list that has it.
fn action(
    namespace: &str,
    (key, goal): (&'static str, &Arc<Type>),
    goals: &Entries<'_>,
    others: [(&str, Entries<'_>); 2],
) -> Result<(Action, [usize; 2]), String> {
    let name = |key: &str| names::topic(namespace, key).ok().flatten();
    let mut earlier = goals
        .iter()
        .map(|(other, _)| *other)
        .take_while(|other| *other != key);
    if let Some(twin) = earlier.find(|other| name(other) == name(key)) {
        return Err(format!("`{twin}` is the same action"));
    }
    let [feedback, result] = others.map(|(list, entries)| {
        let place = partner(entries.iter().map(|(key, _)| *key), key, list, ACTION_PARTS)?;
        Ok::<_, String>((place, Arc::clone(entries[place].1)))
    });
    let ((feedback, feedback_type), (result, result_type)) = (feedback?, result?);
    let name = names::topic(namespace, key)?.ok_or("an action has a name")?;
    let action = Action::of_values(name, goal, &result_type, &feedback_type)?;
    Ok((action, [feedback, result]))
}
