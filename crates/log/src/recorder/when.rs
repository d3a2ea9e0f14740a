//! Recordings that wait for a reason: what they wait for, and what is told of their files.

use std::path::PathBuf;

use jde_board::Nanos;

use crate::trigger::Triggers;

/// Is told what happens to files that conditions ask for, by the writing thread.
pub type OnFile = Box<dyn FnMut(Happened, &Written) + Send>;

/// Writing only when something is worth it: files of what was before and after a condition came true.
pub struct When {
    /// The conditions.
    pub triggers: Triggers,
    /// How much a file has of what was before, ns.
    pub before: Nanos,
    /// How much of what came after the last time that a condition came true, ns.
    pub after: Nanos,
    /// Most bytes of the past that are held in memory; what has to go before its time is counted.
    pub memory: usize,
    /// Told of every file.
    pub on_file: OnFile,
}

/// What happened to a file that a condition asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happened {
    /// A condition came true, and it is being written.
    Began,
    /// A condition came true again, and it goes on for longer.
    FiredAgain,
    /// It is whole.
    Ended,
    /// The disk does not take it. Told once, until a file has been whole again; each firing tries anew.
    Failed,
}

/// A file that a condition asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Where.
    pub path: PathBuf,
    /// What came true: `collision in example/base`.
    pub reason: String,
    /// When, ns since the application's start.
    pub time: Nanos,
    /// How often conditions came true in its time.
    pub fired: u64,
    /// Messages that have reached it.
    pub kept: u64,
    /// Messages of its time that it does not have.
    pub lost: u64,
    /// Its bytes.
    pub bytes: u64,
    /// Why it ends too soon, if it does.
    pub trouble: Option<String>,
}
