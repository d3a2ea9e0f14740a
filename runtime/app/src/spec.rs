//! The part of an application that the rules need; they know nothing of ports and values.

use jde_abi::describe;
use jde_core::{GroupSpec, Kind, SchemaId, SchemaSpec, Spec};

use super::needs::keeps_awake;
use super::{Application, Binding, GroupConfig, ImportSource, InstanceConfig, InstancePort};

impl Application {
    /// Returns the application as the rules see it. Schemas and groups are numbered as in
    /// [`Application::instances`] and [`Application::groups`].
    ///
    /// Perceptive children are no needs: their father wakes them.
    #[must_use]
    pub fn spec(&self) -> Spec {
        Spec {
            schemas: self.instances.map_ids(|id| self.schema_spec(id)),
            groups: self.groups.iter().map(group_spec).collect(),
        }
    }

    fn schema_spec(&self, id: SchemaId) -> SchemaSpec {
        let instance = &self.instances[id];
        let (needs, only_commands) = self.needs(id);
        SchemaSpec {
            name: instance.name.clone(),
            kind: match instance.schema.kind {
                describe::Kind::Motor => Kind::Motor,
                describe::Kind::Perceptive | describe::Kind::Driver => Kind::Perceptive,
            },
            needs,
            only_commands,
            restart: instance.restart,
            period: instance.period_ns,
            budget: instance.budget_ns,
            triggered: instance.is_triggered(),
            panel: instance.schema.panel,
        }
    }

    /// Returns the perceptive schemas and drivers whose exports it imports or which it commands, the guards
    /// of its commands, and those that every root needs if it is one, each once; and those that it only commands.
    fn needs(&self, id: SchemaId) -> (Vec<SchemaId>, Vec<SchemaId>) {
        let (mut needs, mut sees) = (Vec::new(), Vec::new());
        for binding in &self.instances[id].bindings {
            let (Binding::Import {
                source: Some(ImportSource::Local(provider)),
                ..
            }
            | Binding::Actuator {
                target: Some(provider),
            }) = *binding
            else {
                continue;
            };
            let InstancePort {
                instance: owner,
                port,
            } = provider;
            let guards = match binding {
                Binding::Actuator { .. } => self.guards(id, provider),
                _ => Vec::new(),
            };
            let is_needed = owner != id && keeps_awake(&self.instances[owner].schema, port);
            let owner = is_needed.then_some(owner);
            if matches!(binding, Binding::Import { .. }) {
                sees.extend(owner);
            }
            sees.extend(&guards);
            for need in owner.into_iter().chain(guards) {
                if !needs.contains(&need) {
                    needs.push(need);
                }
            }
        }
        let is_root = is_root(&self.instances[id]);
        for need in self.awake.iter().filter(|_| is_root) {
            sees.push(*need);
            if !needs.contains(need) {
                needs.push(*need);
            }
        }
        let only_commands = needs
            .iter()
            .copied()
            .filter(|need| !sees.contains(need))
            .collect();
        (needs, only_commands)
    }
}

fn is_root(instance: &InstanceConfig) -> bool {
    instance.schema.kind == describe::Kind::Motor && instance.father.is_none()
}

impl InstanceConfig {
    /// Whether any import re-evaluates its precondition when published (R12).
    #[must_use]
    pub fn is_triggered(&self) -> bool {
        self.bindings.iter().any(|binding| {
            matches!(
                binding,
                Binding::Import {
                    source: Some(_),
                    trigger: true,
                    ..
                }
            )
        })
    }
}

fn group_spec(group: &GroupConfig) -> GroupSpec {
    GroupSpec {
        name: group.name.clone(),
        father: group.father,
        members: group.members.clone(),
        policy: group.policy,
        absence: group.absence,
        patience: group.patience_ns,
        budget: group.budget_ns,
        retry: group.retry_ns,
    }
}
