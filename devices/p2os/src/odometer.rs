//! One continuous pose from the wrapping positions of the robot. It measures nothing and knows no map.

use core::time::Duration;

use crate::{Model, Sip};

/// The pose of a robot, in a fixed frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Ahead of the frame's origin, m.
    pub x: f64,
    /// To the left of the frame's origin, m.
    pub y: f64,
    /// Counter-clockwise, from −π to π rad.
    pub heading: f64,
}

/// Integrates the positions of SIPs.
///
/// Positions may wrap in both directions. A step that the robot cannot have driven is not a motion: the
/// robot's origin was changed, and the pose stays the same.
#[derive(Clone, Debug)]
pub struct Odometer {
    pose: Pose,
    last: Option<Sample>,
    jumps: u64,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    x: u16,
    y: u16,
    heading: f64,
    time: Duration,
}

/// How much farther than its limits a robot may seem to have moved: bytes may arrive late, and firmware
/// rounds.
const SLACK_M: f64 = 0.25;
const SLACK_RAD: f64 = 0.5;
/// A factor for the same reason: SIPs that were delayed together seem closer in time than they are.
const SLACK_FACTOR: f64 = 2.0;

impl Odometer {
    /// Starts at a pose, whatever origin the robot has.
    #[must_use]
    pub fn new(start: Pose) -> Self {
        Self {
            pose: start,
            last: None,
            jumps: 0,
        }
    }

    /// Adds the position of a SIP that arrived by `now`. Returns the pose.
    pub fn update(&mut self, model: &Model, sip: &Sip, now: Duration) -> Pose {
        let sample = Sample {
            x: sip.x,
            y: sip.y,
            heading: model.angle(sip.th),
            time: now,
        };
        if let Some(last) = self.last.replace(sample) {
            self.step(model, &last, &sample);
        }
        self.pose
    }

    /// Identifies the next position with the present pose, since the robot's counts may restart, as after a
    /// new connection.
    pub fn rebase(&mut self) {
        self.last = None;
    }

    /// Returns the pose at the last SIP.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Returns how many times the robot's origin was changed.
    #[must_use]
    pub fn jumps(&self) -> u64 {
        self.jumps
    }

    fn step(&mut self, model: &Model, last: &Sample, sample: &Sample) {
        let bits = model.units.position_bits;
        let meters = |from, to| f64::from(difference(from, to, bits)) * model.units.distance_mm / 1000.0;
        let (dx, dy) = (meters(last.x, sample.x), meters(last.y, sample.y));
        let turn = wrap(sample.heading - last.heading);
        let elapsed = sample.time.saturating_sub(last.time).as_secs_f64() * SLACK_FACTOR;
        let largest_distance = SLACK_M + elapsed * model.limits.velocity_mm_s / 1000.0;
        let largest_turn = SLACK_RAD + elapsed * model.limits.rotation_deg_s.to_radians();
        if libm::hypot(dx, dy) > largest_distance || turn.abs() > largest_turn {
            self.jumps += 1;
            return;
        }
        // Rotate from the robot's frame to the odometer's, by the difference of their headings.
        let (sin, cos) = libm::sincos(self.pose.heading - last.heading);
        self.pose.x += dx * cos - dy * sin;
        self.pose.y += dx * sin + dy * cos;
        self.pose.heading = wrap(self.pose.heading + turn);
    }
}

/// Returns the shorter way between two counts that wrap after `bits` bits, positive if it counts up.
#[must_use]
pub(crate) fn difference(from: u16, to: u16, bits: u32) -> i32 {
    let span = 1 << bits.min(16);
    let up = (i32::from(to) - i32::from(from)).rem_euclid(span);
    if up >= span / 2 { up - span } else { up }
}

/// Normalizes an angle to −π to π rad; an angle that is not finite becomes 0.
#[must_use]
pub(crate) fn wrap(angle: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    let wrapped = (angle + PI).rem_euclid(TAU) - PI;
    if wrapped.is_finite() { wrapped } else { 0.0 }
}
