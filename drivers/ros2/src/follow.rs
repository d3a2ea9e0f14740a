//! The motor schema through which a ROS 2 program drives a robot. It competes like any other (R13), so the
//! application can give a brake or a person precedence, and decide between several programs.

use jde_ros_node::{NodeConfig, Quality, Settings, names};
use jde_schema::prelude::*;

use crate::clock_source::ClockSource;
use crate::connection::{RosConnection, arrival};
use crate::settings::node_schema;
use crate::velocity::{self, VelocitySubscription};

node_schema! {
    /// Drives the base with a velocity from another program while it is fresh.
    ///
    /// The velocity is that of the import, or of a topic of its own. With a topic the schema is a node of ROS 2
    /// while it is awake, so that an application needs nothing else to decide between several programs.
    #[schema(motor, period = "20ms", budget = "10ms")]
    pub struct Follow {
        /// The topic of the velocities, `Twist` or `TwistStamped`, if the import is not bound.
        #[modulation(default = "", fixed)]
        topic: Modulation<Text<128>>,
        /// Oldest velocity that counts; longer than the time between two velocities.
        #[modulation(default = 0.5, unit = "s", min = 0.01, max = 3600.0)]
        patience: Modulation<f64>,
        /// The velocity.
        #[import(optional, trigger)]
        cmd_vel: Import<Twist>,
        /// Speeds of the base.
        #[actuator]
        base: Actuator<Twist>,
        /// Whether the router or other nodes are connected, if it has a topic.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveFollow>,
    }
}

/// The node of a schema with a topic.
struct ActiveFollow {
    connection: RosConnection,
    subscription: VelocitySubscription,
    newest: Option<(Twist, Duration)>,
}

impl Schema for Follow {
    fn awake(&mut self, cx: &Context) -> Result {
        // Without a source it is never READY, and its inspection says why.
        if self.active.is_none() && !self.cmd_vel.is_bound(cx) && !self.topic.get(cx).is_empty() {
            cx.require_real_time()?;
            self.active = Some(self.with_settings(cx, |settings| self.start_with(cx, &settings))?);
        }
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        if let Some(active) = &mut self.active {
            active.connection.begin(cx, ClockSource::Wall);
            let received = active.subscription.receive(cx, &mut active.connection);
            active.newest = received.or(active.newest);
            active
                .connection
                .export_connection(cx, &mut self.connection, None);
        }
        Ok(self.fresh(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        if let Some(twist) = self.fresh(cx) {
            self.base.command(cx, twist);
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(active) = self.active.take() {
            active.connection.close(cx, &mut self.connection);
        }
    }
}

impl Inspect for Follow {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.topic, self.expect_one_source(cx));
        self.inspect_node(cx, &[&self.topic], problems);
    }
}

impl Follow {
    fn expect_one_source(&self, cx: &Context) -> Result<(), &'static str> {
        match (self.cmd_vel.is_bound(cx), self.topic.get(cx).is_empty()) {
            (true, true) | (false, false) => Ok(()),
            (true, false) => Err("bind the import `cmd_vel` or state a topic, not both"),
            (false, true) => {
                Err("no velocity: state a topic, as in \"/cmd_vel\", or bind the import `cmd_vel`")
            }
        }
    }

    fn start_with(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveFollow> {
        let node = settings.node_config()?;
        let topic = names::topic(&node.name.namespace, self.topic.get(cx).as_str())?.unwrap_or_default();
        let config = NodeConfig {
            subscriptions: velocity::topics(&topic, Quality::DEFAULT).to_vec(),
            arrival: arrival(cx),
            ..node
        };
        Ok(ActiveFollow {
            connection: RosConnection::start(config, ClockSource::Wall)?,
            subscription: VelocitySubscription::new(0, &topic),
            newest: None,
        })
    }

    fn fresh(&self, cx: &Context) -> Option<Twist> {
        let (twist, time) = match &self.active {
            Some(active) => active.newest?,
            None => self.cmd_vel.get(cx).map(|sample| (*sample, sample.time()))?,
        };
        let age = cx.now().saturating_sub(time);
        (age.as_secs_f64() <= self.patience.get(cx)).then_some(twist)
    }
}
