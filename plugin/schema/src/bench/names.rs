//! Finds ports and children by name. An unknown name panics with the nearest known one.

use jde_abi::describe::{Port, Role, Schema};
use jde_nearest::nearest;

/// The kind of a port that a test names.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Import,
    Export,
    Modulation,
    Command,
    Actuator,
    ChildModulation(usize),
}

pub(super) fn port(schema: &Schema, kind: Kind, name: &str) -> usize {
    let fits = |port: &Port| match (kind, &port.role) {
        (Kind::Import, Role::Import)
        | (Kind::Export, Role::Export { .. })
        | (Kind::Modulation, Role::Modulation { .. })
        | (Kind::Command, Role::Command { .. })
        | (Kind::Actuator, Role::Actuator) => true,
        (Kind::ChildModulation(requested), Role::ChildModulation { child }) => requested == *child,
        _ => false,
    };
    let found = schema
        .ports
        .iter()
        .position(|port| port.name == name && fits(port));
    let what = match kind {
        Kind::Import => "import",
        Kind::Export => "export",
        Kind::Modulation => "modulation",
        Kind::Command => "command",
        Kind::Actuator => "actuator",
        Kind::ChildModulation(_) => "modulation of that child",
    };
    let known = schema
        .ports
        .iter()
        .filter(|port| fits(port))
        .map(|port| &*port.name);
    found.unwrap_or_else(|| unknown(what, name, known))
}

pub(super) fn child(schema: &Schema, role: &str) -> usize {
    let found = schema.children.iter().position(|child| child.name == role);
    found.unwrap_or_else(|| unknown("child", role, schema.children.iter().map(|child| &*child.name)))
}

pub(super) fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> ! {
    let known: Vec<_> = known.collect();
    match (nearest(name, known.iter().copied()), known.as_slice()) {
        (Some(nearest), _) => panic!("there is no {what} `{name}`; did you mean `{nearest}`?"),
        (None, []) => panic!("there is no {what} `{name}`; the schema has none"),
        (None, known) => panic!(
            "there is no {what} `{name}`; the schema has `{}`",
            known.join("`, `")
        ),
    }
}
