//! The motor schema that lets Nav2 drive: it sends the goal when it wins, and cancels it when it loses.

use jde_ros_node::{ActionClient, GoalEvent, GoalStatus, Middleware, NodeConfig, Quality, Settings, names};
use jde_schema::prelude::*;
use serde_json::json;

use crate::clock_source::FollowedClock;
use crate::connection::RosConnection;
use crate::goal;
use crate::settings::node_schema;
use crate::velocity::{self, VelocitySubscription};

/// Checks without an iteration between them, after which the schema does not drive any more.
const MAX_LOST_CHECKS: u32 = 2;
/// How long a rejected goal is sent again, and how often: Nav2 offers its action before it is active, and rejects goals until
/// then.
const RETRY_TIME: Duration = Duration::from_secs(30);
const RETRY_INTERVAL: Duration = Duration::from_secs(1);
/// How long Nav2 may take to accept a goal.
const ACCEPT_TIMEOUT: Duration = Duration::from_secs(5);
const NO_TOPIC: &str = "it commands the base with the velocities of a topic, as in \"nav/cmd_vel\"";

node_schema! {
    /// Lets Nav2 drive to a target.
    ///
    /// It is READY while there is a target that was not reached or given up and Nav2 answers. As WINNER it sends the target
    /// as a goal of `NavigateToPose`, and commands the base with the velocities that Nav2 publishes. When it loses the base, it
    /// cancels the goal, and sends it again when it wins. A goal that Nav2 rejects is sent again for 30 s, because Nav2 rejects
    /// all of them until it is active.
    #[schema(motor, period = "50ms", budget = "10ms")]
    pub struct Navigate {
        /// The action of Nav2.
        #[modulation(default = "navigate_to_pose", fixed)]
        action: Modulation<Text<128>>,
        /// The topic of Nav2's velocities, which must not reach the base by another way.
        #[modulation(default = "nav/cmd_vel", fixed)]
        topic: Modulation<Text<128>>,
        /// The clock of the stamps: `wall`, or `follow` for that of `/clock`.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// The frame of the target.
        #[modulation(default = "map")]
        frame: Modulation<Text<52>>,
        /// Oldest velocity that counts; longer than the time between two velocities.
        #[modulation(default = 0.5, unit = "s", min = 0.01, max = 3600.0)]
        patience: Modulation<f64>,
        /// Where to drive.
        #[modulation(default = Target::NONE)]
        target: Modulation<Target>,
        /// The target, if another schema chooses it; it replaces the modulation. A target that is chosen again later
        /// is driven to again.
        #[import(optional)]
        chosen: Import<Target>,
        /// Speeds of the base.
        #[actuator]
        base: Actuator<Twist>,
        /// Progress: DONE or FAILED for the newest target.
        #[export(lasting)]
        mission: Export<Mission>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveNavigate>,
    }
}

/// The node, and what it knows of the target.
struct ActiveNavigate {
    connection: RosConnection,
    client: ActionClient,
    middleware: Middleware,
    velocities: VelocitySubscription,
    newest: Option<(Twist, Duration)>,
    /// The newest target.
    target: Option<Pose2D>,
    /// Whether the present goal is the newest target, and whether Nav2 has accepted it.
    is_sent: bool,
    is_accepted: bool,
    /// When Nav2 rejected the newest target first, and when it is sent again.
    rejected: Option<(Duration, Duration)>,
    /// Whether the newest target was reached, or why it was given up.
    outcome: Option<Result<(), String>>,
    /// What Nav2 lacks.
    missing: Option<String>,
    distance: f64,
    reached: u32,
    /// The checks since the last iteration.
    checks: u32,
    exported: Option<Mission>,
}

