//! Lists of ports: tables of the file whose entries are imports, exports or commands of any type, each with settings. An
//! import has the type of the variable that it reads. The two others have the type of the first port that is bound to
//! them, or the one that the file states. Only completes the type of an instance; `wiring` binds the imports.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use jde_abi::describe::{Kind, ListKind, Port, PortList, Role, Schema, Type, Validity};
use jde_abi::lists::ListedPort;
use jde_abi::read::{ENTRY_KEYS, PERIOD};
use jde_board::value::encode;
use toml::de::{DeTable, DeValue};

use super::drafts::{Drafts, refuse_bad_name};
use super::interfaces::{Capacities, Types};
use super::values::ValueTarget;
use super::variable::{self, VariableKind};
use jde_document::section::{Node, Section, Text, expect, integer, report_wrong_shape, text};
use jde_document::{FaultReport, quote};

/// An entry of a list.
pub(super) struct Entry<'a> {
    /// Its key.
    pub(super) label: Text<'a>,
    node: &'a Node<'a>,
}

/// The types that the file may name, and its folder.
#[derive(Clone, Copy)]
pub(super) struct Sources<'s> {
    pub(super) types: Types<'s>,
    pub(super) folder: &'s Path,
}

/// The largest capacity that an entry states.
const MOST_ELEMENTS: usize = 1 << 26;

/// Gives every schema whose type has lists the ports that the file states. Imports come last: one of a list may read an
/// export of another list.
pub(super) fn state_ports(report: &mut FaultReport, drafts: &mut Drafts, sources: Sources<'_>) {
    for imports in [false, true] {
        for index in 0..drafts.list.len() {
            let Some(schema) = drafts.schema(index).map(Arc::clone) else {
                continue;
            };
            for (number, list) in schema.lists.iter().enumerate() {
                if (list.kind == ListKind::Imports) == imports {
                    state_list(report, drafts, index, (number, list), sources);
                }
            }
        }
    }
}

/// Returns the entries of a list, in the order of its ports.
pub(super) fn entries<'a>(section: &Section<'a>, list: &PortList) -> Vec<Entry<'a>> {
    let table = section.get(&list.name).and_then(|node| node.get_ref().as_table());
    let table = table.map(|table| Section::new("", 0..0, table));
    table.map_or_else(Vec::new, |table| {
        table
            .entries()
            .map(|(label, node)| Entry { label, node })
            .collect()
    })
}

fn state_list(
    report: &mut FaultReport,
    drafts: &mut Drafts,
    index: usize,
    (number, list): (usize, &PortList),
    sources: Sources<'_>,
) {
    let section = &drafts.list[index].section;
    let key = section.key(&list.name);
    if let Some(node) = section.get(&list.name) {
        expect(report, &key, "a table", node, node.get_ref().as_table());
    }
    for entry in entries(section, list) {
        let what = format!("{} in {key}", quote(entry.label.text));
        let found = entry.node.get_ref();
        if !found.is_str() && !found.is_table() {
            let example = match list.kind {
                ListKind::Imports => "from = \"SCHEMA.VARIABLE\"",
                ListKind::Exports { .. } | ListKind::Commands { .. } => "as = \"NAME\"",
            };
            let expected = format!("a text, or a table such as {{ {example} }}");
            report_wrong_shape(report, &what, &expected, entry.node);
            continue;
        }
        let port = match list.kind {
            ListKind::Imports => import(report, drafts, index, &list.name, (&what, &entry)),
            ListKind::Exports { validity } => {
                let port = variable(report, drafts, index, (&what, &entry), (EXPORT, sources.types));
                port.map(|port| Port {
                    role: Role::Export { validity },
                    ..port
                })
            }
            ListKind::Commands { validity_ns } => {
                let port = variable(report, drafts, index, (&what, &entry), (COMMAND, sources.types));
                port.map(|port| Port {
                    role: Role::Command {
                        neutral: vec![0; port.value_type.bytes],
                        validity_ns,
                        trigger: true,
                    },
                    ..port
                })
            }
        };
        let settings = settings(report, (&what, &key), list, &entry, sources.folder);
        if let (Some(port), Some(settings)) = (port, settings)
            && let Some(resolved) = &mut drafts.list[index].resolved
        {
            resolved.listed.push(ListedPort {
                list: number,
                label: entry.label.text.to_owned(),
                value_type: Arc::clone(&port.value_type),
                settings,
            });
            resolved.schema = Arc::new(resolved.schema.with_ports([port]));
        }
    }
}

