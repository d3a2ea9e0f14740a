//! Who is whose father: reads the roles of children, and checks that every motor schema has one place to compete in.

use std::ops::Range;

use jde_abi::describe::{Kind, Role, Type};

use super::cycle::{Edge, cycles};
use super::document::Text;
use super::outline::{Drafts, Here};
use super::report::{Report, quote};
use super::variable;
use super::{Binding, ChildTarget};

/// The modulation that every schema has, and its type.
const PERIOD: (&str, &str) = ("period", "std_msgs/msg/Float64");

/// One child as a father names it.
pub(super) struct Kin {
    /// The father's role for it; none if the father's type is unknown.
    pub(super) role: Option<usize>,
    pub(super) child: usize,
    pub(super) span: Range<usize>,
}

/// Reads `children` of an instance, in the file's order.
pub(super) fn children(report: &mut Report, drafts: &Drafts, index: usize) -> Vec<Kin> {
    let section = &drafts.get(index).section;
    let what = section.key("children");
    let mut kin: Vec<Kin> = Vec::new();
    for (role, written) in section.pairs(report, "children") {
        let what_role = format!("{} in {what}", quote(role.text));
        let Some(child) = drafts.find(report, &what_role, written.text, &written.span) else {
            continue;
        };
        if kin.iter().any(|earlier| earlier.child == child) {
            let message = format!(
                "{what_role} names {} a second time; one schema plays one role",
                quote(written.text)
            );
            report
                .fault(&written.span, message)
                .advise("define a second instance of the same type");
            continue;
        }
        let role = drafts
            .schema(index)
            .and_then(|_| play(report, drafts, index, &what, &role, child, &written.span));
        kin.push(Kin {
            role,
            child,
            span: written.span,
        });
    }
    if let Some(schema) = drafts.schema(index) {
        let given = |name: &str| {
            section.get("children").is_some_and(|node| {
                node.get_ref()
                    .as_table()
                    .is_none_or(|table| table.contains_key(name))
            })
        };
        for role in schema
            .children
            .iter()
            .filter(|role| !role.optional && !given(&role.name))
        {
            let kind = if role.motor { "motor" } else { "perceptive" };
            report
                .fault(
                    &section.key_span("children"),
                    format!("{} has nobody in its role {}", section.what, quote(&role.name)),
                )
                .advise(format!(
                    "add children.{} = \"...\" with a {kind} schema",
                    role.name
                ));
        }
    }
    kin
}

/// The role of that name, if the child can play it.
fn play(
    report: &mut Report,
    drafts: &Drafts,
    father: usize,
    what: &str,
    role: &Text,
    child: usize,
    span: &Range<usize>,
) -> Option<usize> {
    let roles = &drafts.schema(father)?.children;
    let Some(place) = roles.iter().position(|known| known.name == role.text) else {
        report
            .fault(
                &role.span,
                format!("{what}: there is no role {}", quote(role.text)),
            )
            .suggest(role.text, "roles", roles.iter().map(|role| role.name.as_str()));
        return None;
    };
    let kind = drafts.schema(child).map(|schema| schema.kind);
    let needed = match (roles[place].motor, kind) {
        (true, Some(Kind::Perceptive | Kind::Driver)) => "a motor schema",
        (false, Some(Kind::Motor)) => "a perceptive schema",
        (true, Some(Kind::Motor) | None) | (false, Some(Kind::Perceptive | Kind::Driver) | None) => {
            return Some(place);
        }
    };
    let kind = kind.map(|kind| kind.to_string()).unwrap_or_default();
    report.fault(
        span,
        format!(
            "{} in {what} takes {needed}, and {} is a {kind} schema",
            quote(role.text),
            drafts.quoted(child)
        ),
    );
    None
}

