//! The state by which the guard judges: where the joints are, what they may do, and where the arm may not be.

use core::time::Duration;

use jde_schema::prelude::*;
use jde_schema::types::{JointState, Zones};

use super::plane;

/// The names of the joints.
pub(super) const JOINT_NAMES: [&str; 2] = ["shoulder", "elbow"];
/// The poses on the way to a stop that are examined: at 2 rad/s the hand moves some centimetres from one to the next.
const STOP_SAMPLES: u32 = 12;
/// The parts of a command that it limits it to, the greatest first.
const LIMITED_PARTS: [f64; 5] = [0.75, 0.5, 0.25, 0.1, 0.05];
/// What rounding may do to a distance, m, and to an angle, rad.
const ROUNDING_ERROR: f64 = 1e-6;

/// Where an arm is and what it may do. Each list has the shoulder, then the elbow.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/ArmState")]
pub struct ArmState {
    /// Angles of the joints.
    #[value(unit = "rad")]
    pub angles: [f64; 2],
    /// Speeds of the joints.
    #[value(unit = "rad/s")]
    pub speeds: [f64; 2],
    /// Least angles.
    #[value(unit = "rad")]
    pub least: [f64; 2],
    /// Greatest angles.
    #[value(unit = "rad")]
    pub greatest: [f64; 2],
    /// Lengths of the upper arm and the forearm.
    #[value(unit = "m")]
    pub links: [f64; 2],
    /// Where no part of the arm may be, in the frame of the shoulder.
    pub zones: Zones,
    /// Distance to keep from the zones.
    #[value(unit = "m")]
    pub margin: f64,
    /// Time for which a command is in force.
    #[value(unit = "s")]
    pub reaction: f64,
    /// Greatest decline of the speed of a joint.
    #[value(unit = "rad/s2")]
    pub deceleration: f64,
}

impl ArmState {
    /// Judges the speeds of the joints by where the arm stops after them.
    ///
    /// # Errors
    /// What the arm would do.
    pub(super) fn judge(&self, age: Duration, command: &JointState) -> Result<(), String> {
        let wanted = speeds(command)?;
        if wanted == [0.0; 2] {
            return Ok(());
        }
        let now = [0, 1].map(|joint| self.angles[joint] + self.speeds[joint] * age.as_secs_f64());
        let way = [0, 1].map(|joint| self.way(joint, wanted[joint]));
        for (joint, name) in JOINT_NAMES.into_iter().enumerate() {
            let stop = now[joint] + way[joint];
            let beyond = |angle: f64| (self.least[joint] - angle).max(angle - self.greatest[joint]);
            if beyond(stop) > beyond(now[joint]).max(0.0) + ROUNDING_ERROR {
                let limit = if way[joint] < 0.0 {
                    self.least[joint]
                } else {
                    self.greatest[joint]
                };
                return Err(format!(
                    "the {name} would stop at {stop:.2} rad, beyond {limit:.2} rad"
                ));
            }
        }
        let least = self.gap(now).min(self.margin) - ROUNDING_ERROR;
        for sample in 1..=STOP_SAMPLES {
            let share = f64::from(sample) / f64::from(STOP_SAMPLES);
            let gap = self.gap([0, 1].map(|joint| now[joint] + share * way[joint]));
            if gap < least {
                return Err(format!(
                    "the arm would come within {gap:.2} m of a forbidden zone"
                ));
            }
        }
        Ok(())
    }

    /// Returns the greatest part of a command that it accepts.
    pub(super) fn limit(&self, age: Duration, command: &JointState) -> Option<JointState> {
        let parts = LIMITED_PARTS.into_iter().map(|part| {
            let mut lesser = *command;
            for speed in lesser.velocity.as_mut_slice() {
                *speed *= part;
            }
            lesser
        });
        parts.into_iter().find(|lesser| self.judge(age, lesser).is_ok())
    }

    /// Returns how far a joint turns until it stands: it has the greater of its speed and the commanded one while the
    /// command is in force, and then brakes.
    fn way(&self, joint: usize, wanted: f64) -> f64 {
        let now = self.speeds[joint];
        let speed = if now * wanted > 0.0 && now.abs() > wanted.abs() {
            now
        } else {
            wanted
        };
        speed * self.reaction + speed * speed.abs() / (2.0 * self.deceleration)
    }

    /// Returns the distance from the arm to the nearest zone.
    fn gap(&self, [shoulder, elbow]: [f64; 2]) -> f64 {
        let reach = |from: [f64; 2], angle: f64, length: f64| {
            [
                from[0] + length * libm::cos(angle),
                from[1] + length * libm::sin(angle),
            ]
        };
        let bend = reach([0.0; 2], shoulder, self.links[0]);
        let hand = reach(bend, shoulder + elbow, self.links[1]);
        let zones = self.zones.zones.iter();
        let gaps =
            zones.flat_map(|zone| [[[0.0; 2], bend], [bend, hand]].map(|link| plane::distance(link, zone)));
        gaps.fold(f64::INFINITY, f64::min)
    }
}

/// Returns the speeds of a command. Without names it is the neutral one.
fn speeds(command: &JointState) -> Result<[f64; 2], String> {
    if command.velocity.is_empty() && command.position.is_empty() {
        return Ok([0.0; 2]);
    }
    let of = |name| {
        command
            .joint(name)
            .and_then(|place| command.velocity.get(place).copied())
    };
    match JOINT_NAMES.map(of) {
        [Some(shoulder), Some(elbow)] if command.name.len() == JOINT_NAMES.len() => Ok([shoulder, elbow]),
        _ => Err(String::from("it is not the speeds of the shoulder and the elbow")),
    }
}
