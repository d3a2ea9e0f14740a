//! What goes wrong in a case, and when: chosen by its seed, before anything runs.

mod kind;

use jde_core::Nanos;

use crate::case::{Case, Clock};
use crate::chance::Chance;
pub use kind::{Kind, Whom};

const MS: Nanos = 1_000_000;
/// Time in which an application begins before anything goes wrong: all that is awake has had some turns.
const CALM: Nanos = 300 * MS;
/// Most faults of one case.
const MOST: u64 = 6;
/// Of these, calls that never return: each leaves a thread behind in this process for as long as it lives.
const MOST_HANGS: usize = 1;

/// A fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// When, in the application's time.
    pub at: Nanos,
    /// How long it goes on.
    pub lasts: Nanos,
    /// What kind it is.
    pub kind: Kind,
    /// By what kind of schema.
    pub whom: Whom,
    /// By which: a number that chooses among those who are fit for it when the time has come.
    pub choice: u64,
    /// By anybody, also by who is not about to make the call in question.
    pub any: bool,
    /// It is not taken back: the application ends with it.
    pub stays: bool,
    /// What is done.
    pub act: Act,
}

/// What is done to have a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// A schema is told to misbehave.
    Tell {
        /// What it does.
        trouble: &'static str,
        /// In which call.
        place: &'static str,
    },
    /// Another build takes over, which misbehaves.
    Reload {
        /// What it does.
        trouble: &'static str,
        /// In which call.
        place: &'static str,
        /// Which of the builds.
        build: usize,
    },
    /// Its process is sent a signal.
    Signal(Signal),
    /// Somebody acts on it, and lets go at the end.
    Operate(Operation),
    /// Two stop everything and let it go on, against each other, until the end.
    Contest,
    /// Another build takes over, and before it has, this happens.
    Amid {
        /// Which build.
        build: usize,
        /// What happens.
        meanwhile: Meanwhile,
    },
}

/// What happens while another build takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meanwhile {
    /// Somebody acts on the schema, and lets go at the end.
    Operate(Operation),
    /// Somebody has a third build take over.
    Reload,
    /// The schema panics in each check and iteration.
    Panic,
}

/// What a process is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// It ends.
    Kill,
    /// It stands still.
    Stop,
}

/// What somebody does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Puts it to sleep.
    Stop,
    /// Has it win.
    Force,
    /// Wakes it.
    Play,
    /// Changes its period to so many ns.
    Retime(Nanos),
    /// Ends its instance.
    Unload,
    /// Stops everything.
    StopAll,
}

impl Fault {
    /// When it is over.
    #[must_use]
    pub fn ends(&self) -> Nanos {
        self.at + self.lasts
    }

    /// It in words: "hang in check at 1.234 s for 80 ms".
    #[must_use]
    pub fn words(&self) -> String {
        let what = match &self.act {
            Act::Tell { trouble, place } => format!("{trouble} in {place}"),
            Act::Reload { trouble, place, .. } => format!("a build with {trouble} in {place}"),
            Act::Signal(signal) => format!("{signal:?} to its process").to_lowercase(),
            Act::Operate(operation) => format!("{operation:?} by an operator").to_lowercase(),
            Act::Contest => String::from("two operators who stop and release everything"),
            Act::Amid { meanwhile, .. } => format!("{meanwhile:?} while a build takes over").to_lowercase(),
        };
        let (at, lasts) = (self.at as f64 / 1e9, self.lasts as f64 / 1e6);
        let stays = if self.stays { " and until the end" } else { "" };
        format!("{what}, at {at:.6} s for {lasts:.0} ms{stays}")
    }
}

/// The faults of a case, in order: at most `most`, of these kinds alone.
#[must_use]
pub fn plan(seed: u64, case: Case, kinds: &[Kind], most: u64) -> Vec<Fault> {
    let mut chance = Chance::new(seed, &format!("plan {case}"));
    let fitting: Vec<Kind> = kinds
        .iter()
        .copied()
        .filter(|kind| kind.fits(case.clock))
        .collect();
    if fitting.is_empty() {
        return Vec::new();
    }
    let count = chance.between(1, MOST).min(most);
    let mut at = CALM;
    let mut faults = Vec::new();
    let mut hangs = 0;
    for _ in 0..count {
        at += chance.between(0, 350 * MS);
        let mut kind = chance.pick(&fitting);
        if kind == Kind::Hang {
            hangs += 1;
            if hangs > MOST_HANGS {
                kind = Kind::Dawdle;
            }
        }
        faults.push(fault(kind, at, case, &mut chance));
    }
    faults
}

fn fault(kind: Kind, at: Nanos, case: Case, chance: &mut Chance) -> Fault {
    let whom = chance.pick(kind.whom());
    let mut lasts = chance.between(20, 300) * MS;
    let act = match kind {
        Kind::Kill => Act::Signal(Signal::Kill),
        Kind::Freeze => Act::Signal(Signal::Stop),
        Kind::StopAll => Act::Operate(Operation::StopAll),
        Kind::Operator => Act::Operate(operation(chance)),
        Kind::Contest => Act::Contest,
        Kind::AmidReload => Act::Amid {
            build: chance.between(0, 2) as usize,
            meanwhile: match chance.between(0, 3) {
                0 => Meanwhile::Reload,
                1 => Meanwhile::Panic,
                2 => Meanwhile::Operate(Operation::StopAll),
                _ => Meanwhile::Operate(operation(chance)),
            },
        },
        Kind::Reload => {
            let mut troubles = vec!["panic", "error", "none"];
            if case.clock == Clock::RealTime {
                troubles.push("dawdle");
            }
            Act::Reload {
                trouble: chance.pick(&troubles),
                place: chance.pick(&["awake", "restore", "check", "iterate", "save", "sleep"]),
                build: chance.between(0, 2) as usize,
            }
        }
        Kind::Panic
        | Kind::Error
        | Kind::Hang
        | Kind::Dawdle
        | Kind::Slow
        | Kind::Silence
        | Kind::Nan
        | Kind::Beyond
        | Kind::Flood
        | Kind::Trespass
        | Kind::Chatter
        | Kind::Meddle
        | Kind::Crash => {
            let trouble = chance.pick(kind.troubles());
            let place = chance.pick(kind.places(whom));
            if ["awake", "sleep", "arbitrate", "end"].contains(&place) {
                // These calls come seldom.
                lasts = chance.between(200, 1000) * MS;
            }
            if matches!(kind, Kind::Hang | Kind::Dawdle) && ["check", "iterate"].contains(&place) {
                // Taken back before who hung is there again: one call hangs, not all that follow.
                lasts = chance.between(50, 150) * MS;
            }
            Act::Tell { trouble, place }
        }
        Kind::Client
        | Kind::HostKilled
        | Kind::HostStopped
        | Kind::HostCrashed
        | Kind::LineCut
        | Kind::Unread
        | Kind::TerminalLost
        | Kind::DiskFull
        | Kind::DiskFails => {
            unreachable!("faults of whole processes are no faults of a schema's: see `fits`")
        }
    };
    Fault {
        at,
        lasts,
        kind,
        whom,
        choice: chance.draw(),
        any: chance.once_in(4),
        stays: chance.once_in(6),
        act,
    }
}

/// What somebody does to one schema.
fn operation(chance: &mut Chance) -> Operation {
    match chance.between(0, 4) {
        0 => Operation::Stop,
        1 => Operation::Force,
        2 => Operation::Play,
        3 => Operation::Retime(chance.between(1, 100) * MS),
        _ => Operation::Unload,
    }
}
