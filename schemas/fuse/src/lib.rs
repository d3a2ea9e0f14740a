//! Fuses the odometry of wheels, an IMU and measured positions. The filter is `jde-fuse`; here are its sensors, their
//! times, and what happens when one is missing or wrong. It drives nowhere.

mod begin;
mod dispute;
mod measure;
mod memory;
mod panel;
mod ports;
mod push;
mod refusal;
mod sensor;

use jde_fuse::{Filter, ProcessNoise, Thresholds, Timeline};
use jde_motion::is_finite;
use jde_schema::prelude::*;
use jde_schema::types::Frame;

use begin::Kept;
use dispute::Dispute;
use ports::{ConstantErrors, Deviations, Growth, HeadingUse, ImuUse, InitialPose, Limits, Rejection};
use sensor::Watch;

/// Exports an odometry that is made of that of the wheels, of an IMU and of measured positions, by an extended Kalman filter.
///
/// It goes on without any one of them, and its covariance grows. It is retracted while no sensor measures, or while the
/// velocity is known too badly; `state` says why. The gyro's bias is learned while the base stands. With positions the
/// frame is theirs, and the pose may jump when one comes.
#[derive(Describe)]
#[schema(perceptive, period = "20ms", budget = "10ms")]
pub struct Ekf {
    /// The pose and velocity by the wheels.
    #[import(optional, trigger)]
    odom: Import<Odometry>,
    /// The turn rates, and the orientation if `imu_heading` says so.
    #[import(optional, trigger)]
    imu: Import<Imu>,
    /// Measured positions, as of a satellite receiver.
    #[import(optional, trigger)]
    position: Import<PositionFix>,
    /// Measured poses, as of a localizer.
    #[import(optional, trigger)]
    pose: Import<Odometry>,
    #[ports]
    initial: InitialPose,
    /// Whether the steps of the odometry's pose are used in place of its velocity: where that is rounded or missing.
    #[modulation(default = false, fixed)]
    odom_differential: Modulation<bool>,
    #[ports]
    imu_use: ImuUse,
    /// How far the antenna of `position` is ahead of the centre of the base.
    #[modulation(default = 0.0, unit = "m", min = -10.0, max = 10.0)]
    antenna_x: Modulation<f64>,
    /// How far the antenna of `position` is to the left.
    #[modulation(default = 0.0, unit = "m", min = -10.0, max = 10.0)]
    antenna_y: Modulation<f64>,
    #[ports]
    deviations: Deviations,
    #[ports]
    errors: ConstantErrors,
    #[ports]
    growth: Growth,
    #[ports]
    rejection: Rejection,
    #[ports]
    limits: Limits,
    /// Time without a measurement after which a sensor of velocities is silent.
    #[modulation(default = 0.5, unit = "s", min = 0.05, max = 60.0)]
    sensor_timeout: Modulation<f64>,
    /// How late a measurement may come.
    #[modulation(default = 1.0, unit = "s", min = 0.05, max = 10.0, fixed)]
    history_length: Modulation<f64>,
    /// Time for which the wheels must stand so that the base does.
    #[modulation(default = 0.5, unit = "s", min = 0.1, max = 60.0)]
    standstill_time: Modulation<f64>,
    /// Time for which positions are refused, and agree with each other, before the filter begins anew where they say; and for
    /// which the wheels turn otherwise than the gyro before neither is believed.
    #[modulation(default = 5.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// Least step of the odometry that is a jump and no motion. A turn by more than 90 degrees is a jump too.
    #[modulation(default = 1.0, unit = "m", min = 0.1)]
    jump: Modulation<f64>,
    /// The pose and the velocity with their covariances, as of now.
    #[export]
    odometry: Export<Odometry>,
    /// What the gyro shows at rest, rad/s.
    #[export]
    gyro_bias: Export<f64>,
    /// How well the motion is known, and what is wrong with sensors, in words.
    #[export]
    state: Export<Text<160>>,
    timeline: Option<Timeline>,
    sensors: Sensors,
    /// Time and pose of the last odometry.
    rolled: Option<(Duration, Pose2D)>,
    /// Since when the wheels have stood.
    stood: Option<Duration>,
    /// What the first relative heading lacked to be the one in the frame of the export.
    turned: Option<f64>,
    /// The frame of the positions.
    frame: Option<Frame>,
    /// What was known before a reload or a sleep.
    kept: Option<Kept>,
    /// The gyro's bias that was known before.
    bias: Option<f64>,
    /// Whether it has begun once: `initial_pose` is where the robot was then.
    has_begun: bool,
    dispute: Dispute,
    words: String,
}

