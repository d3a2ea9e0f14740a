//! Decision replay: the present schemas repeat a recorded drive. Every selection, and every value that
//! schemas wrote, is compared with the recorded one. This tests a new build of a behaviour against
//! yesterday's drive.
//!
//! The recording provides what the drivers exported. Every schema takes its turns in the recorded order and
//! reads the recorded values (`jde_host::replay`). A replay starts no driver and moves nothing.

mod compare;
mod diff;
mod drive;
mod mock;
mod replay_reader;
mod steps;
mod translation;
mod values;

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_app::Application;
use jde_core::{Nanos, SchemaId};
use jde_host::replay::{PortReading, Replay, sources};
use jde_host::{Handle, StartError};
use jde_loader::Plugins;
use jde_log::ReadError;
use jde_records::event::{Event, Occurrence, What};
use jde_records::{Decision, DecisionTracker};
use parking_lot::Mutex;

use compare::DecisionMatcher;
pub use compare::{Comparison, Difference, Side};
pub use drive::{AttachedApplication, ReplayedDrive};
pub use mock::mock;
use replay_reader::ReplayReader;
use values::ValueComparer;
pub use values::{Deviation, Tolerance, ToleranceEntry, Values};

/// The largest difference between two times that count as equal, in ns: in a replay, events of timers occur
/// without the machine's delay.
const TIME_TOLERANCE: Nanos = 1_000_000;
/// How late a thread may report its actions before the replay continues without it, in ns.
const REPORT_SLACK: Nanos = 500_000_000;

/// Why a drive cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording lacks something that a replay needs.
    #[error("{path} cannot be replayed: {what}")]
    Incomplete {
        /// The path of the recording.
        path: String,
        /// What it lacks.
        what: String,
    },
    /// A tolerance names a type that no value of the application has.
    #[error("no value in the application is a {name}{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Tolerance {
        /// The type.
        name: String,
        /// The most similar type, if one is similar.
        nearest: Option<String>,
    },
    /// The application did not start.
    #[error(transparent)]
    Start(#[from] StartError),
}

/// The part of a drive that is compared. The whole drive is replayed from its beginning, because schemas have
/// memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first time that is compared, in ns of the application's clock.
    pub from: Nanos,
    /// The last time that is compared, in ns.
    pub to: Nanos,
}

/// The result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayReport {
    /// The comparison of the selections.
    pub comparison: Comparison,
    /// The comparison of the values that schemas wrote. `None` if the recording does not contain them, which
    /// those of older versions do not.
    pub values: Option<Values>,
    /// The time at which the replay ended, in ns.
    pub until: Nanos,
    /// The number of steps of turns that the recording has lost.
    pub lost_steps: u64,
    /// The number of values, by variable, that schemas saw and that are not in the recording or were not
    /// written in the replay. The newest values were used instead.
    pub missed: Vec<(String, u64)>,
    /// Modulations and periods that operators wrote and that are not in the recording.
    pub unknown: Vec<String>,
    /// Schemas whose builds changed during the recording, and when, in ns. Before or after that time another
    /// build ran than in the replay, which may explain differences.
    pub reloads: Vec<(String, Nanos)>,
    /// Where the recording ends too early, if it does.
    pub damage: Option<String>,
}

impl Default for Span {
    fn default() -> Self {
        Self {
            from: 0,
            to: Nanos::MAX,
        }
    }
}

impl ReplayReport {
    /// Returns whether all selections and all written values are equal.
    #[must_use]
    pub fn is_same(&self) -> bool {
        self.comparison.different == 0 && self.values.as_ref().is_none_or(|values| values.different == 0)
    }
}

/// Replays a drive and compares it. `progress` is called repeatedly with the time, and returns whether to
/// continue.
///
/// # Errors
/// [`ReplayError`].
pub fn replay_and_compare(
    drive: &ReplayedDrive,
    application: Application,
    plugins: &Plugins,
    span: Span,
    tolerance: &Tolerance,
    mut progress: impl FnMut(Nanos) -> bool,
) -> Result<ReplayReport, ReplayError> {
    let reader = ReplayReader::new(drive, &application, &sources(&application))?;
    let slack = if drive.hierarchy().lockstep {
        0
    } else {
        REPORT_SLACK
    };
    let time_tolerance = if drive.hierarchy().lockstep {
        0
    } else {
        TIME_TOLERANCE
    };
    let events = Arc::new(Mutex::new(Vec::new()));
    let observed = Arc::clone(&events);
    let observer = Box::new(move |event: &Event| {
        let is_needed = match event {
            Event::Decision(_) => true,
            Event::State(_) => false,
            Event::Other(Occurrence { what, .. }) => {
                matches!(what, What::TookOver { .. } | What::Refused { .. })
            }
        };
        if is_needed {
            observed.lock().push(event.clone());
        }
    });
    let mut tracker = DecisionTracker::new(&application);
    let mut values = ValueComparer::new(span, tolerance, &application);
    let recorded_run = Box::new(reader.clone());
    let mut replay = Replay::start(application, plugins, vec![observer], recorded_run, slack)?;
    let handle = replay.handle();
    let mut decisions = DecisionMatcher::new(span, time_tolerance);
    let mut inputs = BTreeMap::new();
    let mut progress_time = 0;
    loop {
        let continues = replay.step();
        let new_events = std::mem::take(&mut *events.lock());
        for event in new_events {
            if let Event::Decision(record) = &event {
                let candidates = record.candidates.iter().map(|candidate| candidate.id);
                inputs.insert(record.number, candidate_inputs(&handle, &replay, candidates));
            }
            for decision in tracker.process(&event) {
                let inputs = inputs.remove(&decision.number).unwrap_or_default();
                decisions.push_replayed(decision, inputs);
            }
        }
        for write in replay.take_writes() {
            values.add(&write);
        }
        let now = reader.time();
        for decision in reader.decisions() {
            decisions.push_recorded(decision);
        }
        decisions.compare_until(now);
        if !continues || now > span.to {
            break;
        }
        if now >= progress_time + PROGRESS_INTERVAL {
            progress_time = now;
            if !progress(now) {
                break;
            }
        }
    }
    for decision in tracker.drain() {
        let inputs = inputs.remove(&decision.number).unwrap_or_default();
        decisions.push_replayed(decision, inputs);
    }
    let until = reader.time();
    for decision in reader.remaining_decisions() {
        decisions.push_recorded(decision);
    }
    let name = |(schema, time): (u32, Nanos)| {
        let instance = handle.application().instances.get(SchemaId(schema))?;
        Some((instance.name.clone(), time))
    };
    Ok(ReplayReport {
        reloads: reader.reloads().into_iter().filter_map(name).collect(),
        comparison: decisions.finish(until, reader.damage().is_some()),
        values: drive.hierarchy().writes.then(|| values.finish()),
        until,
        lost_steps: reader.lost_steps(),
        missed: replay.missed_values(),
        unknown: replay.unknown_writes(),
        damage: reader.damage(),
    })
}

/// The time of the drive between two calls of `progress`, in ns.
const PROGRESS_INTERVAL: Nanos = 100_000_000;

/// Returns what candidates saw at their last checks.
fn candidate_inputs(
    handle: &Handle,
    replay: &Replay,
    candidates: impl Iterator<Item = SchemaId>,
) -> Vec<(String, Vec<PortReading>)> {
    let instances = &handle.application().instances;
    candidates
        .map(|id| (instances[id].name.clone(), replay.last_inputs(id)))
        .collect()
}

/// A selection, and what its candidates saw.
type ReplayedDecision = (Decision, Vec<(String, Vec<PortReading>)>);
