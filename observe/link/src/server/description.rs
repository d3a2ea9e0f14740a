//! Describes an application to tools: schemas with their ports, groups and variables. Changes nothing.

use std::sync::Arc;

use jde_abi::describe::{Port, Role};
use jde_abi::raw;
use jde_app::{Application, Binding};
use jde_board::{Access, Variable};
use jde_core::{GroupId, SchemaId};

use super::subject::Subject;
use crate::message::{ChildInfo, GroupInfo, PortInfo, Range, SchemaInfo, Schemas, VariableInfo};
use crate::value::to_json;

/// The schemas and groups of an application.
#[must_use]
pub fn schemas(application: &Application) -> Schemas {
    let name = |instance: SchemaId| application.instances[instance].name.clone();
    let group = |group: GroupId| application.groups[group].name.clone();
    let schemas = application.instances.iter().map(|instance| {
        let roles = instance.schema.children.iter().zip(&instance.children);
        let ports = instance.schema.ports.iter().zip(&instance.bindings);
        SchemaInfo {
            name: instance.name.clone(),
            type_name: format!(
                "{}/{}",
                application.plugins[instance.plugin].name, instance.schema.name
            ),
            kind: instance.schema.kind.to_string(),
            doc: if instance.doc.is_empty() {
                instance.schema.doc.clone()
            } else {
                instance.doc.clone()
            },
            father: instance.father.map(name),
            group: instance.group.map(group),
            period_s: instance.period_ns as f64 / 1e9,
            budget_s: instance.budget_ns as f64 / 1e9,
            children: roles
                .map(|(role, child)| ChildInfo {
                    role: role.name.clone(),
                    doc: role.doc.clone(),
                    schema: child.map(name),
                })
                .collect(),
            ports: ports
                .map(|(port, binding)| port_info(application, &instance.name, port, binding))
                .collect(),
            // Known only while the application runs.
            panel: false,
        }
    });
    let groups = application.groups.iter().map(|group| GroupInfo {
        name: group.name.clone(),
        father: group.father.map(name),
        members: group.members.iter().copied().map(name).collect(),
        policy: group.policy.name().to_owned(),
    });
    Schemas {
        schemas: schemas.collect(),
        groups: groups.collect(),
    }
}

fn port_info(application: &Application, owner: &str, port: &Port, binding: &Binding) -> PortInfo {
    let role = match port.role {
        Role::Import => "import",
        Role::Export { .. } => "export",
        Role::Modulation { .. } => "modulation",
        Role::Command { .. } => "command",
        Role::Actuator => "actuator",
        Role::ChildModulation { .. } => "child-modulation",
    };
    PortInfo {
        name: port.name.clone(),
        former_name: port.former_name.clone(),
        role: role.to_owned(),
        type_name: port.value_type.name.clone(),
        unit: port.unit.clone(),
        doc: port.doc.clone(),
        range: match &port.role {
            Role::Modulation { limits, .. } => limits.into(),
            _ => Range::default(),
        },
        fixed: port.has(raw::FIXED),
        variable: variable(application, owner, port, binding),
    }
}

/// The variable that a port reads or writes.
fn variable(application: &Application, owner: &str, port: &Port, binding: &Binding) -> Option<String> {
    match binding {
        Binding::Export | Binding::Modulation { .. } | Binding::Command => {
            Some(format!("{owner}.{}", port.name))
        }
        Binding::Import { source, .. } => source.map(|source| application.source_name(source)),
        Binding::Actuator { target } => target.map(|command| application.variable_name(command)),
        Binding::ChildModulation { target } => target.map(|target| application.target_name(target)),
    }
}

/// The description of a variable without its status.
pub(crate) fn variable_info(subject: &dyn Subject, variable: &Arc<Variable>) -> VariableInfo {
    let declared = variable.describe();
    VariableInfo {
        name: declared.full_name(),
        owner: declared.owner.clone(),
        variable: declared.name.clone(),
        access: match declared.access {
            Access::Export { .. } => "export",
            Access::Modulation => "modulation",
            Access::Command { .. } => "command",
        }
        .to_owned(),
        type_name: jde_ros::definition::name(&declared.value_type),
        definition: jde_ros::definition::definition(&declared.value_type),
        unit: declared.unit.clone(),
        doc: declared.doc.clone(),
        range: subject.range(variable),
        fixed: subject.is_fixed(variable),
        stated: subject.stated(variable).as_ref().map(to_json),
        status: None,
    }
}
