//! The rows of the hierarchy without the folded and the filtered parts.

use std::collections::BTreeSet;

use jde_abi::describe::Kind;
use jde_core::Health;
use jde_records::snapshot::{SchemaView, Snapshot};
use jde_timeline::{Hierarchy, HierarchyRow, health_word, state_word};
use serde::{Deserialize, Serialize};

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
                state_word(view),
                health_word(&view.health)
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

/// Lists the hierarchy. Returns the rows, and the number of schemas that the filter hides.
pub(super) fn rows(
    hierarchy: &Hierarchy,
    snapshot: &Snapshot,
    filter: &Filter,
    folded: &BTreeSet<String>,
) -> (Vec<HierarchyRow>, usize) {
    let words: Vec<_> = filter.text.split_whitespace().map(str::to_lowercase).collect();
    let views = snapshot.schemas.iter();
    let passes: Vec<_> = views.map(|view| filter.passes(view, &words)).collect();
    // A search also finds schemas in folded parts.
    let is_named = |place: usize| {
        snapshot
            .schemas
            .get(place)
            .is_some_and(|view| folded.contains(&view.name))
    };
    let is_folded = |place: usize| filter.is_empty() && is_named(place);
    let mut rows = hierarchy.rows_of(|place| passes.get(place) == Some(&true), is_folded);
    rows.retain(|row| row.is_in(snapshot));
    (rows, passes.iter().filter(|passes| !**passes).count())
}

#[cfg(test)]
mod tests {
    use jde_timeline::{Children, Item};

    use super::super::fixture;
    use super::*;

    fn text(snapshot: &Snapshot, filter: &Filter, folded: &[&str]) -> Vec<String> {
        let hierarchy = Hierarchy::of_snapshot(snapshot);
        let folded = folded.iter().map(|name| (*name).to_owned()).collect();
        let (list, _) = rows(&hierarchy, snapshot, filter, &folded);
        let lines = list.into_iter().map(|row| match row.item {
            Item::Group(group) => {
                format!("{}[{}]", "  ".repeat(row.depth), snapshot.groups[group].name)
            }
            Item::Schema(schema, below) => {
                let fold = if below == Children::Folded { " +" } else { "" };
                format!(
                    "{}{}{fold}",
                    "  ".repeat(row.depth),
                    snapshot.schemas[schema].name
                )
            }
            Item::Others => "#".to_owned(),
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
        let hierarchy = Hierarchy::of_snapshot(&snapshot);
        let (list, left_out) = rows(&hierarchy, &snapshot, &troubled, &BTreeSet::new());
        assert_eq!(left_out, 4);
        assert_eq!(list.len(), 5, "goon, stop and their fathers: {list:?}");
    }
}
