//! A running application of this process, as the oscilloscope sees it.

use std::time::Duration;

use jde_core::{Id, SchemaId};
use jde_host::{Handle, OperatorHandle};
use jde_records::snapshot::Snapshot;
use jde_timeline::{Ending, Hierarchy, MissionTimeline, Timeline};
use jde_types::Pose2D;
use parking_lot::Mutex;

use super::sampler::Sampler;
use crate::log::Log;
use crate::top::{ObservedApplication, RobotView, ScreenAction};

/// An application in this process.
pub(crate) struct LocalApplication<'l> {
    handle: Handle,
    operator: OperatorHandle,
    hierarchy: Hierarchy,
    sampler: Mutex<Sampler>,
    log: &'l Log,
}

impl<'l> LocalApplication<'l> {
    /// Wraps an application and the lines that the log keeps.
    pub(crate) fn new(handle: Handle, log: &'l Log) -> Self {
        let sampler = Mutex::new(Sampler::new(&handle, false));
        Self {
            operator: terminal_operator(&handle),
            hierarchy: Hierarchy::of_application(handle.application()),
            handle,
            sampler,
            log,
        }
    }
}

/// Returns the operator at this process's terminal.
#[must_use]
pub fn terminal_operator(handle: &Handle) -> OperatorHandle {
    handle.operator(&std::env::var("USER").unwrap_or_else(|_| String::from("terminal")))
}

impl ObservedApplication for LocalApplication<'_> {
    fn snapshot(&self) -> Snapshot {
        self.handle.snapshot()
    }

    fn robot(&self) -> Option<RobotView> {
        let mut sampler = self.sampler.lock();
        // Nobody needs to know who acts.
        sampler.sample(self.handle.now(), &Timeline::default());
        let robot = sampler.drive.led_robot(&self.hierarchy)?;
        // The target is in the frame of the odometry, so the robot is shown in that frame too.
        Some(robot_view(robot.odometry.or(robot.pose)?, &sampler.drive.mission))
    }

    fn act(&self, action: ScreenAction) -> Result<(), String> {
        match action {
            ScreenAction::Play(schema) => self.operator.play(SchemaId::new(schema)),
            ScreenAction::Stop(schema) => self.operator.hold_asleep(SchemaId::new(schema)),
            ScreenAction::Force(schema) => self.operator.force(SchemaId::new(schema)),
            ScreenAction::Release(schema) => self.operator.release(SchemaId::new(schema)),
            ScreenAction::Period(schema, period) => self.operator.set_period(SchemaId::new(schema), period),
            ScreenAction::StopAll => self.operator.stop_all(),
            ScreenAction::ReleaseAll => self.operator.release_all(),
            ScreenAction::Continue => self.operator.continue_time(),
            ScreenAction::Step => self.operator.step_time(),
        }
    }

    fn ending(&self) -> Option<Ending> {
        self.handle.outcome().map(Ending::Known)
    }

    fn silent(&self) -> Duration {
        Duration::ZERO
    }

    fn log_lines(&self) -> Vec<String> {
        self.log.buffered_lines()
    }
}

/// Returns what the oscilloscope shows of a robot. A mission counts only if its targets are places.
pub fn robot_view(pose: Pose2D, mission: &MissionTimeline) -> RobotView {
    let newest = mission.newest().filter(|_| mission.has_places());
    RobotView {
        pose: (pose.x, pose.y, pose.theta),
        target: mission.target(),
        reached: newest.map_or(0, |mission| mission.reached),
        total: newest.map_or(0, |mission| mission.total),
    }
}
