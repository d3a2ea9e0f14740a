//! What is known around a robot at one time, and the judgement of commands by it. It keeps nothing between two
//! judgements. `schemas/guard` exports the value; others import it, to know what the guard would accept.

use core::time::Duration;

use jde_types::{Footprint, Point2D, Seq, Twist, Value, Vector3};

use crate::stopping::is_still;
use crate::{BaseDynamics, Maneuver, Outline, Stopping};

/// The most points of [`Surroundings`]: those of a scan, and the boundary of what is known.
pub const MAX_POINTS: usize = 2048;

/// The robot and the points that it must not touch, in the frame of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Surroundings")]
pub struct Surroundings {
    /// The present velocity of the base.
    pub velocity: Twist,
    /// What the velocity lacks of the one that a lagging base strives for.
    pub lead: Twist,
    /// The outline of the robot.
    pub footprint: Footprint,
    /// How long a command is in force before the next judgement of it takes effect.
    #[value(unit = "s")]
    pub reaction: f64,
    /// The greatest part of its speed that a command loses before it is refused.
    pub slowdown: f64,
    /// The distance to keep.
    #[value(unit = "m")]
    pub margin: f64,
    /// How the base follows its commands.
    pub dynamics: BaseDynamics,
    /// What the laser sees or has seen, and the boundary of what it has never seen.
    pub points: Seq<Point2D, MAX_POINTS>,
}

impl Surroundings {
    /// Judges a command: the robot must be able to follow it for the time of reaction and then stop, without
    /// coming nearer to a point than the margin. A robot that is nearer already may move as long as it comes no
    /// nearer than it does if it stands. To stand is accepted always: nothing stops the robot sooner.
    ///
    /// Which commands the base got since the time of the surroundings is unknown. Two cases are tried, and both must be
    /// free: that it strove for the same as at that time until now, and that it followed the command all the time. What
    /// is between them, or another command meanwhile, is not tried.
    ///
    /// # Errors
    /// What is in the way.
    pub fn judge(&self, age: Duration, command: &Twist) -> Result<(), String> {
        if is_still(command) {
            return Ok(());
        }
        let outline = Outline::try_from(&self.footprint).map_err(|error| error.to_string())?;
        let (age, points) = (age.as_secs_f64(), self.points.as_slice());
        let waits: &[f64] = if age > 0.0 { &[0.0, age] } else { &[0.0] };
        for &wait in waits {
            let maneuver = Maneuver {
                velocity: self.velocity,
                lead: self.lead,
                wait,
                command: *command,
                hold: self.reaction + age - wait,
                dynamics: self.dynamics,
            };
            match maneuver.stopping(&outline, points, self.margin) {
                Stopping::Free => {}
                Stopping::Touches { .. } if maneuver.keeps_clear(&outline, points, self.margin) => {}
                Stopping::Touches { after, point } => {
                    return Err(format!(
                        "within {after:.1} s and the stop it would touch what is {:.2} m ahead and {:.2} m left",
                        point.x, point.y
                    ));
                }
                Stopping::Unknown => {
                    return Err(String::from(
                        "a velocity or a limit is not a finite number, or the stop takes too long",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Returns the greatest part of a command that it accepts, on the same curve; `None` if the command would lose
    /// more of its speed than [`Self::slowdown`].
    #[must_use]
    pub fn limit(&self, age: Duration, command: &Twist) -> Option<Twist> {
        /// Halvings of the part: to 3 % of the command, about the error of a base.
        const HALVINGS: u32 = 5;
        let accepts = |part: f64| self.judge(age, &part_of(command, part)).is_ok();
        let (mut accepted, mut refused) = (1.0 - self.slowdown, 1.0);
        if accepted >= refused || !accepts(accepted) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(accepted, refused);
            if accepts(middle) {
                accepted = middle;
            } else {
                refused = middle;
            }
        }
        Some(part_of(command, accepted))
    }
}

/// This part of a command: the same curve, more slowly.
fn part_of(command: &Twist, part: f64) -> Twist {
    let scaled = |Vector3 { x, y, z }| Vector3 {
        x: x * part,
        y: y * part,
        z: z * part,
    };
    Twist {
        linear: scaled(command.linear),
        angular: scaled(command.angular),
    }
}
