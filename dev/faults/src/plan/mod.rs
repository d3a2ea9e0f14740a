//! The faults of a case and their times, chosen by the seed before the case runs.

mod kind;

use std::borrow::Cow;

use jde_core::Nanos;
use jde_host::SensorFault;

use crate::case::{Case, RunMode};
use crate::rng::Rng;
pub use kind::{Kind, TargetKind};

const MS: Nanos = 1_000_000;
/// Time before the first fault, so that every awake schema has had some turns.
const CALM_BEFORE_FAULTS: Nanos = 300 * MS;
/// Most faults of one case.
const MAX_FAULTS: u64 = 6;
/// Most calls among them that never return, since each keeps a thread of this process until it ends.
const MAX_HANGS: usize = 1;

/// A fault.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedFault {
    /// Its time, in the application's clock.
    pub at: Nanos,
    /// Its duration, ns.
    pub duration: Nanos,
    /// Its kind.
    pub kind: Kind,
    /// The kind of schema.
    pub target: TargetKind,
    /// A number that selects one of the schemas that are suitable at that time.
    pub choice: u64,
    /// Any schema may be chosen, not only one that is about to make the call.
    pub any: bool,
    /// The fault lasts until the application ends.
    pub stays: bool,
    /// The action.
    pub act: Act,
}

/// The action that causes a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// A schema misbehaves from now on.
    SetTrouble {
        /// The misbehaviour.
        trouble: Cow<'static, str>,
        /// The call in which it occurs.
        place: &'static str,
    },
    /// Another build, which misbehaves, takes over.
    Reload {
        /// The misbehaviour.
        trouble: Cow<'static, str>,
        /// The call in which it occurs.
        place: &'static str,
        /// The index of the build.
        build: usize,
    },
    /// The schema's process receives a signal.
    Signal(Signal),
    /// An operator acts on the schema, and releases it at the end.
    Operate(Operation),
    /// An export fails, and is repaired at the end.
    FailExport(&'static str, SensorFault),
    /// Two operators stop and release everything concurrently, until the end.
    Contest,
    /// An operator stops the schema; two others act on it under leases, until the end.
    Leases,
    /// Another build takes over, and during this something else occurs.
    DuringReload {
        /// The index of the build.
        build: usize,
        /// What occurs.
        meanwhile: Meanwhile,
    },
}

/// What occurs while another build takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meanwhile {
    /// An operator acts on the schema, and releases it at the end.
    Operate(Operation),
    /// A third build is to take over.
    Reload,
    /// The schema panics in each check.
    Panic,
}

/// A signal to a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// The process ends.
    Kill,
    /// The process stops.
    Stop,
}

/// An action of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Puts the schema to sleep.
    Stop,
    /// Makes the schema win.
    Force,
    /// Wakes the schema.
    Play,
    /// Changes the schema's period, ns.
    Retime(Nanos),
    /// Ends the schema's instance.
    Unload,
    /// Stops everything.
    StopAll,
}

impl PlannedFault {
    /// The time when the fault ends.
    #[must_use]
    pub fn ends(&self) -> Nanos {
        self.at + self.duration
    }

    /// The fault as text: "hang in check at 1.234 s for 80 ms".
    #[must_use]
    pub fn describe(&self) -> String {
        let what = match &self.act {
            Act::SetTrouble { trouble, place } => format!("{trouble} in {place}"),
            Act::Reload { trouble, place, .. } => format!("a build with {trouble} in {place}"),
            Act::Signal(signal) => format!("{signal:?} to its process").to_lowercase(),
            Act::Operate(operation) => format!("{operation:?} by an operator").to_lowercase(),
            Act::FailExport(export, fault) => format!("`{export}` is {fault:?}").to_lowercase(),
            Act::Contest => String::from("two operators who stop and release everything"),
            Act::Leases => String::from("two operators with leases on a stopped schema"),
            Act::DuringReload { meanwhile, .. } => {
                format!("{meanwhile:?} while a build takes over").to_lowercase()
            }
        };
        let (at, duration) = (self.at as f64 / 1e9, self.duration as f64 / 1e6);
        let stays = if self.stays { " and until the end" } else { "" };
        format!("{what}, at {at:.6} s for {duration:.0} ms{stays}")
    }
}

