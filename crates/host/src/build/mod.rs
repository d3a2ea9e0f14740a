//! Builds of schema types: which build each instance runs, and how its port and role numbers map to those of
//! the application.
//!
//! An application never changes; builds do. The third port of a build may be the application's first, or
//! unknown to it. So everything outside the instance, including recordings, keeps the application's numbers.
//! Calls no schema.

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

/// Identifies a build of a plugin, for people.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BuildName {
    /// The plugin's version, as its author states it.
    pub version: String,
    /// Its file; `None` if it is linked in.
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

/// One build of an instance's type.
pub(crate) struct Build {
    pub(crate) table: Functions,
    pub(crate) state: Option<raw::State>,
    /// The place of the type in its plugin.
    pub(crate) number: usize,
    pub(crate) name: BuildName,
    /// Where each of its ports leads.
    ports: Vec<Way>,
    /// For each of its roles, the application's role.
    roles: Vec<Option<usize>>,
    /// The library that contains its functions.
    pub(crate) plugin: Loaded,
}

/// Where a port of a build leads.
pub(crate) enum Way {
    /// To the application's port of that number.
    Bound(usize),
    /// Nowhere: it is new and optional.
    Unbound,
    /// To a constant: a new modulation has its default, a new command its neutral value.
    Fixed { value: Aligned, neutral: bool },
    /// To no reader: a new export of that many bytes.
    Unheard(usize),
}

impl Build {
    /// Returns the build against which the application was checked; `about` is the type as the application
    /// has it.
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

    /// Returns another build, mapped as `fit` states.
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

    /// The number of its ports.
    pub(crate) fn ports(&self) -> usize {
        self.ports.len()
    }

    /// Returns where a port leads; `None` if the build has no such port.
    pub(crate) fn way(&self, port: u32) -> Option<&Way> {
        self.ports.get(port as usize)
    }

    /// Maps the build's role number to the application's: `None` if the build has no such role, `Some(None)`
    /// if the application does not have it.
    pub(crate) fn role(&self, role: u32) -> Option<Option<usize>> {
        self.roles.get(role as usize).copied()
    }

    /// Maps the application's role number to the build's.
    pub(crate) fn own_role(&self, role: usize) -> Option<usize> {
        self.roles.iter().position(|own| *own == Some(role))
    }

    /// The number of its roles.
    pub(crate) fn roles(&self) -> usize {
        self.roles.len()
    }
}

/// Returns the place of a type in another build of its plugin.
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

/// A shared build.
pub(crate) type Shared = Arc<Build>;
