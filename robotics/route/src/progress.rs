//! Detects that the robot gets no nearer to its target. Only time between frequent calls counts, so that no
//! time accumulates while another schema drives.

use core::time::Duration;

use jde_schema::prelude::*;

/// Least decrease of the distance that counts as nearer, m: more than the odometry drifts while a robot turns
/// on the spot.
const NEARER: f64 = 0.05;
/// Longest time between two calls that counts. A longer gap means that the schema did not run; a shorter one
/// can occur on a slow machine.
const PAUSE: Duration = Duration::from_secs(1);

/// The smallest distance to the target so far, and the time without getting nearer.
#[derive(Debug)]
pub struct Progress {
    nearer: f64,
    pause: Duration,
    target: Option<Pose2D>,
    nearest: f64,
    waited: Duration,
    updated_at: Duration,
}

/// A target that counts as out of reach.
#[derive(Debug)]
pub struct Stuck {
    /// Time without getting nearer.
    pub waited: Duration,
    /// The smallest distance, m.
    pub nearest: f64,
}

impl Default for Progress {
    fn default() -> Self {
        Self::new(NEARER, PAUSE)
    }
}

impl Progress {
    /// Returns the progress of a drive that has not begun. A distance that is smaller by `nearer` m counts as nearer, and no
    /// time between two calls that is longer than `pause`.
    #[must_use]
    pub const fn new(nearer: f64, pause: Duration) -> Self {
        Self {
            nearer,
            pause,
            target: None,
            nearest: 0.0,
            waited: Duration::ZERO,
            updated_at: Duration::ZERO,
        }
    }

    /// Records the distance, m. Once the robot got no nearer for `patience`, returns how long and how
    /// near, and starts again. Always returns `None` if `patience` is zero.
    pub fn stuck(
        &mut self,
        now: Duration,
        target: &Pose2D,
        distance: f64,
        patience: Duration,
    ) -> Option<Stuck> {
        let since = now.saturating_sub(self.updated_at);
        self.updated_at = now;
        if self.target != Some(*target) || distance < self.nearest - self.nearer {
            (self.target, self.nearest, self.waited) = (Some(*target), distance, Duration::ZERO);
            return None;
        }
        if since <= self.pause {
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
