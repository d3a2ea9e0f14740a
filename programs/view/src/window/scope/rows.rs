//! The hierarchy as rows: fathers before children, with groups between them, without folded and filtered
//! parts. No schema is lost: one that no group and no father leads to is listed at the end.

use std::collections::BTreeSet;

use jde_abi::describe::Kind;
use jde_core::Health;
use jde_records::snapshot::{SchemaView, Snapshot};
use serde::{Deserialize, Serialize};

/// A row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Row {
    /// A group, by its index.
    Group { group: usize, depth: usize },
    /// A schema, by its index.
    Schema {
        schema: usize,
        depth: usize,
        below: Children,
    },
    /// The heading of the schemas that do not compete.
    Ungrouped,
}

/// Whether a schema has rows below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Children {
    Nothing,
    Shown,
    Folded,
}

/// Selects the schemas to show.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Filter {
    /// Words that must all occur in the name, type, kind, state or health.
    pub(super) text: String,
    /// Only schemas that are not SLEPT.
    pub(super) awake: bool,
    /// Only schemas that need attention, as in [`is_troubled`].
    pub(super) troubled: bool,
}

impl Filter {
    /// Whether it hides nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.text.trim().is_empty() && !self.awake && !self.troubled
    }

    fn passes(&self, view: &SchemaView, words: &[String]) -> bool {
        if self.awake && view.state == jde_core::State::Slept {
            return false;
        }
        if self.troubled && !is_troubled(view) {
            return false;
        }
        words.is_empty() || {
            let kind = match view.kind {
                Kind::Perceptive => "perceptive",
                Kind::Motor => "motor",
                Kind::Driver => "driver",
            };
            let text = format!(
                "{} {} {kind} {} {}",
                view.name,
                view.type_name,
                view.state.name(),
                health(&view.health).0
            )
            .to_lowercase();
            words.iter().all(|word| text.contains(word))
        }
    }
}

/// Whether a schema needs attention: its health is not Ok, it had overruns, faults or refusals, or an
/// operator holds it.
pub(super) fn is_troubled(view: &SchemaView) -> bool {
    view.health != Health::Ok || view.overruns + view.faults + view.refused > 0 || view.operator.is_some()
}

/// The health in one word, and the details, if any.
pub(super) fn health(health: &Health) -> (&'static str, Option<&str>) {
    match health {
        Health::Ok => ("ok", None),
        Health::Overrun => ("overrun", Some("it missed its deadline or exceeded its budget")),
        Health::ArbitrationFailed(reason) => ("arbitration", Some(reason)),
        Health::Faulted(reason) => ("faulted", Some(reason)),
    }
}

/// Lists the hierarchy. Returns the rows, and the number of schemas that the filter hides.
pub(super) fn rows(snapshot: &Snapshot, filter: &Filter, folded: &BTreeSet<String>) -> (Vec<Row>, usize) {
    let count = snapshot.schemas.len();
    let mut list = List {
        snapshot,
        groups: vec![Vec::new(); count],
        alone: vec![Vec::new(); count],
        listed: vec![false; count],
        shown: vec![true; count],
        folded,
        filtered: !filter.is_empty(),
        rows: Vec::new(),
    };
    let mut roots = Vec::new();
    for (group, view) in snapshot.groups.iter().enumerate() {
        match view.father.and_then(|father| list.groups.get_mut(father)) {
            Some(groups) => groups.push(group),
            None => roots.push(group),
        }
    }
    for (schema, view) in snapshot.schemas.iter().enumerate() {
        if let (Some(father), None) = (view.father, view.group)
            && let Some(alone) = list.alone.get_mut(father)
        {
            alone.push(schema);
        }
    }
    let left_out = if list.filtered { list.filter(filter) } else { 0 };
    for group in roots {
        list.group(group, 0);
    }
    let mut ungrouped: Vec<usize> = (0..count).filter(|&schema| !list.listed[schema]).collect();
    ungrouped.sort_by_key(|&schema| snapshot.schemas[schema].father.is_some());
    let heading = list.rows.len();
    for schema in ungrouped {
        list.schema(schema, 1);
    }
    if list.rows.len() > heading {
        list.rows.insert(heading, Row::Ungrouped);
    }
    (list.rows, left_out)
}

struct List<'a> {
    snapshot: &'a Snapshot,
    /// The groups of each schema.
    groups: Vec<Vec<usize>>,
    /// The children of each schema that are in no group.
    alone: Vec<Vec<usize>>,
    listed: Vec<bool>,
    /// Whether a schema passes the filter, or is an ancestor of one that does.
    shown: Vec<bool>,
    folded: &'a BTreeSet<String>,
    filtered: bool,
    rows: Vec<Row>,
}

