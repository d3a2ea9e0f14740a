//! The topics of a jde robot: its sensors are published, and velocities from ROS 2 are exported for a motor
//! schema.

mod publisher;

use jde_ros_node::{NodeConfig, Quality, Settings, names};
use jde_schema::prelude::*;

use crate::connection::RosConnection;
use crate::messages::PoseWithCovarianceStamped;
use crate::settings::{Modulations, with_settings};
use crate::tf::{Transforms, range_messages};
use crate::velocity::{self, VelocitySubscription};
use publisher::{Publications, Spread, TopicPublisher, publish_new, take_due};

/// Publishes a robot in ROS 2. Each bound import is published on its topic when it is new and has
/// subscribers. Velocities from ROS 2 are exported for `ros2/follow`.
///
/// A topic's name is relative to the namespace unless it begins with `/`; an empty name switches the topic
/// off.
#[derive(Describe)]
#[schema(driver, period = "20ms", budget = "20ms")]
pub struct Topics {
    /// The router of ROS 2, or other nodes, to connect to; separated by commas.
    #[modulation(default = "tcp/localhost:7447", fixed)]
    connect: Modulation<Text<512>>,
    /// Addresses at which other nodes can connect, such as "tcp/localhost:7448"; if empty, all messages pass
    /// through the router.
    #[modulation(default = "", fixed)]
    listen: Modulation<Text<512>>,
    /// A Zenoh configuration file instead of these two, for TLS, passwords and other settings.
    #[modulation(default = "", unit = "path", fixed)]
    config: Modulation<Text<1024>>,
    /// Domain; -1 for the environment's ROS_DOMAIN_ID, or 0 without one.
    #[modulation(default = -1, min = -1.0, max = 232.0, fixed)]
    domain: Modulation<i32>,
    /// Namespace of the node and its topics.
    #[modulation(default = "", fixed)]
    namespace: Modulation<Text<128>>,
    /// Name of the node; empty for that of this schema.
    #[modulation(default = "", fixed)]
    node: Modulation<Text<128>>,
    /// Topic of the laser.
    #[modulation(default = "scan", fixed)]
    laser_topic: Modulation<Text<128>>,
    /// Topic of the odometry.
    #[modulation(default = "odom", fixed)]
    odometry_topic: Modulation<Text<128>>,
    /// Topic of the camera.
    #[modulation(default = "image", fixed)]
    image_topic: Modulation<Text<128>>,
    /// Topic of the sonars: one message per sonar, in frames `sonar_0`, `sonar_1` and so on.
    #[modulation(default = "sonar", fixed)]
    sonars_topic: Modulation<Text<128>>,
    /// Topic of the battery.
    #[modulation(default = "battery_state", fixed)]
    battery_topic: Modulation<Text<128>>,
    /// Topic of the depths of a camera.
    #[modulation(default = "depth/image", fixed)]
    depth_topic: Modulation<Text<128>>,
    /// Topic of the inertial unit.
    #[modulation(default = "imu", fixed)]
    imu_topic: Modulation<Text<128>>,
    /// Topic of the measured position.
    #[modulation(default = "position", fixed)]
    position_topic: Modulation<Text<128>>,
    /// Topic of the transforms between frames: the base by the odometry, and on it the laser and the sonars.
    #[modulation(default = "/tf", fixed)]
    tf_topic: Modulation<Text<128>>,
    /// Topic of the velocities from ROS 2.
    #[modulation(default = "cmd_vel", fixed)]
    cmd_vel_topic: Modulation<Text<128>>,
    /// Pose of the laser on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    laser_mount: Modulation<Pose2D>,
    /// Time after which a velocity without a successor is retracted.
    #[modulation(default = 0.5, unit = "s", min = 0.01, max = 3600.0)]
    stale: Modulation<f64>,
    /// The scan of a laser.
    #[import(optional)]
    laser: Import<LaserScan>,
    /// Pose and velocity from the wheels.
    #[import(optional)]
    odometry: Import<Odometry>,
    /// The picture of a camera.
    #[import(optional)]
    image: Import<Image>,
    /// The ranges of the sonars.
    #[import(optional)]
    sonars: Import<RangeRing>,
    /// The state of the battery.
    #[import(optional)]
    battery: Import<BatteryState>,
    /// The depths of a camera.
    #[import(optional)]
    depth: Import<Image>,
    /// The measurement of the inertial unit.
    #[import(optional)]
    imu: Import<Imu>,
    /// The measured position.
    #[import(optional)]
    position: Import<PositionFix>,
    /// The velocity from ROS 2, while it is fresh.
    #[export]
    cmd_vel: Export<Twist>,
    /// Whether the router or other nodes are connected.
    #[export]
    connection: Export<Connection>,
    active: Option<ActiveTopics>,
}

/// The node with its topics.
struct ActiveTopics {
    connection: RosConnection,
    laser: Option<TopicPublisher<LaserScan>>,
    odometry: Option<TopicPublisher<Odometry>>,
    image: Option<TopicPublisher<Image>>,
    depth: Option<TopicPublisher<Image>>,
    sonars: Option<TopicPublisher<Range>>,
    /// The messages of the newest ring that were not sent yet.
    ranges: Spread,
    battery: Option<TopicPublisher<BatteryState>>,
    imu: Option<TopicPublisher<Imu>>,
    position: Option<TopicPublisher<PoseWithCovarianceStamped>>,
    tf: Option<TopicPublisher<Transforms>>,
    cmd_vel: Option<VelocitySubscription>,
}

