//! What led to a failure: the robot's path and the last selections, kept as they are when the first property
//! fails.

use jde_app::Application;
use jde_core::Nanos;
use jde_records::event::Event;
use jde_timeline::{Hierarchy, Keep, Switch, Timeline};

use crate::result::DriveFailure;

/// The most selections that are kept: enough to see two handovers in each of two groups, and their causes.
const MAX_SELECTIONS: usize = 12;
/// The time between two positions of the path, ns: at 0.4 m/s a robot moves 4 cm.
const PATH_INTERVAL: Nanos = 100_000_000;
/// The most positions of a path in a result.
const MAX_POSITIONS: usize = 200;

/// The situation of a drive.
pub(super) struct Situation {
    timeline: Timeline,
    /// Positions, and who acted.
    path: Vec<([f64; 2], Option<usize>)>,
    next_position: Nanos,
    pose: Option<[f64; 3]>,
    /// The situation when the first property failed.
    kept: Option<DriveFailure>,
}

impl Situation {
    pub(super) fn new(application: &Application) -> Self {
        let keep = Keep {
            switches: MAX_SELECTIONS,
            ..Keep::PRESENT
        };
        Self {
            timeline: Timeline::new(Hierarchy::of_application(application), keep),
            path: Vec::new(),
            next_position: 0,
            pose: None,
            kept: None,
        }
    }

    /// Keeps an event.
    pub(super) fn add_event(&mut self, event: &Event) {
        self.timeline.add_event(event);
    }

    /// Keeps the robot's pose at an instant.
    pub(super) fn add_pose(&mut self, now: Nanos, pose: Option<[f64; 3]>) {
        self.pose = pose;
        if let Some([x, y, _]) = pose
            && now >= self.next_position
        {
            self.next_position = now + PATH_INTERVAL;
            self.path.push(([x, y], self.timeline.acting().first().copied()));
        }
    }

    /// Keeps the present situation as that of the failure, unless one is kept already.
    pub(super) fn keep(&mut self, at: Nanos) {
        if self.kept.is_none() {
            self.kept = Some(self.failure(at));
        }
    }

    /// Returns the situation that was kept, or else the present one.
    pub(super) fn into_failure(mut self, now: Nanos) -> DriveFailure {
        self.keep(now);
        self.kept.unwrap_or_default()
    }

    fn failure(&self, at: Nanos) -> DriveFailure {
        let step = self.path.len().div_ceil(MAX_POSITIONS).max(1);
        // Counted from the end, so that the place of the failure is among them.
        let mut path: Vec<_> = self.path.iter().rev().step_by(step).collect();
        path.reverse();
        let mut winners: Vec<(usize, Option<String>)> = Vec::new();
        let mut before = None;
        for (place, (_, acting)) in path.iter().enumerate() {
            if before != Some(*acting) {
                before = Some(*acting);
                let name = |schema| self.timeline.hierarchy().name(Some(schema)).to_owned();
                winners.push((place, acting.map(name)));
            }
        }
        let selections = self.timeline.newest_switches(MAX_SELECTIONS).into_iter();
        DriveFailure {
            at: at as f64 / 1e9,
            pose: self.pose.map(|pose| pose.map(round)),
            path: path.into_iter().map(|(at, _)| at.map(round)).collect(),
            winners,
            selections: selections
                .rev()
                .map(|(group, switch)| self.line(group, switch))
                .collect(),
        }
    }

    fn line(&self, group: usize, switch: &Switch) -> String {
        let hierarchy = self.timeline.hierarchy();
        format!(
            "{:.3} s  {}: {} -> {}  {} ({})",
            switch.time as f64 / 1e9,
            hierarchy.groups()[group].name,
            hierarchy.name(switch.from),
            hierarchy.name(switch.to),
            switch.reason,
            switch.decider,
        )
    }
}

/// Rounds to a millimetre, or a thousandth of a radian.
fn round(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}
