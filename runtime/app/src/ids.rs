//! The numbers of what an instance has: its ports and the roles of its children.

use jde_core::{Id, SchemaId};

/// A port of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstancePort {
    /// The instance.
    pub instance: SchemaId,
    /// The place of the port in [`Schema::ports`](jde_abi::describe::Schema::ports).
    pub port: usize,
}

impl InstancePort {
    /// Returns the port of an instance at this place.
    #[must_use]
    pub const fn new(instance: SchemaId, port: usize) -> Self {
        Self { instance, port }
    }
}

/// A role of a father for a child, by its place in [`Schema::children`](jde_abi::describe::Schema::children).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoleId(
    /// The place.
    pub u32,
);

impl Id for RoleId {
    fn new(index: usize) -> Self {
        Self(index as u32)
    }

    fn index(self) -> usize {
        self.0 as usize
    }
}
