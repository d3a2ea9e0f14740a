//! Finds the variable that a file names as `instance.variable`, and checks whether a port may be bound to it.
//! Binds nothing.

use std::ops::Range;
use std::sync::Arc;

use jde_abi::describe::{Port, Role};

use super::InstancePort;
use super::drafts::Drafts;
use jde_document::section::Text;
use jde_document::{FaultReport, quote, quote_all};

/// The requested kind of variable.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum VariableKind {
    /// An export or a modulation, to read.
    Readable,
    /// An export.
    Export,
    /// A command, to write.
    Command,
}

impl VariableKind {
    /// Whether a port of that role is of this kind.
    pub(super) fn admits(self, role: &Role) -> bool {
        match role {
            Role::Export { .. } => self != Self::Command,
            Role::Modulation { .. } => self == Self::Readable,
            Role::Command { .. } => self == Self::Command,
            Role::Import | Role::Actuator | Role::ChildModulation { .. } => false,
        }
    }

    /// Returns the kind that was most likely intended.
    fn likely(self) -> &'static str {
        match self {
            Self::Readable | Self::Export => "exports",
            Self::Command => "commands",
        }
    }

    fn plural(self) -> &'static str {
        match self {
            Self::Readable => "exports and modulations",
            Self::Export => "exports",
            Self::Command => "commands",
        }
    }
}

/// Finds `instance.variable`; reports its faults, except for an instance whose own type is unknown. `reader`
/// is the port that reads it, if there is one.
pub(super) fn find(
    report: &mut FaultReport,
    drafts: &Drafts,
    what: &str,
    written: &Text,
    kind: VariableKind,
    reader: Option<&Port>,
) -> Option<InstancePort> {
    let (instance, name) = match written.text.split_once('.') {
        Some((instance, name)) => (instance, Some(name)),
        None => (written.text, None),
    };
    let id = drafts.find(report, what, instance, &written.span)?;
    let schema = Arc::clone(drafts.schema(id)?);
    let admitted = || schema.ports.iter().filter(|port| kind.admits(&port.role));
    let names = || admitted().map(|port| port.name.as_str());
    let owner = quote(instance);
    let Some(name) = name else {
        let fault = report.fault(
            &written.span,
            format!("{what} names {owner}, and no variable of it"),
        );
        let fitting = |port: &&Port| reader.is_none_or(|reader| reader.value_type.same_as(&port.value_type));
        match admitted().find(fitting) {
            Some(port) => fault.advise(format!("write \"{instance}.{}\"", port.name)),
            None => fault.advise(format!("{} of {owner}: {}", kind.plural(), quote_all(names()))),
        };
        return None;
    };
    // Only ports of the requested kind: an export and an import may have the same name.
    let place = schema
        .ports
        .iter()
        .position(|port| port.name == name && kind.admits(&port.role));
    if let Some(port) = place {
        return Some(InstancePort { instance: id, port });
    }
    match schema.ports.iter().find(|port| port.name == name) {
        Some(port) => {
            let message = format!(
                "{what} is {}, which is {}",
                quote(written.text),
                role_noun(&port.role)
            );
            let fault = report.fault(&written.span, message);
            // Modulations can be read too, but are rarely intended.
            let likely = admitted().filter(|port| !matches!(port.role, Role::Modulation { .. }));
            let likely = quote_all(likely.map(|port| port.name.as_str()));
            fault.advise(format!("{} of {owner}: {likely}", kind.likely()));
        }
        None => report
            .fault(&written.span, format!("{what}: {owner} has no {}", quote(name)))
            .suggest(name, &format!("{} of {owner}", kind.plural()), names()),
    }
    None
}

/// Whether `port` may be bound to a variable: both have the same type and, for plain numbers, the same unit.
/// Reports a difference; `help` returns the advice.
pub(super) fn can_bind(
    report: &mut FaultReport,
    drafts: &Drafts,
    what: &str,
    port: &Port,
    InstancePort {
        instance,
        port: number,
    }: InstancePort,
    span: &Range<usize>,
    help: impl FnOnce() -> Option<String>,
) -> bool {
    let Some(schema) = drafts.schema(instance) else {
        return false;
    };
    let other = &schema.ports[number];
    let full = quote(&format!("{}.{}", drafts.list[instance].name, other.name));
    if !port.value_type.same_as(&other.value_type) {
        let (takes, has) = (quote(&port.value_type.name), quote(&other.value_type.name));
        if takes == has {
            let difference = port.value_type.difference(&other.value_type).unwrap_or_default();
            let message = format!("{what}: {full} is {takes} too, but of another layout: {difference}");
            report
                .fault(span, message)
                .advise("build both plugins with the same definition of the type, from a crate or a header that both use");
        } else {
            let fault = report.fault(span, format!("{what} is {takes}, and {full} is {has}"));
            fault.suggest_by(help);
        }
        return false;
    }
    let Some((takes, has)) = unit_conflict(port, other) else {
        return true;
    };
    let has = if has.is_empty() {
        "has no unit".to_owned()
    } else {
        format!("is in {}", quote(has))
    };
    let fault = report.fault(span, format!("{what} is in {}, and {full} {has}", quote(takes)));
    fault.suggest_by(help);
    false
}

/// Whether `port` may be bound to a variable `other` by type and unit.
pub(super) fn fits(port: &Port, other: &Port) -> bool {
    port.value_type.same_as(&other.value_type) && unit_conflict(port, other).is_none()
}

/// Returns the units of a port and a variable if they differ.
fn unit_conflict<'p>(port: &'p Port, other: &'p Port) -> Option<(&'p str, &'p str)> {
    let (takes, has) = (unit(port)?, unit(other)?);
    // A port without a unit accepts any: a plotter, a filter.
    (!takes.is_empty() && !jde_abi::unit::same(takes, has)).then_some((takes, has))
}

/// Returns the unit of a plain number: the port's own, or that of the only field of its type.
pub(super) fn unit(port: &Port) -> Option<&str> {
    port.value_type.as_number()?;
    Some(match port.unit.as_str() {
        "" => &port.value_type.fields[0].unit,
        unit => unit,
    })
}

fn role_noun(role: &Role) -> &'static str {
    match role {
        Role::Import => "an import",
        Role::Export { .. } => "an export",
        Role::Modulation { .. } => "a modulation",
        Role::Command { .. } => "a command",
        Role::Actuator => "an actuator",
        Role::ChildModulation { .. } => "a modulation of a child",
    }
}
