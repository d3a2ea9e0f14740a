//! A watchdog of a ROS 2 robot: it runs in a process of its own, and stops a robot whose velocities have ceased, as when
//! the program that gave them was killed. It never drives, and is silent while anybody gives velocities.

use jde_ros_node::{NodeConfig, Quality, Settings, Topic, names};
use jde_schema::prelude::*;

use crate::clock_source::FollowedClock;
use crate::connection::{RosConnection, arrival};
use crate::drive::{MIN_STOP_TIME, REPEAT_INTERVAL};
use crate::settings::node_schema;
use crate::velocity::{self, VelocityPublisher, VelocitySubscription};

node_schema! {
    /// Stops a robot whose velocities have ceased, for robots whose own node keeps the last one.
    ///
    /// It listens to the topic of the robot's velocity. When the newest one moves the robot, and none has followed it for
    /// `timeout`, it is READY, and publishes zeros until another program publishes a velocity there. Before the first
    /// velocity it knows of no motion, and does nothing.
    #[schema(motor, period = "20ms", budget = "10ms")]
    pub struct Watchdog {
        /// The topic of the robot's velocity, `Twist` or `TwistStamped`.
        #[modulation(default = "cmd_vel", fixed)]
        topic: Modulation<Text<128>>,
        /// Time without a velocity after which it publishes zeros; longer than the time between two velocities.
        #[modulation(default = 0.5, unit = "s", min = 0.01, max = 60.0)]
        timeout: Modulation<f64>,
        /// The clock of the stamps: `wall`, or `follow` for that of `/clock`, which a simulator of ROS 2 publishes.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// The newest velocity of another program.
        #[export(validity = "500ms")]
        velocity: Export<Twist>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveWatchdog>,
    }
}

/// The node, and what it has heard.
struct ActiveWatchdog {
    connection: RosConnection,
    subscription: VelocitySubscription,
    publisher: VelocityPublisher,
    /// The topic's full name.
    topic: String,
    /// The newest velocity of another program, and its arrival.
    newest: Option<(Twist, Duration)>,
    /// Since when it publishes zeros, and when the next one is due.
    zeros: Option<(Duration, Duration)>,
}

impl Schema for Watchdog {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.active = Some(self.with_settings(cx, |settings| self.start_with(cx, &settings))?);
        }
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let (clock, timeout) = (self.clock.get(cx), Duration::from_secs_f64(self.timeout.get(cx)));
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        active.connection.begin(cx, clock.into());
        let received = active.subscription.receive(cx, &mut active.connection);
        if let Some((twist, arrived)) = received {
            self.velocity.write_at(cx, twist, arrived);
        }
        active.newest = received.or(active.newest);
        let must_stop = active.judge(cx, timeout);
        active
            .connection
            .export_connection(cx, &mut self.connection, None);
        Ok(must_stop.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        if let Some(active) = &mut self.active {
            active.stop(cx);
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(active) = self.active.take() {
            active.connection.close(cx, &mut self.connection);
            self.velocity.retract(cx);
        }
    }
}

impl Inspect for Watchdog {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        if self.topic.get(cx).is_empty() {
            problems.wrong(
                &self.topic,
                "no topic: state that of the robot's velocity, as in \"cmd_vel\"",
            );
        }
        self.inspect_node(cx, &[&self.topic], problems);
    }
}

impl Watchdog {
    fn start_with(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveWatchdog> {
        let node = settings.node_config()?;
        let topic = names::topic(&node.name.namespace, self.topic.get(cx).as_str())?.unwrap_or_default();
        let topics = velocity::topics(&topic, Quality::DEFAULT).map(|topic| Topic {
            is_command: false,
            is_standby: true,
            ..topic
        });
        let config = NodeConfig {
            publications: topics.to_vec(),
            subscriptions: topics.to_vec(),
            arrival: arrival(cx),
            ..node
        };
        Ok(ActiveWatchdog {
            connection: RosConnection::start(config, self.clock.get(cx).into())?,
            subscription: VelocitySubscription::new(0, &topic),
            publisher: VelocityPublisher::new(0),
            topic,
            newest: None,
            zeros: None,
        })
    }
}

impl ActiveWatchdog {
    /// Returns whether the robot must be stopped: velocities have ceased after one that moves it. A zero of others, which
    /// another watchdog may have published, ends that after a while, and any other velocity at once.
    fn judge(&mut self, cx: &Context, timeout: Duration) -> bool {
        let now = cx.now();
        let must_stop = self
            .newest
            .is_some_and(|(twist, arrived)| match twist == Twist::ZERO {
                true => self.zeros.is_some_and(|(since, _)| now < since + MIN_STOP_TIME),
                false => now > arrived + timeout,
            });
        match (must_stop, self.zeros) {
            (true, None) => {
                self.zeros = Some((now, now));
                warn!(
                    cx,
                    "no velocity has come on {} for {:.2} s: zeros are published until one comes",
                    self.topic,
                    timeout.as_secs_f64()
                );
            }
            (false, Some(_)) => {
                self.zeros = None;
                info!(cx, "velocities come on {} again: no more zeros", self.topic);
            }
            (true, Some(_)) | (false, None) => {}
        }
        must_stop
    }

    /// Publishes a zero if one is due.
    fn stop(&mut self, cx: &Context) {
        if let Some((since, due)) = self.zeros.filter(|(_, due)| *due <= cx.now()) {
            self.publisher.publish(cx, &self.connection, &Twist::ZERO);
            self.zeros = Some((since, (due + REPEAT_INTERVAL).max(cx.now())));
        }
    }
}
