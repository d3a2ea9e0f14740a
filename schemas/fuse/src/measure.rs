//! Takes what the sensors have measured since the last iteration.

use jde_fuse::{Filter, Heading, Measurement, Place, Position, State, Timeline, Turn, Wheels};
use jde_motion::{is_jump, jumped};
use jde_schema::prelude::*;

use crate::ports::{HeadingUse, covariance, stated};
use crate::{Ekf, Settings};

/// How far the wheels go while an IMU, which has noise, cannot repeat itself to the bit; m and rad.
const FROZEN_IMU: f64 = 0.1;
/// The same for positions: those of some receivers are rounded to decimetres.
const FROZEN_POSITION: f64 = 0.5;
/// What a base without wheels to the side moves there, m/s.
const SIDE_DEVIATION: f64 = 0.005;
/// A wheel that stands measures less than this, m/s or rad/s.
const STILL: f64 = 1e-6;
/// The deviation of the place where an odometry begins by definition, m and rad.
const EXACT: f64 = 1e-4;

impl Ekf {
    /// Begins when the first sensor that says where the robot is has measured.
    ///
    /// # Errors
    /// What is missing.
    pub(crate) fn begin(&mut self, cx: &Context) -> Result<(), String> {
        if self.timeline.is_some() {
            return Ok(());
        }
        let now = cx.now();
        let odom = self.odom.get(cx).filter(|odom| odom.time() <= now);
        if self.odom.is_bound(cx) && odom.is_none() && self.kept.is_none() {
            return Err("no odometry of the wheels yet".to_owned());
        }
        let wheels = odom.map_or(Pose2D::ORIGIN, |odom| odom.pose2d());
        let (at, position, heading) = self.place(cx, &wheels)?;
        let initial = self.errors.initial(cx, position, heading);
        let state = State {
            x: at.x,
            y: at.y,
            yaw: at.theta,
            bias: self.kept.map_or(0.0, |(_, bias)| bias),
            ..State::default()
        };
        let oldest = Duration::try_from_secs_f64(self.history_length.get(cx)).unwrap_or_default();
        let time = odom
            .map_or(now, |odom| odom.time())
            .max(now.saturating_sub(oldest));
        self.timeline = Some(Timeline::new(time, Filter::new(state, &initial), oldest));
        Ok(())
    }

