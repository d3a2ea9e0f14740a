//! A plugin's description as data for programs: the object that `jde describe --json` prints.

use std::path::{Path, PathBuf};

use jde_abi::describe::{Child, Plugin, Port, Role, Schema, Validity};
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
    optional: bool,
}

#[derive(Serialize)]
#[serde(tag = "role", rename_all = "kebab-case")]
enum RoleData {
    Import {
        trigger: bool,
    },
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
        fixed: bool,
    },
    Command {
        neutral: serde_json::Value,
        validity_ns: u64,
        trigger: bool,
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
            Role::Import { trigger } => RoleData::Import { trigger: *trigger },
            Role::Export { validity } => RoleData::Export {
                validity_ns: match validity {
                    Validity::Periods | Validity::Lasting => None,
                    Validity::Time(ns) => Some(*ns),
                },
                lasting: *validity == Validity::Lasting,
            },
            Role::Modulation {
                default,
                limits,
                fixed,
            } => RoleData::Modulation {
                default: json(default),
                min: limits.least,
                max: limits.greatest,
                choices: limits.choices.clone(),
                fixed: *fixed,
            },
            Role::Command {
                neutral,
                validity_ns,
                trigger,
            } => RoleData::Command {
                neutral: json(neutral),
                validity_ns: *validity_ns,
                trigger: *trigger,
            },
            Role::Actuator => RoleData::Actuator,
            Role::ChildModulation { child } => RoleData::ChildModulation {
                child: schema.children[*child].name.clone(),
            },
        },
        value_type: port.value_type.name.clone(),
        unit: port.unit.clone(),
        doc: port.doc.clone(),
        optional: port.optional,
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
