//! The battery of a robot: what it gives, and what is left.
//!
//! A model of a constant resistance and a straight line. It never charges, and a robot goes on when it is empty.

use crate::geometry::Twist2;

/// The charge of a full battery in ampere hours: three lead-acid blocks of 7.2 Ah, as a Pioneer carries them.
pub const BATTERY_CAPACITY: f64 = 3.0 * 7.2;

/// The open voltage of a block of six cells, empty and full.
const EMPTY_VOLTS: f64 = 11.7;
const FULL_VOLTS: f64 = 12.8;
/// Ohms of three blocks side by side, each of 0.09 Ω, and of their cables.
const RESISTANCE: f64 = 0.04;
/// Amperes of the electronics, the laser and the computer while the robot stands.
const IDLE: f64 = 1.6;
/// Amperes for each m/s: 10 N of rolling friction through motors and gears that make half of the power into motion.
const PER_METRE_A_SECOND: f64 = 1.7;
/// Amperes for each rad/s on the spot: each wheel rolls half a track of 0.36 m.
const PER_RADIAN_A_SECOND: f64 = 0.4;
/// Amperes of wheels that want to turn and are held, which is where the motor controller limits them.
const STALLED: f64 = 4.0;

/// What is known of a battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    /// Volts at the terminals, under the load of the moment.
    pub voltage: f64,
    /// What is left of [`BATTERY_CAPACITY`], from 0 to 1.
    pub charge: f64,
    /// Amperes; negative while it discharges.
    pub current: f64,
}

impl Battery {
    /// A full battery under a robot that stands.
    pub(crate) fn full() -> Self {
        let mut battery = Self {
            voltage: FULL_VOLTS,
            charge: 1.0,
            current: 0.0,
        };
        battery.step(Twist2::default(), false, 0.0);
        battery
    }

    /// Gives for `dt` seconds what a motion takes.
    pub(crate) fn step(&mut self, twist: Twist2, stalled: bool, dt: f64) {
        let motion = PER_METRE_A_SECOND * twist.linear.abs() + PER_RADIAN_A_SECOND * twist.angular.abs();
        let draw = IDLE + motion + if stalled { STALLED } else { 0.0 };
        self.charge = (self.charge - draw * dt / 3600.0 / BATTERY_CAPACITY).max(0.0);
        self.current = -draw;
        self.voltage = EMPTY_VOLTS + (FULL_VOLTS - EMPTY_VOLTS) * self.charge - RESISTANCE * draw;
    }
}