impl Schema for Navigate {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.active = Some(self.with_settings(cx, |settings| self.start(cx, &settings))?);
        }
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let target = self.target(cx);
        let Some(active) = &mut self.active else {
            return Ok(false.into());
        };
        active.connection.begin(cx, self.clock.get(cx).into());
        active.choose(target);
        active.receive(cx);
        active.checks += 1;
        if active.checks >= MAX_LOST_CHECKS || active.target.is_none() {
            active.client.cancel(&active.connection.node);
            active.is_sent = false;
        }
        let mission = active.mission(cx.now(), self.patience.get(cx));
        let last = active.exported.replace(mission);
        if last != Some(mission) {
            self.mission.write(cx, mission);
        }
        if last.is_none_or(|last| last.note != mission.note) {
            match mission.state {
                Mission::FAILED => warn!(cx, "{}", mission.note),
                _ => info!(cx, "{}", mission.note),
            }
        }
        let missing = active.missing.as_deref();
        active
            .connection
            .export_connection(cx, &mut self.connection, missing);
        Ok(active.is_ready().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let (frame, patience) = (self.frame.get(cx), self.patience.get(cx));
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        active.checks = 0;
        let Some(target) = active.target else {
            return Ok(());
        };
        let node = &active.connection.node;
        let may_send = active.rejected.is_none_or(|(_, again)| cx.now() >= again);
        if !active.is_sent && may_send {
            let stamp = active.connection.clock.stamp(cx.now());
            let pose = goal::stamped(target, frame.as_str(), stamp);
            let goal = goal::encode(active.middleware, "Goal", &json!({ "pose": pose }));
            active.client.send(node, &goal);
            (active.is_sent, active.is_accepted) = (true, false);
        }
        if let Some(twist) = active.velocity(cx.now(), patience) {
            self.base.command(cx, twist);
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(mut active) = self.active.take() {
            active.client.cancel(&active.connection.node);
            active.connection.close(cx, &mut self.connection);
            self.mission.retract(cx);
        }
    }
}

impl Inspect for Navigate {
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
        if self.topic.get(cx).is_empty() {
            problems.wrong(&self.topic, NO_TOPIC);
        }
    }
}

impl Navigate {
    fn target(&self, cx: &Context) -> Option<Pose2D> {
        let target = match self.chosen.is_bound(cx) {
            true => self.chosen.get(cx).and_then(|target| target.get()),
            false => self.target.get(cx).get(),
        };
        target.filter(Pose2D::is_finite)
    }

    fn start(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveNavigate> {
        goal::refuse_bridge(settings)?;
        let node = settings.node_config()?;
        let (name, middleware) = (self.action.get(cx), node.name.middleware);
        let action = goal::action(&node.name.namespace, name.as_str(), middleware)?;
        let topic = names::topic(&node.name.namespace, self.topic.get(cx).as_str())?;
        let topic = topic.ok_or(NO_TOPIC)?;
        let mut config = NodeConfig {
            subscriptions: velocity::topics(&topic, Quality::DEFAULT).to_vec(),
            ..node
        };
        Ok(ActiveNavigate {
            client: ActionClient::declare(action, ACCEPT_TIMEOUT, &mut config),
            middleware,
            velocities: VelocitySubscription::new(0, &topic),
            connection: RosConnection::start(config, self.clock.get(cx).into())?,
            newest: None,
            target: None,
            is_sent: false,
            is_accepted: false,
            rejected: None,
            outcome: None,
            missing: None,
            distance: 0.0,
            reached: 0,
            checks: 0,
            exported: None,
        })
    }
}

impl ActiveNavigate {
    /// Takes the newest target. Another one has no outcome yet.
    fn choose(&mut self, target: Option<Pose2D>) {
        if self.target != target {
            (self.target, self.outcome, self.is_sent) = (target, None, false);
            (self.rejected, self.distance) = (None, 0.0);
        }
    }

