//! The description of a list of ports.

use std::sync::Arc;

use super::Type;

/// A list of ports: a table of the application file whose entries are ports of any type.
#[derive(Clone, Debug, PartialEq)]
pub struct PortList {
    /// Name of the table.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Whether its ports are exports; otherwise they are imports.
    pub exports: bool,
    /// Type of the settings of each entry.
    pub settings: Arc<Type>,
    /// The settings that an entry does not state.
    pub initial: Vec<u8>,
}
