//! Checks whether a plugin keeps the promises of the ABI, in any language that makes libraries.
//!
//! Each promise is a named [`Check`]. It runs in a process of its own, which plays the host for the plugin, and
//! which is ended when it does not finish. So a plugin that crashes, exits or hangs fails the check for that and
//! spoils no other.
//!
//! Nothing is opened and nothing moves: the processes state that time is not real, so a driver of a device
//! refuses to awake. What it would do afterwards is then skipped, with its reason.

#![deny(missing_docs)]

mod bench;
mod checks;
mod life;
mod malformed;
mod measurement;
mod run;
mod serve;

use serde::{Deserialize, Serialize};

pub use checks::{CHECKS, Check};
pub use run::{ValidationError, validate};
pub use serve::serve;

/// The result of a check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "result", content = "words", rename_all = "lowercase")]
pub enum CheckResult {
    /// The promise is kept, as far as the check sees.
    Ok,
    /// It is not kept, in these words.
    Failed(String),
    /// The check does not apply, for this reason.
    Skipped(String),
}

/// What one check found for one type of schema.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The name of the check.
    pub check: &'static str,
    /// The type of schema; `None` for the plugin as a whole.
    #[serde(rename = "type")]
    pub schema: Option<String>,
    /// What it found.
    #[serde(flatten)]
    pub verdict: CheckResult,
}
