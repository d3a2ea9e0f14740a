//! Ends an application when the variable that it names as its mission is done or failed, and reports when the
//! distance to the target does not decrease. It reads the mission at each publication and applies no other
//! criterion.

use std::sync::{Arc, Weak};

use jde_core::Nanos;
use jde_records::event::{Outcome, What};
use jde_types::{Mission, Value};
use parking_lot::Mutex;

use crate::engine::Engine;

/// The decrease of the distance that counts as progress, m: more than the pose noise of a robot at rest.
const MIN_PROGRESS: f64 = 0.05;

/// The smallest distance to the current target, and since when there has been no progress.
#[derive(Default)]
struct Progress {
    mission: Mission,
    nearest: f64,
    since: Nanos,
    reported: bool,
}

/// Concludes the application when its mission is published as done or failed.
pub(crate) fn watch_mission(engine: &Arc<Engine>) {
    let Some(mission) = engine.application.mission else {
        return;
    };
    let Some(variable) = engine.variables.of(mission) else {
        unreachable!("a mission is an export");
    };
    let progress = Mutex::new(Progress::default());
    // The watch must hold no strong reference to the engine, which holds the watch.
    let weak: Weak<Engine> = Arc::downgrade(engine);
    engine.retain_watches([variable.watch(move || {
        let Some(engine) = weak.upgrade() else { return };
        let Some(variable) = engine.variables.of(mission) else {
            return;
        };
        let mut reader = variable.reader("mission");
        let published = reader
            .latch(engine.clock.now())
            .and_then(|latched| Mission::from_bytes(latched.bytes));
        let Some(published) = published else { return };
        match published.state {
            Mission::DONE => engine.outcome.conclude(Outcome::Done),
            Mission::FAILED => engine.outcome.conclude(Outcome::Failed),
            _ => {}
        }
        let Some(patience) = engine.application.mission_stalls_ns else {
            return;
        };
        let now = engine.clock.now();
        let mut progress = progress.lock();
        if let Some(since) = progress.check_stall(published, now, patience) {
            drop(progress);
            // The publishing thread may be inside a call, and must not wait for the rules' lock.
            engine.rules.report_later(
                What::Stalled {
                    schema: mission.instance,
                    since,
                    distance: published.distance,
                    reached: published.reached,
                }
                .at(now),
            );
        }
    })]);
}

impl Progress {
    /// Returns since when there was no progress, if that is at least `patience` ago and has not been reported
    /// yet.
    fn check_stall(&mut self, mission: Mission, now: Nanos, patience: Nanos) -> Option<Nanos> {
        let previous = std::mem::replace(&mut self.mission, mission);
        let has_changed = (previous.reached, previous.total, previous.target)
            != (mission.reached, mission.total, mission.target);
        let nearer = mission.distance < self.nearest - MIN_PROGRESS;
        // Without a route there is no distance that could decrease.
        let idle = mission.state != Mission::RUNNING || mission.distance <= 0.0;
        if has_changed || nearer || idle || self.since == 0 {
            (self.nearest, self.since, self.reported) = (mission.distance, now.max(1), false);
        }
        let is_stalled = !self.reported && now.saturating_sub(self.since) >= patience;
        self.reported |= is_stalled;
        is_stalled.then_some(self.since)
    }
}

#[cfg(test)]
mod tests {
    use jde_types::Pose2D;

    use super::*;

    const SECOND: Nanos = 1_000_000_000;

    fn mission_at(distance: f64, reached: u32) -> Mission {
        Mission {
            distance,
            reached,
            total: 3,
            target: Pose2D::new(f64::from(reached), 0.0, 0.0),
            ..Mission::default()
        }
    }

    #[test]
    fn a_stalled_mission_is_reported_once_until_it_progresses() {
        let mut progress = Progress::default();
        let mut stall = |second: Nanos, distance, reached| {
            progress.check_stall(mission_at(distance, reached), second * SECOND, 10 * SECOND)
        };
        assert_eq!(stall(1, 5.0, 0), None);
        assert_eq!(
            stall(10, 4.96, 0),
            None,
            "a decrease within the noise is no progress"
        );
        assert_eq!(stall(11, 5.5, 0), Some(SECOND));
        assert_eq!(stall(12, 5.5, 0), None, "the stall has been reported");
        assert_eq!(stall(13, 4.0, 0), None, "the distance has decreased");
        assert_eq!(stall(22, 4.0, 0), None);
        assert_eq!(stall(23, 4.0, 0), Some(13 * SECOND));
        assert_eq!(stall(24, 9.0, 1), None, "the target has changed");
        assert_eq!(stall(33, 9.0, 1), None);
        assert_eq!(stall(34, 9.0, 1), Some(24 * SECOND));
    }
}
