//! Whether a robot can stop before it touches what it sees: the basis of collision checks.
//!
//! It knows static points only. It allocates nothing, so that a guard can call it in each period.

use jde_types::{Point2D, Pose2D, Twist};

use crate::{BaseDynamics, Outline, Travel};

/// Time from one simulated pose to the next, s. At 1 m/s a robot moves 2 cm in a step, about the noise of
/// a scanner.
const STEP: f64 = 0.02;
/// Greatest simulated time, s. A base that needs longer to stop counts as one that touches.
const HORIZON: f64 = 30.0;
/// Distance that counts as touching, m. It covers the error of the simulated position.
const SKIN: f64 = 1e-3;

/// A command that takes effect after a time, is held, and then a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maneuver {
    /// The present velocity of the base, in its frame.
    pub velocity: Twist,
    /// What the velocity lacks of the one that the base strives for at present.
    pub lead: Twist,
    /// How long the base goes on striving for that before the command takes effect, s.
    pub wait: f64,
    /// The command, in the frame of the base.
    pub command: Twist,
    /// How long the base follows the command before it brakes, s: at least the time until the next check
    /// takes effect.
    pub hold: f64,
    /// How the base follows.
    pub dynamics: BaseDynamics,
}

/// The end of a maneuver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stopping {
    /// The robot stops without touching a point.
    Free,
    /// The robot could touch a point.
    Touches {
        /// When, s after the start; at most one step early.
        after: f64,
        /// The point, in the frame of the base at the start.
        point: Point2D,
    },
    /// A velocity, the time or a limit is not finite, a limit is not above 0, or the stop takes longer than
    /// 30 s.
    Unknown,
}

impl Stopping {
    /// Whether the robot stops without touching a point.
    #[must_use]
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free)
    }
}

impl Maneuver {
    /// Returns whether `outline` stays clear of `points` by `margin` m until it stands still.
    ///
    /// It advances conservatively (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996): after a clearance of
    /// `c` m nothing is computed until a point of the outline can have moved by `c` m. Time: the points once
    /// in open space, and more often the closer they are.
    #[must_use]
    pub fn stopping(&self, outline: &Outline, points: &[Point2D], margin: f64) -> Stopping {
        if !self.is_valid() || !margin.is_finite() {
            return Stopping::Unknown;
        }
        let (mut travel, mut safe, mut time) = (self.start(), 0.0, 0.0);
        while time < HORIZON {
            let Some((step, next)) = self.next(time, &travel) else {
                return Stopping::Free;
            };
            let fastest = speed(&travel.velocity, outline).max(speed(&next.velocity, outline));
            let moved = fastest * step;
            if moved >= safe {
                safe = outline.clearance(&travel.pose, points) - margin - SKIN;
                // A robot that stands still among close points may stay there.
                if moved > 0.0 && safe <= moved {
                    return Stopping::Touches {
                        after: time,
                        point: nearest(outline, &travel.pose, points),
                    };
                }
            }
            safe -= moved;
            time += step;
            travel = next;
        }
        Stopping::Unknown
    }

    /// Returns whether `outline` comes no closer to `points` than if the command were to stand, up to 0.1 mm, and does not
    /// touch them by that: how a robot that is too close may still move. A base that is measured to move by some mm/s
    /// comes that much closer whatever the command is. A point that is touched already counts for itself, and permits
    /// nothing with the others: those keep `margin` m, or come no closer. Time: the points twice for each step of 20 ms,
    /// and each touched point once more.
    #[must_use]
    pub fn keeps_clear(&self, outline: &Outline, points: &[Point2D], margin: f64) -> bool {
        /// Points of a part, which is as large as the stack of any thread allows.
        const PART: usize = 256;
        let clearance = |points: &[Point2D]| outline.clearance(&Pose2D::ORIGIN, points);
        if !self.is_valid() {
            return false;
        }
        if clearance(points) > SKIN {
            return self.comes_no_closer(outline, points);
        }
        points.chunks(PART).all(|part| {
            let (mut others, mut count) = ([Point2D::default(); PART], 0);
            for point in part {
                let one = core::slice::from_ref(point);
                if clearance(one) > SKIN {
                    others[count] = *point;
                    count += 1;
                } else if !self.comes_no_closer(outline, one) {
                    return false;
                }
            }
            let others = &others[..count];
            self.stopping(outline, others, margin).is_free() || self.comes_no_closer(outline, others)
        })
    }

