//! A running application of this process, as the oscilloscope sees it.

use std::sync::Mutex;
use std::time::Duration;

use jde_host::{Handle, OperatorHandle};
use jde_records::event::Outcome;
use jde_records::snapshot::Snapshot;
use jde_types::Pose2D;

use super::sampler::Sampler;
use crate::lock::lock;
use crate::log::Log;
use crate::top::{Action, ObservedApplication, RobotView};

/// An application in this process.
pub(crate) struct LocalApplication<'l> {
    handle: Handle,
    operator: OperatorHandle,
    sampler: Mutex<Sampler>,
    log: &'l Log,
}

impl<'l> LocalApplication<'l> {
    /// Wraps an application and the lines that the log keeps.
    pub(crate) fn new(handle: Handle, log: &'l Log) -> Self {
        let sampler = Mutex::new(Sampler::new(&handle));
        Self {
            operator: terminal_operator(&handle),
            handle,
            sampler,
            log,
        }
    }
}

/// Returns the operator at this process's terminal.
pub(super) fn terminal_operator(handle: &Handle) -> OperatorHandle {
    handle.operator(&std::env::var("USER").unwrap_or_else(|_| String::from("terminal")))
}

impl ObservedApplication for LocalApplication<'_> {
    fn snapshot(&self) -> Snapshot {
        self.handle.snapshot()
    }

    fn robot(&self) -> Option<RobotView> {
        let observation = lock(&self.sampler).sample(self.handle.now());
        // The target is in the frame of the odometry, so the robot is shown in that frame too.
        Some(robot_view(
            observation.odometry.or(observation.truth)?,
            observation.mission.as_ref(),
        ))
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
            Action::Continue => self.operator.continue_time(),
            Action::Step => self.operator.step_time(),
        }
    }

    fn outcome(&self) -> Option<Outcome> {
        self.handle.outcome()
    }

    fn silent(&self) -> Duration {
        Duration::ZERO
    }

    fn log_lines(&self) -> Vec<String> {
        self.log.buffered_lines()
    }
}

/// Returns what the oscilloscope shows of a robot. A mission counts only if its targets are places.
pub(crate) fn robot_view(pose: Pose2D, mission: Option<&crate::session::MissionProgress>) -> RobotView {
    let mission = mission.filter(|mission| mission.counts_positions);
    RobotView {
        pose: (pose.x, pose.y, pose.theta),
        target: mission.and_then(|mission| mission.target),
        reached: mission.map_or(0, |mission| mission.reached),
        total: mission.map_or(0, |mission| mission.total),
    }
}
