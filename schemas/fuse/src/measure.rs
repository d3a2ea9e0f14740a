//! Takes what the sensors have measured since the last iteration.

use jde_fuse::{Heading, MAX_GAP, Measurement, Outcome, Place, Position, Turn, Wheels};
use jde_motion::{is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::Frame;

use crate::begin::MAX_HEADING_VARIANCE;
use crate::ports::{HeadingUse, covariance, stated};
use crate::sensor::Watch;
use crate::{Ekf, Settings};

/// How far the wheels go while an IMU, which has noise, cannot repeat itself to the bit; m and rad.
const FROZEN_IMU: f64 = 0.1;
/// How far they turn while its turn rates cannot: the sooner that is seen, the fewer false ones have counted; rad.
const FROZEN_RATES: f64 = 0.05;
/// The same for positions: those of some receivers are rounded to decimetres.
const FROZEN_POSITION: f64 = 0.5;
/// Deviations by which a bias changes at most.
const MAX_CHANGE: f64 = 3.0;
/// A heading counts once in this time, s.
const HEADING_TIME: f64 = 1.0;
/// The same for poses: a localizer may measure anew only after such a step.
const FROZEN_POSE: f64 = 0.3;
/// What a base without wheels to the side moves there, m/s.
const SIDE_DEVIATION: f64 = 0.005;
/// A wheel that stands measures less than this, m/s or rad/s.
const STILL: f64 = 1e-6;

impl Ekf {
    pub(crate) fn measure(&mut self, cx: &Context, settings: &Settings) {
        // The gyro first: the wheels are compared with it.
        self.measure_imu(cx, settings);
        self.measure_wheels(cx, settings);
        self.measure_position(cx, settings);
        self.measure_pose(cx, settings);
    }

    fn measure_wheels(&mut self, cx: &Context, settings: &Settings) {
        let Some(odom) = self.sensors.wheels.fresh(cx, &self.odom, settings.oldest) else {
            return;
        };
        let (time, pose, twist) = (odom.time(), odom.pose2d(), odom.twist.twist);
        let last = self.rolled.replace((time, pose));
        let jump = last.filter(|(_, last)| is_jump(last, &pose, self.jump.get(cx)));
        if let Some((_, last)) = &jump {
            warn!(cx, "{}", jumped(last, &pose));
            for sensor in [
                &mut self.sensors.imu,
                &mut self.sensors.rates,
                &mut self.sensors.position,
                &mut self.sensors.pose,
            ] {
                sensor.jump(last, &pose);
            }
        }
        let mut velocity = [twist.linear.x, twist.linear.y, twist.angular.z];
        let mut lasts = Duration::ZERO;
        if self.odom_differential.get(cx) {
            // The first one, and one that jumped, say nothing.
            let Some((before, last)) = last.filter(|_| jump.is_none()) else {
                return;
            };
            lasts = time - before;
            let step = last.localize(&pose);
            velocity = chord(&step).map(|part| part / lasts.as_secs_f64());
        }
        let is_still =
            velocity.iter().all(|speed| speed.abs() < STILL) && last.is_none_or(|(_, last)| last == pose);
        self.stood = if is_still { self.stood.or(Some(time)) } else { None };
        let stands = (self.stood).map_or(0.0, |since| time.saturating_sub(since).as_secs_f64());
        let speed = self.deviations.odom_speed_deviation.get(cx);
        let rate = self.deviations.odom_turn_rate_deviation.get(cx);
        let wheels = Wheels {
            velocity: [velocity[0], velocity[1]],
            rate: velocity[2],
            covariance: covariance(&odom.twist.covariance, [speed, SIDE_DEVIATION, rate]),
            lasts,
            is_standing: stands >= self.standstill_time.get(cx),
        };
        if let Some(timeline) = &mut self.timeline {
            let outcome = timeline.add(
                time,
                Measurement::Wheels(wheels),
                &settings.noise,
                &settings.thresholds,
            );
            if let Ok(outcome) = outcome {
                let filter = timeline.newest().1;
                let mut expected = self.errors.initial(cx, 0.0, 0.0);
                expected.bias = filter.bias_deviation();
                let patience = self.patience.get(cx);
                let roll = (&wheels, outcome);
                let change = (self.dispute).roll(time, roll, filter.state(), &expected, patience);
                let deviation = self.errors.initial(cx, 0.0, 0.0).bias;
                if let Some((change, lasted)) =
                    change.filter(|(change, _)| change.abs() < MAX_CHANGE * deviation)
                {
                    warn!(
                        cx,
                        "the gyro's bias has changed by {:.2} degrees/s: it is learned anew",
                        change.to_degrees()
                    );
                    timeline.doubt_bias(deviation, change * lasted);
                }
            }
            self.sensors.wheels.note(cx.now(), outcome);
        }
    }

    /// The rotation of the IMU on the base.
    fn mounted(&self, cx: &Context) -> Quaternion {
        let about = |angle: f64, [x, y, z]: [f64; 3]| {
            let (sin, cos) = libm::sincos(angle / 2.0);
            Quaternion {
                x: sin * x,
                y: sin * y,
                z: sin * z,
                w: cos,
            }
        };
        about(self.imu_use.imu_yaw.get(cx), [0.0, 0.0, 1.0])
            .compose(&about(self.imu_use.imu_pitch.get(cx), [0.0, 1.0, 0.0]))
            .compose(&about(self.imu_use.imu_roll.get(cx), [1.0, 0.0, 0.0]))
    }

    /// The heading of the base by the orientation of the IMU; NaN if it has none.
    pub(crate) fn yaw(&self, cx: &Context, imu: &Imu) -> f64 {
        imu.orientation.compose(&self.mounted(cx).inverse()).yaw()
    }

    fn measure_imu(&mut self, cx: &Context, settings: &Settings) {
        let Some(imu) = self.sensors.imu.fresh(cx, &self.imu, settings.oldest) else {
            return;
        };
        let measured = Twist {
            linear: imu.linear_acceleration,
            angular: imu.angular_velocity,
        };
        let base = self.rolled.map(|(_, pose)| pose);
        // The rates may be stuck while the accelerations have noise. On a straight way those of a coarse gyro stay the same.
        let turned = base.map(|base| Pose2D::new(0.0, 0.0, base.theta));
        let are_stuck = self
            .sensors
            .rates
            .is_frozen(&imu.angular_velocity, turned, FROZEN_RATES);
        if self.sensors.imu.is_frozen(&measured, base, FROZEN_IMU) {
            return;
        }
        if are_stuck {
            let words = "the turn rates of the IMU repeat themselves although the wheels turn";
            self.sensors.imu.trouble::<()>(words.to_owned());
            return;
        }
        if imu.angular_velocity_covariance[0] < 0.0 {
            self.sensors
                .imu
                .trouble::<()>("the IMU measures no turn rates".to_owned());
            return;
        }
        let mount = self.mounted(cx);
        let Vector3 { x, y, z } = imu.angular_velocity;
        // The axis up of the base, in the frame of the unit: by it the variances of the unit's axes add up.
        let up = mount.inverse().rotate([0.0, 0.0, 1.0]);
        let deviation = self.deviations.imu_turn_rate_deviation.get(cx);
        let variances = [0, 4, 8].map(|at| imu.angular_velocity_covariance[at]);
        let variance = if variances
            .iter()
            .all(|variance| variance.is_finite() && *variance > 0.0)
        {
            up.iter()
                .zip(variances)
                .map(|(part, variance)| part * part * variance)
                .sum()
        } else {
            deviation * deviation
        };
        let turn = Turn {
            rate: mount.rotate([x, y, z])[2],
            variance,
        };
        let heading = self.heading(cx, &imu);
        let Some(timeline) = &mut self.timeline else {
            return;
        };
        let (time, now) = (imu.time(), cx.now());
        let outcome = timeline.add(
            time,
            Measurement::Turn(turn),
            &settings.noise,
            &settings.thresholds,
        );
        if outcome == Ok(Outcome::Taken) {
            let bias = timeline.newest().1.state().bias;
            self.dispute.turn(time, turn.rate - bias);
        }
        self.sensors.imu.note(now, outcome);
        if outcome == Ok(Outcome::Taken) && self.sensors.imu.step() > Some(MAX_GAP) {
            let words = "the IMU measures too seldom to notice wheels that slip";
            self.sensors.imu.trouble::<()>(words.to_owned());
        }
        if let Some(heading) = heading {
            let heading = Measurement::Heading(heading);
            let outcome = timeline.add(time, heading, &settings.noise, &settings.thresholds);
            self.sensors.heading.note(now, outcome);
            if matches!(outcome, Ok(Outcome::Refused(_))) {
                self.sensors.heading.refuse(now, [0.0; 2], [0.0; 2], 0.0);
            }
        }
    }

    /// The heading of the IMU in the frame of the export, if it is used.
    fn heading(&mut self, cx: &Context, imu: &Imu) -> Option<Heading> {
        let (yaw, stated) = (self.yaw(cx, imu), imu.orientation_covariance[8]);
        let heading_use = self.imu_use.imu_heading.get(cx);
        if heading_use == HeadingUse::None {
            return None;
        }
        let watch = &mut self.sensors.heading;
        if imu.orientation_covariance[0] < 0.0 || !yaw.is_finite() {
            return watch.trouble("the IMU measures no orientation".to_owned());
        }
        if stated > MAX_HEADING_VARIANCE {
            return watch.trouble("the IMU does not know the heading: has it a compass?".to_owned());
        }
        // The errors of one heading are those of the next: a hundred in a second are one.
        if watch.is_alive(cx.now(), HEADING_TIME) {
            return None;
        }
        let present = self.timeline.as_ref()?.newest().1.state().yaw;
        let offset = match heading_use {
            HeadingUse::None => return None,
            HeadingUse::Absolute => self.yaw_offset(cx),
            HeadingUse::Relative => *self.turned.get_or_insert(present - yaw),
        };
        let deviation = self.deviations.heading_deviation.get(cx);
        let variance = if stated.is_finite() && stated > 0.0 {
            stated
        } else {
            deviation * deviation
        };
        Some(Heading {
            yaw: normalize_angle(yaw + offset),
            variance,
        })
    }

    fn yaw_offset(&self, cx: &Context) -> f64 {
        self.imu_use.yaw_offset.get(cx)
    }

    fn measure_position(&mut self, cx: &Context, settings: &Settings) {
        let Some(fix) = self.sensors.position.fresh(cx, &self.position, settings.oldest) else {
            return;
        };
        let base = self.rolled.map(|(_, pose)| pose);
        let measured = Vector3 {
            x: fix.x,
            y: fix.y,
            z: 0.0,
        };
        if self.sensors.position.is_frozen(&measured, base, FROZEN_POSITION)
            || !is_same_frame(&mut self.frame, &mut self.sensors.position, &fix.header)
        {
            return;
        }
        let deviation = self.deviations.position_deviation.get(cx);
        let [xx, xy, yx, yy] = fix.covariance;
        let position = Position {
            position: [fix.x, fix.y],
            covariance: stated([[xx, xy], [yx, yy]], [deviation; 2]),
            antenna: [self.antenna_x.get(cx), self.antenna_y.get(cx)],
        };
        let Some(timeline) = &mut self.timeline else {
            return;
        };
        let outcome = timeline.add(
            fix.time(),
            Measurement::Position(position),
            &settings.noise,
            &settings.thresholds,
        );
        self.sensors.position.note(cx.now(), outcome);
        if matches!(outcome, Ok(Outcome::Refused(_))) {
            let state = timeline.newest().1.state();
            let deviation = position.covariance[0][0].max(position.covariance[1][1]).sqrt();
            (self.sensors.position).refuse(cx.now(), [fix.x, fix.y], [state.x, state.y], deviation);
        }
    }

    fn measure_pose(&mut self, cx: &Context, settings: &Settings) {
        let Some(pose) = self.sensors.pose.fresh(cx, &self.pose, settings.oldest) else {
            return;
        };
        let base = self.rolled.map(|(_, pose)| pose);
        let measured = Vector3 {
            x: pose.pose2d().x,
            y: pose.pose2d().y,
            z: pose.pose2d().theta,
        };
        if self.sensors.pose.is_frozen(&measured, base, FROZEN_POSE)
            || !is_same_frame(&mut self.frame, &mut self.sensors.pose, &pose.header)
        {
            return;
        }
        let (position, heading) = (
            self.deviations.position_deviation.get(cx),
            self.deviations.heading_deviation.get(cx),
        );
        let at = pose.pose2d();
        let place = Place {
            pose: [at.x, at.y, at.theta],
            covariance: covariance(&pose.pose.covariance, [position, position, heading]),
        };
        let Some(timeline) = &mut self.timeline else {
            return;
        };
        let outcome = timeline.add(
            pose.time(),
            Measurement::Place(place),
            &settings.noise,
            &settings.thresholds,
        );
        self.sensors.pose.note(cx.now(), outcome);
        if matches!(outcome, Ok(Outcome::Refused(_))) {
            let state = timeline.newest().1.state();
            let deviation = place.covariance[0][0].max(place.covariance[1][1]).sqrt();
            (self.sensors.pose).refuse(cx.now(), [at.x, at.y], [state.x, state.y], deviation);
        }
    }
}

/// Whether a position is in the frame of those before.
fn is_same_frame(before: &mut Option<Frame>, watch: &mut Watch, header: &Header) -> bool {
    let frame = *before.get_or_insert(header.frame_id);
    let is_same = frame == header.frame_id;
    if !is_same {
        watch.trouble::<()>(format!(
            "positions are in the frames \"{frame}\" and \"{}\"",
            header.frame_id
        ));
    }
    is_same
}

/// The velocity that moves by a step in one second: the logarithm of SE(2).
fn chord(step: &Pose2D) -> [f64; 3] {
    let half = step.theta / 2.0;
    // Near 0 the quotient is 1 to the last bits.
    let scale = if half.abs() < 1e-6 {
        1.0
    } else {
        half / libm::tan(half)
    };
    [
        scale * step.x + half * step.y,
        scale * step.y - half * step.x,
        step.theta,
    ]
}
