//! Where the estimate begins: at first, after a sleep, and after the robot was found to be elsewhere.

use jde_fuse::{Filter, State, Timeline};
use jde_motion::{is_finite, is_jump};
use jde_schema::prelude::*;
use jde_schema::types::Frame;

use crate::Ekf;
use crate::ports::{HeadingUse, covariance};
use crate::sensor::check_age;

/// The deviation of the place where an odometry begins by definition, m and rad.
const EXACT: f64 = 1e-4;
/// A heading with a larger variance says nothing, rad².
pub(crate) const MAX_HEADING_VARIANCE: f64 = 1.0;

/// What was known before a sleep or a reload.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    /// Where the frame of the odometry was in that of the export.
    pub(crate) frame: Pose2D,
    /// The covariance of the pose.
    pub(crate) covariance: [[f64; 3]; 3],
    /// The last odometry.
    pub(crate) rolled: Pose2D,
}

/// Where the robot is, when, and how well that is known, m and rad.
struct Begin {
    at: Pose2D,
    time: Duration,
    deviations: [f64; 2],
    frame: Option<Frame>,
}

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
        let oldest = self.history_length.get(cx);
        let odom = self.odom.get(cx);
        if self.odom.is_bound(cx) {
            let odom = odom.as_ref().ok_or("no odometry of the wheels yet")?;
            check_age("odometries", now, odom.time(), oldest)?;
            if !is_finite(odom) {
                return Err("the odometries have numbers that are none".to_owned());
            }
        }
        let wheels = odom.as_ref().map(|odom| (odom.time(), odom.pose2d()));
        let Begin {
            at,
            time,
            deviations: [position, heading],
            frame,
        } = self.place(cx, wheels)?;
        if !at.is_finite() || !position.is_finite() || !heading.is_finite() {
            return Err("the place has numbers or covariances that are none".to_owned());
        }
        if let (Some(before), Some(frame)) = (self.frame, frame)
            && before != frame
        {
            return Err(format!(
                "positions are in the frames \"{before}\" and \"{frame}\""
            ));
        }
        self.frame = self.frame.or(frame);
        let initial = self.errors.initial(cx, position, heading);
        let state = State {
            x: at.x,
            y: at.y,
            yaw: at.theta,
            bias: self.bias.unwrap_or(0.0),
            ..State::default()
        };
        let oldest = Duration::try_from_secs_f64(oldest).unwrap_or_default();
        // From the time at which the robot was there: the velocity is not known, and until the wheels measure it the
        // covariance grows by that.
        let time = time.clamp(now.saturating_sub(oldest), now);
        self.timeline = Some(Timeline::new(time, Filter::new(state, &initial), oldest));
        (self.kept, self.has_begun) = (None, true);
        Ok(())
    }

    fn place(&self, cx: &Context, wheels: Option<(Duration, Pose2D)>) -> Result<Begin, String> {
        let by_wheels = wheels.unwrap_or((cx.now(), Pose2D::ORIGIN));
        let initial = [
            self.initial.initial_deviation.get(cx),
            self.initial.initial_heading_deviation.get(cx),
        ];
        if let Some(at) = (self.initial.initial_pose.get(cx).get()).filter(|_| !self.has_begun) {
            return Ok(Begin {
                at,
                time: by_wheels.0,
                deviations: initial,
                frame: None,
            });
        }
        let by_pose = self.by_pose(cx, initial);
        if !self.position.is_bound(cx) && !self.pose.is_bound(cx) {
            return self.by_wheels(cx, by_wheels);
        }
        match by_pose {
            Err(words) if !self.position.is_bound(cx) => Err(words),
            Err(_) => self.by_position(cx, initial),
            by_pose => by_pose,
        }
    }

    /// Where the wheels say, from where the robot was before a sleep. That their odometry begins somewhere is exact.
    fn by_wheels(&self, cx: &Context, (time, wheels): (Duration, Pose2D)) -> Result<Begin, String> {
        let going_on = self
            .kept
            .filter(|kept| !is_jump(&kept.rolled, &wheels, self.jump.get(cx)));
        if self.has_begun && going_on.is_none() && self.initial.initial_pose.get(cx).get().is_some() {
            return Err(
                "the odometry jumped since it was used last, or was none: where the robot is now, is not known"
                    .to_owned(),
            );
        }
        let (at, deviations) = going_on.map_or((wheels, [EXACT; 2]), |kept| {
            let step = kept.rolled.localize(&wheels);
            (
                kept.frame.transform(&wheels),
                self.errors.on_the_way(cx, &kept.covariance, &step),
            )
        });
        Ok(Begin {
            at,
            time,
            deviations,
            frame: None,
        })
    }

    fn by_pose(&self, cx: &Context, [position, heading]: [f64; 2]) -> Result<Begin, String> {
        let pose = self.pose.get(cx).ok_or("no pose yet")?;
        check_age("poses", cx.now(), pose.time(), self.history_length.get(cx))?;
        let [[xx, ..], [_, yy, _], [.., heading_variance]] =
            covariance(&pose.pose.covariance, [position, position, heading]);
        if heading_variance > MAX_HEADING_VARIANCE {
            return Err("the poses do not know the heading".to_owned());
        }
        Ok(Begin {
            at: pose.pose2d(),
            time: pose.time(),
            deviations: [
                xx.max(yy).sqrt().max(position),
                heading_variance.sqrt().max(heading),
            ],
            frame: Some(pose.header.frame_id),
        })
    }

    fn by_position(&self, cx: &Context, [_, heading]: [f64; 2]) -> Result<Begin, String> {
        let (now, oldest) = (cx.now(), self.history_length.get(cx));
        let fix = self.position.get(cx).ok_or("no position yet")?;
        check_age("positions", now, fix.time(), oldest)?;
        if self.imu_use.imu_heading.get(cx) != HeadingUse::Absolute {
            return Err(
                "a position says no heading: give `initial_pose`, or an IMU with `imu_heading` absolute"
                    .to_owned(),
            );
        }
        let imu = self.imu.get(cx).ok_or("no heading of the IMU yet")?;
        check_age("IMU's values", now, imu.time(), oldest)?;
        let (yaw, variance) = self.absolute_heading(cx, &imu)?;
        // It may have turned between the two.
        let between = fix.time().abs_diff(imu.time()).as_secs_f64();
        let turned = between * {
            let Vector3 { x, y, z } = imu.angular_velocity;
            libm::hypot(libm::hypot(x, y), z)
        };
        let heading = libm::hypot(variance.sqrt().max(heading), turned);
        let antenna = Pose2D::new(self.antenna_x.get(cx), self.antenna_y.get(cx), 0.0);
        let from = Pose2D::new(0.0, 0.0, yaw).transform(&antenna);
        let stated = fix.covariance[0].max(fix.covariance[3]).max(0.0).sqrt();
        let position = stated.max(self.deviations.position_deviation.get(cx));
        Ok(Begin {
            at: Pose2D::new(fix.x - from.x, fix.y - from.y, yaw),
            time: fix.time(),
            deviations: [
                libm::hypot(position, libm::hypot(antenna.x, antenna.y) * heading),
                heading,
            ],
            frame: Some(fix.header.frame_id),
        })
    }

    /// The heading by a compass in the frame of the export, and its variance.
    fn absolute_heading(&self, cx: &Context, imu: &Imu) -> Result<(f64, f64), String> {
        let yaw = self.yaw(cx, imu);
        if imu.orientation_covariance[0] < 0.0 || !yaw.is_finite() {
            return Err("the IMU measures no orientation".to_owned());
        }
        let variance = imu.orientation_covariance[8];
        if variance > MAX_HEADING_VARIANCE {
            return Err("the IMU does not know the heading: has it a compass?".to_owned());
        }
        Ok((
            normalize_angle(yaw + self.imu_use.yaw_offset.get(cx)),
            if variance > 0.0 { variance } else { 0.0 },
        ))
    }

    /// Forgets where the robot is, and begins anew by what measures it.
    pub(crate) fn lose(&mut self) {
        self.bias = self.known_bias();
        (self.timeline, self.kept, self.turned) = (None, None, None);
        for sensor in [
            &mut self.sensors.position,
            &mut self.sensors.pose,
            &mut self.sensors.heading,
        ] {
            sensor.awake();
        }
    }

    /// The bias of the gyro that was learned.
    pub(crate) fn known_bias(&self) -> Option<f64> {
        if self.dispute.words().is_some() {
            return None;
        }
        (self.timeline.as_ref())
            .map(|timeline| timeline.newest().1.state().bias)
            .filter(|bias| bias.is_finite())
            .or(self.bias)
    }

    /// What is known for after a sleep. Positions say it themselves then.
    pub(crate) fn known(&self) -> Option<Kept> {
        let (Some(timeline), Some((_, rolled)), None) = (&self.timeline, self.rolled, self.frame) else {
            return self.kept;
        };
        if self.dispute.words().is_some() {
            return None;
        }
        let filter = timeline.newest().1;
        let State { x, y, yaw, .. } = *filter.state();
        Some(Kept {
            frame: Pose2D::new(x, y, yaw).transform(&rolled.localize(&Pose2D::ORIGIN)),
            covariance: filter.pose_covariance(),
            rolled,
        })
    }
}
