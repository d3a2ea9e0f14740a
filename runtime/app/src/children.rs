//! The children of a father: their roles, and what the father writes to them. It does not form groups.

use std::collections::{HashMap, HashSet};

use jde_abi::describe::{Kind, Port, Role, Scalar, Type};
use jde_abi::raw;
use jde_core::{Id, SchemaId};

use super::drafts::{Drafts, InstanceContext};
use super::variable;
use super::wiring::is_modulation;
use super::{Binding, ChildTarget, InstancePort, RoleId};
use jde_document::section::Text;
use jde_document::{FaultReport, quote};

/// The modulation that every schema has, and its type.
const PERIOD: (&str, &str) = ("period", "std_msgs/msg/Float64");

/// One child as a father names it.
pub(super) struct NamedChild<'a> {
    /// The father's role for it; `None` if it cannot have one, which has been reported.
    pub(super) role: Option<RoleId>,
    pub(super) child: SchemaId,
    /// Its name in the file.
    pub(super) name: Text<'a>,
}

/// Reads `children` of an instance, in the file's order. Returns those that are schemas of the application.
pub(super) fn read<'a>(
    report: &mut FaultReport,
    drafts: &Drafts<'a>,
    father: SchemaId,
) -> Vec<NamedChild<'a>> {
    let section = &drafts.list[father].section;
    let what = section.key("children");
    let roles = drafts.schema(father).map_or(&[][..], |schema| &schema.children);
    let mut ids = HashMap::new();
    for (place, role) in roles.iter().enumerate() {
        ids.entry(role.name.as_str()).or_insert(RoleId::new(place));
    }
    let mut all: Vec<NamedChild> = Vec::new();
    let mut known = HashSet::new();
    for (role, name) in section.pairs(report, "children") {
        let what_role = format!("{} in {what}", quote(role.text));
        let Some(child) = drafts.find(report, &what_role, name.text, &name.span) else {
            continue;
        };
        let twice = !known.insert(child);
        if twice {
            let message = format!("{what_role} names {} a second time", quote(name.text));
            report
                .fault(&name.span, message)
                .advise("a schema can have only one role: define a second instance of the same type");
        }
        let id = ids.get(role.text).copied();
        let role = find_role(report, drafts, father, (&role, id), child, &name).filter(|_| !twice);
        all.push(NamedChild { role, child, name });
    }
    if roles.iter().any(|role| role.many) {
        // The members of the groups give the order of children that the type does not name.
        all.sort_by_key(|child| child.role);
    }
    for role in roles.iter().filter(|role| !role.optional) {
        if !section.is_set("children", &role.name) {
            let kind = kind_noun(if role.motor { Kind::Motor } else { Kind::Perceptive });
            let message = format!("{} has no child in its role {}", section.label, quote(&role.name));
            report
                .fault(&section.key_span("children"), message)
                .advise(format!("add children.{} = \"NAME\", naming {kind}", role.name));
        }
    }
    all
}

/// Returns the role, if the father's type has it and the child fits it.
fn find_role(
    report: &mut FaultReport,
    drafts: &Drafts,
    father: SchemaId,
    (role, id): (&Text, Option<RoleId>),
    child: SchemaId,
    name: &Text,
) -> Option<RoleId> {
    let what = drafts.list[father].section.key("children");
    let roles = &drafts.schema(father)?.children;
    let Some(id) = id else {
        report
            .fault(
                &role.span,
                format!("{what}: there is no role {}", quote(role.text)),
            )
            .suggest(role.text, "roles", roles.iter().map(|role| role.name.as_str()));
        return None;
    };
    let needed = match (roles[id.index()].motor, drafts.schema(child)?.kind) {
        (true, Kind::Motor) | (false, Kind::Perceptive | Kind::Driver) => return Some(id),
        (true, Kind::Perceptive | Kind::Driver) => Kind::Motor,
        (false, Kind::Motor) => Kind::Perceptive,
    };
    let message = format!(
        "{} in {what} takes {}, and {} is {}",
        quote(role.text),
        kind_noun(needed),
        quote(name.text),
        kind_noun(drafts.schema(child)?.kind)
    );
    report.fault(&name.span, message);
    None
}

/// Binds a father's writes to its children.
pub(super) fn bind_modulations(
    report: &mut FaultReport,
    instance: &InstanceContext,
    children: &[NamedChild],
    bindings: &mut [Binding],
) {
    let of_role: HashMap<_, _> = children.iter().map(|child| (child.role, child)).collect();
    for (port, binding) in instance.schema.ports.iter().zip(bindings) {
        if let (Role::ChildModulation { child: role }, Binding::ChildModulation { target }) =
            (&port.role, binding)
            && let Some(child) = of_role.get(&Some(RoleId::new(*role)))
        {
            *target = modulation_target(report, instance, port, *role, child);
        }
    }
}

/// Returns the target of a father's port at the child in that role.
fn modulation_target(
    report: &mut FaultReport,
    instance: &InstanceContext,
    port: &Port,
    role: usize,
    child: &NamedChild,
) -> Option<ChildTarget> {
    let schema = instance.drafts.schema(child.child)?;
    let what = format!(
        "{} that {} writes to {}",
        quote(&port.name),
        instance.section().label,
        quote(&instance.schema.children[role].name)
    );
    if port.name == PERIOD.0 {
        if !is_period(&port.value_type) {
            let (takes, has) = (quote(PERIOD.1), quote(&port.value_type.name));
            report.fault(
                &child.name.span,
                format!("{what} is {has}, and a period is {takes}"),
            );
        }
        return Some(ChildTarget::Period(child.child));
    }
    if let Some(place) = schema.modulation_named(&port.name) {
        let found = InstancePort {
            instance: child.child,
            port: place,
        };
        return variable::can_bind(
            report,
            instance.drafts,
            &what,
            port,
            found,
            &child.name.span,
            || None,
        )
        .then_some(ChildTarget::Port(found));
    }
    if !port.has(raw::OPTIONAL) {
        let modulations = schema.ports.iter().filter(|port| is_modulation(port));
        report
            .fault(
                &child.name.span,
                format!(
                    "{what} is a modulation, and {} has none of that name",
                    quote(child.name.text)
                ),
            )
            .suggest(
                &port.name,
                "its modulations",
                modulations.map(|port| port.name.as_str()),
            );
    }
    None
}

/// Returns the name of a kind of schema for messages.
pub(super) fn kind_noun(kind: Kind) -> &'static str {
    match kind {
        Kind::Perceptive => "a perceptive schema",
        Kind::Motor => "a motor schema",
        Kind::Driver => "a driver",
    }
}

fn is_period(ty: &Type) -> bool {
    ty.name == PERIOD.1 && ty.as_number() == Some(Scalar::F64)
}
