//! Converts messages of a ROS 2 robot to exports. Messages with invalid numbers or missing parts are reported
//! and dropped.

use core::time::Duration;

use jde_motion::scan_duration;
use jde_schema::prelude::*;

use super::hazards::HazardDetectionVector;
use super::sonars::Sonars;
use crate::connection::{RosConnection, TopicSubscription};
use crate::drive::{self, Drive};
use crate::messages::{PoseWithCovarianceStamped, Stamped};
use crate::scan::{Reading, Sweep};
use crate::velocity::VelocityPublisher;

/// How long a topic may take to have its first message.
const PATIENCE: Duration = Duration::from_secs(5);

/// The battery's topic is infrequent: its time limit is this many times `stale`.
pub(super) const BATTERY: u32 = 10;

/// The node with its topics.
pub(super) struct ActiveBase {
    pub(super) connection: RosConnection,
    pub(super) laser: Option<TopicSubscription<Sweep>>,
    pub(super) odometry: Option<TopicSubscription<Odometry>>,
    pub(super) image: Option<TopicSubscription<Image>>,
    pub(super) depth: Option<TopicSubscription<Image>>,
    pub(super) imu: Option<TopicSubscription<Imu>>,
    pub(super) position: Option<TopicSubscription<PoseWithCovarianceStamped>>,
    pub(super) battery: Option<TopicSubscription<BatteryState>>,
    pub(super) hazards: Option<TopicSubscription<HazardDetectionVector>>,
    pub(super) sonars: Sonars,
    pub(super) velocity: Option<VelocityPublisher>,
    pub(super) drive: Drive,
    /// Whether the robot moves, by its newest odometry.
    pub(super) moves: bool,
    /// Since when messages of the robot come.
    pub(super) since: Option<Duration>,
    /// The age from which messages do not count.
    pub(super) stale: Duration,
    /// Buffer for scans, which are too large for a stack.
    pub(super) sweep: Box<Sweep>,
}

impl ActiveBase {
    pub(super) fn publish_scan(&mut self, cx: &Context, export: &mut Export<LaserScan>, reading: Reading) {
        let Some(subscription) = &mut self.laser else {
            return;
        };
        let Some(arrived) = self.connection.receive(cx, subscription, &mut self.sweep) else {
            return;
        };
        let time = self
            .connection
            .stamp(cx, subscription, &mut self.sweep.header, arrived);
        let times = (time, arrived);
        if !(self.connection).is_fresh(cx, subscription.topic(), times, Some(self.stale)) {
            return;
        }
        let mut laser = export.loan(cx);
        let filled = self.sweep.fill(reading, &mut laser);
        match filled {
            Ok(()) => {
                subscription.mark_received(arrived);
                // Its stamp is the time of its first beam, and a value has that of the oldest.
                let before = Duration::from_secs_f64((-scan_duration(&laser)).max(0.0));
                laser.publish_at(time.saturating_sub(before));
            }
            Err(why) => {
                // Nobody drives by the scan before it. Retracting discards the loan.
                export.retract(cx);
                let message = format!("{}: the scan is no measurement: {why}", subscription.topic());
                self.connection.warn_once(cx, message);
            }
        }
    }

    pub(super) fn publish_odometry(&mut self, cx: &Context, export: &mut Export<Odometry>) {
        let moves = &mut self.moves;
        publish(
            cx,
            &mut self.connection,
            &mut self.odometry,
            export,
            self.stale,
            |odometry| {
                *moves = drive::moves(&odometry.twist.twist);
                odometry.measured().map_err(|why| why.to_string())?;
                Ok(*odometry)
            },
        );
    }

    pub(super) fn publish_imu(&mut self, cx: &Context, export: &mut Export<Imu>) {
        publish(
            cx,
            &mut self.connection,
            &mut self.imu,
            export,
            self.stale,
            |imu| {
                let parts = [imu.angular_velocity, imu.linear_acceleration];
                let is_usable = parts.iter().all(|part| all_finite(&[part.x, part.y, part.z]));
                is_usable
                    .then_some(*imu)
                    .ok_or_else(|| not_finite("its rates and accelerations"))
            },
        );
    }

    pub(super) fn publish_position(&mut self, cx: &Context, export: &mut Export<PositionFix>) {
        publish(
            cx,
            &mut self.connection,
            &mut self.position,
            export,
            self.stale,
            |pose| {
                let fix = PositionFix::from(pose);
                let is_usable = all_finite(&[fix.x, fix.y]) && all_finite(&fix.covariance);
                is_usable
                    .then_some(fix)
                    .ok_or_else(|| not_finite("its position and covariance"))
            },
        );
    }

    pub(super) fn publish_battery(&mut self, cx: &Context, export: &mut Export<BatteryState>) {
        publish(
            cx,
            &mut self.connection,
            &mut self.battery,
            export,
            self.stale * BATTERY,
            |battery| Ok(*battery),
        );
    }

