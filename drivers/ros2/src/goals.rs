//! The driver by which programs of ROS 2 send targets: the server of Nav2's action, and RViz's topic of goals.

use jde_ros_node::{ActionServer, GoalId, GoalStatus, Middleware, Quality, ServerEvent, Settings, names};
use jde_schema::prelude::*;
use serde_json::json;

use crate::clock_source::FollowedClock;
use crate::connection::{RosConnection, TopicSubscription};
use crate::goal;
use crate::messages::Codec;
use crate::settings::node_schema;

/// The time between two messages of feedback.
const FEEDBACK: Duration = Duration::from_millis(100);
/// Nav2's code of an error without a code of its own.
const UNKNOWN_ERROR: u16 = 9000;

node_schema! {
    /// Takes targets from ROS 2, one at a time, and reports how each ends.
    ///
    /// It is the server of `NavigateToPose`, and it also takes poses of a topic, as RViz publishes them. A new target
    /// takes the place of the previous one, whose goal is aborted. The mission of the schema that drives, such as
    /// `navigate`, states whether a target is reached or given up.
    #[schema(driver, period = "50ms", budget = "10ms")]
    pub struct Goals {
        /// The action that it offers.
        #[modulation(default = "navigate_to_pose", fixed)]
        action: Modulation<Text<128>>,
        /// The topic of poses to drive to, `geometry_msgs/msg/PoseStamped`; empty for none.
        #[modulation(default = "goal_pose", fixed)]
        topic: Modulation<Text<128>>,
        /// The clock of the stamps: `wall`, or `follow` for that of `/clock`.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// The frame of the targets. A target in another frame is refused.
        #[modulation(default = "map")]
        frame: Modulation<Text<52>>,
        /// Progress of the schema that drives to `target`. Without a target it must not state the end of an old one.
        #[import]
        mission: Import<Mission>,
        /// Pose of the robot in the frame of the targets, for the feedback.
        #[import(optional)]
        pose: Import<Odometry>,
        /// Where to drive.
        #[export(lasting)]
        target: Export<Target>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveGoals>,
    }
}

/// The node, and the present target.
struct ActiveGoals {
    connection: RosConnection,
    server: ActionServer,
    poses: Option<TopicSubscription<PoseStamped>>,
    current: Option<CurrentTarget>,
    middleware: Middleware,
}

/// A target that was not reached or given up.
struct CurrentTarget {
    pose: Pose2D,
    /// The goal of the action; none for a pose of the topic.
    id: Option<GoalId>,
    since: Duration,
    feedback_at: Duration,
    /// Whether it is exported. It waits while the mission still states the end of an earlier target at this pose.
    is_exported: bool,
}

impl Schema for Goals {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.active = Some(self.with_settings(cx, |settings| self.start(cx, &settings))?);
            self.target.write(cx, Target::NONE);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let frame = self.frame.get(cx);
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        active.connection.begin(cx, self.clock.get(cx).into());
        let before = active.exported();
        active.take_requests(cx, frame.as_str());
        active.take_pose(cx, frame.as_str());
        active.judge(self.mission.get(cx));
        active.release(cx, self.mission.get(cx));
        active.report(cx, self.mission.get(cx), self.pose.get(cx), frame.as_str());
        let exported = active.exported();
        if exported != before {
            let target = exported.map_or(Target::NONE, |(_, pose)| Target::facing(pose));
            self.target.write(cx, target);
        }
        active
            .connection
            .export_connection(cx, &mut self.connection, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(mut active) = self.active.take() {
            active.end(GoalStatus::Aborted, "the robot takes no targets any more");
            active.connection.close(cx, &mut self.connection);
            self.target.retract(cx);
        }
    }
}

impl Inspect for Goals {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.inspect_node(cx, &[&self.topic], problems);
        problems.expect(
            &self.connect,
            self.with_settings(cx, |settings| goal::refuse_bridge(&settings)),
        );
        problems.expect(
            &self.action,
            goal::action("", self.action.get(cx).as_str(), Middleware::Rmw),
        );
    }
}

impl Goals {
    fn start(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveGoals> {
        goal::refuse_bridge(settings)?;
        let mut config = settings.node_config()?;
        let (namespace, middleware) = (&config.name.namespace, config.name.middleware);
        let action = goal::action(namespace, self.action.get(cx).as_str(), middleware)?;
        let topic = names::topic(namespace, self.topic.get(cx).as_str())?;
        let poses = topic.map(|topic| {
            let codec = Codec::new();
            config
                .subscriptions
                .push(codec.topic(topic.clone(), Quality::DEFAULT));
            TopicSubscription::new(0, topic, codec)
        });
        Ok(ActiveGoals {
            middleware,
            server: ActionServer::declare(action, &mut config),
            connection: RosConnection::start(config, self.clock.get(cx).into())?,
            poses,
            current: None,
        })
    }
}

impl ActiveGoals {
    /// Takes the goals of the action and their cancellations.
    fn take_requests(&mut self, cx: &Context, frame: &str) {
        let now: Duration = self.connection.clock.stamp(cx.now()).into();
        let mut refused = None;
        let middleware = self.middleware;
        let pose = |goal: &[u8]| {
            let goal = goal::decode(middleware, "Goal", goal)?;
            goal::pose(&goal["pose"], frame)
        };
        let events = self.server.poll(&self.connection.node, now, |goal| {
            pose(goal).map_err(|error| refused = Some(error)).is_ok()
        });
        if let Some(error) = refused {
            let message = format!("a goal is rejected: {error}");
            self.connection.warn_once(cx, message);
        }
        for event in events {
            match event {
                ServerEvent::Accepted(id, goal) => {
                    if let Ok(pose) = pose(&goal) {
                        self.choose(cx, pose, Some(id));
                    }
                }
                ServerEvent::Canceled(id)
                    if self.current.as_ref().and_then(|current| current.id) == Some(id) =>
                {
                    self.end(GoalStatus::Canceled, "");
                }
                ServerEvent::Canceled(_) => {}
            }
        }
    }

