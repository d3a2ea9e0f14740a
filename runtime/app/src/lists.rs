//! Lists of ports: tables of the file whose entries are imports, exports or commands of any type, each with settings. An
//! import has the type of the variable that it reads. The two others have the type of the first port that is bound to
//! them, or the one that the file states. Only completes the type of an instance; `wiring` binds the imports.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use jde_abi::describe::{Attributes, Kind, ListKind, Port, PortList, Role, Schema, Type, Validity};
use jde_abi::lists::ListedPort;
use jde_abi::raw;
use jde_abi::read::{ENTRY_KEYS, PERIOD};
use jde_board::value::encode;
use jde_core::SchemaId;
use toml::de::{DeTable, DeValue};

use super::drafts::{Drafts, refuse_bad_name};
use super::interfaces::{Capacities, Types};
use super::values::ValueTarget;
use super::variable::{self, VariableKind};
use jde_document::section::{Node, Section, Text, expect, integer, report_wrong_shape, text};
use jde_document::{FaultReport, quote};

/// An entry of a list.
pub(super) struct ListEntry<'a> {
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

/// The most entries of the lists of one schema: more topics than a robot has.
const MAX_PORTS: usize = 4096;

/// The largest capacity that an entry states.
const MOST_ELEMENTS: usize = 1 << 26;

/// Gives every schema whose type has lists the ports that the file states. Imports come last: one of a list may read an
/// export of another list.
pub(super) fn state_ports(report: &mut FaultReport, drafts: &mut Drafts, sources: Sources<'_>) {
    let bound = [EXPORT, COMMAND].map(|usage| Bound::of(drafts, usage));
    for imports in [false, true] {
        for id in drafts.list.ids() {
            let Some(schema) = drafts.schema(id).map(Arc::clone) else {
                continue;
            };
            for (number, list) in schema.lists.iter().enumerate() {
                if (list.kind == ListKind::Imports) == imports {
                    state_list(report, drafts, id, (number, list), (sources, &bound));
                }
            }
        }
    }
}

/// Returns the entries of a list, in the order of its ports.
pub(super) fn entries<'a>(section: &Section<'a>, list: &PortList) -> Vec<ListEntry<'a>> {
    let table = section.get(&list.name).and_then(|node| node.get_ref().as_table());
    let table = table.map(|table| Section::new("", 0..0, table));
    table.map_or_else(Vec::new, |table| {
        table
            .entries()
            .map(|(label, node)| ListEntry { label, node })
            .collect()
    })
}

fn state_list(
    report: &mut FaultReport,
    drafts: &mut Drafts,
    id: SchemaId,
    (number, list): (usize, &PortList),
    (sources, [exports, commands]): (Sources<'_>, &[Bound; 2]),
) {
    let section = &drafts.list[id].section;
    let key = section.key(&list.name);
    if let Some(node) = section.get(&list.name) {
        expect(report, &key, "a table", node, node.get_ref().as_table());
    }
    let entries = entries(section, list);
    let mut known = Known::of(drafts, id);
    if known.listed + entries.len() > MAX_PORTS {
        let message = format!(
            "the lists of {} have more than {MAX_PORTS} entries",
            section.label
        );
        report.fault(&section.key_span(&list.name), message);
        return;
    }
    let (mut ports, mut listed) = (Vec::new(), Vec::new());
    for entry in entries {
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
            ListKind::Imports => import(report, drafts, id, (&list.name, &known), (&what, &entry)),
            ListKind::Exports { validity } => {
                let port = variable(
                    report,
                    drafts,
                    (id, &known),
                    (&what, &entry),
                    (exports, sources.types),
                );
                port.map(|port| Port {
                    role: Role::Export { validity },
                    ..port
                })
            }
            ListKind::Commands { validity_ns } => {
                let port = variable(
                    report,
                    drafts,
                    (id, &known),
                    (&what, &entry),
                    (commands, sources.types),
                );
                port.map(|port| Port {
                    role: Role::Command {
                        neutral: vec![0; port.value_type.bytes],
                        validity_ns,
                    },
                    attributes: Attributes::of(raw::COMMAND, raw::TRIGGER),
                    ..port
                })
            }
        };
        let settings = settings(report, (&what, &key), list, &entry, sources.folder);
        if let (Some(port), Some(settings)) = (port, settings) {
            listed.push(ListedPort {
                list: number,
                label: entry.label.text.to_owned(),
                value_type: Arc::clone(&port.value_type),
                settings,
            });
            known.add(&port, true);
            ports.push(port);
        }
    }
    if let Some(resolved) = &mut drafts.list[id].resolved {
        resolved.listed.extend(listed);
        resolved.schema = Arc::new(resolved.schema.with_ports(ports));
    }
}

/// The names of an instance's ports, those of its lists among them.
#[derive(Default)]
struct Known {
    imports: HashSet<String>,
    listed_imports: HashSet<String>,
    variables: HashSet<String>,
    listed: usize,
}

impl Known {
    fn of(drafts: &Drafts, id: SchemaId) -> Self {
        let mut known = Self::default();
        let ports = drafts.schema(id).map_or(&[][..], |schema| &schema.ports);
        let own = ports.len() - drafts.listed(id).len();
        for (place, port) in ports.iter().enumerate() {
            known.add(port, place >= own);
        }
        known
    }

