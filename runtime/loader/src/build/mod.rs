//! Builds of schema types, and the mapping of their port and role numbers to those of the application.
//!
//! An application never changes; builds do. The third port of a build may be the application's first, or
//! unknown to it. So all code outside the instance, including recordings, uses the application's numbers.
//! It calls no schema.

mod compatibility;

use std::sync::Arc;

use jde_abi::{describe, raw};
use jde_app::RoleId;
use jde_core::Id;
use jde_records::reload::BuildName;

use crate::instance::memory_of;
use crate::{AlignedBytes, Judge, LoadedPlugin, SchemaFunctions};
pub use compatibility::{BuildMapping, map_build};

/// One build of an instance's type.
pub struct Build {
    /// The functions of the type.
    pub table: SchemaFunctions,
    /// Its functions for saving and restoring memory, if it has them.
    pub state: Option<raw::State>,
    /// Its function that judges commands, if it is a guard (R18).
    pub judge: Option<Judge>,
    /// The index of the type in its plugin.
    pub number: usize,
    /// The build's version and file.
    pub name: BuildName,
    /// The mapping of each of its ports.
    ports: Vec<PortMapping>,
    /// For each of its roles, the application's role.
    roles: Vec<Option<RoleId>>,
    /// The library that contains its functions.
    pub plugin: LoadedPlugin,
}

/// The mapping of a port of a build.
pub enum PortMapping {
    /// To the application's port of that number.
    Bound(usize),
    /// To nothing: it is new and optional.
    Unbound,
    /// To a constant: a new modulation has its default, a new command its neutral value.
    Fixed {
        /// The value.
        value: AlignedBytes,
        /// Whether it is the neutral value of a command.
        neutral: bool,
    },
    /// To no reader: a new export of that many bytes.
    Discarded(usize),
}

impl Build {
    /// Returns the build against which the application was checked; `schema` is the type in the
    /// application.
    pub fn original(plugin: LoadedPlugin, number: usize, schema: &describe::Schema) -> Self {
        let mapping = BuildMapping {
            ports: (0..schema.ports.len()).map(PortMapping::Bound).collect(),
            roles: (0..schema.children.len())
                .map(|role| Some(RoleId::new(role)))
                .collect(),
            notes: Vec::new(),
        };
        let table = plugin.schema(number);
        let state = memory_of(&table).unwrap_or_else(|error| {
            tracing::warn!(
                "the memory of `{}` is not kept across builds: {error}",
                schema.name
            );
            None
        });
        Self::new(plugin, number, state, mapping)
    }

    /// Returns another build, mapped by `mapping`.
    pub fn new(
        plugin: LoadedPlugin,
        number: usize,
        state: Option<raw::State>,
        mapping: BuildMapping,
    ) -> Self {
        let table = plugin.schema(number);
        Self {
            judge: Judge::of(&table),
            table,
            state,
            number,
            name: BuildName {
                version: plugin.description.version.clone(),
                file: plugin.path.clone(),
            },
            ports: mapping.ports,
            roles: mapping.roles,
            plugin,
        }
    }

    /// Returns the number of its ports.
    pub fn ports(&self) -> usize {
        self.ports.len()
    }

    /// Returns the mapping of a port; `None` if the build has no such port.
    pub fn mapping(&self, port: u32) -> Option<&PortMapping> {
        self.ports.get(port as usize)
    }

    /// Maps the build's role number to the application's: `None` if the build has no such role, `Some(None)`
    /// if the application does not have it.
    pub fn role(&self, role: u32) -> Option<Option<RoleId>> {
        self.roles.get(role as usize).copied()
    }

    /// Maps the application's role number to the build's.
    pub fn own_role(&self, role: RoleId) -> Option<usize> {
        self.roles.iter().position(|own| *own == Some(role))
    }

    /// Returns the number of its roles.
    pub fn roles(&self) -> usize {
        self.roles.len()
    }
}

/// Returns the index of a type in another build of its plugin.
pub fn schema_index(plugin: &describe::Plugin, schema: &str) -> Option<usize> {
    plugin.schemas.iter().position(|other| other.name == schema)
}

impl PortMapping {
    fn fixed(value: &[u8], neutral: bool) -> Self {
        Self::Fixed {
            value: AlignedBytes::new(value),
            neutral,
        }
    }
}

/// A shared build.
pub type SharedBuild = Arc<Build>;