/// The watches.
#[derive(Debug)]
struct Sensors {
    wheels: Watch,
    imu: Watch,
    /// The turn rates of the IMU alone.
    rates: Watch,
    /// The headings of the IMU.
    heading: Watch,
    position: Watch,
    pose: Watch,
}

impl Default for Sensors {
    fn default() -> Self {
        Self {
            wheels: Watch::new("odometries"),
            imu: Watch::new("IMU's values"),
            rates: Watch::new("turn rates of the IMU"),
            heading: Watch::new("headings of the IMU"),
            position: Watch::new("positions"),
            pose: Watch::new("poses"),
        }
    }
}

/// A receiver of satellites measures once a second, and a localizer may pause, s.
const FIX_TIMEOUT: f64 = 2.5;

/// What the filter is told.
struct Settings {
    noise: ProcessNoise,
    thresholds: Thresholds,
    oldest: f64,
}

impl Schema for Ekf {
    fn awake(&mut self, _: &Context) -> Result {
        (self.kept, self.bias) = (self.known(), self.known_bias());
        (self.timeline, self.rolled, self.stood, self.turned) = (None, None, None, None);
        (self.frame, self.dispute) = (None, Dispute::default());
        let Sensors {
            wheels,
            imu,
            rates,
            heading,
            position,
            pose,
        } = &mut self.sensors;
        [wheels, imu, rates, heading, position, pose]
            .into_iter()
            .for_each(Watch::awake);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.odometry.retract(cx);
        self.gyro_bias.retract(cx);
        self.state.retract(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let words = match self.fuse(cx) {
            Ok(words) => words,
            Err(words) => {
                self.odometry.retract(cx);
                self.gyro_bias.retract(cx);
                words
            }
        };
        self.state.write(cx, Text::truncated(&words));
        self.words = words;
        Ok(())
    }
}

impl Ekf {
    /// Exports the odometry.
    ///
    /// # Errors
    /// Why there is none.
    fn fuse(&mut self, cx: &Context) -> Result<String, String> {
        let settings = Settings {
            noise: self.growth.get(cx, self.sensor_timeout.get(cx)),
            thresholds: self.rejection.get(cx),
            oldest: self.history_length.get(cx),
        };
        self.begin(cx)?;
        self.measure(cx, &settings);
        if self.is_elsewhere(cx) {
            warn!(
                cx,
                "the robot is not where it should be: it begins anew where the positions say"
            );
            self.lose();
            self.begin(cx)?;
        }
        let trouble = self.trouble(cx);
        let said = |words: String| {
            if trouble.is_empty() {
                words
            } else {
                format!("{}: {words}", trouble.join("; "))
            }
        };
        let now = cx.now();
        let timeout = self.sensor_timeout.get(cx);
        let Sensors {
            wheels,
            imu,
            position,
            pose,
            ..
        } = &self.sensors;
        let is_measured = [
            (wheels, timeout),
            (imu, timeout),
            (position, FIX_TIMEOUT),
            (pose, FIX_TIMEOUT),
        ]
        .into_iter()
        .any(|(sensor, timeout)| sensor.is_alive(now, timeout));
        let Some(timeline) = self.timeline.as_ref().filter(|_| is_measured) else {
            return Err(said("no sensor measures".to_owned()));
        };
        self.agree(cx).map_err(said)?;
        let filter = timeline.at(now, &settings.noise);
        let twist = filter.twist_covariance();
        let [speed, rate] = [twist[0][0], twist[2][2]].map(|variance| variance.max(0.0).sqrt());
        if speed.is_nan() || speed > self.limits.max_speed_deviation.get(cx) {
            return Err(said(format!("the speed may be off by {speed:.2} m/s")));
        }
        if rate.is_nan() || rate > self.limits.max_turn_rate_deviation.get(cx) {
            return Err(said(format!("the turn rate may be off by {rate:.2} rad/s")));
        }
        let [[xx, ..], [_, yy, _], [.., heading]] = filter.pose_covariance();
        let [place, heading] = [xx.max(yy), heading].map(|variance| variance.max(0.0).sqrt());
        let has_place = self.position.is_bound(cx) || self.pose.is_bound(cx);
        if has_place && place > self.limits.max_position_deviation.get(cx) {
            return Err(said(format!("the position may be off by {place:.1} m")));
        }
        if has_place && heading > self.limits.max_heading_deviation.get(cx) {
            return Err(said(format!(
                "the heading may be off by {:.0} degrees",
                heading.to_degrees()
            )));
        }
        let odometry = self.exported(now, &filter);
        if !is_finite(&odometry) {
            return Err(said("the estimate has numbers that are none".to_owned()));
        }
        self.gyro_bias.write(cx, filter.state().bias);
        self.odometry.write(cx, odometry);
        Ok(said(format!(
            "speed to {speed:.3} m/s, heading to {:.1} degrees, bias {:.2} degrees/s",
            heading.to_degrees(),
            filter.state().bias.to_degrees()
        )))
    }