/// Returns the faults of a case in order of time: at most `max_faults`, only of these kinds.
#[must_use]
pub fn plan(seed: u64, case: Case, kinds: &[Kind], max_faults: u64) -> Vec<PlannedFault> {
    let mut rng = Rng::new(seed, &format!("plan {case}"));
    let possible: Vec<Kind> = kinds
        .iter()
        .copied()
        .filter(|kind| kind.fits(case.clock))
        .collect();
    if possible.is_empty() {
        return Vec::new();
    }
    let count = rng.between(1, MAX_FAULTS).min(max_faults);
    let mut at = CALM_BEFORE_FAULTS;
    let mut faults = Vec::new();
    let mut hangs = 0;
    for _ in 0..count {
        at += rng.between(0, 350 * MS);
        let mut kind = rng.pick(&possible);
        if kind == Kind::Hang {
            hangs += 1;
            if hangs > MAX_HANGS {
                kind = Kind::Dawdle;
            }
        }
        faults.push(fault(kind, at, case, &mut rng));
    }
    faults
}

fn fault(kind: Kind, at: Nanos, case: Case, rng: &mut Rng) -> PlannedFault {
    let target = rng.pick(kind.targets());
    let mut duration = rng.between(20, 300) * MS;
    let act = match kind {
        Kind::Kill => Act::Signal(Signal::Kill),
        Kind::Freeze => Act::Signal(Signal::Stop),
        Kind::StopAll => Act::Operate(Operation::StopAll),
        Kind::Operator => Act::Operate(operation(rng)),
        Kind::Sense => {
            // Long enough to drive by it.
            duration = rng.between(100, 4000) * MS;
            Act::FailExport(rng.pick(&["laser", "odometry"]), sensor_fault(rng))
        }
        Kind::Contest => Act::Contest,
        Kind::Leases => Act::Leases,
        Kind::AmidReload => Act::DuringReload {
            build: rng.between(0, 2) as usize,
            meanwhile: match rng.between(0, 3) {
                0 => Meanwhile::Reload,
                1 => Meanwhile::Panic,
                2 => Meanwhile::Operate(Operation::StopAll),
                _ => Meanwhile::Operate(operation(rng)),
            },
        },
        Kind::Reload => {
            let mut troubles = vec!["panic", "error", "none"];
            if case.clock == RunMode::RealTime {
                troubles.push("dawdle");
            }
            Act::Reload {
                trouble: rng.pick(&troubles).into(),
                place: rng.pick(&["awake", "restore", "check", "iterate", "save", "sleep"]),
                build: rng.between(0, 2) as usize,
            }
        }
        kind => {
            // A fault of a whole process has no trouble, and is not planned here: see `fits`.
            let trouble = rng.pick(kind.troubles());
            let place = rng.pick(kind.places(target));
            if kind == Kind::Reckless {
                // Until the robot is fast.
                duration = rng.between(1000, 4000) * MS;
            }
            if ["awake", "sleep", "arbitrate", "end"].contains(&place) {
                // These calls are rare.
                duration = rng.between(200, 1000) * MS;
            }
            if matches!(kind, Kind::Hang | Kind::Dawdle) && ["check", "iterate"].contains(&place) {
                // The fault ends before the hung schema runs again, so that only one call hangs.
                duration = rng.between(50, 150) * MS;
            }
            Act::SetTrouble {
                trouble: trouble.into(),
                place,
            }
        }
    };
    PlannedFault {
        at,
        duration,
        kind,
        target,
        choice: rng.next_u64(),
        any: rng.one_in(4),
        stays: rng.one_in(6) && !matches!(act, Act::FailExport(..) | Act::Contest | Act::Leases),
        act,
    }
}

/// A failure of the laser or the odometry. One that does not fit the export is refused.
fn sensor_fault(rng: &mut Rng) -> SensorFault {
    match rng.between(0, 4) {
        0 => SensorFault::Silent,
        1 => SensorFault::Frozen,
        2 => SensorFault::Contradictory,
        3 => SensorFault::Blocked {
            first: 0,
            last: u32::MAX,
            range: 0.0,
        },
        _ => SensorFault::Late {
            by: rng.between(100, 1500) * MS,
        },
    }
}

/// An action on one schema.
fn operation(rng: &mut Rng) -> Operation {
    match rng.between(0, 4) {
        0 => Operation::Stop,
        1 => Operation::Force,
        2 => Operation::Play,
        3 => Operation::Retime(rng.between(1, 100) * MS),
        _ => Operation::Unload,
    }
}
