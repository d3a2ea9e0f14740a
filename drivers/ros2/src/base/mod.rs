//! A ROS 2 robot as a base, behind the same ports as the simulated and the real Pioneer, so that an
//! application changes only the driver's lines. The conversion of messages is in `active`.

mod active;
mod hazards;
mod sonars;

use jde_ros_node::{NodeConfig, Quality, Settings, Topic, names};
use jde_schema::prelude::*;
use jde_schema::types::Route;

use crate::clock_source::FollowedClock;
use crate::connection::{RosConnection, TopicSubscription, arrival};
use crate::drive::Drive;
use crate::messages::Codec;
use crate::scan::{Reading, Sweep};
use crate::settings::node_schema;
use crate::velocity::{self, VelocityPublisher};
use active::{ActiveBase, BATTERY};
pub(crate) use hazards::HazardDetectionVector;
#[cfg(test)]
pub(crate) use hazards::{BUMP, HazardDetection};
use sonars::Sonars;

/// Those of most robots for rooms: an application for a faster robot states its own.
const LIMITS: Twist = Twist {
    linear: Vector3 {
        x: 1.0,
        y: 1.0,
        z: 0.0,
    },
    ..Twist::planar(0.0, 2.0)
};

node_schema! {
    /// A ROS 2 robot as a base: it exports the robot's topics, and publishes the commanded velocity.
    ///
    /// A topic's name is relative to the namespace unless it begins with `/`; an empty name switches the topic
    /// off. An export is retracted when its topic falls silent, and returns with the next message.
    #[schema(driver, period = "20ms", budget = "20ms")]
    pub struct Base {
        /// Topic of the laser.
        #[modulation(default = "scan", fixed)]
        laser_topic: Modulation<Text<128>>,
        /// Topic of the odometry.
        #[modulation(default = "odom", fixed)]
        odometry_topic: Modulation<Text<128>>,
        /// Topic of the camera.
        #[modulation(default = "", fixed)]
        image_topic: Modulation<Text<128>>,
        /// Topic of the depths of a camera.
        #[modulation(default = "", fixed)]
        depth_topic: Modulation<Text<128>>,
        /// Topic of the inertial unit.
        #[modulation(default = "imu", fixed)]
        imu_topic: Modulation<Text<128>>,
        /// Topic of the measured position.
        #[modulation(default = "position", fixed)]
        position_topic: Modulation<Text<128>>,
        /// Topic of the battery.
        #[modulation(default = "battery_state", fixed)]
        battery_topic: Modulation<Text<128>>,
        /// Topic of the hazards of a Create 3, which have the bumpers: `irobot_create_msgs/msg/HazardDetectionVector`.
        #[modulation(default = "", fixed)]
        hazard_topic: Modulation<Text<128>>,
        /// Topics of the sonars, with commas between: `sensor_msgs/msg/Range` of one sonar each.
        #[modulation(default = "", fixed)]
        sonar_topics: Modulation<Text<1024>>,
        /// Their poses on the base, in the same order.
        #[modulation(default = Route { poses: Seq::new() }, fixed)]
        sonar_mounts: Modulation<Route>,
        /// Topic of the velocity.
        #[modulation(default = "cmd_vel", fixed)]
        velocity_topic: Modulation<Text<128>>,
        /// The clock of the stamps: `wall`, or `follow` for that of `/clock`, which a simulator of ROS 2 publishes.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// Angle by which the laser is turned to the left on the base.
        #[modulation(default = 0.0, unit = "rad", fixed)]
        laser_yaw: Modulation<f64>,
        /// Whether +∞, or the greatest range, says that nothing is within reach. Many drivers say it also where no return came
        /// back; then it says nothing.
        #[modulation(default = Flag::FALSE)]
        inf_is_valid: Modulation<Flag>,
        /// Time after which an export without a new message is retracted, and the age from which a message is not taken, if its
        /// stamp can be compared; ten times as long for the battery.
        #[modulation(default = 1.0, unit = "s", min = 0.01, max = 5.0)]
        stale: Modulation<f64>,
        /// Greatest speeds that any command asks of the base, in either direction; 0 limits none.
        #[modulation(default = LIMITS, fixed)]
        #[expect(dead_code, reason = "the host applies them to each command")]
        velocity_limits: Modulation<Twist>,
        /// Speeds of the base.
        #[command(neutral = Twist::ZERO, validity = "500ms", trigger)]
        velocity: Command<Twist>,
        /// The scan of the laser. If it has more beams than fit, groups of adjacent beams are replaced by their
        /// nearest.
        #[export(validity = "5s")]
        laser: Export<LaserScan>,
        /// Pose and velocity from the wheels.
        #[export(validity = "5s")]
        odometry: Export<Odometry>,
        /// The picture of the camera.
        #[export(validity = "5s")]
        image: Export<Image>,
        /// The depths of a camera.
        #[export(validity = "5s")]
        depth: Export<Image>,
        /// The measurements of the inertial unit.
        #[export(validity = "5s")]
        imu: Export<Imu>,
        /// The measured position.
        #[export(validity = "5s")]
        position: Export<PositionFix>,
        /// The state of the battery.
        #[export(lasting)]
        battery: Export<BatteryState>,
        /// The bumpers, and whether the wheels are blocked.
        #[export(validity = "5s")]
        bumpers: Export<Bumpers>,
        /// The ranges of the sonars. The range of a silent sonar is not a number.
        #[export(validity = "5s")]
        sonars: Export<RangeRing>,
        /// Whether messages of the robot arrive.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveBase>,
    }
}