/// Returns the settings of an entry: those of the list, with what the entry states.
fn settings(
    report: &mut FaultReport,
    (what, key): (&str, &str),
    list: &PortList,
    entry: &Entry,
    folder: &Path,
) -> Option<Vec<u8>> {
    let mut bytes = list.initial.clone();
    let Some(table) = entry.node.get_ref().as_table() else {
        return Some(bytes);
    };
    // A key of the other kind of list is no setting, so it is refused as one.
    let own = |key: &str| ENTRY_KEYS.contains(&key) && (list.kind == ListKind::Imports) == (key == "from");
    let stated = table.iter().filter(|(key, _)| !own(key.get_ref()));
    let stated: DeTable = stated.map(|(key, node)| (key.clone(), node.clone())).collect();
    let target = ValueTarget {
        name: entry.label.text.to_owned(),
        owner: key,
        unit: "",
        folder,
    };
    let value = target.by_name(report, &list.settings, &stated)?;
    match encode(&list.settings, &value, &mut bytes) {
        Ok(()) => Some(bytes),
        Err(error) => {
            report.fault(&entry.node.span(), format!("{what}: {error}"));
            None
        }
    }
}

/// Returns the import that an entry states. Its name is the key, with that of the list if another list has this key too.
fn import(
    report: &mut FaultReport,
    drafts: &Drafts,
    index: usize,
    list: &str,
    (what, entry): (&str, &Entry),
) -> Option<Port> {
    let draft = &drafts.list[index];
    let ports = &drafts.schema(index)?.ports;
    let (own, listed) = ports.split_at(ports.len() - drafts.listed(index).len());
    let has = |ports: &[Port], name: &str| {
        let mut imports = ports.iter().filter(|port| (EXPORT.is_port)(port));
        imports.any(|port| port.name == name)
    };
    let name = match has(listed, entry.label.text) {
        true => format!("{list}.{}", entry.label.text),
        false => entry.label.text.to_owned(),
    };
    if has(own, entry.label.text) || has(listed, &name) {
        let message = format!(
            "{what}: {} has an import {} already",
            draft.section.label,
            quote(&name)
        );
        report
            .fault(&entry.label.span, message)
            .advise("name it otherwise");
        return None;
    }
    let from = source(report, (what, entry))?;
    if from.text.contains(':') {
        let message = format!(
            "{what} is {}, and a list takes variables of this application",
            quote(from.text)
        );
        report.fault(&from.span, message);
        return None;
    }
    let (owner, port) = variable::find(report, drafts, what, &from, VariableKind::Readable, None)?;
    Some(Port {
        name,
        // A driver passes new values on at once (R12). It does not trigger itself.
        role: Role::Import {
            trigger: drafts.schema(index)?.kind == Kind::Driver && owner != index,
        },
        optional: true,
        ..drafts.schema(owner)?.ports[port].clone()
    })
}

/// Returns the variable that an import of a list names.
pub(super) fn source<'a>(report: &mut FaultReport, (what, entry): (&str, &Entry<'a>)) -> Option<Text<'a>> {
    let node = match entry.node.get_ref() {
        DeValue::Table(table) => table.get("from"),
        _ => Some(entry.node),
    };
    let Some(node) = node else {
        let fault = report.fault(&entry.label.span, format!("{what} has no `from`"));
        fault.advise("name the variable, as in from = \"pioneer.laser\"");
        return None;
    };
    text(report, what, node)
}

/// What the other schemas do with a variable of a list.
#[derive(Clone, Copy)]
struct Use {
    noun: &'static str,
    direction: &'static str,
    /// What a schema does that is bound to it, and the port by which.
    verb: &'static str,
    port: &'static str,
    /// The table of the file that binds that port.
    table: &'static str,
    example: &'static str,
    is_port: fn(&Port) -> bool,
}

const EXPORT: Use = Use {
    noun: "an export",
    direction: "From",
    verb: "imports",
    port: "an import",
    table: "imports",
    example: "as = \"map\"",
    is_port: |port| matches!(port.role, Role::Import { .. }),
};
const COMMAND: Use = Use {
    noun: "a command",
    direction: "To",
    verb: "commands",
    port: "an actuator",
    table: "actuators",
    example: "as = \"dock\"",
    is_port: |port| matches!(port.role, Role::Actuator),
};