/// Binds what a father writes to its children.
pub(super) fn modulate(report: &mut Report, here: &Here, kin: &[Kin], bindings: &mut [Binding]) {
    for (port, binding) in here.schema.ports.iter().zip(bindings) {
        let (Role::ChildModulation { child: role }, Binding::ChildModulation { target }) =
            (&port.role, binding)
        else {
            continue;
        };
        let Some(kin) = kin.iter().find(|kin| kin.role == Some(*role)) else {
            continue;
        };
        let Some(schema) = here.drafts.schema(kin.child) else {
            continue;
        };
        let (name, role) = (quote(&port.name), quote(&here.schema.children[*role].name));
        let what = format!("{} modulates {name} of its role {role}", here.section().what);
        if port.name == PERIOD.0 {
            *target = Some(ChildTarget::Period(kin.child));
            if !is_period(&port.value_type) {
                let message = format!(
                    "{what} as {}, and a period is {}",
                    quote(&port.value_type.name),
                    quote(PERIOD.1)
                );
                report.fault(&kin.span, message);
            }
            continue;
        }
        let modulation = |other: &&jde_abi::describe::Port| matches!(other.role, Role::Modulation { .. });
        let place = schema
            .ports
            .iter()
            .position(|other| other.name == port.name && modulation(&other));
        match place {
            Some(place) => {
                let found = (kin.child, place);
                if variable::fits(report, here.drafts, &what, port, found, &kin.span) {
                    *target = Some(ChildTarget::Port(kin.child, place));
                }
            }
            None if port.optional => {}
            None => report
                .fault(
                    &kin.span,
                    format!(
                        "{what}, and {} has no such modulation",
                        here.drafts.quoted(kin.child)
                    ),
                )
                .suggest(
                    &port.name,
                    "its modulations",
                    schema
                        .ports
                        .iter()
                        .filter(modulation)
                        .map(|port| port.name.as_str()),
                ),
        }
    }
}

fn is_period(ty: &Type) -> bool {
    ty.name == PERIOD.1 && ty.as_number() == Some(jde_abi::describe::Scalar::F64)
}

/// Reads `roots`: the motor schemas of the top level, with where each is named.
pub(super) fn roots(report: &mut Report, drafts: &Drafts, written: &[Text]) -> Vec<Edge> {
    let mut roots: Vec<Edge> = Vec::new();
    for root in written {
        let Some(index) = drafts.find(report, "`roots` of the application", root.text, &root.span) else {
            continue;
        };
        if roots.iter().any(|(earlier, _)| *earlier == index) {
            let message = format!("`roots` of the application names {} twice", quote(root.text));
            report.fault(&root.span, message).advise("remove one");
            continue;
        }
        if let Some(kind @ (Kind::Perceptive | Kind::Driver)) = drafts.schema(index).map(|schema| schema.kind)
        {
            report
                .fault(
                    &root.span,
                    format!(
                        "the root {} is a {kind} schema, and only motor schemas compete",
                        quote(root.text)
                    ),
                )
                .advise("remove it from `roots`; it is awake while a schema that needs it is");
            continue;
        }
        roots.push((index, root.span.clone()));
    }
    roots
}

/// The father of every motor schema that has one; reports second fathers, roots with a father, ways round and schemas that
/// nobody wakes.
pub(super) fn fathers(
    report: &mut Report,
    drafts: &Drafts,
    kin: &[Vec<Kin>],
    roots: &[Edge],
) -> Vec<Option<usize>> {
    let is_motor = |index: usize| {
        drafts
            .schema(index)
            .is_some_and(|schema| schema.kind == Kind::Motor)
    };
    let mut fathers = vec![None; drafts.len()];
    let mut named = vec![false; drafts.len()];
    for (father, kin) in kin.iter().enumerate() {
        for kin in kin {
            named[kin.child] = true;
            if !is_motor(kin.child) {
                continue;
            }
            let Some(earlier) = fathers[kin.child] else {
                fathers[kin.child] = Some(father);
                continue;
            };
            report
                .fault(
                    &kin.span,
                    format!(
                        "{} has two fathers, {} and {}",
                        drafts.quoted(kin.child),
                        drafts.quoted(earlier),
                        drafts.quoted(father)
                    ),
                )
                .advise("define a second instance of the same type for the other");
        }
    }
    for (root, span) in roots {
        if let Some(father) = fathers[*root] {
            report
                .fault(
                    span,
                    format!(
                        "the root {} has a father, {}",
                        drafts.quoted(*root),
                        drafts.quoted(father)
                    ),
                )
                .advise(
                    "a schema competes in one place: remove it from `roots`, or from its father's `children`",
                );
        }
    }
    let edges: Vec<Vec<Edge>> = kin
        .iter()
        .map(|kin| kin.iter().map(|kin| (kin.child, kin.span.clone())).collect())
        .collect();
    for (way, span) in cycles(&edges) {
        let names: Vec<_> = way.iter().map(|index| drafts.get(*index).name).collect();
        report
            .fault(
                &span,
                format!(
                    "{} is its own father: {}",
                    quote(names[0]),
                    quote(&names.join(" -> "))
                ),
            )
            .advise("take one of them out of its father's `children`");
    }
    for (index, draft) in drafts.iter().enumerate() {
        if is_motor(index) && !named[index] && !roots.iter().any(|(root, _)| *root == index) {
            report
                .fault(
                    &draft.section.span,
                    format!("nobody wakes the motor {}", draft.section.what),
                )
                .advise("name it in `roots` or in the `children` of a father");
        }
    }
    fathers
}
