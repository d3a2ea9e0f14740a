//! Schemas in a process of their own: the same plugin and the same ABI, beyond a boundary that nothing of it can break through.
//!
//! The host keeps everything that is shared: it reads, loans and publishes in the name of the schema, on the schema's own thread,
//! as if the plugin ran there. So authority, latching, records and triggers are what they are for everybody, and when the process
//! dies, at whatever instruction, nothing of the host's is in its hands. What crosses is one message for each thing the plugin asks;
//! large values do not: their memory is mapped in both, to read only where it is read (`jde_board::Shared`).
//!
//! ```text
//! host, schema's thread            child
//!   Apart ── call ───────────────► serve ── plugin's function
//!   Call  ◄── read, publish, … ───  table ◄─ host's table
//!   Apart ◄── done ───────────────
//!   Process: a thread that starts the child, waits for its end and tells the rules of it
//! ```
//! A schema has one child, or two while a build of it is on trial: the other waits asleep for the end of that.
//! What a child may use is limited in `limits`; nothing here decides what follows a death: that is the restart policy's.

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

pub(crate) use caller::{Apart, MOST_SENT};
pub(crate) use inspect::{inspected, only_look};
pub(crate) use process::{Processes, end_in_words};
pub use serve::{ServeError, serve};
pub(crate) use wire::{Frame, Kind, Wire};

use crate::app::Isolation;

/// The program that runs a schema in a process of its own: it calls [`serve`] and does nothing else.
#[derive(Clone, Debug)]
pub struct Program {
    /// Its file.
    pub path: PathBuf,
    /// What it is called with.
    pub arguments: Vec<OsString>,
}

/// What it takes to run an instance in a process of its own.
pub(crate) struct Room {
    pub(crate) program: Program,
    pub(crate) limits: Isolation,
}

/// Which functions: a plugin as this process has it, and the place of the type in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Code {
    pub(crate) plugin: Plugin,
    pub(crate) number: usize,
}

/// Where the child finds a plugin.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Plugin {
    /// In the file that is mapped here: the same bytes, whatever was built since.
    File(#[serde(with = "as_bytes")] PathBuf),
    /// Linked into the program.
    LinkedIn(String),
}

/// Paths as they are: they need not be texts.
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
