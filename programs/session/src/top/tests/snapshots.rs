//! Snapshots of applications, for the tests of what shows them. Those of `jde` have the same.

use jde_abi::describe::Kind;
use jde_core::{Health, Nanos, State};
use jde_records::snapshot::{GroupView, Hold, HoldKind, SchemaView, Snapshot, Switch};

const MS: Nanos = 1_000_000;

pub(crate) fn schema(name: &str) -> SchemaView {
    SchemaView {
        name: name.to_owned(),
        type_name: format!("safe-navigation/{name}"),
        kind: Kind::Motor,
        period: 75 * MS,
        ..SchemaView::default()
    }
}

pub(crate) fn held(kind: HoldKind) -> Option<Hold> {
    let by = "ana@laptop".to_owned();
    Some(Hold {
        kind,
        with_everything: false,
        leased: false,
        by,
    })
}

pub(crate) fn group(name: &str) -> GroupView {
    GroupView {
        name: name.to_owned(),
        policy: "priority".to_owned(),
        ..GroupView::default()
    }
}

pub(crate) fn snapshot(time: Nanos, schemas: Vec<SchemaView>, groups: Vec<GroupView>) -> Snapshot {
    Snapshot {
        time,
        schemas,
        groups,
        ..Snapshot::default()
    }
}

/// The example of the paper's section 5, in the middle of a drive.
pub(crate) fn navigation() -> Snapshot {
    let mut schemas = ["teleop", "example", "goon", "vff", "stop", "map", "pioneer"]
        .map(schema)
        .to_vec();
    for child in [2, 3, 4, 5] {
        schemas[child].father = Some(1);
    }
    for (index, group, state) in [
        (0, Some(0), State::Checking),
        (1, Some(0), State::Winner),
        (2, Some(1), State::Ready),
        (3, Some(1), State::Winner),
        (4, Some(1), State::Checking),
        (5, None, State::Slept),
        (6, None, State::Winner),
    ] {
        schemas[index].group = group;
        schemas[index].state = state;
        schemas[index].authority = state == State::Winner;
    }
    schemas[3].measured = Some(75_020_000);
    schemas[3].load = 0.123;
    schemas[3].iterations = 1234;
    schemas[3].operator = held(HoldKind::Forced);
    schemas[3].longest = 1_250_000;
    schemas[3].overruns = 2;
    schemas[3].refused = 3;
    schemas[4].period = 200 * MS;
    schemas[4].health = Health::Faulted("panicked: index out of bounds".to_owned());
    schemas[5].kind = Kind::Perceptive;
    schemas[6].kind = Kind::Driver;
    let mut roots = group("roots");
    (roots.members, roots.winner, roots.switches) = (vec![0, 1], Some(1), 1);
    let mut base = group("example/base");
    (base.father, base.members, base.winner) = (Some(1), vec![2, 3, 4], Some(3));
    (base.policy, base.switches, base.worst, base.allowed) = ("father".into(), 12, 3_100_000, 80 * MS);
    base.last = Some(Switch {
        time: 12_345 * MS,
        from: Some(2),
        to: Some(3),
        decider: jde_records::DecidedBy::Father,
        reason: "obstacle ahead".to_owned(),
        latency: Some(3_100_000),
    });
    snapshot(12_400 * MS, schemas, vec![roots, base])
}
