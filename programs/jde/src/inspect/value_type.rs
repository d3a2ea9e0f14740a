//! Describes a type of value: its fields, and the ports of schemas that have it. As text or JSON.

use std::collections::BTreeMap;
use std::io::{self, Write};

use jde_abi::describe::{FieldKind, Type};
use jde_loader::DescribedPlugin;
use jde_terminal::{FAINT, TITLE};
use serde::Serialize;

use super::doc::join_lines;
use super::plugin::{PARTS, port_name, write_section};
use crate::failure::Failure;

/// A type of value.
#[derive(Serialize)]
pub(crate) struct ValueTypeData {
    name: String,
    doc: String,
    bytes: usize,
    fields: Vec<FieldData>,
    ports: Vec<PortData>,
}

/// A field, or a field of a field: `header.stamp.sec`.
#[derive(Serialize)]
struct FieldData {
    name: String,
    shape: String,
    unit: String,
    doc: String,
}

/// A port that has the type.
#[derive(Serialize)]
struct PortData {
    /// "imports", "exports" and so on.
    part: &'static str,
    schema: String,
    port: String,
    doc: String,
    /// In what the layout differs from the fields above.
    difference: Option<String>,
}

/// Returns the names of the standard types of value and of those in the plugins.
pub(crate) fn names(plugins: &[DescribedPlugin]) -> Vec<String> {
    let standard = jde_types::standard();
    types(plugins, &standard).into_keys().map(str::to_owned).collect()
}

impl ValueTypeData {
    /// Finds a type by its name, with its package or without.
    ///
    /// # Errors
    /// It is no standard type, and no plugin has it. The error has the nearest name.
    pub(crate) fn find(name: &str, plugins: &[DescribedPlugin]) -> Result<Self, Failure> {
        let standard = jde_types::standard();
        let types = types(plugins, &standard);
        let in_full = name.contains('/');
        let plain = |full| if in_full { full } else { without_package(full) };
        let found = types.iter().find(|(full, _)| plain(full) == name);
        let Some((_, value_type)) = found else {
            let known = types.keys().map(|full| plain(full));
            return Err(Failure::unknown("type of value", name, known));
        };
        let mut fields = Vec::new();
        push_fields("", value_type, &mut fields);
        Ok(Self {
            name: value_type.name.clone(),
            doc: value_type.doc.clone(),
            bytes: value_type.bytes,
            fields,
            ports: ports(value_type, plugins),
        })
    }

    /// Writes the description.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let Self { name, doc, bytes, .. } = self;
        writeln!(output, "{TITLE}{name}{TITLE:#}  {FAINT}{bytes} bytes{FAINT:#}")?;
        if !doc.is_empty() {
            writeln!(output, "{}", join_lines(doc))?;
        }
        let fields = self.fields.iter().map(|field| {
            let shape = format!("{} {}", field.shape, field.unit);
            [
                field.name.clone(),
                shape.trim_end().to_owned(),
                join_lines(&field.doc),
            ]
        });
        write_section("fields", fields.collect(), output)?;
        for (title, _) in PARTS {
            let ports = self.ports.iter().filter(|port| port.part == title);
            let rows = ports.map(|port| {
                let difference = port.difference.iter();
                let differs = difference.map(|what| format!(", of another layout: {what}"));
                [
                    port.schema.clone(),
                    port.port.clone() + &differs.collect::<String>(),
                    join_lines(&port.doc),
                ]
            });
            write_section(title, rows.collect(), output)?;
        }
        Ok(())
    }
}

/// Every type of the plugins' ports, and every type within these.
fn types<'a>(plugins: &'a [DescribedPlugin], standard: &'a [Type]) -> BTreeMap<&'a str, &'a Type> {
    let mut found = BTreeMap::new();
    let schemas = plugins.iter().flat_map(|plugin| &plugin.description.schemas);
    let mut pending: Vec<&Type> = schemas
        .flat_map(|schema| schema.ports.iter().map(|port| &*port.value_type))
        .chain(standard)
        .collect();
    while let Some(value_type) = pending.pop() {
        found.insert(&*value_type.name, value_type);
        pending.extend(value_type.fields.iter().filter_map(|field| match &field.kind {
            FieldKind::Struct(inner) => Some(&**inner),
            FieldKind::Scalar(_) => None,
        }));
    }
    found
}

fn push_fields(within: &str, value_type: &Type, fields: &mut Vec<FieldData>) {
    for field in &value_type.fields {
        let name = format!("{within}{}", field.name);
        fields.push(FieldData {
            name: name.clone(),
            shape: field.shape(),
            unit: field.unit.clone(),
            doc: field.doc.clone(),
        });
        if let FieldKind::Struct(inner) = &field.kind {
            push_fields(&format!("{name}."), inner, fields);
        }
    }
}

fn ports(value_type: &Type, plugins: &[DescribedPlugin]) -> Vec<PortData> {
    let mut ports = Vec::new();
    for plugin in plugins {
        let plugin = &plugin.description;
        for schema in &plugin.schemas {
            let of_type = schema
                .ports
                .iter()
                .filter(|port| port.value_type.name == value_type.name);
            ports.extend(of_type.filter_map(|port| {
                let (part, _) = PARTS.iter().find(|(_, is_part)| is_part(&port.role))?;
                Some(PortData {
                    part,
                    schema: format!("{}/{}", plugin.name, schema.name),
                    port: port_name(schema, port),
                    doc: port.doc.clone(),
                    difference: value_type.difference(&port.value_type),
                })
            }));
        }
    }
    ports
}

/// `LaserScan` of `sensor_msgs/msg/LaserScan`.
fn without_package(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}