    /// Returns where the robot is at first, and how well that is known, m and rad.
    fn place(&self, cx: &Context, wheels: &Pose2D) -> Result<(Pose2D, f64, f64), String> {
        let deviations = (
            self.initial.initial_deviation.get(cx),
            self.initial.initial_heading_deviation.get(cx),
        );
        if let Some((frame, _)) = self.kept {
            return Ok((frame.transform(wheels), EXACT, EXACT));
        }
        if let Some(pose) = self.initial.initial_pose.get(cx).get() {
            return Ok((pose, deviations.0, deviations.1));
        }
        if self.pose.is_bound(cx) {
            let pose = self.pose.get(cx).ok_or("no pose yet")?;
            return Ok((pose.pose2d(), deviations.0, deviations.1));
        }
        if self.position.is_bound(cx) {
            let fix = self.position.get(cx).ok_or("no position yet")?;
            if self.imu_use.imu_heading.get(cx) != HeadingUse::Absolute {
                return Err(
                    "a position says no heading: give `initial_pose`, or an IMU with `imu_heading` absolute"
                        .to_owned(),
                );
            }
            let imu = self.imu.get(cx).ok_or("no heading of the IMU yet")?;
            let yaw = self.yaw(cx, &imu) + self.yaw_offset(cx);
            let deviation = self
                .deviations
                .position_deviation
                .get(cx)
                .max(fix.covariance[0].max(0.0).sqrt());
            return Ok((Pose2D::new(fix.x, fix.y, yaw), deviation, deviations.1));
        }
        Ok((*wheels, EXACT, EXACT))
    }

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
            for sensor in [&mut self.sensors.imu, &mut self.sensors.position] {
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
            self.sensors.wheels.note(cx.now(), outcome);
        }
    }

    /// The rotation of the IMU on the base.
    fn mounted(&self, cx: &Context) -> Quaternion {
        let about = |angle: f64, [x, y, z]: [f64; 3]| {
            let (sin, cos) = (angle / 2.0).sin_cos();
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
    fn yaw(&self, cx: &Context, imu: &Imu) -> f64 {
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
        if self.sensors.imu.is_frozen(&measured, base, FROZEN_IMU) {
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
        self.sensors.imu.note(now, outcome);
        if let Some(heading) = heading {
            let heading = Measurement::Heading(heading);
            let outcome = timeline.add(time, heading, &settings.noise, &settings.thresholds);
            self.sensors.imu.note(now, outcome);
        }
    }

    /// The heading of the IMU in the frame of the export, if it is used.
    fn heading(&mut self, cx: &Context, imu: &Imu) -> Option<Heading> {
        let (yaw, stated) = (self.yaw(cx, imu), imu.orientation_covariance[8]);
        let offset = match self.imu_use.imu_heading.get(cx) {
            HeadingUse::None => return None,
            HeadingUse::Absolute => self.yaw_offset(cx),
            HeadingUse::Relative => {
                let present = self.timeline.as_ref()?.newest().1.state().yaw;
                *self.turned.get_or_insert(present - yaw)
            }
        };
        if imu.orientation_covariance[0] < 0.0 || !yaw.is_finite() {
            return self
                .sensors
                .imu
                .trouble("the IMU measures no orientation".to_owned());
        }
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
            || !self.is_same_frame(&fix.header)
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
        let patience = self.patience.get(cx);
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
        if self.sensors.position.is_refused(cx.now(), patience) {
            let yaw = timeline.newest().1.state().yaw;
            let at = Pose2D::new(fix.x, fix.y, yaw);
            self.begin_again(cx, settings, &at, position.covariance[0][0].sqrt());
        }
    }

    fn measure_pose(&mut self, cx: &Context, settings: &Settings) {
        let Some(pose) = self.sensors.pose.fresh(cx, &self.pose, settings.oldest) else {
            return;
        };
        if !self.is_same_frame(&pose.header) {
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
        let patience = self.patience.get(cx);
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
        if self.sensors.pose.is_refused(cx.now(), patience) {
            self.begin_again(cx, settings, &at, place.covariance[0][0].sqrt());
        }
    }

    /// Takes it as given that the robot is where positions say that were refused for long.
    fn begin_again(&mut self, cx: &Context, settings: &Settings, at: &Pose2D, deviation: f64) {
        let heading = self.initial.initial_heading_deviation.get(cx);
        let Some(timeline) = &mut self.timeline else {
            return;
        };
        let mut filter = timeline.at(cx.now(), &settings.noise);
        let from = filter.state();
        let way = at.distance_to(&Pose2D::new(from.x, from.y, 0.0));
        warn!(
            cx,
            "the robot is {way:.2} m from where it should be: it is taken to be where the positions say"
        );
        filter.place_at([at.x, at.y, at.theta], deviation, heading);
        let length = Duration::try_from_secs_f64(settings.oldest).unwrap_or_default();
        *timeline = Timeline::new(cx.now(), filter, length);
        for sensor in [&mut self.sensors.position, &mut self.sensors.pose] {
            sensor.awake();
        }
    }

    /// Whether a position is in the frame of those before.
    fn is_same_frame(&mut self, header: &Header) -> bool {
        let frame = *self.frame.get_or_insert(header.frame_id);
        let is_same = frame == header.frame_id;
        if !is_same {
            let words = format!(
                "positions are in the frames \"{frame}\" and \"{}\"",
                header.frame_id
            );
            self.sensors.position.trouble::<()>(words);
        }
        is_same
    }
}

/// The velocity that moves by a step in one second: the logarithm of SE(2).
fn chord(step: &Pose2D) -> [f64; 3] {
    let half = step.theta / 2.0;
    // Near 0 the quotient is 1 to the last bits.
    let scale = if half.abs() < 1e-6 { 1.0 } else { half / half.tan() };
    [
        scale * step.x + half * step.y,
        scale * step.y - half * step.x,
        step.theta,
    ]
}
