//! Schemas in processes of their own: the same plugin and the same ABI, behind a boundary that the plugin
//! cannot break.
//!
//! The host keeps everything that is shared. It reads, loans and publishes for the schema, on the schema's
//! own thread, as if the plugin ran there. So authority, latching, records and triggers work as for any
//! schema, and when the process dies, at whatever instruction, it holds nothing of the host. Each request of
//! the plugin is one message. Large values are not sent: their memory is mapped in both processes, read-only
//! where it is only read (`jde_board::Shared`).
//!
//! ```text
//! host, schema's thread            child
//!   Apart ── call ───────────────► serve ── plugin's function
//!   Call  ◄── read, publish, … ───  table ◄─ host's table
//!   Apart ◄── done ───────────────
//!   Process: a thread that starts the child, waits for its end and reports it to the rules
//! ```
//! A schema has one child process, or two while a build of it is on trial: the other waits asleep for the end
//! of the trial. `limits` restricts what a child may use. Nothing here decides what follows a death: the
//! restart policy does.

mod caller;
mod inspect;
mod launch;
mod limits;
mod memory;
mod process;
mod serve;
mod table;
mod wire;

use std::ffi::OsString;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

pub(crate) use caller::{IsolatedInstance, MAX_INLINE_BYTES};
pub(crate) use inspect::{restrict_to_reading, run_inspection};
pub(crate) use process::{ProcessTable, describe_exit_status};
pub use serve::{ServeError, serve};
pub(crate) use wire::{Frame, FrameKind, Wire};

use jde_app::Isolation;

/// The program that runs a schema in a process of its own: it calls [`serve`] and does nothing else.
#[derive(Clone, Debug)]
pub struct Program {
    /// Its file.
    pub path: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
}

/// The program and the limits that run an instance in a process of its own.
pub(crate) struct ProcessConfig {
    pub(crate) program: Program,
    pub(crate) limits: Isolation,
}

/// The functions to run: a plugin as this process has it, and the index of the type in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct TypeLocation {
    pub(crate) plugin: PluginLocation,
    pub(crate) number: usize,
}

/// Where the child finds a plugin.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum PluginLocation {
    /// In the file that is mapped here: the same bytes, whatever was built since.
    File(#[serde(with = "as_bytes")] PathBuf),
    /// Linked into the program.
    LinkedIn(String),
}

/// Serializes paths as bytes: they need not be valid text.
pub(crate) mod as_bytes {
    use std::ffi::OsString;
    use std::os::unix::ffi::{OsStrExt, OsStringExt};
    use std::path::{Path, PathBuf};

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
        path.as_os_str().as_bytes().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PathBuf, D::Error> {
        Ok(OsString::from_vec(Vec::deserialize(deserializer)?).into())
    }
}
