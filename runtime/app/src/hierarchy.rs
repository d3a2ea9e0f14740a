//! The father of each schema. Checks that every motor schema has exactly one place to compete in.

use std::collections::HashSet;

use jde_abi::describe::Kind;
use jde_core::{SchemaId, Table};

use super::children::{self, NamedChild};
use super::cycle::{Edge, find_cycles, in_words};
use super::drafts::Drafts;
use super::outline::Roots;
use jde_document::section::Text;
use jde_document::{FaultReport, quote};

/// The most schemas above each other, of which a robot has five. Tools draw them as a tree.
pub const MAX_DEPTH: usize = 256;

/// Fathers and children, as the file states them.
pub(super) struct DeclaredHierarchy<'a> {
    /// The children of each instance, in the file's order.
    pub(super) children: Table<SchemaId, Vec<NamedChild<'a>>>,
    /// The motor schemas of each top level, each with its position in the file.
    pub(super) roots: Vec<Vec<Edge>>,
    /// Every name in `roots` and `children` is that of a schema. Otherwise a schema without a father may only
    /// be misspelt there.
    complete: bool,
}

impl<'a> DeclaredHierarchy<'a> {
    /// Reads `roots`, and the `children` of every instance.
    pub(super) fn read(report: &mut FaultReport, drafts: &Drafts<'a>, roots: &Roots<'a>) -> Self {
        let mut names = roots.levels.iter().flat_map(|level| &level.members);
        let mut complete = roots.complete && names.all(|root| drafts.id_of(root.text).is_some());
        let roots = self::read_roots(report, drafts, roots);
        let children = drafts.list.map_ids(|id| {
            let named = children::read(report, drafts, id);
            complete &= drafts.list[id].section.entry_count("children") == named.len();
            named
        });
        Self {
            children,
            roots,
            complete,
        }
    }

    /// Returns the father of every motor schema that has one. Reports second fathers, roots with a father,
    /// cycles, and schemas that are never woken.
    pub(super) fn fathers(
        &self,
        report: &mut FaultReport,
        drafts: &Drafts,
    ) -> Table<SchemaId, Option<SchemaId>> {
        let mut fathers = drafts.list.map_ids(|_| None);
        for (father, children) in self.children.entries() {
            for child in children.iter().filter(|child| is_motor(drafts, child.child)) {
                match fathers[child.child] {
                    None => fathers[child.child] = Some(father),
                    // The same father twice is a fault of its roles, and has been reported.
                    Some(earlier) if earlier == father => {}
                    Some(earlier) => refuse_second_father(report, drafts, child, earlier, father),
                }
            }
        }
        for (root, span) in self.roots.iter().flatten() {
            if let Some(father) = fathers[*root] {
                let (root, father) = (drafts.quoted(*root), drafts.quoted(father));
                report
                    .fault(span, format!("the root {root} has a father, {father}"))
                    .advise("remove it from `roots`, or from its father's `children`");
            }
        }
        self.refuse_cycles(report, drafts);
        self.refuse_orphans(report, drafts);
        fathers
    }

    /// Reports the first schema below too many fathers. Returns whether there is one. In a cycle there is none.
    pub(super) fn is_too_deep(
        &self,
        report: &mut FaultReport,
        drafts: &Drafts,
        fathers: &Table<SchemaId, Option<SchemaId>>,
    ) -> bool {
        let mut reached: Table<SchemaId, bool> = fathers.iter().map(Option::is_none).collect();
        let mut level: Vec<SchemaId> = fathers.ids().filter(|id| reached[*id]).collect();
        for _ in 0..MAX_DEPTH {
            let children = level.iter().flat_map(|father| &self.children[*father]);
            level = children
                .map(|child| child.child)
                .filter(|child| !std::mem::replace(&mut reached[*child], true))
                .collect();
        }
        let Some(deepest) = level.first().map(|id| &drafts.list[*id]) else {
            return false;
        };
        let what = &deepest.section.label;
        let message = format!(
            "{what} is below {MAX_DEPTH} others, and at most {} may be",
            MAX_DEPTH - 1
        );
        report.fault(&deepest.section.span, message);
        true
    }

    fn refuse_cycles(&self, report: &mut FaultReport, drafts: &Drafts) {
        let edges: Table<SchemaId, Vec<Edge>> = self
            .children
            .iter()
            .map(|children| {
                let edges = children.iter();
                edges
                    .map(|child| (child.child, child.name.span.clone()))
                    .collect()
            })
            .collect();
        for (cycle, span) in find_cycles(&edges) {
            let names = in_words(&cycle, |id| drafts.list[id].name.to_owned());
            report
                .fault(
                    &span,
                    format!("{} is its own father: {names}", drafts.quoted(cycle[0])),
                )
                .advise("remove one of them from its father's `children`");
        }
    }

    fn refuse_orphans(&self, report: &mut FaultReport, drafts: &Drafts) {
        let mut woken = drafts.list.map_ids(|_| false);
        for id in self.children.iter().flatten().map(|child| child.child) {
            woken[id] = true;
        }
        for (root, _) in self.roots.iter().flatten() {
            woken[*root] = true;
        }
        for (id, draft) in drafts.list.entries() {
            if self.complete && !woken[id] && is_motor(drafts, id) {
                report
                    .fault(
                        &draft.section.span,
                        format!(
                            "no father wakes the motor {}, and it is not a root",
                            draft.section.label
                        ),
                    )
                    .advise("name it in `roots`, or in the `children` of a father");
            }
        }
    }
}

fn read_roots(report: &mut FaultReport, drafts: &Drafts, written: &Roots) -> Vec<Vec<Edge>> {
    let mut known = HashSet::new();
    let levels = written.levels.iter();
    levels
        .map(|level| read_level(report, drafts, &level.members, &mut known))
        .collect()
}

/// Returns the roots of one level; `known` are those already named, in this level or another.
fn read_level(
    report: &mut FaultReport,
    drafts: &Drafts,
    names: &[Text],
    known: &mut HashSet<SchemaId>,
) -> Vec<Edge> {
    let mut roots: Vec<Edge> = Vec::new();
    for root in names {
        let Some(id) = drafts.find(report, "`roots` of the application", root.text, &root.span) else {
            continue;
        };
        let name = quote(root.text);
        if known.contains(&id) {
            report
                .fault(
                    &root.span,
                    format!("`roots` of the application names {name} twice"),
                )
                .advise("remove one");
            continue;
        }
        if let Some(kind @ (Kind::Perceptive | Kind::Driver)) = drafts.schema(id).map(|schema| schema.kind) {
            let kind = children::kind_noun(kind);
            report
                .fault(
                    &root.span,
                    format!("the root {name} is {kind}, and only motor schemas compete"),
                )
                .advise("remove it from `roots`; it is awake while a schema that needs it is");
            continue;
        }
        known.insert(id);
        roots.push((id, root.span.clone()));
    }
    roots
}

fn refuse_second_father(
    report: &mut FaultReport,
    drafts: &Drafts,
    duplicate: &NamedChild,
    first: SchemaId,
    second: SchemaId,
) {
    let (child, first, second) = (
        drafts.quoted(duplicate.child),
        drafts.quoted(first),
        drafts.quoted(second),
    );
    report
        .fault(
            &duplicate.name.span,
            format!("{child} has two fathers, {first} and {second}"),
        )
        .advise("define a second instance of the same type for the other");
}

fn is_motor(drafts: &Drafts, id: SchemaId) -> bool {
    drafts.schema(id).is_some_and(|schema| schema.kind == Kind::Motor)
}
