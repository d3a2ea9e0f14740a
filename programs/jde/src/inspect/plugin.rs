//! Describes a plugin as text.

use std::io::{self, Write};
use std::path::Path;

use jde_abi::describe::{ATTRIBUTES, ListKind, Plugin, Port, Role, Schema, Validity};
use jde_app::period::format_setting;
use jde_terminal::{FAINT, TITLE};

use super::doc::{self, join_lines};
use super::value::{format_value, short_type_name};
use crate::failure;
use crate::remote::table::{Cell, Table};

/// Whether a role belongs to a part.
pub(super) type RoleFilter = fn(&Role) -> bool;

/// The parts of a description, in the order of interest: each has the ports of some roles.
pub(super) const PARTS: [(&str, RoleFilter); 6] = [
    ("imports", |role| matches!(role, Role::Import)),
    ("exports", |role| matches!(role, Role::Export { .. })),
    ("modulations", |role| matches!(role, Role::Modulation { .. })),
    ("commands", |role| matches!(role, Role::Command { .. })),
    ("actuators", |role| matches!(role, Role::Actuator)),
    ("writes to children", |role| {
        matches!(role, Role::ChildModulation { .. })
    }),
];

/// Writes the description.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write(plugin: &Plugin, path: Option<&Path>, output: &mut dyn Write) -> io::Result<()> {
    let path = path.map_or_else(|| "linked in".to_owned(), failure::display_path);
    let (major, minor) = plugin.abi;
    writeln!(
        output,
        "{TITLE}{} {}{TITLE:#}  {FAINT}{path}, ABI {major}.{minor}{FAINT:#}",
        plugin.name, plugin.version
    )?;
    if !plugin.doc.is_empty() {
        doc::write(&plugin.doc, output)?;
    }
    plugin
        .schemas
        .iter()
        .try_for_each(|schema| write_schema(plugin, schema, output))
}

fn write_schema(plugin: &Plugin, schema: &Schema, output: &mut dyn Write) -> io::Result<()> {
    writeln!(output)?;
    writeln!(
        output,
        "{TITLE}{}/{}{TITLE:#}  {}, every {}, at most {} an iteration",
        plugin.name,
        schema.name,
        schema.kind,
        format_setting(schema.period_ns),
        format_setting(schema.budget_ns.unwrap_or(schema.period_ns))
    )?;
    if !schema.doc.is_empty() {
        doc::write(&schema.doc, output)?;
    }
    if schema.arbitrates {
        writeln!(output, "Arbitrates among its children itself.")?;
    }
    if schema.panel {
        writeln!(output, "Draws a panel of its own.")?;
    }
    for (title, belongs) in PARTS {
        let ports: Vec<_> = schema.ports.iter().filter(|port| belongs(&port.role)).collect();
        let rows = ports.iter().map(|port| {
            [
                port_name(schema, port),
                describe_port(port),
                join_lines(&port.doc),
            ]
        });
        write_section(title, rows.collect(), output)?;
    }
    let rows = schema.lists.iter().map(|list| {
        let settings = list.settings.fields.iter().map(|field| field.name.as_str());
        [
            list.name.clone(),
            format!(
                "{} of any type{}, settings: {}",
                list.kind,
                match list.kind {
                    ListKind::Commands { validity_ns } => {
                        format!(", in force for {}", format_setting(validity_ns))
                    }
                    _ => String::new(),
                },
                settings.collect::<Vec<_>>().join(", ")
            ),
            join_lines(&list.doc),
        ]
    });
    write_section("lists of ports", rows.collect(), output)?;
    let rows = schema.children.iter().map(|child| {
        let kind = if child.motor {
            format!("motor, group {}", child.group)
        } else {
            "perceptive".to_owned()
        };
        [
            child.name.clone(),
            kind + if child.many {
                ", any number, named by the application"
            } else {
                optional_suffix(child.optional)
            },
            join_lines(&child.doc),
        ]
    });
    write_section("children", rows.collect(), output)
}

pub(super) fn write_section(title: &str, rows: Vec<[String; 3]>, output: &mut dyn Write) -> io::Result<()> {
    if rows.is_empty() {
        return Ok(());
    }
    writeln!(output, "  {TITLE}{title}{TITLE:#}")?;
    let mut table = Table::untitled(3).indented(4);
    for [name, facts, doc] in rows {
        table.add_row([name.into(), facts.into(), Cell::from(doc).styled(FAINT)]);
    }
    table.write(output)
}

/// Returns a port's name. For a child's modulation, the child's name is prepended.
pub(super) fn port_name(schema: &Schema, port: &Port) -> String {
    match port.role {
        Role::ChildModulation { child } => format!("{}.{}", schema.children[child].name, port.name),
        _ => port.name.clone(),
    }
}

fn describe_port(port: &Port) -> String {
    let value_type = short_type_name(&port.value_type);
    let of_type = |bytes: &[u8]| format_value(&port.value_type, bytes, &port.unit);
    let facts = match &port.role {
        Role::Export { validity } => match validity {
            Validity::Periods => value_type.to_owned(),
            Validity::Time(ns) => format!("{value_type}, valid for {}", format_setting(*ns)),
            Validity::Lasting => format!("{value_type}, lasting"),
        },
        Role::Import | Role::Actuator | Role::ChildModulation { .. } => value_type.to_owned(),
        Role::Modulation { default, limits } => {
            let range = match (limits.least, limits.greatest) {
                (None, None) => String::new(),
                (Some(least), None) => format!(", at least {least}"),
                (None, Some(most)) => format!(", at most {most}"),
                (Some(least), Some(most)) => format!(", {least} to {most}"),
            };
            let number = port.value_type.number_of(default).unwrap_or_default();
            match limits.choices.get(number as usize) {
                Some(chosen) => format!("{chosen}, of {}", limits.choices.join(", ")),
                None => format!("{value_type} = {}{range}", of_type(default)),
            }
        }
        Role::Command { neutral, validity_ns } => {
            format!(
                "{value_type}, in force for {}, neutral {}",
                format_setting(*validity_ns),
                of_type(neutral)
            )
        }
    };
    let attributes = ATTRIBUTES.iter().filter(|attribute| port.has(attribute.flag));
    attributes.fold(facts, |facts, attribute| facts + ", " + attribute.words)
}

fn optional_suffix(optional: bool) -> &'static str {
    if optional { ", optional" } else { "" }
}
