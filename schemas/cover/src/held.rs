//! Whether the robot does not move at all: it is held, its wheels are stuck or in the air, or nobody drives it. Then no place is to
//! blame.

use jde_schema::prelude::*;

/// A way that is a motion, m: more than the pose of a robot that stands drifts, and less than a recovery moves it.
const MOTION: f64 = 0.15;
/// How many places the robot fails to come nearer to, one after another, before it counts as held: each is elsewhere.
const FAILURES: usize = 3;
/// The same if no other place is left.
const LAST_FAILURES: usize = 2;

/// The paths that ended where they began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Held {
    /// Where the robot stands, and how many paths ended there.
    stands: Option<(Pose2D, usize)>,
    is_held: bool,
}

impl Held {
    /// Takes the robot's place. Returns whether it moves again.
    pub(crate) fn follow(&mut self, robot: &Pose2D) -> bool {
        let has_moved = |(place, _): &mut (Pose2D, usize)| place.distance_to(robot) > MOTION;
        if self.stands.take_if(has_moved).is_none() {
            return false;
        }
        core::mem::take(&mut self.is_held)
    }

    /// Notes that the robot came no nearer to its place. Returns how many places are to be forgotten: all since it stands, once it
    /// counts as held.
    pub(crate) fn fail(&mut self, robot: &Pose2D) -> Option<usize> {
        let (_, failures) = self.stands.get_or_insert((*robot, 0));
        *failures += 1;
        self.is_held = *failures >= FAILURES;
        self.is_held.then_some(*failures)
    }

    /// Notes that no other place is left. As [`Held::fail`].
    pub(crate) fn exhaust(&mut self) -> Option<usize> {
        let (_, failures) = self.stands?;
        self.is_held |= failures >= LAST_FAILURES;
        self.is_held.then_some(failures)
    }

    pub(crate) const fn is_held(&self) -> bool {
        self.is_held
    }
}