    fn add(&mut self, port: &Port, is_listed: bool) {
        let names = match (matches!(port.role, Role::Import), is_listed) {
            (false, _) => &mut self.variables,
            (true, false) => &mut self.imports,
            (true, true) => &mut self.listed_imports,
        };
        names.insert(port.name.clone());
        self.listed += usize::from(is_listed);
    }
}

/// Returns the settings of an entry: those of the list, with what the entry states.
fn settings(
    report: &mut FaultReport,
    (what, key): (&str, &str),
    list: &PortList,
    entry: &ListEntry,
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
    id: SchemaId,
    (list, known): (&str, &Known),
    (what, entry): (&str, &ListEntry),
) -> Option<Port> {
    let draft = &drafts.list[id];
    let name = match known.listed_imports.contains(entry.label.text) {
        true => format!("{list}.{}", entry.label.text),
        false => entry.label.text.to_owned(),
    };
    if known.imports.contains(entry.label.text) || known.listed_imports.contains(&name) {
        let message = format!(
            "{what}: {} has an import {} already",
            draft.section.label,
            quote(&name)
        );
        report
            .fault(&entry.label.span, message)
            .advise("give it another name");
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
    let source = variable::find(report, drafts, what, &from, VariableKind::Readable, None)?;
    // A driver passes new values on at once (R12). It does not trigger itself.
    let is_trigger = drafts.schema(id)?.kind == Kind::Driver && source.instance != id;
    let trigger = if is_trigger { raw::TRIGGER } else { 0 };
    Some(Port {
        name,
        role: Role::Import,
        attributes: Attributes::of(raw::IMPORT, raw::OPTIONAL | trigger),
        former_name: None,
        ..drafts.schema(source.instance)?.ports[source.port].clone()
    })
}

/// Returns the variable that an import of a list names.
pub(super) fn source<'a>(
    report: &mut FaultReport,
    (what, entry): (&str, &ListEntry<'a>),
) -> Option<Text<'a>> {
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
    is_port: |port| matches!(port.role, Role::Import),
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
    (id, known): (SchemaId, &Known),
    (what, entry): (&str, &ListEntry),
    (bound, types): (&Bound, Types<'_>),
) -> Option<Port> {
    let usage = bound.usage;
    let draft = &drafts.list[id];
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
    if name.text == PERIOD || known.variables.contains(name.text) {
        let message = format!(
            "{what}: {} has a variable {} already",
            draft.section.label,
            quote(name.text)
        );
        report.fault(&name.span, message).advise("give it another name");
        return None;
    }
    let type_name = stated(report, "type");
    let full = format!("{}.{}", draft.name, name.text);
    let capacities = capacities(report, (what, entry))?;
    let stated = (type_name, &name.span);
    let value_type = value_type(report, drafts, (what, &full), stated, (bound, types, capacities))?;
    Some(Port {
        name: name.text.to_owned(),
        doc: format!("{} `{}`.", usage.direction, entry.label.text),
        unit: String::new(),
        value_type,
        role: Role::Export {
            validity: Validity::default(),
        },
        attributes: Attributes::default(),
        former_name: None,
    })
}

/// Returns the type of a variable: that of a port which is bound to it, otherwise the one of the stated name.
fn value_type(
    report: &mut FaultReport,
    drafts: &Drafts,
    (what, variable): (&str, &str),
    (stated, span): (Option<Text>, &Range<usize>),
    (bound, types, capacities): (&Bound, Types<'_>, Capacities),
) -> Option<Arc<Type>> {
    let usage = bound.usage;
    if let Some(value_type) = bound
        .value_type(drafts, variable)
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
fn capacities(report: &mut FaultReport, (what, entry): (&str, &ListEntry)) -> Option<Capacities> {
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

/// What the file binds to each variable: instances, and the names of their ports.
struct Bound {
    usage: Use,
    ports: HashMap<String, Vec<(SchemaId, String)>>,
}

impl Bound {
    fn of(drafts: &Drafts, usage: Use) -> Self {
        let mut ports: HashMap<String, Vec<(SchemaId, String)>> = HashMap::new();
        for (id, draft) in drafts.list.entries() {
            let table = draft.section.get(usage.table);
            let table = table.and_then(|node| node.get_ref().as_table());
            for (role, node) in table.into_iter().flat_map(DeTable::iter) {
                let from = match node.get_ref() {
                    DeValue::Table(table) => table.get("from").and_then(|node| node.get_ref().as_str()),
                    other => other.as_str(),
                };
                let Some(from) = from else { continue };
                let bound = ports.entry(from.to_owned()).or_default();
                // The first of each instance counts.
                if bound.last().is_none_or(|(last, _)| *last != id) {
                    bound.push((id, role.get_ref().to_string()));
                }
            }
        }
        Self { usage, ports }
    }

    /// Returns the type of the first port that is bound to a variable.
    fn value_type(&self, drafts: &Drafts, variable: &str) -> Option<Arc<Type>> {
        let mut ports = self.ports.get(variable)?.iter();
        ports.find_map(|(id, role)| port_type(drafts.schema(*id)?, role, self.usage))
    }
}

fn port_type(schema: &Schema, role: &str, usage: Use) -> Option<Arc<Type>> {
    let is_role = |port: &&Port| port.name == role && (usage.is_port)(port);
    schema
        .ports
        .iter()
        .find(is_role)
        .map(|port| Arc::clone(&port.value_type))
}
