//! Recordings on conditions: the conditions, and the reports about their files.

use std::path::PathBuf;

use jde_board::Nanos;

use jde_conditions::Triggers;

/// Called by the writing thread with each report about a file that conditions have caused.
pub type OnFile = Box<dyn FnMut(FileEvent, &TriggeredFile) + Send>;

/// How to record on conditions: each file contains the time before and after a condition became true.
pub struct TriggerOptions {
    /// The conditions.
    pub triggers: Triggers,
    /// How much time before the condition became true a file contains, in ns.
    pub before: Nanos,
    /// How much time a file contains after the last moment at which a condition became true, in ns.
    pub after: Nanos,
    /// The upper limit of the past in memory, in bytes. Messages that are removed before their time ends are
    /// counted.
    pub memory: usize,
    /// Called with each report about a file.
    pub on_file: OnFile,
}

/// A report about a file that a condition has caused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileEvent {
    /// A condition became true, and the file is being written.
    Started,
    /// A condition became true again, and the file continues for longer.
    Extended,
    /// The file is complete.
    Ended,
    /// The disk does not accept the file. Reported once, until a file is complete again. Each time a
    /// condition becomes true, a new attempt is made.
    Failed,
}

/// A file that a condition has caused.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TriggeredFile {
    /// The path of the file.
    pub path: PathBuf,
    /// The condition that became true: `conflict in example/base`.
    pub reason: String,
    /// The time at which it became true, in ns since the application's start.
    pub time: Nanos,
    /// How often conditions became true during the time of the file.
    pub fired: u64,
    /// Messages that have reached the file.
    pub written: u64,
    /// Messages of the file's time that it does not contain.
    pub lost: u64,
    /// The size of the file in bytes.
    pub bytes: u64,
    /// Why the file ends too early, if it does.
    pub error: Option<String>,
}
