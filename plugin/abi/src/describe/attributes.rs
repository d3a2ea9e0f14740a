//! The attributes that a port has or has not: one list, from which tables, macros, descriptions and Python are made.

use serde::{Deserialize, Serialize};

use super::{Port, Role};
use crate::raw;

/// An attribute of ports.
#[derive(Debug)]
pub struct Attribute {
    /// Its name as an option of the macros and of Python, and in the output of tools for programs.
    pub name: &'static str,
    /// The flag in [`raw::Port::flags`].
    pub flag: u32,
    /// The kinds of ports that may have it.
    pub kinds: &'static [u32],
    /// What tools say of a port that has it.
    pub words: &'static str,
}

/// All attributes, in the order in which tools show them.
pub const ATTRIBUTES: &[Attribute] = &[
    Attribute {
        name: "trigger",
        flag: raw::TRIGGER,
        kinds: &[raw::IMPORT, raw::COMMAND],
        words: "triggers",
    },
    Attribute {
        name: "mount",
        flag: raw::MOUNT,
        kinds: &[raw::MODULATION],
        words: "mount of its sensor",
    },
    Attribute {
        name: "margin",
        flag: raw::MARGIN,
        kinds: &[raw::MODULATION],
        words: "distance to obstacles",
    },
    Attribute {
        name: "limit",
        flag: raw::LIMIT,
        kinds: &[raw::MODULATION],
        words: "limit of the base",
    },
    Attribute {
        name: "fixed",
        flag: raw::FIXED,
        kinds: &[raw::MODULATION],
        words: "taken on awakening",
    },
    Attribute {
        name: "optional",
        flag: raw::OPTIONAL,
        kinds: &[raw::IMPORT, raw::ACTUATOR, raw::CHILD_MODULATION],
        words: "optional",
    },
];

/// The attributes of one port, as flags of the ABI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attributes(u32);

impl Attributes {
    /// Returns the attributes with these flags, without those that a port of that kind has not: they mean nothing.
    #[must_use]
    pub fn of(kind: u32, flags: u32) -> Self {
        let possible = ATTRIBUTES
            .iter()
            .filter(|attribute| attribute.kinds.contains(&kind));
        Self(flags & possible.fold(0, |known, attribute| known | attribute.flag))
    }

    /// Returns their flags.
    #[must_use]
    pub fn flags(self) -> u32 {
        self.0
    }
}

impl Attribute {
    /// Returns the flag of the attribute with this name; 0 if there is none.
    #[must_use]
    pub fn flag(name: &str) -> u32 {
        let named = ATTRIBUTES.iter().find(|attribute| attribute.name == name);
        named.map_or(0, |attribute| attribute.flag)
    }
}

impl Port {
    /// Returns whether the port has the attribute with this flag.
    #[must_use]
    pub fn has(&self, flag: u32) -> bool {
        self.attributes.0 & flag != 0
    }
}

impl Role {
    /// Returns the kind of port in the ABI.
    #[must_use]
    pub fn kind(&self) -> u32 {
        match self {
            Self::Import => raw::IMPORT,
            Self::Export { .. } => raw::EXPORT,
            Self::Modulation { .. } => raw::MODULATION,
            Self::Command { .. } => raw::COMMAND,
            Self::Actuator => raw::ACTUATOR,
            Self::ChildModulation { .. } => raw::CHILD_MODULATION,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_has_no_attribute_of_another_kind() {
        let agreed = raw::MOUNT | raw::MARGIN | raw::LIMIT;
        let all = raw::TRIGGER | raw::FIXED | raw::OPTIONAL | raw::MANY | agreed;
        let flags = |kind| Attributes::of(kind, all).flags();
        assert_eq!(flags(raw::IMPORT), raw::TRIGGER | raw::OPTIONAL);
        assert_eq!(flags(raw::MODULATION), raw::FIXED | agreed);
        assert_eq!(flags(raw::EXPORT), 0);
    }
}
