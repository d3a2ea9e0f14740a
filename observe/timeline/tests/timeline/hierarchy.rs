//! The hierarchy and its rows.

use jde_records::snapshot::{GroupView, SchemaView, Snapshot};
use jde_timeline::{Children, HierarchyRow, Item, Keep};

use super::*;

/// The rows as text: two spaces for each depth, groups in brackets, `+` for folded children.
fn text(hierarchy: &Hierarchy, shown: impl Fn(&str) -> bool, folded: &str) -> Vec<String> {
    let name = |place: usize| hierarchy.schemas()[place].name.as_str();
    let rows = hierarchy.rows_of(|place| shown(name(place)), |place| name(place) == folded);
    let rows = rows.into_iter().map(|row| {
        let text = match row.item {
            Item::Group(group) => format!("[{}]", hierarchy.groups()[group].name),
            Item::Schema(schema, Children::Folded) => format!("{} +", name(schema)),
            Item::Schema(schema, Children::Nothing | Children::Shown) => name(schema).to_owned(),
            Item::Others => "#".to_owned(),
        };
        format!("{}{text}", "  ".repeat(row.depth))
    });
    rows.collect()
}

#[test]
fn children_follow_their_fathers_in_any_order_of_selections() {
    let mut timeline = Timeline::new(Hierarchy::default(), Keep::ALL);
    timeline.add(&change(0, "pioneer", State::Slept, State::Winner));
    timeline.add(&RunRecord::Decision(decision(
        1,
        0.0,
        "example/base",
        &["stop", "goon"],
        None,
    )));
    timeline.add(&RunRecord::Decision(decision(
        2,
        0.0,
        "roots",
        &["example"],
        None,
    )));
    let hierarchy = timeline.hierarchy();
    assert_eq!(
        text(hierarchy, |_| true, ""),
        [
            "[roots]",
            "  example",
            "    [example/base]",
            "      stop",
            "      goon",
            "#",
            "  pioneer"
        ]
    );
    let actors = (0..4).filter(|schema| hierarchy.is_actor(*schema));
    assert_eq!(
        actors
            .map(|schema| hierarchy.name(Some(schema)))
            .collect::<Vec<_>>(),
        ["stop", "goon"]
    );
}

#[test]
fn a_selection_adds_no_member_to_a_group_that_is_described() {
    let mut hierarchy = navigation();
    hierarchy.add_decision(&decision(1, 0.0, "roots", &["stranger"], None));
    assert_eq!(hierarchy.groups()[0].members, [0, 1]);
}

#[test]
fn rows_are_filtered_and_folded_below_their_fathers() {
    let hierarchy = navigation();
    assert_eq!(
        text(&hierarchy, |name| name == "left", ""),
        [
            "[roots]",
            "  example",
            "    [example/base]",
            "      goon",
            "        [goon/base]",
            "          left"
        ]
    );
    assert_eq!(
        text(&hierarchy, |_| true, "example"),
        ["[roots]", "  teleop", "  example +", "#", "  pioneer"]
    );
    let last: Vec<_> = hierarchy.rows().iter().map(|row| row.is_last).collect();
    assert_eq!(
        last,
        [true, false, true, true, false, true, true, true, true, true]
    );
}

#[test]
fn a_loop_of_fathers_is_cut_and_every_schema_has_one_row() {
    let mut hierarchy = Hierarchy::default();
    hierarchy.add_decision(&decision(1, 0.0, "a/base", &["b"], None));
    hierarchy.add_decision(&decision(2, 0.0, "b/base", &["a"], None));
    hierarchy.add_decision(&decision(3, 0.0, "c/base", &["c"], None));
    let schemas = hierarchy.rows().iter().filter_map(HierarchyRow::schema).count();
    assert_eq!(schemas, 3);
    let group = |name: &str, father, member| GroupView {
        name: name.to_owned(),
        father: Some(father),
        members: vec![member],
        ..GroupView::default()
    };
    let schema = |name: &str| SchemaView {
        name: name.to_owned(),
        ..SchemaView::default()
    };
    let hostile = Snapshot {
        schemas: vec![schema("a"), schema("b"), schema("b")],
        groups: vec![group("one", 1, 0), group("other", 0, 1), group("none", 9, 9)],
        ..Snapshot::default()
    };
    let hierarchy = Hierarchy::of_snapshot(&hostile);
    assert_eq!(
        hierarchy.rows().iter().filter_map(HierarchyRow::schema).count(),
        3
    );
    let mut timeline = Timeline::default();
    timeline.add_snapshot(&hostile);
    timeline.add_snapshot(&hostile);
    assert_eq!(
        (
            timeline.schemas().len(),
            timeline.groups().len(),
            timeline.rewinds()
        ),
        (3, 3, 1)
    );
    assert!((0..3).all(|place| hierarchy.fathers(place).count() <= 2));
}
