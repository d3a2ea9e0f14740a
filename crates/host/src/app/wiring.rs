//! Binds the imports and actuators of an instance to variables of others, and chooses its triggers.

use jde_abi::describe::{Kind, Port, Role, Schema};

use super::Binding;
use super::children::noun;
use super::document::Text;
use super::drafts::{Drafts, Here};
use super::report::{Report, quote};
use super::variable::{self, Wanted};

/// The type of the variable that says when an application is done.
const MISSION: &str = "jde_msgs/msg/Mission";

/// A port, and the variable found for it.
type Bound = (usize, Option<(usize, usize)>);

/// Every port as its type has it: modulations at their defaults, everything else unbound.
pub(super) fn unbound(schema: &Schema) -> Vec<Binding> {
    schema
        .ports
        .iter()
        .map(|port| match &port.role {
            Role::Import { trigger } => Binding::Import {
                source: None,
                trigger: *trigger,
            },
            Role::Export => Binding::Export,
            Role::Modulation { default, .. } => Binding::Modulation {
                initial: default.clone(),
            },
            Role::Command { .. } => Binding::Command,
            Role::Actuator => Binding::Actuator { target: None },
            Role::ChildModulation { .. } => Binding::ChildModulation { target: None },
        })
        .collect()
}

/// Reads `imports`.
pub(super) fn imports(report: &mut Report, here: &Here, bindings: &mut [Binding]) {
    for (port, found) in bind(report, here, "imports", is_import, Wanted::Readable) {
        if let Binding::Import { source, .. } = &mut bindings[port] {
            *source = found;
        }
    }
}

/// Reads `actuators`.
pub(super) fn actuators(report: &mut Report, here: &Here, bindings: &mut [Binding]) {
    for (port, found) in bind(report, here, "actuators", is_actuator, Wanted::Command) {
        if let Binding::Actuator { target } = &mut bindings[port] {
            *target = found;
        }
    }
}

/// Reads `triggers`; without the key, each import is as the type says.
pub(super) fn triggers(report: &mut Report, here: &Here, bindings: &mut [Binding]) {
    let section = here.section();
    let Some(names) = section.texts(report, "triggers") else {
        return;
    };
    for binding in bindings.iter_mut() {
        if let Binding::Import { trigger, .. } = binding {
            *trigger = false;
        }
    }
    if let (Some(first), kind @ (Kind::Perceptive | Kind::Driver)) = (names.first(), here.schema.kind) {
        let message = format!(
            "{} is {}, which has no precondition to re-evaluate",
            section.what,
            noun(kind)
        );
        report
            .fault(&first.span, message)
            .advise("remove `triggers`, or give it a shorter `period`");
        return;
    }
    let what = section.key("triggers");
    for name in names {
        let Some(port) = position(here.schema, is_import, name.text) else {
            let imports = here.schema.ports.iter().filter(|port| is_import(port));
            report
                .fault(
                    &name.span,
                    format!("{what} names {}, which is no import of it", quote(name.text)),
                )
                .suggest(name.text, "imports", imports.map(|port| port.name.as_str()));
            continue;
        };
        if here.schema.ports[port].optional && !section.is_given("imports", name.text) {
            report
                .fault(
                    &name.span,
                    format!("{what} names {}, which is not bound", quote(name.text)),
                )
                .advise("bind it in `imports`, or remove it here");
        }
        if let Binding::Import { trigger, .. } = &mut bindings[port] {
            *trigger = true;
        }
    }
}

/// Finds the variable that says when the application is done.
pub(super) fn mission(report: &mut Report, drafts: &Drafts, written: &Text) -> Option<(usize, usize)> {
    let what = "`mission` of the application";
    let (instance, port) = variable::find(report, drafts, what, written, Wanted::Export, None)?;
    let found = &drafts.schema(instance)?.ports[port].value_type.name;
    if found == MISSION {
        return Some((instance, port));
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
        .advise("name the export that says whether the mission is done");
    None
}

/// Reads a table of roles and variables, and reports what does not fit and what is missing.
fn bind(
    report: &mut Report,
    here: &Here,
    key: &str,
    is_role: fn(&Port) -> bool,
    wanted: Wanted,
) -> Vec<Bound> {
    let what = here.section().key(key);
    let mut bound = Vec::new();
    for (role, written) in here.section().pairs(report, key) {
        let Some(port) = position(here.schema, is_role, role.text) else {
            let roles = here.schema.ports.iter().filter(|port| is_role(port));
            report
                .fault(&role.span, format!("{what}: there is no {}", quote(role.text)))
                .suggest(role.text, key, roles.map(|port| port.name.as_str()));
            continue;
        };
        let what = format!("{} in {what}", quote(role.text));
        let found = variable::find(
            report,
            here.drafts,
            &what,
            &written,
            wanted,
            Some(&here.schema.ports[port]),
        )
        .filter(|&found| {
            let port = &here.schema.ports[port];
            variable::fits(report, here.drafts, &what, port, found, &written.span)
        });
        bound.push((port, found));
    }
    for port in here
        .schema
        .ports
        .iter()
        .filter(|port| is_role(port) && !port.optional)
    {
        if !here.section().is_given(key, &port.name) {
            missing(report, here, key, port, wanted);
        }
    }
    bound
}

fn missing(report: &mut Report, here: &Here, key: &str, port: &Port, wanted: Wanted) {
    let section = here.section();
    let candidate = (0..here.drafts.len())
        .filter(|index| *index != here.index)
        .find_map(|index| {
            let other = here.drafts.schema(index)?.ports.iter().find(|other| {
                // A modulation may be read, but is hardly ever what is meant.
                wanted.admits(&other.role)
                    && !matches!(other.role, Role::Modulation { .. })
                    && port.value_type.same_as(&other.value_type)
            })?;
            Some(format!("{}.{}", here.drafts.get(index).name, other.name))
        });
    let message = format!(
        "{} leaves {} of its {key} unbound; it takes {}",
        section.what,
        quote(&port.name),
        quote(&port.value_type.name)
    );
    report
        .fault(&section.key_span(key), message)
        .advise(match candidate {
            Some(candidate) => format!("add {key}.{} = \"{candidate}\"", port.name),
            None => "no schema of the application has such a variable; add one that does".to_owned(),
        });
}

fn is_import(port: &Port) -> bool {
    matches!(port.role, Role::Import { .. })
}

fn is_actuator(port: &Port) -> bool {
    port.role == Role::Actuator
}

fn position(schema: &Schema, is_role: fn(&Port) -> bool, name: &str) -> Option<usize> {
    schema
        .ports
        .iter()
        .position(|port| port.name == name && is_role(port))
}
