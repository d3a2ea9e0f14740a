//! The names that conditions may use: the schemas, groups and variables of an application, and the signals
//! that follow from them.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::{Role, Type};
use jde_app::Application;
use jde_types::Value;

use super::signals;

/// The names of an application. For an application in another process, the client that queries it fills them
/// in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    /// The schemas, in their order.
    pub schemas: Vec<String>,
    /// The groups, in their order: `roots`, `example/base`.
    pub groups: Vec<String>,
    /// The full names of the variables, and their types.
    pub variables: BTreeMap<String, Arc<Type>>,
    /// The seed of the application, where it is known.
    pub seed: Option<u64>,
}

impl Names {
    /// Returns the names of an application, including the variables that it has when it runs.
    #[must_use]
    pub fn of(application: &Application) -> Self {
        let period = Arc::new(f64::describe());
        let mut variables = BTreeMap::new();
        for instance in &application.instances {
            for port in &instance.schema.ports {
                match port.role {
                    Role::Export { .. } | Role::Modulation { .. } | Role::Command { .. } => {
                        let name = format!("{}.{}", instance.name, port.name);
                        variables.insert(name, Arc::clone(&port.value_type));
                    }
                    Role::Import | Role::Actuator | Role::ChildModulation { .. } => {}
                }
            }
            variables.insert(format!("{}.period", instance.name), Arc::clone(&period));
        }
        for remote in &application.remotes {
            variables.insert(remote.local.clone(), Arc::clone(&remote.value_type));
        }
        let instances = application.instances.iter();
        let groups = application.groups.iter();
        Self {
            schemas: instances.map(|instance| instance.name.clone()).collect(),
            groups: groups.map(|group| group.name.clone()).collect(),
            variables,
            seed: Some(application.seed),
        }
    }

    /// Returns what an expression may name, and the types: the variables and the signals. A variable hides a
    /// signal of the same name.
    #[must_use]
    pub fn inputs(&self) -> BTreeMap<String, Arc<Type>> {
        let mut inputs = self.variables.clone();
        inputs.extend(signals::of(self));
        inputs
    }
}
