//! The drive to the docking place, in the frame of the mark: x away from the mark, so that the line to follow is y = 0.

use jde_schema::prelude::*;

use crate::astray;

/// Where the base shall be, and how fast.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    pub(crate) leave: bool,
    pub(crate) distance: f64,
    pub(crate) off: f64,
    pub(crate) margin: f64,
    pub(crate) speed: f64,
    pub(crate) turn: f64,
    /// The least speed and turn rate at which the base moves, m/s and rad/s.
    pub(crate) least: (f64, f64),
    /// A heading toward the mark that is exact enough, rad.
    pub(crate) heading: f64,
}

/// What the base does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Manoeuvre {
    #[default]
    Approach,
    /// Straight back.
    Back,
    /// Turns toward the mark.
    Turn,
    /// It is where it shall be.
    There,
}

/// The drive so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Course {
    step: Manoeuvre,
    leaves: bool,
}

/// How near the place is near enough, m: a tenth of what is promised.
const POSITION_TOLERANCE: f64 = 0.002;
/// A heading at the docking place from which on it begins anew, rad: two degrees, or twice what is exact enough.
const HEADING_ERROR: f64 = 0.035;
/// The length along which a deviation from the line decays, m.
const DECAY: f64 = 0.25;
/// The steepest way to the line, rad.
const MAX_ANGLE: f64 = 0.9;
/// The largest deviation beside the docking place, m, and how much larger it may be for each metre before it: the base
/// still gets onto the line.
const LATERAL_TOLERANCE: (f64, f64) = (0.012, 0.5);
/// Nearer to the docking place than this, m, a larger deviation makes it begin anew.
const DECISION: f64 = 0.5;
/// How far back it drives to begin anew: at least, for each metre beside the line, and at most, m.
const BACKUP_DISTANCE: (f64, f64, f64) = (0.3, 2.0, 1.2);
/// Speed for each metre to go, 1/s.
const APPROACH_GAIN: f64 = 1.0;
/// Turn rate for each radian, 1/s.
const TURN_GAIN: f64 = 2.0;

impl Course {
    /// Returns what to do at a pose.
    pub(crate) fn step(&mut self, local: &Pose2D, goal: &Goal) -> Manoeuvre {
        if self.leaves != goal.leave {
            *self = Self {
                step: Manoeuvre::default(),
                leaves: goal.leave,
            };
        }
        self.step = if goal.leave {
            leaving(self.step, local, goal)
        } else {
            docking(self.step, local, goal)
        };
        self.step
    }

    /// Returns the speed ahead and the turn rate.
    pub(crate) fn command(&self, step: Manoeuvre, local: &Pose2D, goal: &Goal) -> [f64; 2] {
        let rate = |error: f64, least: f64| {
            let rate = (TURN_GAIN * error.abs()).clamp(least, goal.turn.max(least));
            rate.copysign(error)
        };
        let heading = astray(local);
        match step {
            Manoeuvre::There => [0.0; 2],
            Manoeuvre::Turn => [0.0, rate(-heading, goal.least.1)],
            Manoeuvre::Approach => {
                // Facing the mark, +y is to the right: the way to the line is a turn to the left for a positive y.
                let wanted = steer(local.y);
                let error = wanted - heading;
                let left = (local.x - goal.distance).max(0.0);
                let speed = (APPROACH_GAIN * left).clamp(goal.least.0, goal.speed.max(goal.least.0));
                // It turns before it drives when it looks elsewhere.
                [speed * (1.0 - error.abs() / MAX_ANGLE).max(0.0), rate(error, 0.0)]
            }
            Manoeuvre::Back => {
                let error = -steer(local.y) / 2.0 - heading;
                [
                    -goal.speed * (1.0 - error.abs() / MAX_ANGLE).max(0.0),
                    rate(error, 0.0),
                ]
            }
        }
    }
}

/// Returns the heading, relative to that toward the mark, that leads to the line.
fn steer(y: f64) -> f64 {
    libm::atan(y / DECAY).clamp(-MAX_ANGLE, MAX_ANGLE)
}

fn docking(step: Manoeuvre, local: &Pose2D, goal: &Goal) -> Manoeuvre {
    let left = local.x - goal.distance;
    let beside = local.y.abs() > LATERAL_TOLERANCE.0 + LATERAL_TOLERANCE.1 * left.max(0.0);
    match step {
        Manoeuvre::There
            if libm::hypot(left, local.y) <= goal.margin
                && astray(local).abs() <= HEADING_ERROR.max(2.0 * goal.heading) =>
        {
            Manoeuvre::There
        }
        Manoeuvre::Turn if astray(local).abs() <= goal.heading => Manoeuvre::There,
        Manoeuvre::Turn => Manoeuvre::Turn,
        Manoeuvre::Back
            if left
                < BACKUP_DISTANCE
                    .2
                    .min(BACKUP_DISTANCE.0 + BACKUP_DISTANCE.1 * local.y.abs()) =>
        {
            Manoeuvre::Back
        }
        Manoeuvre::There | Manoeuvre::Approach | Manoeuvre::Back => {
            let too_near = left < -goal.margin;
            if too_near || (beside && left < DECISION) {
                Manoeuvre::Back
            } else if left <= POSITION_TOLERANCE {
                Manoeuvre::Turn
            } else {
                Manoeuvre::Approach
            }
        }
    }
}

fn leaving(step: Manoeuvre, local: &Pose2D, goal: &Goal) -> Manoeuvre {
    let enough = if step == Manoeuvre::There {
        goal.off - goal.margin
    } else {
        goal.off
    };
    if local.x >= enough {
        Manoeuvre::There
    } else {
        Manoeuvre::Back
    }
}
