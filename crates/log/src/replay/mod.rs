//! Decision replay: a recorded drive is taken again by the schemas as they are now, and every selection and all that schemas wrote is
//! held against what was recorded. So a new build of a behaviour is tested against yesterday's drive.
//!
//! What the drivers exported comes from the recording, every schema takes its turns in the order of then and sees the values of
//! then (`jde_host::replay`). Starts no driver, moves nothing.

mod compare;
mod differ;
mod drive;
mod steps;
mod tape;
mod translation;
mod values;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use jde_core::Nanos;
use jde_host::app::Application;
use jde_host::event::Event;
use jde_host::plugin::Plugins;
use jde_host::replay::{Replay, Sight, sources};
use jde_host::story::{Decided, Decision};
use jde_host::{Handle, StartError};

use crate::ReadError;
use compare::Compared;
pub use compare::{Comparison, Difference, Side};
pub use drive::{Attached, Drive};
use tape::Tape;
use values::Held;
pub use values::{Allowed, Deviation, Tolerance, Values};

/// How far apart two times may be that are one: what happened by itself in a replay, as timers do, has not the machine's delay.
const APART: Nanos = 1_000_000;
/// How late a thread may be to tell of what it did before the replay goes on without it.
const SLACK: Nanos = 500_000_000;

/// Why a drive cannot be taken again.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It lacks something.
    #[error("{path} cannot be replayed: {what}")]
    Lacks {
        /// The recording.
        path: String,
        /// What it lacks.
        what: String,
    },
    /// A tolerance is stated for a type that nothing is written of.
    #[error("nothing in the application is a {name}{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Tolerance {
        /// The type.
        name: String,
        /// The nearest there is.
        nearest: Option<String>,
    },
    /// The application did not start.
    #[error(transparent)]
    Start(#[from] StartError),
}

/// Which part of a drive is compared. All of it is taken again from its beginning, for schemas remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// From then on, ns.
    pub from: Nanos,
    /// Until then.
    pub to: Nanos,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The selections, held against each other.
    pub comparison: Comparison,
    /// What schemas did, held against what they did then; none if the recording, of an older version, does not tell.
    pub values: Option<Values>,
    /// How far it went, ns.
    pub until: Nanos,
    /// Steps of turns that the recording has lost.
    pub lost_steps: u64,
    /// Values that were seen and are not in the recording, or have not come to be this time, by variable; the newest were shown
    /// instead.
    pub missed: Vec<(String, u64)>,
    /// Modulations and periods that operators wrote and that are not in the recording.
    pub unknown: Vec<String>,
    /// Schemas whose builds changed while it was recorded, and when, ns: before or after that they had another build than now, and
    /// what is decided otherwise may be that build's doing.
    pub reloads: Vec<(String, Nanos)>,
    /// Where the recording ends too soon, if it does.
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

impl Verdict {
    /// Whether every selection is as it was, and all that schemas did.
    #[must_use]
    pub fn is_same(&self) -> bool {
        self.comparison.different == 0 && self.values.as_ref().is_none_or(|values| values.different == 0)
    }
}

/// Takes a drive again and compares. `progress` is told the time now and then, and answers whether to go on.
///
/// # Errors
/// [`ReplayError`].
pub fn decide(
    drive: &Drive,
    application: Application,
    plugins: &Plugins,
    span: Span,
    tolerance: &Tolerance,
    mut progress: impl FnMut(Nanos) -> bool,
) -> Result<Verdict, ReplayError> {
    let tape = Tape::new(drive, &application, &sources(&application))?;
    let slack = if drive.cast().lockstep { 0 } else { SLACK };
    let apart = if drive.cast().lockstep { 0 } else { APART };
    let heard = Arc::new(Mutex::new(Vec::new()));
    let ear = Arc::clone(&heard);
    let observer = Box::new(move |event: &Event| {
        if matches!(event, Event::Decided(_) | Event::Took { .. }) {
            ear.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(event.clone());
        }
    });
    let mut decided = Decided::new(&application);
    let mut held = Held::new(span, tolerance, &application);
    let past = Box::new(tape.clone());
    let mut replay = Replay::start(application, plugins, vec![observer], past, slack)?;
    let handle = replay.handle();
    let mut compared = Compared::new(span, apart);
    let mut saw = BTreeMap::new();
    let mut told = 0;
    loop {
        let goes_on = replay.step();
        let events = std::mem::take(&mut *heard.lock().unwrap_or_else(PoisonError::into_inner));
        for event in events {
            if let Event::Decided(record) = &event {
                let candidates = record.candidates.iter().map(|candidate| candidate.id.index());
                saw.insert(record.number, sights(&handle, &replay, candidates));
            }
            for decision in decided.hear(&event) {
                let saw = saw.remove(&decision.number).unwrap_or_default();
                compared.replayed(decision, saw);
            }
        }
        for deed in replay.deeds() {
            held.add(&deed);
        }
        let now = tape.time();
        for decision in tape.decisions() {
            compared.recorded(decision);
        }
        compared.settle(now);
        if !goes_on || now > span.to {
            break;
        }
        if now >= told + TELL {
            told = now;
            if !progress(now) {
                break;
            }
        }
    }
    for decision in decided.rest() {
        let saw = saw.remove(&decision.number).unwrap_or_default();
        compared.replayed(decision, saw);
    }
    let until = tape.time();
    for decision in tape.rest() {
        compared.recorded(decision);
    }
    let name = |(schema, time): (u32, Nanos)| {
        let instance = handle.application().instances.get(schema as usize)?;
        Some((instance.name.clone(), time))
    };
    Ok(Verdict {
        reloads: tape.reloads().into_iter().filter_map(name).collect(),
        comparison: compared.finish(until),
        values: drive.cast().writes.then(|| held.finish()),
        until,
        lost_steps: tape.lost_steps(),
        missed: replay.missed(),
        unknown: replay.unknown(),
        damage: tape.damage(),
    })
}

/// How often progress is told, in the time of the drive.
const TELL: Nanos = 100_000_000;

/// What candidates saw at their last checks.
fn sights(
    handle: &Handle,
    replay: &Replay,
    candidates: impl Iterator<Item = usize>,
) -> Vec<(String, Vec<Sight>)> {
    let instances = &handle.application().instances;
    candidates
        .map(|number| (instances[number].name.clone(), replay.saw(number)))
        .collect()
}

/// A selection, with what its candidates saw.
type Seen = (Decision, Vec<(String, Vec<Sight>)>);
