//! Binds the imports and actuators of an instance to variables of other instances, and sets its triggers.
//! Children are bound in `children`.

use std::collections::HashMap;

use jde_abi::describe::{ListKind, Port, Role, Schema};
use jde_abi::raw;

use super::drafts::{Drafts, InstanceContext};
use super::lists;
use super::remote::{self, RemoteVariables};
use super::variable::{self, VariableKind};
use super::{Binding, ImportSource, InstancePort};
use jde_document::MAX_LISTED;
use jde_document::section::Text;
use jde_document::{FaultReport, quote, quote_all};

/// The type of the variable that states when an application is done.
const MISSION: &str = "jde_msgs/msg/Mission";

/// The advice where no variable fits a port.
const NO_CANDIDATE: &str = "no schema of the application has such a variable; add one that does";

/// A table of roles and variables: `imports` or `actuators`.
#[derive(Clone, Copy)]
struct RoleTable {
    key: &'static str,
    is_role: fn(&Port) -> bool,
    kind: VariableKind,
}

/// Returns the ports as the type defines them: modulations at their defaults, all others unbound.
pub(super) fn unbound(schema: &Schema) -> Vec<Binding> {
    schema
        .ports
        .iter()
        .map(|port| match &port.role {
            Role::Import => Binding::Import {
                source: None,
                trigger: port.has(raw::TRIGGER),
                stale_ns: None,
            },
            Role::Export { .. } => Binding::Export,
            Role::Modulation { default, .. } => Binding::Modulation {
                initial: default.clone(),
                stated: default.clone(),
                set: false,
            },
            Role::Command { .. } => Binding::Command,
            Role::Actuator => Binding::Actuator { target: None },
            Role::ChildModulation { .. } => Binding::ChildModulation { target: None },
        })
        .collect()
}

/// Reads `imports`.
pub(super) fn imports(
    report: &mut FaultReport,
    instance: &InstanceContext,
    remotes: &mut RemoteVariables,
    bindings: &mut [Binding],
) {
    let table = RoleTable {
        key: "imports",
        is_role: is_import,
        kind: VariableKind::Readable,
    };
    for entry in remote::entries(report, instance.section()) {
        let Some((port, what)) = table.port(report, instance, &entry.role) else {
            continue;
        };
        let found = if entry.is_remote() {
            let port = &instance.schema.ports[port];
            remotes
                .find(report, &what, &entry, port)
                .map(ImportSource::Remote)
        } else {
            let found = table.find(report, instance, &what, &entry.from, port);
            found.map(ImportSource::Local)
        };
        if let Binding::Import { source, stale_ns, .. } = &mut bindings[port] {
            (*source, *stale_ns) = (found, entry.local_stale());
        }
    }
    table.refuse_unbound(report, instance);
    listed_imports(report, instance, table, bindings);
}

/// Binds the imports of lists.
fn listed_imports(
    report: &mut FaultReport,
    instance: &InstanceContext,
    table: RoleTable,
    bindings: &mut [Binding],
) {
    let listed = instance.listed();
    let own = instance.schema.ports.len() - listed.len();
    let places = listed.iter().enumerate();
    let places: HashMap<_, _> = places
        .map(|(place, port)| ((port.list, port.label.as_str()), place))
        .collect();
    let lists = instance.schema.lists.iter().enumerate();
    for (number, list) in lists.filter(|(_, list)| list.kind == ListKind::Imports) {
        for entry in lists::entries(instance.section(), list) {
            let Some(place) = places.get(&(number, entry.label.text)) else {
                continue;
            };
            let what = format!(
                "{} in {}",
                quote(entry.label.text),
                instance.section().key(&list.name)
            );
            let Some(from) = lists::source(report, (&what, &entry)) else {
                continue;
            };
            let place = own + place;
            let found = table.find(report, instance, &what, &from, place);
            if let Binding::Import { source, .. } = &mut bindings[place] {
                *source = found.map(ImportSource::Local);
            }
        }
    }
}

/// Reads `actuators`.
pub(super) fn actuators(report: &mut FaultReport, instance: &InstanceContext, bindings: &mut [Binding]) {
    let table = RoleTable {
        key: "actuators",
        is_role: is_actuator,
        kind: VariableKind::Command,
    };
    for (role, written) in instance.section().pairs(report, table.key) {
        let Some((port, what)) = table.port(report, instance, &role) else {
            continue;
        };
        if written.text.contains(':') {
            let message = format!(
                "{what} is {}, and commands do not leave an application",
                quote(written.text)
            );
            report
                .fault(&written.span, message)
                .advise("let a schema of the other application command, and import what it is to do");
            continue;
        }
        let found = table.find(report, instance, &what, &written, port);
        if let Binding::Actuator { target } = &mut bindings[port] {
            *target = found;
        }
    }
    table.refuse_unbound(report, instance);
}

