//! A plugin's description as data for programs: the object that `jde describe --json` prints.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jde_abi::describe::{ATTRIBUTES, Child, Plugin, Port, Role, Schema, Validity};
use jde_abi::raw;
use jde_link::value::to_json;
use serde::Serialize;

use super::value;

/// A plugin.
#[derive(Serialize)]
pub(crate) struct PluginData {
    name: String,
    version: String,
    doc: String,
    abi: String,
    path: Option<PathBuf>,
    schemas: Vec<SchemaData>,
}

#[derive(Serialize)]
struct SchemaData {
    name: String,
    kind: String,
    doc: String,
    period_ns: u64,
    budget_ns: u64,
    arbitrates: bool,
    panel: bool,
    inspects: bool,
    /// The type of the commands that it judges, if it is a guard.
    #[serde(skip_serializing_if = "Option::is_none")]
    judges: Option<String>,
    ports: Vec<PortData>,
    children: Vec<ChildData>,
}

#[derive(Serialize)]
struct PortData {
    name: String,
    #[serde(flatten)]
    role: RoleData,
    #[serde(rename = "type")]
    value_type: String,
    unit: String,
    doc: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    former_name: Option<String>,
    /// Whether it has each attribute that a port of its role may have, and whether it is optional.
    #[serde(flatten)]
    attributes: BTreeMap<&'static str, bool>,
}

#[derive(Serialize)]
#[serde(tag = "role", rename_all = "kebab-case")]
enum RoleData {
    Import,
    Export {
        #[serde(skip_serializing_if = "Option::is_none")]
        validity_ns: Option<u64>,
        lasting: bool,
    },
    Modulation {
        default: serde_json::Value,
        min: Option<f64>,
        max: Option<f64>,
        #[serde(skip_serializing_if = "Vec::is_empty")]
        choices: Vec<String>,
    },
    Command {
        neutral: serde_json::Value,
        validity_ns: u64,
    },
    Actuator,
    ChildModulation {
        child: String,
    },
}

#[derive(Serialize)]
struct ChildData {
    role: String,
    kind: &'static str,
    group: String,
    doc: String,
    optional: bool,
    /// Whether any number of children may have this role, which the application names.
    many: bool,
}

impl PluginData {
    /// Converts a plugin's description. `path` is the plugin's file.
    pub(crate) fn new(plugin: &Plugin, path: Option<&Path>) -> Self {
        Self {
            name: plugin.name.clone(),
            version: plugin.version.clone(),
            doc: plugin.doc.clone(),
            abi: format!("{}.{}", plugin.abi.0, plugin.abi.1),
            path: path.map(Path::to_owned),
            schemas: plugin.schemas.iter().map(schema).collect(),
        }
    }
}

fn schema(schema: &Schema) -> SchemaData {
    SchemaData {
        name: schema.name.clone(),
        kind: schema.kind.to_string(),
        doc: schema.doc.clone(),
        period_ns: schema.period_ns,
        budget_ns: schema.budget_ns.unwrap_or(schema.period_ns),
        arbitrates: schema.arbitrates,
        panel: schema.panel,
        inspects: schema.inspects,
        judges: schema.guard.as_ref().map(|guard| guard.command.name.clone()),
        ports: schema.ports.iter().map(|it| port(schema, it)).collect(),
        children: schema.children.iter().map(child).collect(),
    }
}

fn port(schema: &Schema, port: &Port) -> PortData {
    let json = |bytes: &[u8]| to_json(&value::decode_plain(&port.value_type, bytes));
    PortData {
        name: port.name.clone(),
        role: match &port.role {
            Role::Import => RoleData::Import,
            Role::Export { validity } => RoleData::Export {
                validity_ns: match validity {
                    Validity::Periods | Validity::Lasting => None,
                    Validity::Time(ns) => Some(*ns),
                },
                lasting: *validity == Validity::Lasting,
            },
            Role::Modulation { default, limits } => RoleData::Modulation {
                default: json(default),
                min: limits.least,
                max: limits.greatest,
                choices: limits.choices.clone(),
            },
            Role::Command { neutral, validity_ns } => RoleData::Command {
                neutral: json(neutral),
                validity_ns: *validity_ns,
            },
            Role::Actuator => RoleData::Actuator,
            Role::ChildModulation { child } => RoleData::ChildModulation {
                child: schema.children[*child].name.clone(),
            },
        },
        value_type: port.value_type.name.clone(),
        unit: port.unit.clone(),
        doc: port.doc.clone(),
        former_name: port.former_name.clone(),
        attributes: ATTRIBUTES
            .iter()
            .filter(|attribute| {
                attribute.flag == raw::OPTIONAL || attribute.kinds.contains(&port.role.kind())
            })
            .map(|attribute| (attribute.name, port.has(attribute.flag)))
            .collect(),
    }
}

fn child(child: &Child) -> ChildData {
    ChildData {
        role: child.name.clone(),
        kind: if child.motor { "motor" } else { "perceptive" },
        group: child.group.clone(),
        doc: child.doc.clone(),
        optional: child.optional,
        many: child.many,
    }
}