impl Schema for Topics {
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
        active.connection.begin(cx);
        let (node, clock) = (&active.connection.node, &active.connection.clock);
        let (laser, odometry, sonars) = (self.laser.get(cx), self.odometry.get(cx), self.sonars.get(cx));
        publish_new(node, clock, &mut active.laser, laser);
        publish_new(node, clock, &mut active.odometry, odometry);
        publish_new(node, clock, &mut active.image, self.image.get(cx));
        publish_new(node, clock, &mut active.depth, self.depth.get(cx));
        publish_new(node, clock, &mut active.battery, self.battery.get(cx));
        publish_new(node, clock, &mut active.imu, self.imu.get(cx));
        if let Some((publisher, fix)) = take_due(node, &mut active.position, self.position.get(cx)) {
            let pose = PoseWithCovarianceStamped::from(&*fix);
            let message = publisher.codec.encode_stamped(&pose, fix.time(), clock);
            node.publish(publisher.number, vec![message]);
        }
        if active.ranges.is_empty()
            && let Some((publisher, ring)) = take_due(node, &mut active.sonars, sonars)
        {
            let message = |(range, _)| publisher.codec.encode_stamped(&range, ring.time(), clock);
            active.ranges = Spread::new(range_messages(&ring).map(message).collect());
        }
        if let Some(publisher) = &active.sonars
            && !active.ranges.is_empty()
            && node.has_sent(publisher.number)
        {
            node.publish(publisher.number, active.ranges.part());
        }
        if let Some((publisher, odometry)) = take_due(node, &mut active.tf, odometry) {
            let mut tree = Transforms::of(&odometry, odometry.time(), clock);
            if let Some(laser) = laser {
                tree.mount(laser.header.frame_id, self.laser_mount.get(cx));
            }
            if let Some(sonars) = sonars.filter(|_| active.sonars.is_some()) {
                range_messages(&sonars).for_each(|(range, pose)| tree.mount(range.header.frame_id, pose));
            }
            node.publish(publisher.number, vec![publisher.codec.encode(&tree)]);
        }
        if let Some(subscription) = &mut active.cmd_vel {
            if let Some((twist, arrived)) = subscription.receive(cx, &mut active.connection) {
                self.cmd_vel.write_at(cx, twist, arrived);
            }
            if subscription.falls_silent(cx.now(), Duration::from_secs_f64(self.stale.get(cx))) {
                self.cmd_vel.retract(cx);
            }
        }
        active
            .connection
            .export_connection(cx, &mut self.connection, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(active) = self.active.take() {
            active.connection.close(cx, &mut self.connection);
            self.cmd_vel.retract(cx);
        }
    }
}

impl Inspect for Topics {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let topics = [
            &self.laser_topic,
            &self.odometry_topic,
            &self.image_topic,
            &self.depth_topic,
            &self.sonars_topic,
            &self.battery_topic,
            &self.imu_topic,
            &self.position_topic,
            &self.tf_topic,
            &self.cmd_vel_topic,
        ];
        let modulations = Modulations {
            config: &self.config,
            connect: &self.connect,
            domain: &self.domain,
            namespace: &self.namespace,
            node: &self.node,
            topics: topics.map(|topic| (topic, topic.get(cx))).to_vec(),
        };
        self.with_settings(cx, |settings| modulations.inspect(&settings, problems));
    }
}

with_settings!(Topics);

impl Topics {
    /// Starts a node with a topic for each import that is bound.
    fn start(&self, cx: &Context) -> Result<ActiveTopics> {
        self.with_settings(cx, |settings| self.start_with(cx, &settings))
    }

    fn start_with(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveTopics> {
        let name = settings.name()?;
        let (config, endpoint) = settings.connection_config()?;
        let namespace = name.namespace.as_str();
        let mut topics = Publications::new(namespace);
        let sensor = Quality::Sensor;
        let laser = topics.add(self.laser.is_bound(cx), self.laser_topic.get(cx), sensor)?;
        let odometry = topics.add(self.odometry.is_bound(cx), self.odometry_topic.get(cx), sensor)?;
        let image = topics.add(self.image.is_bound(cx), self.image_topic.get(cx), sensor)?;
        let depth = topics.add(self.depth.is_bound(cx), self.depth_topic.get(cx), sensor)?;
        let sonars = topics.add(self.sonars.is_bound(cx), self.sonars_topic.get(cx), sensor)?;
        let battery = topics.add(self.battery.is_bound(cx), self.battery_topic.get(cx), sensor)?;
        let imu = topics.add(self.imu.is_bound(cx), self.imu_topic.get(cx), sensor)?;
        let position = topics.add(self.position.is_bound(cx), self.position_topic.get(cx), sensor)?;
        let tf = topics.add(
            self.odometry.is_bound(cx),
            self.tf_topic.get(cx),
            Quality::Reliable,
        )?;
        let cmd_vel = names::topic(namespace, self.cmd_vel_topic.get(cx).as_str())?;
        let connection = RosConnection::start(NodeConfig {
            config,
            endpoint,
            publications: topics.topics,
            subscriptions: cmd_vel.iter().flat_map(|topic| velocity::topics(topic)).collect(),
            name,
        })?;
        Ok(ActiveTopics {
            connection,
            laser,
            odometry,
            image,
            depth,
            sonars,
            ranges: Spread::default(),
            battery,
            imu,
            position,
            tf,
            cmd_vel: cmd_vel.map(|topic| VelocitySubscription::new(0, &topic)),
        })
    }
}
