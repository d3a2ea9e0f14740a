//! A running application of this process, as the oscilloscope sees it.

use std::sync::{Mutex, PoisonError};

use jde_host::event::Outcome;
use jde_host::snapshot::Snapshot;
use jde_host::{Handle, Operating};
use jde_types::Pose2D;

use super::sight::Sight;
use crate::log::Log;
use crate::top::{Action, Application, RobotView};

/// An application in this process.
pub(crate) struct Live<'l> {
    handle: Handle,
    operator: Operating,
    sight: Mutex<Sight>,
    log: &'l Log,
}

impl<'l> Live<'l> {
    /// Wraps an application and the lines that the log keeps.
    pub(crate) fn new(handle: Handle, log: &'l Log) -> Self {
        let sight = Mutex::new(Sight::new(&handle));
        let by = std::env::var("USER").unwrap_or_else(|_| String::from("terminal"));
        Self {
            operator: handle.operator(&by),
            handle,
            sight,
            log,
        }
    }
}

impl Application for Live<'_> {
    fn snapshot(&self) -> Snapshot {
        self.handle.snapshot()
    }

    fn robot(&self) -> Option<RobotView> {
        let seen = self.sight.lock().unwrap_or_else(PoisonError::into_inner).look();
        // The target is in the frame of the odometry, so the robot is shown in that frame too.
        Some(robot(seen.odometry.or(seen.truth)?, seen.mission.as_ref()))
    }

    fn act(&self, action: Action) -> Result<(), String> {
        match action {
            Action::Play(schema) => self.operator.play(schema),
            Action::Stop(schema) => self.operator.hold_asleep(schema),
            Action::Force(schema) => self.operator.force(schema),
            Action::Release(schema) => self.operator.release(schema),
            Action::Period(schema, period) => self.operator.set_period(schema, period),
            Action::StopAll => self.operator.stop_all(),
            Action::ReleaseAll => self.operator.release_all(),
        }
    }

    fn outcome(&self) -> Option<Outcome> {
        self.handle.outcome()
    }

    fn log_lines(&self) -> Vec<String> {
        self.log.kept()
    }
}

/// Returns what the oscilloscope shows of a robot. A mission counts only if its targets are places.
pub(crate) fn robot(pose: Pose2D, mission: Option<&crate::session::Mission>) -> RobotView {
    let mission = mission.filter(|mission| mission.of_places);
    RobotView {
        pose: (pose.x, pose.y, pose.theta),
        target: mission.and_then(|mission| mission.target),
        reached: mission.map_or(0, |mission| mission.reached),
        total: mission.map_or(0, |mission| mission.total),
    }
}
