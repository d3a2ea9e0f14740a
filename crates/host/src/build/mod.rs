//! Builds of types of schemas: which one each instance runs, and how the numbers of its ports and roles are the application's.
//!
//! An application never changes; builds do. What a build calls its third port may be the application's first, or nobody's, so that
//! everything outside the instance, recordings included, keeps the numbers of the application. Calls no schema.

mod fit;
mod register;

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use jde_abi::{describe, raw};
use serde::{Deserialize, Serialize};

use crate::history::Aligned;
use crate::instance::memory_of;
use crate::plugin::{Functions, Loaded};
pub(crate) use fit::{Fit, fit};
pub(crate) use register::Register;

/// Which build of a plugin it is, for people.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BuildName {
    /// The version of the plugin, as its author counts.
    pub version: String,
    /// Its file; none if it is linked in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
}

/// "0.2.0 from target/debug/libvff.so".
impl fmt::Display for BuildName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.version)?;
        match &self.file {
            Some(file) => write!(f, " from {}", file.display()),
            None => Ok(()),
        }
    }
}

/// One build of the type of an instance.
pub(crate) struct Build {
    pub(crate) table: Functions,
    pub(crate) state: Option<raw::State>,
    /// The place of the type in its plugin.
    pub(crate) number: usize,
    pub(crate) name: BuildName,
    /// Where each of its ports leads.
    ports: Vec<Way>,
    /// Each of its roles among those of the application.
    roles: Vec<Option<usize>>,
    /// What its functions are in.
    pub(crate) plugin: Loaded,
}

/// Where a port of a build leads.
pub(crate) enum Way {
    /// To the application's port of that number.
    Bound(usize),
    /// Nowhere: it is new, and optional.
    Unbound,
    /// To a value that nobody writes: it is a new modulation, or a new command, whose neutral value is in force.
    Fixed { value: Aligned, neutral: bool },
    /// To nobody: it is a new export of so many bytes.
    Unheard(usize),
}

impl Build {
    /// The one that the application was checked against; `about` is the type as the application has it.
    pub(crate) fn original(plugin: Loaded, number: usize, about: &describe::Schema) -> Self {
        let fit = Fit {
            ports: (0..about.ports.len()).map(Way::Bound).collect(),
            roles: (0..about.children.len()).map(Some).collect(),
            notes: Vec::new(),
        };
        let table = plugin.schema(number);
        let state = memory_of(&table).unwrap_or_else(|wrong| {
            tracing::warn!("`{}` remembers nothing from build to build: {wrong}", about.name);
            None
        });
        Self::new(plugin, number, state, fit)
    }

    /// Another, in the place that `fit` found for it.
    pub(crate) fn new(plugin: Loaded, number: usize, state: Option<raw::State>, fit: Fit) -> Self {
        Self {
            table: plugin.schema(number),
            state,
            number,
            name: BuildName {
                version: plugin.description.version.clone(),
                file: plugin.path.clone(),
            },
            ports: fit.ports,
            roles: fit.roles,
            plugin,
        }
    }

    /// How many ports it has.
    pub(crate) fn ports(&self) -> usize {
        self.ports.len()
    }

    /// Where a port leads; none if it has none of that number.
    pub(crate) fn way(&self, port: u32) -> Option<&Way> {
        self.ports.get(port as usize)
    }

    /// A role of the application by the build's number: none if it has none of that number, and none within if nobody has it.
    pub(crate) fn role(&self, role: u32) -> Option<Option<usize>> {
        self.roles.get(role as usize).copied()
    }

    /// The build's number of a role of the application.
    pub(crate) fn own_role(&self, role: usize) -> Option<usize> {
        self.roles.iter().position(|own| *own == Some(role))
    }

    /// How many roles it has.
    pub(crate) fn roles(&self) -> usize {
        self.roles.len()
    }
}

/// The place of a type in another build of its plugin.
pub(crate) fn place(plugin: &describe::Plugin, schema: &str) -> Option<usize> {
    plugin.schemas.iter().position(|other| other.name == schema)
}

impl Way {
    fn fixed(value: &[u8], neutral: bool) -> Self {
        Self::Fixed {
            value: Aligned::new(value),
            neutral,
        }
    }
}

/// A build that may be shared.
pub(crate) type Shared = Arc<Build>;