    pub(super) fn publish_bumpers(&mut self, cx: &Context, export: &mut Export<Bumpers>) {
        publish(
            cx,
            &mut self.connection,
            &mut self.hazards,
            export,
            self.stale,
            |hazards| Ok(Bumpers::from(hazards)),
        );
    }

    /// Publishes the picture and the depths of the camera.
    pub(super) fn publish_images(&mut self, cx: &Context, exports: [&mut Export<Image>; 2]) {
        for (subscription, export) in [&mut self.image, &mut self.depth].into_iter().zip(exports) {
            if let Some(subscription) = subscription {
                publish_image(cx, &mut self.connection, subscription, export, self.stale);
            }
        }
    }

    /// Publishes the command in force, or what stops the robot.
    pub(super) fn drive(&mut self, cx: &Context, command: Option<Twist>) {
        let moves = self.moves
            && self
                .odometry
                .as_ref()
                .is_some_and(TopicSubscription::has_received);
        if let Some(twist) = self.drive.step(cx.now(), command, moves) {
            self.publish_velocity(cx, &twist);
        }
    }

    /// Publishes what stops the robot, as often as a driver that stays awake.
    pub(super) fn stop(&mut self, cx: &Context) {
        let mut drive = core::mem::take(&mut self.drive);
        drive.end(cx.now(), |twist| self.publish_velocity(cx, twist));
    }

    fn publish_velocity(&self, cx: &Context, twist: &Twist) {
        if let Some(publisher) = &self.velocity {
            publisher.publish(cx, &self.connection, twist);
        }
    }

    /// Warns once if other messages of the robot come, and still none of its laser or of its odometry.
    pub(super) fn report_missing(&mut self, cx: &Context) {
        if !self.has_received() {
            self.since = None;
            return;
        }
        let since = *self.since.get_or_insert(cx.now());
        if cx.now().saturating_sub(since) < PATIENCE {
            return;
        }
        let laser = self.laser.as_ref().and_then(TopicSubscription::unused);
        let odometry = self.odometry.as_ref().and_then(TopicSubscription::unused);
        let topics = [laser, odometry].map(|topic| topic.map(str::to_owned));
        for topic in topics.into_iter().flatten() {
            let message =
                format!("nothing has arrived on {topic} yet, although other messages of the robot arrive");
            self.connection.warn_once(cx, message);
        }
    }

    /// Whether a message of the robot is fresh. The battery does not count.
    pub(super) fn has_received(&self) -> bool {
        fn is_fresh<T: Value>(subscription: &Option<TopicSubscription<T>>) -> bool {
            subscription.as_ref().is_some_and(TopicSubscription::has_received)
        }
        is_fresh(&self.laser)
            || is_fresh(&self.odometry)
            || is_fresh(&self.image)
            || is_fresh(&self.depth)
            || is_fresh(&self.imu)
            || is_fresh(&self.position)
            || is_fresh(&self.hazards)
            || self.sonars.has_received()
    }
}

fn not_finite(what: &str) -> String {
    format!("{what} are not finite numbers")
}

/// Exports the newest message of a topic as `convert` returns it. If that returns an error, the message is reported and the
/// value before it retracted. One that is older than `stale` is dropped.
fn publish<T: Stamped + Default, U: Value>(
    cx: &Context,
    connection: &mut RosConnection,
    subscription: &mut Option<TopicSubscription<T>>,
    export: &mut Export<U>,
    stale: Duration,
    convert: impl FnOnce(&T) -> Result<U, String>,
) {
    let Some(subscription) = subscription else { return };
    let mut message = T::default();
    let Some(arrived) = connection.receive(cx, subscription, &mut message) else {
        return;
    };
    let time = connection.stamp(cx, subscription, message.header_mut(), arrived);
    if !connection.is_fresh(cx, subscription.topic(), (time, arrived), Some(stale)) {
        return;
    }
    match convert(&message) {
        Ok(value) => {
            subscription.mark_received(arrived);
            export.write_at(cx, value, time);
        }
        Err(why) => {
            export.retract(cx);
            connection.warn_once(cx, format!("{}: {why}", subscription.topic()));
        }
    }
}

fn publish_image(
    cx: &Context,
    connection: &mut RosConnection,
    subscription: &mut TopicSubscription<Image>,
    export: &mut Export<Image>,
    stale: Duration,
) {
    let mut image = export.loan(cx);
    let Some(arrived) = connection.receive(cx, subscription, &mut image) else {
        return;
    };
    let bytes = u64::from(image.step) * u64::from(image.height);
    if bytes > image.data.len() as u64 {
        let message = format!("{}: a picture with rows missing", subscription.topic());
        connection.warn_once(cx, message);
        return;
    }
    let time = connection.stamp(cx, subscription, &mut image.header, arrived);
    if connection.is_fresh(cx, subscription.topic(), (time, arrived), Some(stale)) {
        subscription.mark_received(arrived);
        image.publish_at(time);
    }
}

fn all_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}
