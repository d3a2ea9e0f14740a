//! The battery of a robot: its voltage, current and charge.
//!
//! The model is a constant resistance and a linear voltage. A robot keeps driving when its battery is empty.

use crate::geometry::Twist2;

/// The charge of a full battery in ampere hours: three lead-acid blocks of 7.2 Ah, as in a Pioneer.
pub const BATTERY_CAPACITY: f64 = 3.0 * 7.2;

/// The open-circuit voltage of a block of six cells, empty and full.
const EMPTY_VOLTS: f64 = 11.7;
const FULL_VOLTS: f64 = 12.8;
/// Ohms of three blocks in parallel, each of 0.09 Ω, and of their cables.
const RESISTANCE: f64 = 0.04;
/// Amperes of the electronics, the laser and the computer while the robot is at rest.
const IDLE: f64 = 1.6;
/// Amperes for each m/s: 10 N of rolling friction, through motors and gears with an efficiency of one half.
const PER_METRE_A_SECOND: f64 = 1.7;
/// Amperes for each rad/s on the spot: each wheel rolls on half a track of 0.36 m.
const PER_RADIAN_A_SECOND: f64 = 0.4;
/// Extra amperes of blocked wheels: the limit of the motor controller.
const STALLED: f64 = 4.0;

/// The state of a battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    /// Volts at the terminals, under the present load.
    pub voltage: f64,
    /// The remaining part of the capacity, from 0 to 1.
    pub charge: f64,
    /// Amperes; negative while it discharges, 0 while it is full on a charger.
    pub current: f64,
    /// Ampere hours of a full battery.
    pub capacity: f64,
}

impl Battery {
    /// Creates a full battery under a robot at rest.
    pub(crate) fn full(capacity: f64) -> Self {
        let mut battery = Self {
            voltage: FULL_VOLTS,
            charge: 1.0,
            current: 0.0,
            capacity,
        };
        battery.step(Twist2::default(), false, 0.0, 0.0);
        battery
    }

    /// Discharges the battery by `dt` seconds of a motion, and charges it by the amperes of a charger.
    pub(crate) fn step(&mut self, twist: Twist2, stalled: bool, supply: f64, dt: f64) {
        let motion = PER_METRE_A_SECOND * (twist.linear.abs() + twist.lateral.abs())
            + PER_RADIAN_A_SECOND * twist.angular.abs();
        let draw = IDLE + motion + if stalled { STALLED } else { 0.0 };
        self.current = supply - draw;
        self.charge = (self.charge + self.current * dt / 3600.0 / self.capacity).clamp(0.0, 1.0);
        if self.charge >= 1.0 {
            self.current = self.current.min(0.0);
        }
        self.voltage = EMPTY_VOLTS + (FULL_VOLTS - EMPTY_VOLTS) * self.charge + RESISTANCE * self.current;
    }
}
