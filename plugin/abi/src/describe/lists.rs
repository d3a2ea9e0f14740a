//! The description of a list of ports.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Type, Validity, shared};

/// A list of ports: a table of the application file whose entries are ports of any type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PortList {
    /// Name of the table.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// What its ports are.
    pub kind: ListKind,
    /// Type of the settings of each entry.
    #[serde(with = "shared")]
    pub settings: Arc<Type>,
    /// The settings that an entry does not state.
    pub initial: Vec<u8>,
}

/// What the ports of a list are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ListKind {
    /// Imports.
    Imports,
    /// Exports.
    Exports {
        /// How long a value is valid (R19).
        validity: Validity,
    },
    /// Commands of a driver. Their neutral value is all zeros, and a new command lets the driver iterate at once (R12).
    Commands {
        /// How long a command is in force, ns.
        validity_ns: u64,
    },
}

impl fmt::Display for ListKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Imports => "imports",
            Self::Exports { .. } => "exports",
            Self::Commands { .. } => "commands",
        })
    }
}
