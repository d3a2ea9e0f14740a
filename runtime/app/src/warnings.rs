//! Warnings about settings that may be intended, so they are no faults: roots that compete in one group
//! although they share no actuator, a period far from the type's, a C++ plugin that may throw, what is valid for too long or too
//! short a time, values that do not agree, imports that never have a value, commands that no guard judges, and schemas that trigger each other.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use jde_core::{Nanos, SchemaId};

use super::{Application, Binding, GroupConfig, InstanceConfig, InstancePort};
use crate::period::{format_setting, is_far_longer};
use jde_document::quote_all;

/// How many times longer or shorter than the type's period the period that was meant may be.
const MEANT_UNIT_FACTOR: Nanos = 10;
/// The ratio of a unit of time to the next smaller one.
const NEXT_UNIT: Nanos = 1000;

/// Instances and ports of commands.
type Commands = BTreeSet<InstancePort>;

impl Application {
    /// Returns warnings about settings that are valid but may not be intended: a sentence or two each, with
    /// the line.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let levels = self.groups.iter().filter(|group| group.father.is_none());
        let mut below = self.commands_below();
        let disjoint_roots = levels.filter_map(|level| self.warn_of_disjoint_roots(level, &mut below));
        disjoint_roots
            .chain(self.instances.iter().filter_map(warn_of_period))
            .chain(self.warn_of_exceptions())
            .chain(self.warn_of_validity())
            .chain(self.warn_of_disagreements())
            .chain(self.warn_of_sensors())
            .chain(self.absent_imports())
            .chain(self.warn_of_unjudged())
            .chain(self.warn_of_trigger_loops())
            .chain(self.link.warnings())
            .collect()
    }

    /// Warns of C++ plugins that run in the host's process and do not declare that they catch their
    /// exceptions.
    fn warn_of_exceptions(&self) -> impl Iterator<Item = String> {
        let numbers = 0..self.plugins.len();
        numbers.filter(|number| self.plugins[*number].throws).filter_map(|number| {
            let in_host = |instance: &&InstanceConfig| instance.plugin == number && instance.isolate.is_none();
            let instances: Vec<_> = self.instances.iter().filter(in_host).collect();
            let line = instances.iter().map(|instance| instance.line).min()?;
            let names = quote_all(instances.iter().map(|instance| instance.name.as_str()));
            Some(format!(
                "line {line}: {names} are of the plugin `{}`, which is in C++: an exception that leaves one of its functions ends the \
                 application. Write isolate = \"process\", or have the plugin catch it (jde_guarded and JDE_PLUGIN_GUARDED of jde.h)",
                self.plugins[number].name
            ))
        })
    }

    /// Returns, for each root, the commands that it and the schemas below it are bound to.
    fn commands_below(&self) -> HashMap<SchemaId, Commands> {
        let mut below: HashMap<SchemaId, Commands> = HashMap::new();
        for (id, instance) in self.instances.entries() {
            let commands = instance.bindings.iter().filter_map(|binding| match binding {
                Binding::Actuator { target } => *target,
                _ => None,
            });
            below.entry(self.root(id)).or_default().extend(commands);
        }
        below
    }

    /// Warns of a level whose members share no actuator. Takes the commands of its members.
    fn warn_of_disjoint_roots(
        &self,
        level: &GroupConfig,
        below: &mut HashMap<SchemaId, Commands>,
    ) -> Option<String> {
        // Members that share a command are one part, which its last member names.
        let mut user_of: HashMap<InstancePort, usize> = HashMap::new();
        let mut newer: Vec<usize> = Vec::new();
        let last = |newer: &mut Vec<usize>, mut member: usize| {
            while newer[member] != member {
                newer[member] = newer[newer[member]];
                member = newer[member];
            }
            member
        };
        let used = level.members.iter().filter_map(|root| below.remove_entry(root));
        let members: Vec<_> = used.filter(|(_, commands)| !commands.is_empty()).collect();
        for (member, (_, commands)) in members.iter().enumerate() {
            newer.push(member);
            for command in commands {
                if let Some(other) = user_of.insert(*command, member) {
                    let other = last(&mut newer, other);
                    newer[other] = member;
                }
            }
        }
        let mut parts: BTreeMap<usize, Vec<SchemaId>> = BTreeMap::new();
        for (member, (root, _)) in members.iter().enumerate() {
            let part = last(&mut newer, member);
            parts.entry(part).or_default().push(*root);
        }
        if parts.len() < 2 {
            return None;
        }
        let name = |root: &SchemaId| self.instances[*root].name.as_str();
        let mut names = parts.values().map(|roots| quote_all(roots.iter().map(name)));
        let (first, rest) = (names.next()?, names.collect::<Vec<_>>().join(", nor with "));
        let line = parts
            .values()
            .filter_map(|roots| roots.first())
            .map(|root| self.instances[*root].line)
            .min()?;
        Some(format!(
            "line {line}: the roots {first} share no actuator with {rest}, and only one of all acts at a time. If they are to act at \
             once, give each its own level: [roots.NAME] with members = [...]"
        ))
    }

    /// Returns the root above a schema, or the schema itself.
    fn root(&self, mut id: SchemaId) -> SchemaId {
        while let Some(father) = self.instances[id].father {
            id = father;
        }
        id
    }
}

/// Warns of a period that is far from the type's.
fn warn_of_period(instance: &InstanceConfig) -> Option<String> {
    let (period, usual) = (instance.period_ns, instance.schema.period_ns);
    let meant = if is_far_longer(period, usual) {
        period / NEXT_UNIT
    } else if is_far_longer(usual, period) {
        period * NEXT_UNIT
    } else {
        return None;
    };
    let advice = if meant / MEANT_UNIT_FACTOR < usual && usual / MEANT_UNIT_FACTOR < meant {
        format!("; if {0} is meant, write period = \"{0}\"", format_setting(meant))
    } else {
        String::new()
    };
    Some(format!(
        "line {}: `period` of schema `{}` is {}, and {} in its type{advice}",
        instance.line,
        instance.name,
        format_setting(period),
        format_setting(usual)
    ))
}