    fn exported(&self, now: Duration, filter: &Filter) -> Odometry {
        let state = filter.state();
        let [ahead, left, rate] = state.twist();
        let mut twist = Twist::planar(ahead, rate);
        twist.linear.y = left;
        let pose = Pose2D::new(state.x, state.y, state.yaw);
        let mut odometry = Odometry {
            pose: PoseWithCovariance::planar(pose, &filter.pose_covariance()),
            twist: TwistWithCovariance::planar(twist, &filter.twist_covariance()),
            ..Odometry::planar(now, pose, twist)
        };
        if let Some(frame) = self.frame {
            odometry.header.frame_id = frame;
        }
        odometry
    }

    /// What is wrong with the sensors that are bound.
    fn trouble(&self, cx: &Context) -> Vec<String> {
        let (now, timeout) = (cx.now(), self.sensor_timeout.get(cx));
        let Sensors {
            wheels,
            imu,
            position,
            pose,
            ..
        } = &self.sensors;
        let bound = [
            (self.odom.is_bound(cx), wheels, timeout),
            (self.imu.is_bound(cx), imu, timeout),
            (self.position.is_bound(cx), position, FIX_TIMEOUT),
            (self.pose.is_bound(cx), pose, FIX_TIMEOUT),
        ];
        let has_headings = self.imu.is_bound(cx) && self.imu_use.imu_heading.get(cx) != HeadingUse::None;
        let headings = (self.sensors.heading.words(now, FIX_TIMEOUT)).filter(|_| has_headings);
        bound
            .into_iter()
            .filter_map(|(is_bound, sensor, timeout)| sensor.words(now, timeout).filter(|_| is_bound))
            .chain(headings)
            .collect()
    }

    /// Checks that no two sensors contradict each other for longer than `patience`.
    ///
    /// # Errors
    /// Which ones.
    fn agree(&self, cx: &Context) -> Result<(), String> {
        let (now, patience) = (cx.now(), self.patience.get(cx));
        let Sensors {
            heading,
            position,
            pose,
            ..
        } = &self.sensors;
        if let Some(words) = self.dispute.words() {
            return Err(words.to_owned());
        }
        if self.dispute.is_pushed() {
            return Err("the gyro shows a turn that is no steady bias although the wheels stand".to_owned());
        }
        if heading.is_refused(now, patience) {
            return Err("the headings of the IMU contradict all else".to_owned());
        }
        for (refused, other) in [(position, pose), (pose, position)] {
            if refused.is_refused(now, patience) && other.is_alive(now, FIX_TIMEOUT) {
                return Err("the positions and the poses contradict each other".to_owned());
            }
        }
        Ok(())
    }

    /// Whether the robot is not where it should be: positions say so for longer than `patience`, and nothing says otherwise.
    fn is_elsewhere(&self, cx: &Context) -> bool {
        let (now, patience) = (cx.now(), self.patience.get(cx));
        let Sensors { position, pose, .. } = &self.sensors;
        [position, pose]
            .iter()
            .any(|sensor| sensor.is_refused(now, patience))
            && self.agree(cx).is_ok()
    }
}

jde_schema::export!("fuse", "Fuses odometry, an IMU and positions.", [Ekf]);

#[cfg(test)]
mod tests;
