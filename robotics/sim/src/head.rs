//! The pan-tilt head of a robot: two axes that turn at the commanded speeds, up to their limits.
//!
//! It has no inertia, and does not depend on the cameras on it.

use crate::error::{WorldError, check};

/// A pan-tilt head on a robot. By default a Canon VC-C4.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadConfig {
    /// Where the two axes cross, in the robot's frame: ahead, to the left and above the floor, in metres.
    pub mount: [f64; 3],
    /// Greatest pan to either side, in radians.
    pub max_pan: f64,
    /// Greatest tilt down, in radians.
    pub max_tilt_down: f64,
    /// Greatest tilt up, in radians, as a positive number.
    pub max_tilt_up: f64,
    /// Greatest speed of the pan, in rad/s.
    pub max_pan_speed: f64,
    /// Greatest speed of the tilt, in rad/s.
    pub max_tilt_speed: f64,
}

/// A direction for a head, and the speeds at which to turn there. All zero keeps the head as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadCommand {
    /// Radians to the left.
    pub pan: f64,
    /// Radians down.
    pub tilt: f64,
    /// Radians a second; the sign is ignored, and 0 holds the pan where it is.
    pub pan_speed: f64,
    /// Radians a second; the sign is ignored, and 0 holds the tilt where it is.
    pub tilt_speed: f64,
}

/// The direction of a head, and its turn rates over the last step of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Head {
    /// Radians to the left of the robot's heading.
    pub pan: f64,
    /// Radians down: REP-103's positive direction about the axis to the left.
    pub tilt: f64,
    /// Radians a second to the left.
    pub pan_velocity: f64,
    /// Radians a second down.
    pub tilt_velocity: f64,
}

impl Default for HeadConfig {
    fn default() -> Self {
        Self {
            // On the top plate of a P3-DX, a little ahead of its middle.
            mount: [0.05, 0.0, 0.35],
            // The specification of the VC-C4 is 100 degrees to the sides, 90 up and 30 down. Two degrees of
            // pan and of tilt up are kept as a margin.
            max_pan: 98f64.to_radians(),
            max_tilt_down: 30f64.to_radians(),
            max_tilt_up: 88f64.to_radians(),
            max_pan_speed: 90f64.to_radians(),
            max_tilt_speed: 70f64.to_radians(),
        }
    }
}

impl HeadConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        let angle = |value: f64| (0.0..=std::f64::consts::PI).contains(&value);
        for (what, value) in ["head mount.x", "head mount.y", "head mount.z"]
            .into_iter()
            .zip(self.mount)
        {
            check(what, value, "a finite number", |_| true)?;
        }
        check("head max_pan", self.max_pan, "0 to π rad", angle)?;
        check("head max_tilt_down", self.max_tilt_down, "0 to π rad", angle)?;
        check("head max_tilt_up", self.max_tilt_up, "0 to π rad", angle)?;
        let speed = |value: f64| (0.0..=100.0).contains(&value);
        check("head max_pan_speed", self.max_pan_speed, "0 to 100 rad/s", speed)?;
        check(
            "head max_tilt_speed",
            self.max_tilt_speed,
            "0 to 100 rad/s",
            speed,
        )
    }
}

impl HeadCommand {
    pub(crate) fn is_finite(self) -> bool {
        [self.pan, self.tilt, self.pan_speed, self.tilt_speed]
            .iter()
            .all(|value| value.is_finite())
    }
}

impl Head {
    /// Turns for `dt` seconds.
    pub(crate) fn step(&mut self, config: &HeadConfig, command: HeadCommand, dt: f64) {
        let pan = command.pan.clamp(-config.max_pan, config.max_pan);
        let tilt = command.tilt.clamp(-config.max_tilt_up, config.max_tilt_down);
        (self.pan, self.pan_velocity) = turn(self.pan, pan, command.pan_speed, config.max_pan_speed, dt);
        (self.tilt, self.tilt_velocity) =
            turn(self.tilt, tilt, command.tilt_speed, config.max_tilt_speed, dt);
    }
}

/// Returns the angle after `dt` seconds, and the velocity that led there.
fn turn(angle: f64, target: f64, speed: f64, fastest: f64, dt: f64) -> (f64, f64) {
    let stride = speed.abs().min(fastest) * dt;
    let change = (target - angle).clamp(-stride, stride);
    // The target angle is reached exactly.
    let next = if (target - angle).abs() <= stride && stride > 0.0 {
        target
    } else {
        angle + change
    };
    (next, change / dt)
}