/// Reads `triggers`; without the key, each import triggers as the type states.
pub(super) fn triggers(report: &mut FaultReport, instance: &InstanceContext, bindings: &mut [Binding]) {
    let section = instance.section();
    let Some(names) = section.texts(report, "triggers") else {
        return;
    };
    for binding in bindings.iter_mut() {
        if let Binding::Import { trigger, .. } = binding {
            *trigger = false;
        }
    }
    let what = section.key("triggers");
    for name in names {
        let Some(port) = position(instance.schema, is_import, name.text) else {
            let imports = instance.schema.ports.iter().filter(|port| is_import(port));
            report
                .fault(
                    &name.span,
                    format!("{what} names {}, which is not an import of it", quote(name.text)),
                )
                .suggest(name.text, "imports", imports.map(|port| port.name.as_str()));
            continue;
        };
        if instance.schema.ports[port].has(raw::OPTIONAL) && !section.is_set("imports", name.text) {
            report
                .fault(
                    &name.span,
                    format!("{what} names {}, which is not bound", quote(name.text)),
                )
                .advise("bind it in `imports`, or remove it from `triggers`");
        }
        if let Binding::Import { trigger, .. } = &mut bindings[port] {
            *trigger = true;
        }
    }
}

/// Finds the variable that states when the application is done.
pub(super) fn mission(report: &mut FaultReport, drafts: &Drafts, written: &Text) -> Option<InstancePort> {
    let what = "`mission` of the application";
    let export = variable::find(report, drafts, what, written, VariableKind::Export, None)?;
    let found = &drafts.schema(export.instance)?.ports[export.port].value_type.name;
    if found == MISSION {
        return Some(export);
    }
    report
        .fault(
            &written.span,
            format!(
                "{what} takes {}, and {} is {}",
                quote(MISSION),
                quote(written.text),
                quote(found)
            ),
        )
        .advise("name the export that states whether the mission is done");
    None
}

impl RoleTable {
    /// Returns the port in that role, and the name of the entry in messages; reports a missing role.
    fn port(
        self,
        report: &mut FaultReport,
        instance: &InstanceContext,
        role: &Text,
    ) -> Option<(usize, String)> {
        let what = instance.section().key(self.key);
        let port = position(instance.schema, self.is_role, role.text);
        if port.is_none() {
            let roles = instance.schema.ports.iter().filter(|port| (self.is_role)(port));
            report
                .fault(&role.span, format!("{what}: there is no {}", quote(role.text)))
                .suggest(role.text, self.key, roles.map(|port| port.name.as_str()));
        }
        Some((port?, format!("{} in {what}", quote(role.text))))
    }

    /// Returns the variable of that name if it fits the port; reports what does not fit.
    fn find(
        self,
        report: &mut FaultReport,
        instance: &InstanceContext,
        what: &str,
        written: &Text,
        port: usize,
    ) -> Option<InstancePort> {
        let port = &instance.schema.ports[port];
        let found = variable::find(report, instance.drafts, what, written, self.kind, Some(port))?;
        let help = || Some(list_candidates(instance, port, self.kind));
        variable::can_bind(report, instance.drafts, what, port, found, &written.span, help).then_some(found)
    }

    /// Reports required ports that the table leaves unbound.
    fn refuse_unbound(self, report: &mut FaultReport, instance: &InstanceContext) {
        let ports = instance.schema.ports.iter();
        for port in ports.filter(|port| (self.is_role)(port) && !port.has(raw::OPTIONAL)) {
            if !instance.section().is_set(self.key, &port.name) {
                report_missing(report, instance, self.key, port, self.kind);
            }
        }
    }
}

fn report_missing(
    report: &mut FaultReport,
    instance: &InstanceContext,
    key: &str,
    port: &Port,
    kind: VariableKind,
) {
    let section = instance.section();
    let message = format!(
        "{} leaves {} of its {key} unbound; it takes {}",
        section.label,
        quote(&port.name),
        quote(&port.value_type.name)
    );
    report.fault(&section.key_span(key), message).suggest_by(|| {
        let candidate = candidates(instance, port, kind).next();
        let add = candidate.map(|candidate| format!("add {key}.{} = \"{candidate}\"", port.name));
        Some(add.unwrap_or_else(|| NO_CANDIDATE.to_owned()))
    });
}

/// Returns the variables of other schemas to which a port can be bound.
fn candidates<'c>(
    instance: &'c InstanceContext,
    port: &'c Port,
    kind: VariableKind,
) -> impl Iterator<Item = String> + 'c {
    let others = instance.drafts.list.ids().filter(|id| *id != instance.id);
    others
        .filter_map(|id| Some((instance.drafts.list[id].name, instance.drafts.schema(id)?)))
        .flat_map(move |(name, schema)| {
            let fitting = schema.ports.iter().filter(move |other| {
                // A modulation can be read, but is rarely intended.
                kind.admits(&other.role)
                    && !matches!(other.role, Role::Modulation { .. })
                    && variable::fits(port, other)
            });
            fitting.map(move |other| format!("{name}.{}", other.name))
        })
}

/// Lists the variables to which a port can be bound.
fn list_candidates(instance: &InstanceContext, port: &Port, kind: VariableKind) -> String {
    let fitting: Vec<_> = candidates(instance, port, kind).take(MAX_LISTED).collect();
    match fitting.as_slice() {
        [] => NO_CANDIDATE.to_owned(),
        fitting => format!("these fit: {}", quote_all(fitting.iter().map(String::as_str))),
    }
}

fn is_import(port: &Port) -> bool {
    matches!(port.role, Role::Import)
}

pub(super) fn is_modulation(port: &Port) -> bool {
    matches!(port.role, Role::Modulation { .. })
}

fn is_actuator(port: &Port) -> bool {
    port.role == Role::Actuator
}

pub(super) fn position(schema: &Schema, is_role: fn(&Port) -> bool, name: &str) -> Option<usize> {
    schema
        .ports
        .iter()
        .position(|port| port.name == name && is_role(port))
}
