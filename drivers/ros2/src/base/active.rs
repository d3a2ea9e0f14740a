//! Converts messages of a ROS 2 robot to exports. Messages with invalid numbers or missing parts are reported
//! and dropped.

use jde_schema::prelude::*;

use crate::connection::{RosConnection, TopicSubscription};
use crate::drive::Drive;
use crate::messages::Codec;
use crate::scan::Sweep;
use crate::topics::is_finite;

/// The node with its topics.
pub(super) struct ActiveBase {
    pub(super) connection: RosConnection,
    pub(super) laser: Option<TopicSubscription<Sweep>>,
    pub(super) odometry: Option<TopicSubscription<Odometry>>,
    pub(super) image: Option<TopicSubscription<Image>>,
    pub(super) battery: Option<TopicSubscription<BatteryState>>,
    pub(super) velocity: Option<Codec<Twist>>,
    pub(super) drive: Drive,
    /// Buffer for scans, which are too large for a stack.
    pub(super) sweep: Box<Sweep>,
}

impl ActiveBase {
    pub(super) fn publish_scan(&mut self, cx: &Context, export: &mut Export<LaserScan>, yaw: f32) {
        let Some(subscription) = &mut self.laser else {
            return;
        };
        let Some(arrived) = self.connection.receive(cx, subscription, &mut self.sweep) else {
            return;
        };
        let time = self
            .connection
            .stamp(cx, subscription, &mut self.sweep.header, arrived);
        let mut laser = export.loan(cx);
        match self.sweep.fill(yaw, &mut laser) {
            Ok(()) => {
                subscription.mark_received(arrived);
                laser.publish_at(time);
            }
            Err(reason) => self
                .connection
                .warn_once(cx, format!("{}: {reason}", subscription.topic())),
        }
    }

    pub(super) fn publish_odometry(&mut self, cx: &Context, export: &mut Export<Odometry>) {
        let Some(subscription) = &mut self.odometry else {
            return;
        };
        let mut odometry = Odometry::default();
        let Some(arrived) = self.connection.receive(cx, subscription, &mut odometry) else {
            return;
        };
        let pose = odometry.pose2d();
        let numbers = [pose.x, pose.y, pose.theta];
        if numbers.iter().any(|number| !number.is_finite()) || !is_finite(&odometry.twist.twist) {
            let message = format!(
                "{}: its pose and velocity are not finite numbers",
                subscription.topic()
            );
            self.connection.warn_once(cx, message);
            return;
        }
        subscription.mark_received(arrived);
        let time = self
            .connection
            .stamp(cx, subscription, &mut odometry.header, arrived);
        export.write_at(cx, odometry, time);
    }

    pub(super) fn publish_image(&mut self, cx: &Context, export: &mut Export<Image>) {
        let Some(subscription) = &mut self.image else {
            return;
        };
        let mut image = export.loan(cx);
        let Some(arrived) = self.connection.receive(cx, subscription, &mut image) else {
            return;
        };
        let bytes = u64::from(image.step) * u64::from(image.height);
        if bytes > image.data.len() as u64 {
            let message = format!("{}: a picture with rows missing", subscription.topic());
            self.connection.warn_once(cx, message);
            return;
        }
        subscription.mark_received(arrived);
        let time = self
            .connection
            .stamp(cx, subscription, &mut image.header, arrived);
        image.publish_at(time);
    }

    pub(super) fn publish_battery(&mut self, cx: &Context, export: &mut Export<BatteryState>) {
        let Some(subscription) = &mut self.battery else {
            return;
        };
        let mut battery = BatteryState::default();
        let Some(arrived) = self.connection.receive(cx, subscription, &mut battery) else {
            return;
        };
        subscription.mark_received(arrived);
        let time = self
            .connection
            .stamp(cx, subscription, &mut battery.header, arrived);
        export.write_at(cx, battery, time);
    }

    pub(super) fn publish_velocity(&self, twist: &Twist) {
        if let Some(codec) = &self.velocity {
            self.connection.node.publish(0, vec![codec.encode(twist)]);
        }
    }

    /// Whether a message of the laser, the odometry or the camera is fresh. The battery does not count.
    pub(super) fn has_received(&self) -> bool {
        self.laser.as_ref().is_some_and(TopicSubscription::has_received)
            || self
                .odometry
                .as_ref()
                .is_some_and(TopicSubscription::has_received)
            || self.image.as_ref().is_some_and(TopicSubscription::has_received)
    }
}
