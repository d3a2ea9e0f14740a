//! Whether the drive comes nearer to its end. One that does not ends in words instead of going on for ever.

use jde_route::Progress;
use jde_schema::prelude::*;
use jde_schema::types::normalize_angle;

use crate::approach::{Goal, Manoeuvre};
use crate::astray;

/// Least decrease of what is left that counts as nearer, m.
const NEARER: f64 = 0.002;
/// How much of the heading is left counts as this way for each radian, m: the half width of a small robot.
const LEVER: f64 = 0.25;
/// A base that moved less than this, m and rad, stands: more than an odometry without motion shows.
const STANDING: (f64, f64) = (0.005, 0.01);

/// The longest time between two commands that counts. A longer one is that of a guard that refused a command, such as before a
/// person, or of another schema that drove.
const MAX_COMMAND_GAP: Duration = Duration::from_millis(250);

/// The progress of a drive.
#[derive(Debug)]
pub(crate) struct Effort {
    progress: Progress,
    commanded_at: Duration,
    /// Where the base stands or was last, in the frame of the mark, and since when.
    stands: Option<(Pose2D, Duration)>,
    failure: Option<Failure>,
}

/// Why a drive ended without its goal.
#[derive(Debug)]
struct Failure {
    words: String,
    leaves: bool,
    /// Where the base was, in the frame of the odometry.
    pose: Pose2D,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            progress: Progress::new(NEARER, MAX_COMMAND_GAP),
            commanded_at: Duration::ZERO,
            stands: None,
            failure: None,
        }
    }
}

impl Effort {
    /// Why it gave up, unless the base was brought elsewhere since, or shall do something else.
    pub(crate) fn failure(&mut self, pose: &Pose2D, goal: &Goal) -> Option<&str> {
        self.failure
            .take_if(|failure| failure.leaves != goal.leave || failure.pose.distance_to(pose) > goal.margin);
        self.failure.as_ref().map(|failure| failure.words.as_str())
    }

    /// Takes a command at a pose in the frame of the mark and in that of the odometry. Gives up once the base came no nearer for
    /// `allowance`, and returns why.
    pub(crate) fn command(
        &mut self,
        now: Duration,
        (step, local, pose): (Manoeuvre, &Pose2D, &Pose2D),
        goal: &Goal,
        allowance: Duration,
    ) -> Option<&str> {
        let last = core::mem::replace(&mut self.commanded_at, now);
        self.stands
            .take_if(|_| now.saturating_sub(last) > MAX_COMMAND_GAP);
        let (place, since) = self.stands.get_or_insert((*local, now));
        let turned = normalize_angle(local.theta - place.theta).abs();
        if place.distance_to(local) > STANDING.0 || turned > STANDING.1 {
            (*place, *since) = (*local, now);
        }
        let stands = now.saturating_sub(*since) >= allowance / 2;
        let aim = Pose2D::new(if goal.leave { goal.off } else { goal.distance }, 0.0, 0.0);
        let left = match goal.leave {
            true => aim.x - local.x,
            false => aim.distance_to(local) + LEVER * astray(local).abs(),
        };
        let stuck = self.progress.stuck(now, &aim, left, allowance)?;
        self.stands = None;
        let waited = stuck.waited.as_secs_f64();
        let words = match (stands, step) {
            (true, Manoeuvre::Turn) => {
                format!("the base does not turn for {waited:.0} s: raise `min_turn`, or free it")
            }
            (true, _) => format!("the base does not move for {waited:.0} s: raise `min_speed`, or free it"),
            (false, _) => {
                let (off, angle) = (1e3 * aim.distance_to(local), astray(local).to_degrees());
                format!("no nearer for {waited:.0} s: {off:.0} mm, {angle:.1} deg left")
            }
        };
        let failure = Failure {
            words,
            leaves: goal.leave,
            pose: *pose,
        };
        Some(self.failure.insert(failure).words.as_str())
    }
}
