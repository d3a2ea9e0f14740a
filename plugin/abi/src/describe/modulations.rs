//! The modulations of a type of schema, by number and by name.

use super::{Port, Role, Schema};

impl Schema {
    /// Returns the modulation with that number. `None` if there is no such port, or if it is not a
    /// modulation.
    #[must_use]
    pub fn modulation(&self, port: u32) -> Option<&Port> {
        let port = self.ports.get(port as usize)?;
        matches!(port.role, Role::Modulation { .. }).then_some(port)
    }

    /// Returns the number of the modulation of that name, or of that former name.
    #[must_use]
    pub fn modulation_named(&self, name: &str) -> Option<usize> {
        let find = |is_named: &dyn Fn(&Port) -> bool| {
            let mut ports = self.ports.iter();
            ports.position(|port| matches!(port.role, Role::Modulation { .. }) && is_named(port))
        };
        find(&|port| port.name == name).or_else(|| find(&|port| port.former_name.as_deref() == Some(name)))
    }
}