impl List<'_> {
    /// Marks the schemas that pass the filter, and their ancestors. Returns the number of schemas that do not
    /// pass.
    fn filter(&mut self, filter: &Filter) -> usize {
        let words: Vec<_> = filter.text.split_whitespace().map(str::to_lowercase).collect();
        let schemas = &self.snapshot.schemas;
        self.shown = vec![false; schemas.len()];
        let mut left_out = 0;
        for (place, view) in schemas.iter().enumerate() {
            if !filter.passes(view, &words) {
                left_out += 1;
                continue;
            }
            let mut next = Some(place);
            while let Some(shown) = next.and_then(|place| self.shown.get_mut(place)) {
                if std::mem::replace(shown, true) {
                    break;
                }
                next = next.and_then(|place| schemas[place].father);
            }
        }
        left_out
    }

    fn group(&mut self, group: usize, depth: usize) {
        let members = &self.snapshot.groups[group].members;
        if !members
            .iter()
            .any(|&member| self.shown.get(member).is_some_and(|shown| *shown))
        {
            for &member in members {
                self.skip(member);
            }
            return;
        }
        self.rows.push(Row::Group { group, depth });
        for &member in members {
            self.schema(member, depth + 1);
        }
    }

    fn schema(&mut self, schema: usize, depth: usize) {
        let Some(listed) = self.listed.get_mut(schema) else {
            return;
        };
        if std::mem::replace(listed, true) {
            return;
        }
        if !self.shown[schema] {
            self.skip_below(schema);
            return;
        }
        let place = self.rows.len();
        let below = |below| Row::Schema { schema, depth, below };
        self.rows.push(below(Children::Nothing));
        let has_children = !self.groups[schema].is_empty() || !self.alone[schema].is_empty();
        // A search also finds schemas in folded parts.
        if has_children && !self.filtered && self.folded.contains(&self.snapshot.schemas[schema].name) {
            self.rows[place] = below(Children::Folded);
            self.skip_below(schema);
            return;
        }
        for group in self.groups[schema].clone() {
            self.group(group, depth + 1);
        }
        for child in self.alone[schema].clone() {
            self.schema(child, depth + 1);
        }
        if self.rows.len() > place + 1 {
            self.rows[place] = below(Children::Shown);
        }
    }

    fn skip(&mut self, schema: usize) {
        if let Some(listed) = self.listed.get_mut(schema)
            && !std::mem::replace(listed, true)
        {
            self.skip_below(schema);
        }
    }

    fn skip_below(&mut self, schema: usize) {
        let snapshot = self.snapshot;
        for group in self.groups[schema].clone() {
            for &member in &snapshot.groups[group].members {
                self.skip(member);
            }
        }
        for child in self.alone[schema].clone() {
            self.skip(child);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    fn text(snapshot: &Snapshot, filter: &Filter, folded: &[&str]) -> Vec<String> {
        let folded = folded.iter().map(|name| (*name).to_owned()).collect();
        let (list, _) = rows(snapshot, filter, &folded);
        let lines = list.into_iter().map(|row| match row {
            Row::Group { group, depth } => {
                format!("{}[{}]", "  ".repeat(depth), snapshot.groups[group].name)
            }
            Row::Schema { schema, depth, below } => {
                let fold = if below == Children::Folded { " +" } else { "" };
                format!("{}{}{fold}", "  ".repeat(depth), snapshot.schemas[schema].name)
            }
            Row::Ungrouped => "#".to_owned(),
        });
        lines.collect()
    }

    #[test]
    fn children_are_listed_below_their_father_in_their_groups() {
        let snapshot = fixture::navigation().snapshot;
        let all = [
            "[roots]",
            "  teleop",
            "  example",
            "    [example/base]",
            "      goon",
            "      vff",
            "      stop",
            "#",
            "  pioneer",
        ];
        assert_eq!(text(&snapshot, &Filter::default(), &[]), all);
        let folded = ["[roots]", "  teleop", "  example +", "#", "  pioneer"];
        assert_eq!(text(&snapshot, &Filter::default(), &["example"]), folded);
    }

    #[test]
    fn a_filter_shows_matching_schemas_below_their_fathers_even_in_folded_parts() {
        let snapshot = fixture::navigation().snapshot;
        let found = ["[roots]", "  example", "    [example/base]", "      vff"];
        let by_text = Filter {
            text: "MOTOR vff/".to_owned(),
            ..Filter::default()
        };
        assert_eq!(text(&snapshot, &by_text, &["example"]), found);
        let drivers = Filter {
            text: "driver".to_owned(),
            ..Filter::default()
        };
        assert_eq!(text(&snapshot, &drivers, &[]), ["#", "  pioneer"]);
        let troubled = Filter {
            troubled: true,
            ..Filter::default()
        };
        let (list, left_out) = rows(&snapshot, &troubled, &BTreeSet::new());
        assert_eq!(left_out, 4);
        assert_eq!(list.len(), 5, "goon, stop and their fathers: {list:?}");
    }

    #[test]
    fn a_cyclic_hierarchy_is_listed_completely() {
        let mut snapshot = fixture::navigation().snapshot;
        snapshot.groups[0].father = Some(4);
        let (list, _) = rows(&snapshot, &Filter::default(), &BTreeSet::new());
        let schemas = list
            .iter()
            .filter(|row| matches!(row, Row::Schema { .. }))
            .count();
        assert_eq!(schemas, snapshot.schemas.len());
    }
}
