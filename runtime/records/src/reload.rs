//! The results of replacing a running schema's build by another one (R10).

use std::fmt;
use std::path::PathBuf;

use jde_core::Nanos;
use serde::{Deserialize, Serialize, Serializer};

/// Identifies a build of a plugin for users.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BuildName {
    /// The plugin's version, as its author states it.
    pub version: String,
    /// Its file; `None` if it is linked in.
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "shown")]
    pub file: Option<PathBuf>,
}

/// Writes a path that may be no text.
fn shown<S: Serializer>(file: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    let shown = file.as_ref().map(|file| file.to_string_lossy());
    shown.serialize(serializer)
}

/// "0.2.0 from target/debug/libvff.so", or the file of one that could not be read.
impl fmt::Display for BuildName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) if self.version.is_empty() => write!(f, "{}", file.display()),
            Some(file) => write!(f, "{} from {}", self.version, file.display()),
            None => f.write_str(&self.version),
        }
    }
}

/// The result of a reload.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReloadReport {
    /// The plugin's file.
    pub file: PathBuf,
    /// How long ago the file was written, ns; `None` if unknown.
    #[serde(default)]
    pub age: Option<Nanos>,
    /// The result for each schema.
    pub schemas: Vec<(String, ReloadOutcome)>,
    /// The builds that the process keeps in memory because of reloads.
    pub memory: ExtraBuilds,
}

/// The result for one schema.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReloadOutcome {
    /// The new build took over.
    Reloaded(Replacement),
    /// It already runs the build in the file.
    Unchanged,
    /// It already runs the build in the file, but had faulted: it may start again, with a fresh instance and
    /// all its restarts.
    Restarted,
    /// The build before continues, for this reason.
    Undone(String),
    /// It is inside a call, and takes over when the call ends.
    Waiting,
}

/// Builds in memory in addition to the first one of each plugin. They are never unmapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExtraBuilds {
    /// Their number.
    pub builds: usize,
    /// The total size of their files, bytes.
    pub bytes: u64,
}

/// How a build took over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Replacement {
    /// The build.
    pub build: BuildName,
    /// The memory taken over from the build before; `None` if the build started without it.
    pub carried: Option<CarriedMemory>,
    /// From the end of the last turn of the build before to the first check of this one, ns of application
    /// time: the schema could not react meanwhile. `None` if it sleeps.
    pub gap: Option<Nanos>,
    /// How long the exchange took, ns of machine time.
    pub took: Nanos,
    /// How long the build is on trial, ns of application time.
    pub probation: Nanos,
    /// Parts of the build that take effect only when the application is restarted.
    pub notes: Vec<String>,
}

/// The memory that one build took over from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CarriedMemory {
    /// The version of its format.
    pub version: u32,
    /// Its size in bytes.
    pub bytes: usize,
}

impl Replacement {
    /// Describes the takeover: "runs 0.2.0 from libvff.so; 12 bytes of memory carried over (version
    /// 1); gap 31.2 ms".
    #[must_use]
    pub fn summary(&self) -> String {
        let carried = self
            .carried
            .map_or_else(|| "begins anew".to_owned(), |carried| carried.to_string());
        let gap = self
            .gap
            .map_or_else(String::new, |gap| format!("; gap {:.1} ms", gap as f64 / 1e6));
        format!("runs {}; {carried}{gap}", self.build)
    }
}

/// "12 bytes of memory carried over (version 1)".
impl fmt::Display for CarriedMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, bytes } = self;
        let unit = if *bytes == 1 { "byte" } else { "bytes" };
        write!(f, "{bytes} {unit} of memory carried over (version {version})")
    }
}

impl ReloadReport {
    /// Whether every schema runs the build in the file.
    #[must_use]
    pub fn is_done(&self) -> bool {
        let is_done_outcome = |outcome: &ReloadOutcome| {
            matches!(
                outcome,
                ReloadOutcome::Reloaded(_) | ReloadOutcome::Unchanged | ReloadOutcome::Restarted
            )
        };
        self.schemas.iter().all(|(_, outcome)| is_done_outcome(outcome))
    }
}