impl Schema for Base {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.active = Some(self.start(cx)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        active.connection.begin(cx, self.clock.get(cx).into());
        active.stale = Duration::from_secs_f64(self.stale.get(cx));
        let reading = Reading {
            yaw: self.laser_yaw.get(cx) as f32,
            inf_is_valid: self.inf_is_valid.get(cx).get(),
        };
        active.publish_scan(cx, &mut self.laser, reading);
        active.publish_odometry(cx, &mut self.odometry);
        active.publish_images(cx, [&mut self.image, &mut self.depth]);
        active.publish_imu(cx, &mut self.imu);
        active.publish_position(cx, &mut self.position);
        active.publish_battery(cx, &mut self.battery);
        active.publish_bumpers(cx, &mut self.bumpers);
        let (from, stale) = (&active.connection, active.stale);
        retract_if_silent(cx, from, &mut active.laser, stale, || self.laser.retract(cx));
        retract_if_silent(cx, from, &mut active.odometry, stale, || {
            self.odometry.retract(cx)
        });
        retract_if_silent(cx, from, &mut active.image, stale, || self.image.retract(cx));
        retract_if_silent(cx, from, &mut active.depth, stale, || self.depth.retract(cx));
        retract_if_silent(cx, from, &mut active.imu, stale, || self.imu.retract(cx));
        retract_if_silent(cx, from, &mut active.position, stale, || {
            self.position.retract(cx)
        });
        retract_if_silent(cx, from, &mut active.hazards, stale, || self.bumpers.retract(cx));
        retract_if_silent(cx, from, &mut active.battery, stale * BATTERY, || {
            self.battery.retract(cx)
        });
        let sonars = &mut active.sonars;
        sonars.publish(cx, &mut active.connection, &mut self.sonars, stale);
        // While the time of a simulation stands, nobody sees where the robot goes.
        let command = self.velocity.get(cx);
        let counts = command.in_force() && !active.connection.is_timeless();
        active.drive(cx, counts.then_some(*command));
        active.report_missing(cx);
        let missing = (!active.has_received()).then_some("robot");
        active
            .connection
            .export_connection(cx, &mut self.connection, missing);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(mut active) = self.active.take() {
            active.stop(cx);
            active.connection.close(cx, &mut self.connection);
            self.laser.retract(cx);
            self.odometry.retract(cx);
            self.image.retract(cx);
            self.depth.retract(cx);
            self.imu.retract(cx);
            self.position.retract(cx);
            self.battery.retract(cx);
            self.bumpers.retract(cx);
            self.sonars.retract(cx);
        }
    }
}

