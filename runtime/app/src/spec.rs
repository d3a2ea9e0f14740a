//! The part of an application that the rules need; they know nothing of ports and values.

use jde_abi::describe;
use jde_core::{GroupSpec, Kind, SchemaId, SchemaSpec, Spec};

use super::needs::keeps_awake;
use super::{Application, Binding, GroupConfig, ImportSource, InstanceConfig};

impl Application {
    /// Returns the application as the rules see it. Schemas and groups are numbered as in
    /// [`Application::instances`] and [`Application::groups`].
    ///
    /// Perceptive children are no needs: their father wakes them.
    #[must_use]
    pub fn spec(&self) -> Spec {
        Spec {
            schemas: (0..self.instances.len())
                .map(|index| self.schema_spec(index))
                .collect(),
            groups: self.groups.iter().map(group_spec).collect(),
        }
    }

    fn schema_spec(&self, index: usize) -> SchemaSpec {
        let instance = &self.instances[index];
        let (needs, only_commands) = self.needs(index);
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
    fn needs(&self, index: usize) -> (Vec<SchemaId>, Vec<SchemaId>) {
        let (mut needs, mut sees) = (Vec::new(), Vec::new());
        for binding in &self.instances[index].bindings {
            let (Binding::Import {
                source: Some(ImportSource::Local(provider, port)),
                ..
            }
            | Binding::Actuator {
                target: Some((provider, port)),
            }) = *binding
            else {
                continue;
            };
            let schema = &self.instances[provider].schema;
            let guards = match binding {
                Binding::Actuator { .. } => self.guards(index, (provider, port)),
                _ => Vec::new(),
            };
            let provider = (provider != index && keeps_awake(schema, port)).then_some(provider);
            if matches!(binding, Binding::Import { .. }) {
                sees.extend(provider.map(id));
            }
            sees.extend(guards.iter().copied().map(id));
            for need in provider.into_iter().chain(guards).map(id) {
                if !needs.contains(&need) {
                    needs.push(need);
                }
            }
        }
        let is_root = is_root(&self.instances[index]);
        for need in self.awake.iter().filter(|_| is_root).copied().map(id) {
            sees.push(need);
            if !needs.contains(&need) {
                needs.push(need);
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
        father: group.father.map(id),
        members: group.members.iter().copied().map(id).collect(),
        policy: group.policy,
        absence: group.absence,
        patience: group.patience_ns,
        budget: group.budget_ns,
        retry: group.retry_ns,
    }
}

fn id(index: usize) -> SchemaId {
    SchemaId(u32::try_from(index).expect("an application file is too small for that many instances"))
}
