//! The motor schema of the suite: it commands the values of its modulations.

use jde_schema::prelude::*;

/// Commands the speeds of its modulations.
#[derive(Describe)]
#[schema(motor, period = "50ms")]
pub(crate) struct Pilot {
    /// Speed ahead.
    #[modulation(default = 0.0, unit = "m/s")]
    linear: Modulation<f64>,
    /// Turn rate.
    #[modulation(default = 0.0, unit = "rad/s")]
    angular: Modulation<f64>,
    /// Pan of the head, to the left.
    #[modulation(default = 0.0, unit = "rad")]
    pan: Modulation<f64>,
    /// Tilt of the head, down.
    #[modulation(default = 0.0, unit = "rad")]
    tilt: Modulation<f64>,
    /// Turn rate of the head; 0 commands nothing.
    #[modulation(default = 0.0, unit = "rad/s")]
    speed: Modulation<f64>,
    /// Above 0, the schema commands nothing.
    #[modulation(default = 0.0)]
    silent: Modulation<f64>,
    /// The base.
    #[actuator]
    base: Actuator<Twist>,
    /// The head.
    #[actuator(optional)]
    head: Actuator<PanTilt>,
}

/// Imports the robot's odometry, and never becomes READY. This keeps the driver awake without a pilot.
#[derive(Describe)]
#[schema(motor, period = "50ms")]
pub(crate) struct Watcher {
    /// The import keeps the driver awake.
    #[import]
    odometry: Import<Odometry>,
}

impl Schema for Pilot {
    fn iterate(&mut self, cx: &Context) -> Result {
        if self.silent.get(cx) > 0.0 {
            return Ok(());
        }
        self.base
            .command(cx, Twist::planar(self.linear.get(cx), self.angular.get(cx)));
        let speed = self.speed.get(cx);
        if speed > 0.0 {
            let target = PanTilt {
                pan: self.pan.get(cx),
                tilt: self.tilt.get(cx),
                pan_velocity: speed,
                tilt_velocity: speed,
                ..PanTilt::default()
            };
            self.head.command(cx, target);
        }
        Ok(())
    }
}

impl Schema for Watcher {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        debug_assert!(self.odometry.is_bound(cx), "the import is bound");
        Ok(false.into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}