/// Returns the export that an entry states, or what a command has in common with one.
fn variable(
    report: &mut FaultReport,
    drafts: &Drafts,
    index: usize,
    (what, entry): (&str, &Entry),
    (usage, types): (Use, Types<'_>),
) -> Option<Port> {
    let draft = &drafts.list[index];
    let stated = |report: &mut FaultReport, key: &str| {
        let node = entry.node.get_ref().as_table()?.get(key)?;
        text(report, &format!("`{key}` of {what}"), node)
    };
    let name = match entry.node.get_ref() {
        DeValue::String(_) => text(report, what, entry.node)?,
        _ => match stated(report, "as") {
            Some(name) => name,
            None => {
                let fault = report.fault(&entry.label.span, format!("{what} has no `as`"));
                fault.advise(format!("name it, as in {}", usage.example));
                return None;
            }
        },
    };
    if !refuse_bad_name(report, &name, usage.noun) {
        return None;
    }
    let mut known = drafts.schema(index)?.ports.iter();
    if name.text == PERIOD
        || known.any(|port| port.name == name.text && !matches!(port.role, Role::Import { .. }))
    {
        let message = format!(
            "{what}: {} has a variable {} already",
            draft.section.label,
            quote(name.text)
        );
        report.fault(&name.span, message).advise("name it otherwise");
        return None;
    }
    let type_name = stated(report, "type");
    let full = format!("{}.{}", draft.name, name.text);
    let capacities = capacities(report, (what, entry))?;
    let stated = (type_name, &name.span);
    let value_type = value_type(report, drafts, (what, &full), stated, (usage, types, capacities))?;
    Some(Port {
        name: name.text.to_owned(),
        doc: format!("{} `{}`.", usage.direction, entry.label.text),
        unit: String::new(),
        value_type,
        role: Role::Export {
            validity: Validity::default(),
        },
        optional: false,
    })
}

/// Returns the type of a variable: that of a port which is bound to it, otherwise the one of the stated name.
fn value_type(
    report: &mut FaultReport,
    drafts: &Drafts,
    (what, variable): (&str, &str),
    (stated, span): (Option<Text>, &Range<usize>),
    (usage, types, capacities): (Use, Types<'_>, Capacities),
) -> Option<Arc<Type>> {
    if let Some(value_type) = bound_type(drafts, variable, usage)
        .filter(|found| stated.as_ref().is_none_or(|stated| stated.text == found.name))
    {
        if let Err(error) = capacities.refuse_all("the port that is bound to it") {
            report.fault(span, format!("{what}: {error}"));
        }
        return Some(value_type);
    }
    let Some(stated) = stated else {
        report
            .fault(
                span,
                format!(
                    "{what}: no schema {} {}, so its type is not known",
                    usage.verb,
                    quote(variable)
                ),
            )
            .advise(format!(
                "state it, as in type = \"sensor_msgs/msg/LaserScan\", or bind {} to it",
                usage.port
            ));
        return None;
    };
    match types.find(stated.text, &capacities) {
        Ok(Some(found)) => return Some(found),
        Ok(None) => {
            let message = format!("{what}: nothing defines the type {}", quote(stated.text));
            let standard = jde_types::standard();
            let known = standard.iter().map(|ty| ty.name.as_str());
            let fault = report.fault(&stated.span, message);
            fault.advise("name the folder of its definition, as in interfaces = [\"msgs\"], or source ROS 2");
            fault.suggest(stated.text, "standard types", known);
        }
        Err(error) => {
            let message = format!("{what}: the type {} cannot be used: {error}", quote(stated.text));
            report.fault(&stated.span, message);
        }
    }
    None
}

/// Reads `capacity` of an entry: a number, or a table of fields with a number each.
fn capacities(report: &mut FaultReport, (what, entry): (&str, &Entry)) -> Option<Capacities> {
    let stated = entry
        .node
        .get_ref()
        .as_table()
        .and_then(|table| table.get("capacity"));
    let Some(node) = stated else {
        return Some(Capacities::Some(Vec::new()));
    };
    let what = format!("`capacity` of {what}");
    let number = |report: &mut FaultReport, node: &Node| {
        let stated = expect(report, &what, "a whole number", node, integer(node.get_ref()))?;
        let number = usize::try_from(stated).ok();
        let number = number.filter(|number| (1..=MOST_ELEMENTS).contains(number));
        if number.is_none() {
            let message = format!("{what} must be 1 to {MOST_ELEMENTS}, not {stated}");
            report.fault(&node.span(), message);
        }
        number
    };
    let Some(table) = node.get_ref().as_table() else {
        return number(report, node).map(Capacities::All);
    };
    let fields = table
        .iter()
        .map(|(field, node)| Some((field.get_ref().to_string(), number(report, node)?)));
    fields.collect::<Option<_>>().map(Capacities::Some)
}

/// Returns the type of the first port that is bound to a variable.
fn bound_type(drafts: &Drafts, variable: &str, usage: Use) -> Option<Arc<Type>> {
    (0..drafts.list.len()).find_map(|index| {
        let table = drafts.list[index]
            .section
            .get(usage.table)?
            .get_ref()
            .as_table()?;
        let table = Section::new("", 0..0, table);
        let mut entries = table.entries();
        let (role, _) = entries.find(|(_, node)| {
            let from = match node.get_ref() {
                DeValue::Table(table) => table.get("from").and_then(|node| node.get_ref().as_str()),
                other => other.as_str(),
            };
            from == Some(variable)
        })?;
        port_type(drafts.schema(index)?, role.text, usage)
    })
}

fn port_type(schema: &Schema, role: &str, usage: Use) -> Option<Arc<Type>> {
    let is_role = |port: &&Port| port.name == role && (usage.is_port)(port);
    schema
        .ports
        .iter()
        .find(is_role)
        .map(|port| Arc::clone(&port.value_type))
}
