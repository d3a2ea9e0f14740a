//! Requests that schemas inspect what their modulations name (`jde.inspect`), and reports the problems at the
//! values. Calls no plugin itself.

use std::sync::Arc;

use jde_abi::describe::{Plugin, Role, Schema};
use jde_abi::lists::ListedPort;

use super::drafts::InstanceContext;
use super::{AbsentExport, Binding, Catalogue, Override, lists};
use jde_document::{FaultReport, quote};

/// A request to a schema type to inspect these values of its modulations.
#[derive(Clone, Debug)]
pub struct Inspection<'q> {
    /// The place of the type in its plugin.
    pub number: usize,
    /// The name of the instance.
    pub name: &'q str,
    /// The binding of each port.
    pub bindings: &'q [Binding],
    /// The ports of the type's lists.
    pub listed: &'q [ListedPort],
}

/// Reports the problems that the type of an instance finds. Returns the exports that never have a value.
pub(super) fn report_problems(
    report: &mut FaultReport,
    catalogue: &dyn Catalogue,
    plugin: &Arc<Plugin>,
    (instance, inspection): (&InstanceContext, &Inspection),
    overrides: &[Override],
) -> Vec<AbsentExport> {
    let mut absent = Vec::new();
    let section = instance.section();
    let entries = instance.schema.lists.iter();
    let stated: usize = entries.map(|list| lists::entries(section, list).len()).sum();
    if stated > inspection.listed.len() {
        // An entry has a fault, which is reported: to the type it would look as if it were missing.
        return absent;
    }
    let problems = match catalogue.inspect(plugin, inspection) {
        Ok(problems) => problems,
        Err(reason) => {
            let plugin = quote(&plugin.name);
            let message = format!(
                "{}: the plugin {plugin} cannot inspect it: {reason}",
                section.label
            );
            report.concern(&section.span, message);
            return absent;
        }
    };
    for problem in problems {
        if let Some((entry, list)) = inspection.entry(instance.schema, problem.port) {
            let message = format!("{} in {}: {}", quote(entry), section.key(list), problem.words);
            let span = section.entry_span(list, entry);
            if problem.unavailable {
                report.concern(&span, message);
            } else {
                report.fault(&span, message);
            }
            continue;
        }
        let port = problem.port as usize;
        let named = instance.schema.ports.get(port);
        if let Some(named) = named.filter(|named| matches!(named.role, Role::Export { .. })) {
            let words = problem.words;
            if problem.unavailable {
                absent.push(AbsentExport { port, words });
            } else {
                let message = format!("{}: {words}", section.key(&named.name));
                report.fault(&section.span, message);
            }
            continue;
        }
        let Some(port) = instance.schema.modulation(problem.port) else {
            let (plugin, number) = (quote(&plugin.name), problem.port);
            let message = format!(
                "{}: the plugin {plugin} cannot inspect it: it reports a problem of modulation {number}, and there is none with that \
                 number; correct the plugin",
                section.label
            );
            report.concern(&section.span, message);
            continue;
        };
        let former_name = port.former_name.as_deref();
        let stated = section.get(&port.name).or_else(|| section.get(former_name?));
        let span = stated.map_or(section.span.clone(), |node| node.span());
        let message = format!("{}: {}", section.key(&port.name), problem.words);
        let add = |report: &mut FaultReport| {
            if problem.unavailable {
                report.concern(&span, message);
            } else {
                report.fault(&span, message);
            }
        };
        let is_of = |given: &&Override| {
            let is_named = given.variable == port.name || Some(&*given.variable) == former_name;
            given.schema == inspection.name && is_named
        };
        match overrides.iter().rfind(is_of) {
            Some(given) => report.in_option(given.to_string(), add),
            None => add(report),
        }
    }
    absent
}

impl<'q> Inspection<'q> {
    /// Returns the key of an entry of a list, and the name of the list, if the port is one of a list.
    fn entry<'s>(&self, schema: &'s Schema, port: u32) -> Option<(&'q str, &'s str)> {
        let own = schema.ports.len() - self.listed.len();
        let listed = self.listed.get((port as usize).checked_sub(own)?)?;
        Some((&listed.label, &schema.lists.get(listed.list)?.name))
    }

    /// Returns the value of a modulation, and whether the application sets it.
    #[must_use]
    pub fn value(&self, port: u32) -> Option<(&'q [u8], bool)> {
        match self.bindings.get(port as usize)? {
            Binding::Modulation { initial, set, .. } => Some((initial, *set)),
            _ => None,
        }
    }
    /// Whether the port is an import without a source.
    #[must_use]
    pub fn is_unbound_import(&self, port: u32) -> bool {
        let binding = self.bindings.get(port as usize);
        matches!(binding, Some(Binding::Import { source: None, .. }))
    }
}
