//! Initial values of modulations: the type's default, then the file's, then an option's.

use std::path::Path;

use jde_abi::describe::{Port, Role, Schema};
use jde_abi::read::RESERVED;
use jde_board::value::{Value, encode};
use jde_types::Value as _;

use super::document::{Node, Section, Text};
use super::drafts::{Drafts, Here};
use super::given::node;
use super::report::{Report, quote};
use super::settings::Settings;
use super::values::Target;
use super::{Binding, Override, time};

/// The one key that is reserved and yet may be given as an option.
const PERIOD: &str = "period";

/// Reads every key of a schema that is a modulation of its type, and reports the others that mean nothing.
pub(super) fn from_file(
    report: &mut Report,
    section: &Section,
    schema: &Schema,
    folder: &Path,
    bindings: &mut [Binding],
) {
    for (key, node) in section.entries().filter(|(key, _)| !RESERVED.contains(&key.text)) {
        match place(schema, key.text) {
            Some(port) => set(report, section, schema, port, node, folder, &mut bindings[port]),
            None => refuse(report, section, schema, &key),
        }
    }
}

/// Sets what an option says; spans mean nothing to the report then.
pub(super) fn from_option(
    report: &mut Report,
    given: &Override,
    here: &Here,
    folder: &Path,
    settings: &mut Settings,
    bindings: &mut [Binding],
) {
    let (section, schema) = (here.section(), here.schema);
    if given.variable == PERIOD {
        let node = node(&given.value, &f64::describe());
        settings.period_ns = time::period(report, &section.key(PERIOD), &node).unwrap_or(settings.period_ns);
        return;
    }
    let Some(port) = place(schema, &given.variable) else {
        let message = format!("{} has no modulation {}", section.what, quote(&given.variable));
        let known = modulations(schema).chain([PERIOD]);
        return report
            .fault(&(0..0), message)
            .suggest(&given.variable, "modulations", known);
    };
    let node = node(&given.value, &schema.ports[port].value_type);
    set(report, section, schema, port, &node, folder, &mut bindings[port]);
}

/// Reports options that name no schema of the application.
pub(super) fn refuse_strangers(report: &mut Report, drafts: &Drafts, overrides: &[Override]) {
    for given in overrides {
        if drafts.place(&given.schema).is_none() {
            report.in_option(given.to_string(), |report| {
                drafts.find(report, "the option", &given.schema, &(0..0));
            });
        }
    }
}

fn place(schema: &Schema, name: &str) -> Option<usize> {
    schema
        .ports
        .iter()
        .position(|port| port.name == name && matches!(port.role, Role::Modulation { .. }))
}

fn modulations(schema: &Schema) -> impl Iterator<Item = &str> {
    schema
        .ports
        .iter()
        .filter(|port| matches!(port.role, Role::Modulation { .. }))
        .map(|port| port.name.as_str())
}

fn refuse(report: &mut Report, section: &Section, schema: &Schema, key: &Text) {
    let message = format!("unknown key {} in {}", quote(key.text), section.what);
    let fault = report.fault(&key.span, message);
    let elsewhere = schema.ports.iter().find(|port| port.name == key.text);
    let table = elsewhere.and_then(|port| match port.role {
        Role::Import { .. } => Some("imports"),
        Role::Actuator => Some("actuators"),
        Role::Export | Role::Modulation { .. } | Role::Command { .. } | Role::ChildModulation { .. } => None,
    });
    let child = schema.children.iter().any(|child| child.name == key.text);
    if let Some(table) = table.or(child.then_some("children")) {
        fault.advise(format!("bind it in `{table}`"));
        return;
    }
    let known = RESERVED.iter().copied().chain(modulations(schema));
    fault.suggest(key.text, "keys", known);
}

fn set(
    report: &mut Report,
    section: &Section,
    schema: &Schema,
    port: usize,
    node: &Node,
    folder: &Path,
    binding: &mut Binding,
) {
    let (port, Binding::Modulation { initial }) = (&schema.ports[port], binding) else {
        return;
    };
    let target = Target {
        name: port.name.clone(),
        owner: &section.what,
        unit: &port.unit,
        folder,
    };
    let Some(value) = target.value(report, &port.value_type, node) else {
        return;
    };
    if let Some(message) = out_of_range(port, &value) {
        report.fault(&node.span(), format!("{} {message}", section.key(&port.name)));
        return;
    }
    if let Err(error) = encode(&port.value_type, &value, initial) {
        report.fault(&node.span(), format!("{}: {error}", section.key(&port.name)));
    }
}

/// Why a plain number is outside of what its port allows.
fn out_of_range(port: &Port, value: &Value) -> Option<String> {
    let Role::Modulation {
        range: (least, most), ..
    } = port.role
    else {
        return None;
    };
    port.value_type.as_number()?;
    let Value::Map(fields) = value else { return None };
    let number = match fields.first()?.1 {
        Value::Float(number) => number,
        Value::Int(number) => number as f64,
        Value::UInt(number) => number as f64,
        Value::Bool(_) | Value::Text(_) | Value::List(_) | Value::Map(_) => return None,
    };
    let unit = if port.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", port.unit)
    };
    let bound = match (least, most) {
        (Some(least), _) if number < least => format!("at least {least}{unit}"),
        (_, Some(most)) if number > most => format!("at most {most}{unit}"),
        _ => return None,
    };
    Some(format!("is {number}{unit}, and {bound} is allowed"))
}
