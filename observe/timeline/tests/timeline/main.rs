//! The promises of a timeline: of any run, fed in any way.

mod feeding;
mod hierarchy;
mod rewinding;

use jde_core::{Case, Nanos, State};
use jde_records::event::StateChange;
use jde_records::{CandidateRecord, DecidedBy, Decision, RunRecord};
use jde_timeline::{Hierarchy, SchemaEntry, Timeline};

const MS: Nanos = 1_000_000;

/// Two roots; `example` has two children, of which `goon` has one itself.
fn navigation() -> Hierarchy {
    let mut hierarchy = Hierarchy::default();
    for name in ["teleop", "example", "goon", "vff", "left", "pioneer"] {
        hierarchy.describe(SchemaEntry {
            name: name.to_owned(),
            ..SchemaEntry::default()
        });
    }
    hierarchy.describe_group("roots", None, ["teleop", "example"]);
    hierarchy.describe_group("example/base", Some("example"), ["goon", "vff"]);
    hierarchy.describe_group("goon/base", Some("goon"), ["left"]);
    hierarchy
}

fn change(time: Nanos, schema: &str, from: State, to: State) -> RunRecord {
    RunRecord::State(StateChange {
        time,
        schema: schema.to_owned(),
        from,
        to,
    })
}

fn decision(number: u64, time_s: f64, group: &str, names: &[&str], choice: Option<&str>) -> Decision {
    let candidate = |name: &&str| CandidateRecord {
        name: (*name).to_owned(),
        state: State::Ready,
        ready: true,
        urgency: None,
    };
    Decision {
        number,
        time_s,
        group: group.to_owned(),
        case: Case::Alone,
        candidates: names.iter().map(candidate).collect(),
        choice: choice.map(str::to_owned),
        decider: DecidedBy::Policy("priority".to_owned()),
        changed: true,
        ..Decision::default()
    }
}

/// The states of a schema: when each began, ms.
fn states(timeline: &Timeline, name: &str) -> Vec<(Nanos, State)> {
    let intervals = timeline.schema(name).expect("the schema is known").states.iter();
    intervals
        .map(|interval| (interval.from / MS, interval.value))
        .collect()
}

/// The winners of a group: when each began, ms.
fn winners(timeline: &Timeline, group: &str) -> Vec<(Nanos, String)> {
    let intervals = timeline.group(group).expect("the group is known").winners.iter();
    let name = |place| timeline.hierarchy().name(place).to_owned();
    intervals
        .map(|interval| (interval.from / MS, name(interval.value)))
        .collect()
}
