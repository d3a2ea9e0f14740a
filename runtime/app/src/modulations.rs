//! Initial values of modulations: the type's default, overridden by the file, overridden by an option. Writes
//! no variable.

use jde_abi::describe::{Limits, Role, Schema};
use jde_abi::read::RESERVED;
use jde_board::value::{Value, encode};
use jde_types::Value as _;

use super::drafts::{Drafts, InstanceContext};
use super::literal::parse_node;
use super::settings::InstanceSettings;
use super::time;
use super::types::TYPE;
use super::values::{Paths, ValueTarget};
use super::wiring::is_modulation;
use super::{Binding, Override};
use jde_document::section::{Node, Section, Text, expect};
use jde_document::{FaultReport, quote};

/// The reserved key that an option may set, beside the type.
const PERIOD: &str = "period";

/// Reads every key of a schema that is a modulation of its type, and reports the unknown ones.
pub(super) fn from_file(
    report: &mut FaultReport,
    section: &Section,
    schema: &Schema,
    paths: Paths<'_>,
    is_replaced: impl Fn(usize) -> bool,
    bindings: &mut [Binding],
) {
    let is_list = |key: &str| schema.lists.iter().any(|list| list.name == key);
    let is_other = |key: &str| RESERVED.contains(&key) || is_list(key);
    for (key, node) in section.entries().filter(|(key, _)| !is_other(key.text)) {
        match schema.modulation_named(key.text) {
            Some(port) => {
                let name = &schema.ports[port].name;
                if key.text != name {
                    warn_of_former_name(report, &key.span, &section.key(key.text), name);
                    if section.get(name).is_some() {
                        let message = format!("{} is stated twice", section.key(name));
                        report
                            .fault(&key.span, message)
                            .advise("remove the key of the former name");
                        continue;
                    }
                }
                // Nobody reads the file of a value that an option replaces.
                let check_files = paths.check_files && !is_replaced(port);
                let paths = Paths { check_files, ..paths };
                set_initial(report, section, schema, port, node, paths, &mut bindings[port]);
                if let Binding::Modulation { initial, stated, .. } = &mut bindings[port] {
                    stated.clone_from(initial);
                }
            }
            None => refuse_unknown_key(report, section, schema, &key),
        }
    }
}

/// Sets the value of an option; spans have no meaning for the report then.
pub(super) fn from_option(
    report: &mut FaultReport,
    given: &Override,
    instance: &InstanceContext,
    paths: Paths<'_>,
    settings: &mut InstanceSettings,
    bindings: &mut [Binding],
) {
    let (section, schema) = (instance.section(), instance.schema);
    if given.variable == TYPE {
        return;
    }
    if given.variable == PERIOD {
        let Some(node) = parse_node(report, &given.value, &f64::describe()) else {
            return;
        };
        settings.period_ns = time::period(report, &section.key(PERIOD), &node).unwrap_or(settings.period_ns);
        return;
    }
    let Some(port) = schema.modulation_named(&given.variable) else {
        let message = format!("{} has no modulation {}", section.label, quote(&given.variable));
        let known = modulations(schema).chain([PERIOD, TYPE]);
        return report
            .fault(&(0..0), message)
            .suggest(&given.variable, "modulations", known);
    };
    let name = &schema.ports[port].name;
    if given.variable != *name {
        warn_of_former_name(report, &(0..0), &section.key(&given.variable), name);
    }
    let value = match &schema.ports[port].role {
        Role::Modulation { limits, .. } => choice_of(limits, &given.value),
        _ => None,
    };
    let value = value.unwrap_or(&given.value);
    if let Some(node) = parse_node(report, value, &schema.ports[port].value_type) {
        set_initial(report, section, schema, port, &node, paths, &mut bindings[port]);
    }
}

/// Reports options that name no schema of the application.
pub(super) fn refuse_unknown_schemas(report: &mut FaultReport, drafts: &Drafts, overrides: &[Override]) {
    for given in overrides {
        if drafts.id_of(&given.schema).is_none() {
            report.in_option(given.to_string(), |report| {
                drafts.find(report, "the option", &given.schema, &(0..0));
            });
        }
    }
}

/// Warns of a modulation that is given by the name which it had before.
pub fn warn_of_former_name(report: &mut FaultReport, span: &std::ops::Range<usize>, given: &str, name: &str) {
    report.concern(
        span,
        format!(
            "{given} is now called {}; the next version does not read the former name",
            quote(name)
        ),
    );
}