impl Inspect for Base {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let topics = [
            &self.laser_topic,
            &self.odometry_topic,
            &self.image_topic,
            &self.depth_topic,
            &self.imu_topic,
            &self.position_topic,
            &self.battery_topic,
            &self.hazard_topic,
            &self.velocity_topic,
        ];
        self.inspect_node(cx, &topics, problems);
        let (topics, mounts) = (self.sonar_topics.get(cx), self.sonar_mounts.get(cx));
        let namespace = names::namespace(self.namespace.get(cx).as_str()).unwrap_or_default();
        for name in sonars::names(topics.as_str()) {
            problems.expect(&self.sonar_topics, names::topic(&namespace, name));
        }
        problems.expect(&self.sonar_mounts, sonars::check(topics.as_str(), &mounts));
    }
}

impl Base {
    fn start(&self, cx: &Context) -> Result<ActiveBase> {
        self.with_settings(cx, |settings| self.start_with(cx, &settings))
    }

    fn start_with(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveBase> {
        let node = settings.node_config()?;
        let mut topics = Vec::new();
        let namespace = node.name.namespace.as_str();
        let laser = subscription(&mut topics, namespace, self.laser_topic.get(cx).as_str())?;
        let odometry = subscription(&mut topics, namespace, self.odometry_topic.get(cx).as_str())?;
        let image = subscription(&mut topics, namespace, self.image_topic.get(cx).as_str())?;
        let depth = subscription(&mut topics, namespace, self.depth_topic.get(cx).as_str())?;
        let imu = subscription(&mut topics, namespace, self.imu_topic.get(cx).as_str())?;
        let position = subscription(&mut topics, namespace, self.position_topic.get(cx).as_str())?;
        let battery = subscription(&mut topics, namespace, self.battery_topic.get(cx).as_str())?;
        let hazards = subscription(&mut topics, namespace, self.hazard_topic.get(cx).as_str())?;
        let list = self.sonar_topics.get(cx);
        let mounts = sonars::check(list.as_str(), &self.sonar_mounts.get(cx))?;
        let mut sonars = Vec::new();
        for name in sonars::names(list.as_str()) {
            sonars.extend(subscription(&mut topics, namespace, name)?);
        }
        let velocity = names::topic(namespace, self.velocity_topic.get(cx).as_str())?;
        let config = NodeConfig {
            publications: velocity
                .iter()
                .flat_map(|topic| velocity::topics(topic, Quality::DEFAULT))
                .collect(),
            subscriptions: topics,
            arrival: arrival(cx),
            ..node
        };
        let connection = RosConnection::start(config, self.clock.get(cx).into())?;
        Ok(ActiveBase {
            connection,
            laser,
            odometry,
            image,
            depth,
            imu,
            position,
            battery,
            hazards,
            sonars: Sonars::new(sonars, mounts),
            velocity: velocity.map(|_| VelocityPublisher::new(0)),
            drive: Drive::default(),
            moves: false,
            since: None,
            stale: Duration::ZERO,
            sweep: Box::new(Sweep::zeroed()),
        })
    }
}

/// Adds a subscription to that topic, unless its name is empty.
fn subscription<T: Value>(
    topics: &mut Vec<Topic>,
    namespace: &str,
    name: &str,
) -> Result<Option<TopicSubscription<T>>> {
    let Some(topic) = names::topic(namespace, name)? else {
        return Ok(None);
    };
    if topics.iter().any(|other| other.name == topic) {
        return Err(format!(
            "two of its topics have the name {topic}; rename one of them, or set it to \"\""
        )
        .into());
    }
    let codec = Codec::new();
    topics.push(Topic {
        has_one_source: true,
        ..codec.topic(topic.clone(), Quality::SENSOR_DATA)
    });
    Ok(Some(TopicSubscription::new(topics.len() - 1, topic, codec)))
}

/// Retracts an export if its topic has just fallen silent, or what came from it has ended.
fn retract_if_silent<T: Value>(
    cx: &Context,
    connection: &RosConnection,
    subscription: &mut Option<TopicSubscription<T>>,
    timeout: Duration,
    retract: impl FnOnce(),
) {
    if subscription
        .as_mut()
        .is_some_and(|subscription| subscription.falls_silent(cx, connection, timeout))
    {
        retract();
    }
}
