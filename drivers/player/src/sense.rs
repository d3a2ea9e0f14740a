//! Exports the robot's data. A quantity that is not measured is NaN or not published.

use core::time::Duration;

use jde_player::{Event, Mount, Ring};
use jde_schema::prelude::*;

use crate::{Robot, convert};

/// How many times longer than other data that of the battery is valid.
const BATTERY: u32 = 10;

/// The state kept between messages.
#[derive(Default)]
pub(crate) struct SensorState {
    /// The frame of the server's odometry, in that of the exported one; kept over losses.
    origin: Option<Pose2D>,
    sonars: Option<Ring>,
    bumper_mounts: Vec<Mount>,
    bumpers: Vec<bool>,
    times: Times,
}

/// The times of the newest data; `None` while nothing is exported.
#[derive(Default)]
struct Times {
    odometry: Option<Duration>,
    laser: Option<Duration>,
    sonars: Option<Duration>,
    bumpers: Option<Duration>,
    battery: Option<Duration>,
    head: Option<Duration>,
}

impl Robot {
    /// Publishes the robot's events.
    pub(crate) fn sense(&mut self, cx: &Context, events: Vec<Event>) {
        let now = cx.now();
        for event in events {
            match event {
                Event::Ready(robot) => {
                    self.body
                        .write(cx, convert::body(now, robot.laser.map(|laser| laser.mount)));
                    self.senses.sonars = robot.sonars;
                    self.senses.bumper_mounts = robot.bumpers.map(|(_, mounts)| mounts).unwrap_or_default();
                    self.senses.bumpers.clear();
                }
                Event::Base(base) => self.publish_base(cx, &base),
                Event::Laser(sweep) => {
                    let last = self.senses.times.laser.replace(now);
                    let mut laser = self.laser.loan(cx);
                    laser.header = Header::new(now, "laser");
                    laser.scan_time = last.map_or(0.0, |last| now.saturating_sub(last).as_secs_f32());
                    convert::fill_scan(&mut laser, &sweep, self.laser_range.get(cx));
                    laser.publish();
                }
                Event::Sonars(ranges) => self.publish_sonars(cx, &ranges),
                Event::Bumpers(states) => {
                    self.senses.bumpers = states;
                    self.senses.times.bumpers = Some(now);
                }
                Event::Battery(power) => {
                    self.senses.times.battery = Some(now);
                    self.battery.write(cx, convert::battery(now, &power));
                }
                Event::Head(head) => {
                    self.senses.times.head = Some(now);
                    let pan_tilt = PanTilt {
                        header: Header::new(now, "base_link"),
                        pan: head.pan.into(),
                        tilt: (-head.tilt).into(),
                        pan_velocity: head.pan_speed.into(),
                        tilt_velocity: (-head.tilt_speed).into(),
                    };
                    self.pan_tilt.write(cx, pan_tilt);
                }
                Event::Warning(_) => {}
            }
        }
    }

    fn publish_base(&mut self, cx: &Context, base: &jde_player::Base) {
        let now = cx.now();
        let [x, y, heading] = base.pose;
        let pose = Pose2D::new(x, y, heading);
        let start = self.start.get(cx);
        let origin =
            (self.senses.origin).get_or_insert_with(|| start.transform(&pose.localize(&Pose2D::ORIGIN)));
        let [ahead, left, turn] = base.velocity;
        let mut twist = Twist::planar(ahead, turn);
        twist.linear.y = left;
        self.odometry
            .write(cx, Odometry::planar(now, origin.transform(&pose), twist));
        self.senses.times.odometry = Some(now);
        let SensorState {
            bumpers,
            bumper_mounts,
            ..
        } = &self.senses;
        self.bumpers
            .write(cx, convert::bumpers(now, bumpers, bumper_mounts, base.stalled));
    }

    fn publish_sonars(&mut self, cx: &Context, ranges: &[f64]) {
        let Some(known) = &self.senses.sonars else { return };
        let or = |reported: f64, default: f64| if reported > 0.0 { reported } else { default };
        let max = or(known.range_max, self.sonar_range.get(cx));
        let count = known.mounts.len().min(ranges.len()).min(Seq::<f32, 32>::CAPACITY);
        let mut ring = self.sonars.loan(cx);
        ring.header = Header::new(cx.now(), "base_link");
        ring.radiation_type = 0;
        ring.padding = Padding::ZERO;
        ring.field_of_view = or(known.view, self.sonar_view.get(cx)) as f32;
        ring.min_range = known.range_min as f32;
        ring.max_range = max as f32;
        for (pose, mount) in ring.poses.resize(count).iter_mut().zip(&known.mounts) {
            *pose = Pose2D::new(mount.x, mount.y, mount.yaw);
        }
        for (range, metres) in ring.ranges.resize(count).iter_mut().zip(ranges) {
            *range = convert::range(*metres, known.range_min, max);
        }
        ring.publish();
        self.senses.times.sonars = Some(cx.now());
    }

    /// Retracts the exports whose newest data have an age that is over.
    pub(crate) fn retract(&mut self, cx: &Context, is_over: impl Fn(Duration) -> bool) {
        let now = cx.now();
        let ends = |newest: &mut Option<Duration>, longer: u32| {
            let newest = newest.take_if(|newest| is_over(now.saturating_sub(*newest) / longer));
            newest.is_some()
        };
        let times = &mut self.senses.times;
        if ends(&mut times.bumpers, 1) {
            self.senses.bumpers.clear();
        }
        if ends(&mut times.odometry, 1) {
            self.odometry.retract(cx);
            self.bumpers.retract(cx);
        }
        if ends(&mut times.laser, 1) {
            self.laser.retract(cx);
        }
        if ends(&mut times.sonars, 1) {
            self.sonars.retract(cx);
        }
        if ends(&mut times.battery, BATTERY) {
            self.battery.retract(cx);
        }
        if ends(&mut times.head, 1) {
            self.pan_tilt.retract(cx);
        }
    }
}
