//! Whether the robot comes nearer to its target. It counts only time in which it is looked at again and again, so that nobody is
//! stuck while somebody else drives.

use core::time::Duration;

use jde_schema::prelude::*;

/// What counts as nearer, m: more than the odometry of a robot that turns on the spot moves by itself.
const NEARER: f64 = 0.05;
/// A longer pause between two looks is none of its time: a hundred of its periods would be long, and one a slow machine.
const PAUSE: Duration = Duration::from_secs(1);

/// How near it came to which target, and how long ago.
#[derive(Default)]
pub(crate) struct Progress {
    target: Option<Pose2D>,
    nearest: f64,
    waited: Duration,
    looked: Duration,
}

/// What a target that is out of reach was like.
pub(crate) struct Stuck {
    /// How long it came no nearer.
    pub(crate) waited: Duration,
    /// How near it came, m.
    pub(crate) nearest: f64,
}

impl Progress {
    /// Looks again; answers if it has come no nearer for `patience`, and then begins anew. With none, never.
    pub(crate) fn stuck(
        &mut self,
        now: Duration,
        target: &Pose2D,
        distance: f64,
        patience: Duration,
    ) -> Option<Stuck> {
        let since = now.saturating_sub(self.looked);
        self.looked = now;
        if self.target != Some(*target) || distance < self.nearest - NEARER {
            (self.target, self.nearest, self.waited) = (Some(*target), distance, Duration::ZERO);
            return None;
        }
        if since <= PAUSE {
            self.waited += since;
        }
        if patience.is_zero() || self.waited < patience {
            return None;
        }
        self.target = None;
        Some(Stuck {
            waited: self.waited,
            nearest: self.nearest,
        })
    }
}
