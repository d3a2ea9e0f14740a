//! The father of each schema. Checks that every motor schema has exactly one place to compete in.

use std::collections::HashSet;

use jde_abi::describe::Kind;

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
    pub(super) children: Vec<Vec<NamedChild<'a>>>,
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
        let mut complete = roots.complete && names.all(|root| drafts.index_of(root.text).is_some());
        let roots = self::read_roots(report, drafts, roots);
        let children = (0..drafts.list.len())
            .map(|index| {
                let named = children::read(report, drafts, index);
                complete &= drafts.list[index].section.entry_count("children") == named.len();
                named
            })
            .collect();
        Self {
            children,
            roots,
            complete,
        }
    }

    /// Returns the father of every motor schema that has one. Reports second fathers, roots with a father,
    /// cycles, and schemas that are never woken.
    pub(super) fn fathers(&self, report: &mut FaultReport, drafts: &Drafts) -> Vec<Option<usize>> {
        let mut fathers = vec![None; drafts.list.len()];
        for (father, children) in self.children.iter().enumerate() {
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
        fathers: &[Option<usize>],
    ) -> bool {
        let mut reached: Vec<bool> = fathers.iter().map(Option::is_none).collect();
        let mut level: Vec<usize> = (0..fathers.len()).filter(|index| reached[*index]).collect();
        for _ in 0..MAX_DEPTH {
            let children = level.iter().flat_map(|father| &self.children[*father]);
            level = children
                .map(|child| child.child)
                .filter(|child| !std::mem::replace(&mut reached[*child], true))
                .collect();
        }
        let Some(deepest) = level.first().map(|index| &drafts.list[*index]) else {
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
        let edges: Vec<Vec<Edge>> = self
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
            let names = in_words(&cycle, |index| drafts.list[index].name.to_owned());
            report
                .fault(
                    &span,
                    format!("{} is its own father: {names}", drafts.quoted(cycle[0])),
                )
                .advise("remove one of them from its father's `children`");
        }
    }

    fn refuse_orphans(&self, report: &mut FaultReport, drafts: &Drafts) {
        let mut woken = vec![false; drafts.list.len()];
        for index in self.children.iter().flatten().map(|child| child.child) {
            woken[index] = true;
        }
        for (root, _) in self.roots.iter().flatten() {
            woken[*root] = true;
        }
        for (index, draft) in drafts.list.iter().enumerate() {
            if self.complete && !woken[index] && is_motor(drafts, index) {
                report
                    .fault(
                        &draft.section.span,
                        format!(
                            "no father wakes the motor {}, and it is no root",
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
    known: &mut HashSet<usize>,
) -> Vec<Edge> {
    let mut roots: Vec<Edge> = Vec::new();
    for root in names {
        let Some(index) = drafts.find(report, "`roots` of the application", root.text, &root.span) else {
            continue;
        };
        let name = quote(root.text);
        if known.contains(&index) {
            report
                .fault(
                    &root.span,
                    format!("`roots` of the application names {name} twice"),
                )
                .advise("remove one");
            continue;
        }
        if let Some(kind @ (Kind::Perceptive | Kind::Driver)) = drafts.schema(index).map(|schema| schema.kind)
        {
            let kind = children::kind_noun(kind);
            report
                .fault(
                    &root.span,
                    format!("the root {name} is {kind}, and only motor schemas compete"),
                )
                .advise("remove it from `roots`; it is awake while a schema that needs it is");
            continue;
        }
        known.insert(index);
        roots.push((index, root.span.clone()));
    }
    roots
}

fn refuse_second_father(
    report: &mut FaultReport,
    drafts: &Drafts,
    duplicate: &NamedChild,
    first: usize,
    second: usize,
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

fn is_motor(drafts: &Drafts, index: usize) -> bool {
    drafts
        .schema(index)
        .is_some_and(|schema| schema.kind == Kind::Motor)
}
