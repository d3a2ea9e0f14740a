//! Schemas in processes of their own: the same plugin and the same ABI, behind a boundary that the plugin
//! cannot break.
//!
//! The host owns everything that is shared. It reads, loans and publishes for the schema, on the schema's
//! own thread, as if the plugin ran on it. So authority, latching, records and triggers work as for any
//! schema, and a process that dies at any instruction holds no resource of the host. The inputs that a call
//! usually reads arrive with it, and what the plugin publishes is a message without a reply if the child knows
//! the outcome; each other request is a message and a reply. Large values are not sent: their memory is mapped
//! in both processes, writable only in the process that exports them (`jde_board::Shared`). What a process writes of
//! others, a command or a modulation, it sends: the host checks and publishes a copy.
//!
//! ```text
//! host, schema's thread            child
//!   Process ─ values, call ──────►  serve ── plugin's function
//!   Wire  ◄── publish, wake, … ───  table ◄─ host's table
//!   Process ◄─ done ──────────────
//!   Process: a thread that starts the child, waits for its end and reports it to the rules
//! ```
//! A schema has one child process, or two while a build of it is on trial: the other sleeps until the end of
//! the trial. `limits` restricts the resources of a child. After a death the
//! restart policy applies.

pub mod authority;
pub mod descendants;
mod inspect;
pub mod launch;
mod limits;
pub mod lines;
mod memory;
pub mod messages;
mod output;
pub mod process;
pub mod python;
mod serve;
mod table;
mod terminal;
mod timers;
mod traceback;
pub mod wire;

use std::ffi::OsString;
use std::path::PathBuf;

use jde_app::Isolation;
use jde_loader::PluginLocation;
use serde::{Deserialize, Serialize};

pub use inspect::{Inspector, serve as serve_inspections};
pub use serve::{ServeError, load, serve};
pub use table::{HOLD, Hold};
pub use terminal::HeldTerminal;
pub use timers::{machine_time, run_when_due};

/// The program that runs a schema in a process of its own, or inspects plugins: it calls [`serve`] or
/// [`serve_inspections`], and does nothing else.
#[derive(Clone, Debug)]
pub struct Program {
    /// Its file.
    pub path: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
}

impl Program {
    /// The argument of the executable `jde` with which it runs a schema.
    pub const SCHEMA: &str = "--serve-schema";
    /// The argument of the executable `jde` with which it inspects plugins.
    pub const INSPECTIONS: &str = "--serve-inspections";

    /// Returns the executable `jde` as the program that runs a schema.
    #[must_use]
    pub fn schema(jde: PathBuf) -> Self {
        Self::new(jde, Self::SCHEMA)
    }

    /// Returns the executable `jde` as the program that inspects plugins.
    #[must_use]
    pub fn inspections(jde: PathBuf) -> Self {
        Self::new(jde, Self::INSPECTIONS)
    }

    /// Returns a program with one argument.
    #[must_use]
    pub fn new(path: PathBuf, argument: &str) -> Self {
        let arguments = vec![argument.into()];
        Self { path, arguments }
    }
}

/// The program and the limits that run an instance in a process of its own.
pub struct ProcessConfig {
    /// The program.
    pub program: Program,
    /// The limits.
    pub limits: Isolation,
    /// Whether its debugger may hold calls and use the host's terminal.
    pub debugged: bool,
    /// Whether it is an interpreter of Python, which says where it was when it is killed.
    pub is_python: bool,
}

/// The functions to run: the location of a plugin, and the index of a type in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TypeLocation {
    /// The location of the plugin.
    pub plugin: PluginLocation,
    /// The index of the type in its plugin.
    pub number: usize,
}