    /// Takes a pose of the topic.
    fn take_pose(&mut self, cx: &Context, frame: &str) {
        let Some(subscription) = &mut self.poses else {
            return;
        };
        let mut goal = PoseStamped::default();
        if self.connection.receive(cx, subscription, &mut goal).is_none() {
            return;
        }
        match goal::check(goal.header.frame_id.as_str(), goal.pose.into(), frame) {
            Ok(pose) => self.choose(cx, pose, None),
            Err(error) => {
                let message = format!("{}: a pose is ignored: {error}", subscription.topic());
                self.connection.warn_once(cx, message);
            }
        }
    }

    /// Takes a target in the place of the one before.
    fn choose(&mut self, cx: &Context, pose: Pose2D, id: Option<GoalId>) {
        self.end(GoalStatus::Aborted, "another target took its place");
        self.current = Some(CurrentTarget {
            pose,
            id,
            since: cx.now(),
            feedback_at: cx.now(),
            is_exported: false,
        });
    }

    /// Begins with the target, unless the mission states the end of an earlier one at this pose.
    fn release(&mut self, cx: &Context, mission: Option<Sample<'_, Mission>>) {
        let Some(current) = self.current.as_mut().filter(|current| !current.is_exported) else {
            return;
        };
        let is_old = |mission: Sample<'_, Mission>| {
            mission.target == current.pose && matches!(mission.state, Mission::DONE | Mission::FAILED)
        };
        if !mission.is_some_and(is_old) {
            (current.is_exported, current.since) = (true, cx.now());
        }
    }

    /// The exported target, and since when it is.
    fn exported(&self) -> Option<(Duration, Pose2D)> {
        let current = self.current.as_ref().filter(|current| current.is_exported);
        current.map(|current| (current.since, current.pose))
    }

    /// Ends the target if the mission of this target has ended.
    fn judge(&mut self, mission: Option<Sample<'_, Mission>>) {
        let (Some(current), Some(mission)) = (&self.current, mission) else {
            return;
        };
        if !current.is_exported || mission.time() <= current.since || mission.target != current.pose {
            return;
        }
        match mission.state {
            Mission::DONE => self.end(GoalStatus::Succeeded, ""),
            Mission::FAILED => self.end(GoalStatus::Aborted, mission.note.as_str()),
            _ => {}
        }
    }

    /// Sends the feedback of the goal, as soon as the distance is known: a mission states 0 until then.
    fn report(
        &mut self,
        cx: &Context,
        mission: Option<Sample<'_, Mission>>,
        pose: Option<Sample<'_, Odometry>>,
        frame: &str,
    ) {
        let Some(current) = self
            .current
            .as_mut()
            .filter(|current| cx.now() >= current.feedback_at)
        else {
            return;
        };
        let Some(id) = current.id else { return };
        let is_known = |mission: &Sample<'_, Mission>| {
            let is_of_it = mission.time() > current.since && mission.target == current.pose;
            current.is_exported && is_of_it && mission.distance > 0.0
        };
        let Some(mission) = mission.filter(is_known) else {
            return;
        };
        current.feedback_at = cx.now() + FEEDBACK;
        let time = cx.now().saturating_sub(current.since);
        let mut feedback = json!({
            "navigation_time": { "sec": time.as_secs(), "nanosec": time.subsec_nanos() },
            "distance_remaining": mission.distance,
        });
        if let Some(pose) = pose {
            let stamp = self.connection.clock.stamp(pose.time());
            feedback["current_pose"] = goal::stamped(Pose2D::from(pose.pose.pose), frame, stamp);
        }
        let feedback = goal::encode(self.middleware, "Feedback", &feedback);
        self.server.feedback(&self.connection.node, id, &feedback);
    }

    /// Ends the target, if there is one.
    fn end(&mut self, status: GoalStatus, note: &str) {
        let Some(id) = self.current.take().and_then(|current| current.id) else {
            return;
        };
        let code = if note.is_empty() { 0 } else { UNKNOWN_ERROR };
        let result = goal::result(self.middleware, code, note);
        self.server.end(&self.connection.node, id, status, Some(result));
    }
}