fn modulations(schema: &Schema) -> impl Iterator<Item = &str> {
    schema
        .ports
        .iter()
        .filter(|port| is_modulation(port))
        .map(|port| port.name.as_str())
}

fn refuse_unknown_key(report: &mut FaultReport, section: &Section, schema: &Schema, key: &Text) {
    let message = format!("unknown key {} in {}", quote(key.text), section.label);
    let fault = report.fault(&key.span, message);
    let elsewhere = schema.ports.iter().find(|port| port.name == key.text);
    let table = elsewhere.and_then(|port| match port.role {
        Role::Import => Some("imports"),
        Role::Actuator => Some("actuators"),
        Role::Export { .. }
        | Role::Modulation { .. }
        | Role::Command { .. }
        | Role::ChildModulation { .. } => None,
    });
    let child = schema.children.iter().any(|child| child.name == key.text);
    if let Some(table) = table.or(child.then_some("children")) {
        fault.advise(format!("bind it in `{table}`"));
        return;
    }
    let lists = schema.lists.iter().map(|list| list.name.as_str());
    let known = RESERVED.iter().copied().chain(modulations(schema)).chain(lists);
    fault.suggest(key.text, "keys", known);
}

fn set_initial(
    report: &mut FaultReport,
    section: &Section,
    schema: &Schema,
    port: usize,
    node: &Node,
    paths: Paths<'_>,
    binding: &mut Binding,
) {
    let (port, Binding::Modulation { initial, set, .. }) = (&schema.ports[port], binding) else {
        return;
    };
    *set = true;
    let target = ValueTarget {
        name: port.name.clone(),
        owner: &section.label,
        unit: &port.unit,
        folder: paths.folder,
    };
    let Role::Modulation { limits, .. } = &port.role else {
        return;
    };
    let value = if limits.choices.is_empty() {
        target.value(report, &port.value_type, node)
    } else {
        choice(report, section, &port.name, limits, node)
    };
    let Some(value) = value else { return };
    if let Some(path) = paths.missing_file(&port.unit, &value) {
        let wrong = match std::path::Path::new(path).exists() {
            true => "which is not a regular file",
            false => "and there is no such file",
        };
        let message = format!("{} is {}, {wrong}", section.key(&port.name), quote(path));
        report.fault(&node.span(), message).advise(format!(
            "put it there, or write another path, absolute or relative to {}",
            quote(&paths.folder.display().to_string())
        ));
    }
    let mut bytes = initial.clone();
    if let Err(error) = encode(&port.value_type, &value, &mut bytes) {
        report.fault(&node.span(), format!("{}: {error}", section.key(&port.name)));
    } else if let Err(not_allowed) = limits.check(&port.value_type, &bytes) {
        let message = format!("{} {}", section.key(&port.name), not_allowed.words(&port.unit));
        report.fault(&node.span(), message);
    } else {
        *initial = bytes;
    }
}

/// Returns the choice that a text states by its number, as parameters of ROS 2 do.
fn choice_of<'l>(limits: &'l Limits, text: &str) -> Option<&'l str> {
    let number: usize = text.parse().ok()?;
    limits.choices.get(number).map(String::as_str)
}

/// Reads one of the choices, by its name.
fn choice(
    report: &mut FaultReport,
    section: &Section,
    name: &str,
    limits: &Limits,
    node: &Node,
) -> Option<Value> {
    let choices = limits.choices.iter().map(String::as_str);
    let expected = format!("one of {}", limits.choices.join(", "));
    let chosen = expect(
        report,
        &section.key(name),
        &expected,
        node,
        node.get_ref().as_str(),
    )?;
    let Some(number) = limits.choice(chosen) else {
        report
            .fault(
                &node.span(),
                format!(
                    "{} is {}, which is not a choice",
                    section.key(name),
                    quote(chosen)
                ),
            )
            .suggest(chosen, "choices", choices);
        return None;
    };
    Some(Value::UInt(number as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_may_state_a_choice_by_its_number() {
        let limits = Limits {
            choices: ["wall", "follow"].map(str::to_owned).to_vec(),
            ..Limits::default()
        };
        assert_eq!(choice_of(&limits, "1"), Some("follow"));
        for other in ["2", "-1", "1.0", "wall", ""] {
            assert_eq!(choice_of(&limits, other), None, "{other}");
        }
        assert_eq!(choice_of(&Limits::default(), "0"), None);
    }
}