    /// Takes the newest velocity, and what has happened to the goal.
    fn receive(&mut self, cx: &Context) {
        let received = self.velocities.receive(cx, &mut self.connection);
        self.newest = received.or(self.newest);
        for event in self.client.poll(&self.connection.node) {
            match event {
                GoalEvent::Feedback(feedback) => {
                    if let Ok(feedback) = goal::decode(self.middleware, "Feedback", &feedback) {
                        self.distance = feedback["distance_remaining"].as_f64().unwrap_or_default();
                    }
                }
                GoalEvent::NotCanceled => {
                    let name = self.client.name();
                    self.connection.warn_once(
                        cx,
                        format!("{name} refuses to cancel a goal, and goes on with it"),
                    );
                }
                // The goal of an earlier target, or one that was canceled here.
                _ if !self.is_sent => {}
                GoalEvent::Accepted => (self.rejected, self.is_accepted) = (None, true),
                GoalEvent::Rejected => self.reject(cx.now()),
                GoalEvent::Ended(GoalStatus::Succeeded, _) => self.end(Ok(())),
                GoalEvent::Ended(GoalStatus::Canceled, _) => {
                    self.end(Err("another program canceled it".to_owned()));
                }
                GoalEvent::Ended(_, result) => {
                    let ended = goal::decode(self.middleware, "GetResult_Response", &result);
                    let result = &ended.unwrap_or_default()["result"];
                    let text = result["error_msg"].as_str().unwrap_or_default();
                    // Nav2 of Humble states no error.
                    let why = result["error_code"]
                        .as_u64()
                        .map(|code| format!(": error {code} {text}"));
                    let why = why.unwrap_or_default();
                    self.end(Err(format!("Nav2 gave up{}", why.trim_end())));
                }
                GoalEvent::Lost(why) => {
                    self.connection.warn_once(cx, why);
                    self.is_sent = false;
                }
            }
        }
        let is_missing = !self.client.has_server(&self.connection.node);
        self.missing = is_missing.then(|| self.client.name().to_owned());
    }

    fn reject(&mut self, now: Duration) {
        let since = self.rejected.map_or(now, |(since, _)| since);
        (self.rejected, self.is_sent) = (Some((since, now + RETRY_INTERVAL)), false);
        if now >= since + RETRY_TIME {
            self.end(Err("Nav2 rejects the target".to_owned()));
        }
    }

    fn end(&mut self, outcome: Result<(), String>) {
        self.reached += u32::from(outcome.is_ok());
        (self.outcome, self.is_sent) = (Some(outcome), false);
    }

    fn is_ready(&self) -> bool {
        self.target.is_some() && self.outcome.is_none() && self.missing.is_none()
    }

    /// Nav2's newest velocity, if it is no older than `patience` in s.
    fn velocity(&self, now: Duration, patience: f64) -> Option<Twist> {
        let (twist, time) = self.newest?;
        (now.saturating_sub(time).as_secs_f64() <= patience).then_some(twist)
    }

    fn mission(&self, now: Duration, patience: f64) -> Mission {
        let (state, note) = match (&self.outcome, &self.missing) {
            (Some(Ok(())), _) => (Mission::DONE, String::from("reached")),
            (Some(Err(why)), _) => (Mission::FAILED, why.clone()),
            (None, Some(name)) => (Mission::RUNNING, format!("no node offers {name}")),
            (None, None) if self.target.is_none() => (Mission::RUNNING, String::from("no target")),
            (None, None) if self.is_sent => {
                let has_velocity = self.velocity(now, patience).is_some();
                let note = match (self.is_accepted, has_velocity) {
                    (false, _) => "Nav2 has not answered yet",
                    (true, true) => "Nav2 drives",
                    (true, false) => "Nav2 has the target, and commands no velocity",
                };
                (Mission::RUNNING, String::from(note))
            }
            (None, None) if self.rejected.is_some() => (
                Mission::RUNNING,
                String::from("Nav2 rejects the target, and is asked again"),
            ),
            (None, None) => (Mission::RUNNING, String::from("waits for the base")),
        };
        Mission {
            state,
            reached: self.reached,
            total: self.reached + u32::from(self.target.is_some() && state != Mission::DONE),
            note: Text::truncated(&note),
            target: self.target.unwrap_or(Pose2D::ORIGIN),
            distance: self.distance,
            ..Mission::default()
        }
    }
}
