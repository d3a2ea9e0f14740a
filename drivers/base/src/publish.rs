//! Exports what the board reports in the standard interfaces: SI units, REP-103 axes. What it has not is not exported.

use core::time::Duration;

use jde_schema::prelude::*;

use crate::Serial;
use crate::hello::Kind;
use crate::odometer::Step;
use crate::report::{Motion, Report};

impl Serial {
    /// Publishes a report that was made at `time`, and where the base is then.
    pub(crate) fn publish(&mut self, cx: &Context, report: &Report, step: &Step, time: Duration) -> Result {
        let Some(hello) = &self.state.hello else {
            return Ok(());
        };
        if !core::mem::replace(&mut self.state.has_exports, true) {
            self.dynamics.write(cx, hello.dynamics);
        }
        let header = Header::new(time, "base_link");
        let pose = self.state.pose.unwrap_or(Pose2D::ORIGIN);
        let was_following = self.state.is_following;
        self.state.is_following = !report.stalled && report.acknowledged.is_some();
        if was_following && !self.state.is_following {
            self.state.setpoint = jde_motion::Setpoint::default();
            self.setpoint.retract(cx);
        }
        // A board that has stopped its motors may have an encoder that counts wrongly.
        let was_stalled = core::mem::replace(&mut self.state.is_stalled, report.stalled);
        if report.stalled {
            if !was_stalled {
                self.odometry.retract(cx);
            }
        } else {
            self.odometry
                .write_at(cx, Odometry::planar(time, pose, step.twist), time);
        }
        if let (Kind::Differential { ticks_per_metre, .. }, Motion::Counts(_)) = (hello.kind, report.motion) {
            let [left, right] = self.state.ticks;
            let encoders = WheelEncoders {
                header,
                left,
                right,
                ticks_per_meter: ticks_per_metre,
            };
            self.encoders.write_at(cx, encoders, time);
        }
        if let Some(volts) = report.battery {
            let percentage = hello.battery.map_or(f32::NAN, |[empty, full]| {
                ((volts - empty) / (full - empty)).clamp(0.0, 1.0)
            });
            let battery = BatteryState {
                header,
                voltage: volts,
                percentage,
                present: Flag::TRUE,
                ..BatteryState::default()
            };
            self.battery.write_at(cx, battery, time);
        }
        if let Some([gyro, acceleration]) = report.imu {
            let vector = |[x, y, z]: [f64; 3]| Vector3 { x, y, z };
            let mut imu = Imu {
                header: Header::new(time, "imu"),
                angular_velocity: vector(gyro),
                linear_acceleration: vector(acceleration),
                ..Imu::default()
            };
            imu.orientation_covariance[0] = -1.0;
            self.imu.write_at(cx, imu, time);
        }
        self.publish_bumpers(cx, report, header, time)
    }

    /// A board without bumpers says at least whether its wheels are blocked.
    fn publish_bumpers(&mut self, cx: &Context, report: &Report, header: Header, time: Duration) -> Result {
        let mut bumpers = Bumpers {
            header,
            stalled: report.stalled.into(),
            ..Bumpers::default()
        };
        let flags =
            |pressed: &[bool]| -> Vec<Flag> { pressed.iter().map(|pressed| (*pressed).into()).collect() };
        bumpers
            .front
            .extend_from_slice(&flags(report.front.as_deref().unwrap_or_default()))?;
        bumpers
            .rear
            .extend_from_slice(&flags(report.rear.as_deref().unwrap_or_default()))?;
        self.bumpers.write_at(cx, bumpers, time);
        Ok(())
    }

    /// Publishes what the motors are led to by a command that counts from now on.
    pub(crate) fn publish_setpoint(&mut self, cx: &Context, wanted: Twist) {
        let Some(hello) = &self.state.hello else { return };
        if self.state.has_exports && self.state.is_following && hello.dynamics.check().is_ok() {
            let strives = self.state.setpoint.update(cx.now(), wanted, &hello.dynamics);
            self.setpoint.write(cx, strives);
        }
    }

    /// Retracts the exports, because they no longer describe the base.
    pub(crate) fn retract_exports(&mut self, cx: &Context) {
        if !core::mem::take(&mut self.state.has_exports) {
            return;
        }
        self.state.setpoint = jde_motion::Setpoint::default();
        self.state.is_following = false;
        self.state.is_stalled = false;
        self.odometry.retract(cx);
        self.encoders.retract(cx);
        self.bumpers.retract(cx);
        self.battery.retract(cx);
        self.imu.retract(cx);
        self.dynamics.retract(cx);
        self.setpoint.retract(cx);
    }
}
