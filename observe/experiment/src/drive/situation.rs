//! What led to a failure: the robot's path and the last selections, kept as they are when the first property
//! fails.

use std::collections::VecDeque;

use jde_app::Application;
use jde_core::{Nanos, Record, SchemaId, State};
use jde_records::event::{Event, StateChange};

use crate::result::Failure;

/// The most selections that are kept: enough to see two handovers in each of two groups, and their causes.
const MAX_SELECTIONS: usize = 12;
/// The time between two positions of the path, ns: at 0.4 m/s a robot moves 4 cm.
const INTERVAL: Nanos = 100_000_000;
/// The most positions of a path in a result.
const MAX_POSITIONS: usize = 200;

/// The situation of a drive.
pub(super) struct Situation {
    schemas: Vec<String>,
    groups: Vec<String>,
    selections: VecDeque<Record>,
    /// Whether each schema is a motor schema without motor children.
    can_act: Vec<bool>,
    /// The schema that acts.
    acting: Option<usize>,
    /// Positions, and who acted.
    path: Vec<([f64; 2], Option<usize>)>,
    next_position: Nanos,
    pose: Option<[f64; 3]>,
    /// The situation when the first property failed.
    kept: Option<Failure>,
}

impl Situation {
    pub(super) fn new(application: &Application) -> Self {
        let instances = application.instances.iter();
        let groups = application.groups.iter();
        Self {
            schemas: instances.map(|instance| instance.name.clone()).collect(),
            groups: groups.map(|group| group.name.clone()).collect(),
            selections: VecDeque::with_capacity(MAX_SELECTIONS),
            can_act: application
                .instances
                .iter()
                .map(|instance| instance.group.is_some() && instance.child_groups.iter().all(Option::is_none))
                .collect(),
            acting: None,
            path: Vec::new(),
            next_position: 0,
            pose: None,
            kept: None,
        }
    }

    /// Keeps a selection that changed the winner, and who acts.
    pub(super) fn add_event(&mut self, event: Event) {
        match event {
            Event::Decision(record) if record.changed && self.kept.is_none() => {
                if self.selections.len() == MAX_SELECTIONS {
                    self.selections.pop_front();
                }
                self.selections.push_back(record);
            }
            Event::State(StateChange { schema, to, .. }) if self.can_act[schema] => {
                if to == State::Winner {
                    self.acting = Some(schema);
                } else if self.acting == Some(schema) {
                    self.acting = None;
                }
            }
            Event::Decision(_) | Event::State(_) | Event::Other(_) => {}
        }
    }

    /// Keeps the robot's pose at an instant.
    pub(super) fn add_pose(&mut self, now: Nanos, pose: Option<[f64; 3]>) {
        self.pose = pose;
        if let Some([x, y, _]) = pose
            && now >= self.next_position
        {
            self.next_position = now + INTERVAL;
            self.path.push(([x, y], self.acting));
        }
    }

    /// Keeps the present situation as that of the failure, unless one is kept already.
    pub(super) fn keep(&mut self, at: Nanos) {
        if self.kept.is_none() {
            self.kept = Some(self.failure(at));
        }
    }

    /// Returns the situation that was kept, or else the present one.
    pub(super) fn into_failure(mut self, now: Nanos) -> Failure {
        self.keep(now);
        self.kept.unwrap_or_default()
    }

    fn failure(&self, at: Nanos) -> Failure {
        let step = self.path.len().div_ceil(MAX_POSITIONS).max(1);
        // Counted from the end, so that the place of the failure is among them.
        let mut path: Vec<_> = self.path.iter().rev().step_by(step).collect();
        path.reverse();
        let mut winners: Vec<(usize, Option<String>)> = Vec::new();
        let mut before = None;
        for (place, (_, acting)) in path.iter().enumerate() {
            if before != Some(*acting) {
                before = Some(*acting);
                winners.push((place, acting.map(|schema| self.schemas[schema].clone())));
            }
        }
        Failure {
            at: at as f64 / 1e9,
            pose: self.pose.map(|pose| pose.map(round)),
            path: path.into_iter().map(|(at, _)| at.map(round)).collect(),
            winners,
            selections: self.selections.iter().map(|record| self.line(record)).collect(),
        }
    }

    fn line(&self, record: &Record) -> String {
        let name = |schema: Option<SchemaId>| schema.map_or("nobody", |schema| &self.schemas[schema.index()]);
        format!(
            "{:.3} s  {}: {} -> {}  {} ({})",
            record.time as f64 / 1e9,
            self.groups[record.group.index()],
            name(record.before),
            name(record.choice),
            record.reason,
            record.decider.name(),
        )
    }
}

/// Rounds to a millimetre, or a thousandth of a radian.
fn round(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}