    /// Whether the least distance to all points is no less than if the command were to stand.
    fn comes_no_closer(&self, outline: &Outline, points: &[Point2D]) -> bool {
        /// Far below what a sensor measures, and far above rounding.
        const TOLERANCE: f64 = 1e-4;
        let stand = Self {
            command: Twist::ZERO,
            ..*self
        };
        let least = |maneuver: &Self| maneuver.least_clearance(outline, points);
        let (Some(of_stand), Some(own)) = (least(&stand), least(self)) else {
            return false;
        };
        let now = outline.clearance(&Pose2D::ORIGIN, points);
        let touch = if now > SKIN { SKIN } else { now - SKIN };
        own >= of_stand.max(touch) - TOLERANCE
    }

    /// Returns the least distance from `outline` to `points` until it stands still, m; `None` if that takes too long.
    fn least_clearance(&self, outline: &Outline, points: &[Point2D]) -> Option<f64> {
        let (mut travel, mut time) = (self.start(), 0.0);
        let mut least = outline.clearance(&travel.pose, points);
        while time < HORIZON {
            let Some((step, next)) = self.next(time, &travel) else {
                return Some(least);
            };
            least = least.min(outline.clearance(&next.pose, points));
            time += step;
            travel = next;
        }
        None
    }

    fn start(&self) -> Travel {
        Travel {
            velocity: self.velocity,
            lead: self.lead,
            ..Travel::default()
        }
    }

    /// Returns the duration of the next step at `time`, s, and the travel after it; `None` if the base stands after the
    /// command.
    fn next(&self, time: f64, travel: &Travel) -> Option<(f64, Travel)> {
        let (effect, end) = (self.wait, self.wait + self.hold);
        let (left, goal) = if time < effect {
            (effect - time, added(&self.velocity, &self.lead))
        } else if time < end {
            (end - time, self.command)
        } else if is_still(&travel.velocity) && is_still(&travel.lead) {
            return None;
        } else {
            (STEP, Twist::ZERO)
        };
        let step = STEP.min(left);
        Some((step, travel.after(step, &goal, &self.dynamics)))
    }

    fn is_valid(&self) -> bool {
        let numbers = [&self.velocity, &self.lead, &self.command];
        self.dynamics.is_valid()
            && self.wait.is_finite()
            && self.hold.is_finite()
            && numbers
                .iter()
                .all(|twist| parts(twist).iter().all(|part| part.is_finite()))
    }
}

/// The point nearest to the outline at `pose`; the origin if there is none.
fn nearest(outline: &Outline, pose: &Pose2D, points: &[Point2D]) -> Point2D {
    let distance = |point: &Point2D| outline.clearance(pose, core::slice::from_ref(point));
    let order = |a: &&Point2D, b: &&Point2D| distance(a).total_cmp(&distance(b));
    points.iter().min_by(order).copied().unwrap_or_default()
}

fn added(a: &Twist, b: &Twist) -> Twist {
    let mut sum = Twist::planar(a.linear.x + b.linear.x, a.angular.z + b.angular.z);
    sum.linear.y = a.linear.y + b.linear.y;
    sum
}

fn parts(twist: &Twist) -> [f64; 3] {
    [twist.linear.x, twist.linear.y, twist.angular.z]
}

pub(crate) fn is_still(twist: &Twist) -> bool {
    parts(twist) == [0.0; 3]
}

/// The greatest speed of a point of the outline, m/s.
fn speed(twist: &Twist, outline: &Outline) -> f64 {
    libm::hypot(twist.linear.x, twist.linear.y) + twist.angular.z.abs() * outline.swing()
}

#[cfg(test)]
mod tests;
