//! What a timeline says does not depend on how it is fed.

use jde_core::Health;
use jde_records::event::{Occurrence, Outcome, What};
use jde_records::snapshot::Snapshot;
use jde_timeline::{Ending, Keep, LogLimits};
use proptest::prelude::*;

use super::*;

/// A change of state, and the changes that it causes below: children before fathers (R5).
fn apply(reference: &mut Timeline, time: Nanos, schema: usize, to: State, records: &mut Vec<RunRecord>) {
    let from = reference.schemas()[schema].state();
    if from == to {
        return;
    }
    if from == State::Winner {
        let groups = reference.hierarchy().schemas()[schema].groups.clone();
        let members = groups
            .iter()
            .flat_map(|group| reference.hierarchy().groups()[*group].members.clone());
        for member in members.collect::<Vec<_>>() {
            apply(reference, time, member, State::Slept, records);
        }
    }
    let name = reference.hierarchy().name(Some(schema)).to_owned();
    let record = change(time, &name, from, to);
    reference.add(&record);
    records.push(record);
}

/// A run of which a snapshot from its start is known.
fn begun() -> Timeline {
    let mut timeline = Timeline::new(navigation(), Keep::ALL);
    let start = timeline.snapshot();
    timeline.add_snapshot(&start);
    timeline
}

/// A run: what happens, and the snapshot after each event.
fn run(steps: &[(u64, usize, usize)]) -> (Timeline, Vec<RunRecord>, Vec<jde_records::snapshot::Snapshot>) {
    let mut reference = begun();
    let (mut records, mut snapshots) = (Vec::new(), Vec::new());
    let mut time = 0;
    for (wait, schema, state) in steps {
        time += 1 + wait * MS;
        let to = State::ALL[*state];
        // R1: the winner before loses first.
        if to == State::Winner
            && let Some(group) = reference.hierarchy().schemas()[*schema].group
            && let Some(winner) = reference.groups()[group].winner()
        {
            apply(&mut reference, time, winner, State::Ready, &mut records);
        }
        apply(&mut reference, time, *schema, to, &mut records);
        snapshots.resize(records.len(), reference.snapshot());
    }
    (reference, records, snapshots)
}

/// All that a timeline knows of states and winners.
fn known(timeline: &Timeline) -> Vec<String> {
    let states = timeline
        .schemas()
        .iter()
        .map(|schema| format!("{:?}", schema.states));
    let winners = timeline
        .groups()
        .iter()
        .map(|group| format!("{:?}", group.winners));
    states.chain(winners).collect()
}

fn steps() -> impl Strategy<Value = Vec<(u64, usize, usize)>> {
    prop::collection::vec((0..50_u64, 0..6_usize, 0..4_usize), 0..60)
}

proptest! {
    #[test]
    fn the_same_run_is_the_same_timeline_with_and_without_snapshots(steps in steps()) {
        let (reference, records, snapshots) = run(&steps);
        let mut watched = begun();
        for (record, snapshot) in records.iter().zip(&snapshots) {
            watched.add(record);
            // Those of one instant are sent after all records of it.
            if record.time() == snapshot.time {
                watched.add_snapshot(snapshot);
            }
        }
        prop_assert_eq!(known(&watched), known(&reference));
        prop_assert_eq!(watched.rewinds(), 0);
        let mut joined = begun();
        let half = records.len() / 2;
        records[..half].iter().for_each(|record| joined.add(record));
        if half > 0 {
            joined.add_snapshot(&snapshots[half - 1]);
        }
        records[half..].iter().for_each(|record| joined.add(record));
        prop_assert_eq!(known(&joined), known(&reference));
    }

    #[test]
    fn intervals_are_disjoint_cover_the_life_and_add_up(steps in steps()) {
        let (reference, ..) = run(&steps);
        for schema in reference.schemas() {
            let intervals: Vec<_> = schema.states.iter().collect();
            prop_assert!(intervals.windows(2).all(|pair| pair[0].from < pair[1].from && pair[0].value != pair[1].value));
            let life = intervals.first().map_or(0, |first| reference.now() - first.from);
            let sum: Nanos = State::ALL.iter().map(|state| schema.time_in(*state, reference.now())).sum();
            prop_assert_eq!(sum, life);
        }
    }

    #[test]
    fn the_loss_of_a_father_needs_no_records_of_its_children(steps in steps()) {
        let (reference, records, _) = run(&steps);
        let mut watched = begun();
        for (place, record) in records.iter().enumerate() {
            let RunRecord::State(change) = record else { continue };
            let hierarchy = reference.hierarchy();
            let schema = hierarchy.find(&change.schema).expect("the schema is known");
            // The record of a child that sleeps because a father lost is lost.
            let mut later = records[place + 1..].iter().take_while(|later| later.time() == change.time);
            let lost = change.to == State::Slept && later.any(|later| {
                matches!(later, RunRecord::State(loss) if loss.from == State::Winner
                    && hierarchy.fathers(schema).skip(1).any(|above| hierarchy.name(Some(above)) == loss.schema))
            });
            if !lost {
                watched.add(record);
            }
        }
        for group in 0..reference.groups().len() {
            prop_assert_eq!(&watched.groups()[group].winners, &reference.groups()[group].winners);
        }
        for (one, other) in watched.schemas().iter().zip(reference.schemas()) {
            prop_assert_eq!(one.state(), other.state());
        }
    }

    #[test]
    fn what_is_kept_is_bounded_and_sums_stay_exact(steps in steps()) {
        let (reference, records, _) = run(&steps);
        let mut bounded = Timeline::new(navigation(), Keep { intervals: 2, ended: true, ..Keep::PRESENT });
        bounded.add_snapshot(&begun().snapshot());
        let mut ended = [[0; 4]; 6];
        for record in &records {
            bounded.add(record);
            for span in bounded.take_ended() {
                ended[span.schema][span.state as usize] += span.to - span.from;
            }
        }
        for (place, (one, all)) in bounded.schemas().iter().zip(reference.schemas()).enumerate() {
            prop_assert!(one.states.len() <= 2);
            for state in State::ALL {
                let now = reference.now();
                prop_assert_eq!(one.time_in(state, now), all.time_in(state, now));
                prop_assert!(ended[place][state as usize] <= all.time_in(state, now));
            }
        }
    }
}

#[test]
fn a_group_whose_father_sleeps_has_no_winner() {
    let mut timeline = Timeline::new(navigation(), Keep::ALL);
    timeline.add(&change(0, "example", State::Slept, State::Winner));
    timeline.add(&RunRecord::Decision(decision(
        1,
        0.1,
        "example/base",
        &["goon"],
        Some("goon"),
    )));
    timeline.add(&change(100 * MS, "goon", State::Ready, State::Winner));
    // Somebody drives by hand. The group selects nobody, since it sleeps.
    timeline.add(&change(500 * MS, "goon", State::Winner, State::Slept));
    timeline.add(&change(500 * MS, "example", State::Winner, State::Ready));
    assert_eq!(
        winners(&timeline, "example/base"),
        [(100, "goon".to_owned()), (500, "nobody".to_owned())]
    );
    assert_eq!(timeline.snapshot().groups[1].winner, None);
    assert!(timeline.acting().is_empty());
}

#[test]
fn a_state_is_known_from_before_the_first_change_and_from_selections() {
    let mut timeline = Timeline::new(Hierarchy::default(), Keep::ALL).beginning(50 * MS);
    timeline.add(&RunRecord::Decision(decision(
        1,
        0.1,
        "roots",
        &["goon", "stop"],
        Some("goon"),
    )));
    timeline.add(&change(100 * MS, "goon", State::Ready, State::Winner));
    timeline.add(&change(200 * MS, "eye", State::Winner, State::Slept));
    assert_eq!(
        states(&timeline, "goon"),
        [(50, State::Ready), (100, State::Winner)]
    );
    assert_eq!(states(&timeline, "stop"), [(50, State::Ready)]);
    assert_eq!(
        states(&timeline, "eye"),
        [(50, State::Winner), (200, State::Slept)]
    );
}

#[test]
fn time_that_goes_back_removes_what_is_later() {
    let mut timeline = Timeline::new(navigation(), Keep::LIVE);
    let snapshot = |timeline: &Timeline, time| Snapshot {
        time,
        ..timeline.snapshot()
    };
    timeline.add(&change(100 * MS, "vff", State::Checking, State::Ready));
    let ready = snapshot(&timeline, 150 * MS);
    timeline.add_snapshot(&ready);
    timeline.add(&change(200 * MS, "vff", State::Ready, State::Winner));
    timeline.add(&RunRecord::Decision(decision(
        7,
        0.2,
        "example/base",
        &["vff"],
        Some("vff"),
    )));
    timeline.add_snapshot(&snapshot(&timeline, 300 * MS));
    let received = timeline.log().received();
    timeline.add_snapshot(&ready);
    assert_eq!(
        states(&timeline, "vff"),
        [(0, State::Checking), (100, State::Ready)]
    );
    assert_eq!(winners(&timeline, "example/base"), []);
    assert_eq!((timeline.rewinds(), timeline.log().decisions().len()), (1, 0));
    assert_eq!(timeline.log().since(received), []);
}

#[test]
fn a_switch_of_a_snapshot_and_its_record_are_one() {
    let mut timeline = Timeline::new(navigation(), Keep::LIVE);
    let mut seen = timeline.snapshot();
    (seen.time, seen.groups[1].switches) = (400 * MS, 1);
    seen.groups[1].last = Some(jde_records::snapshot::Switch {
        time: 300 * MS,
        from: None,
        to: Some(3),
        decider: DecidedBy::Father,
        reason: String::new(),
        latency: None,
    });
    timeline.add_snapshot(&seen);
    let decided = Decision {
        takeover_us: Some(1500.0),
        ..decision(4, 0.3, "example/base", &["vff"], Some("vff"))
    };
    timeline.add(&RunRecord::Decision(decided));
    let [switch] = timeline.groups()[1].switches.iter().collect::<Vec<_>>()[..] else {
        panic!("there is one switch");
    };
    assert_eq!(
        (switch.number, switch.to, switch.latency),
        (Some(4), Some(3), Some(1_500_000))
    );
}

#[test]
fn the_log_is_bounded_by_records_and_by_candidates() {
    let mut timeline = Timeline::new(
        Hierarchy::default(),
        Keep {
            records: LogLimits {
                records: 3,
                candidates: 5,
                switches: 0,
            },
            ..Keep::LIVE
        },
    );
    for number in 1..=6 {
        timeline.add(&RunRecord::Decision(decision(
            number,
            number as f64,
            "roots",
            &["a", "b"],
            Some("a"),
        )));
    }
    let decisions = timeline.log().decisions();
    assert_eq!(
        (decisions.len(), decisions.get(0).map(|first| first.number)),
        (2, Some(5))
    );
    assert!(decisions.find(6).is_some() && decisions.find(4).is_none());
}

#[test]
fn switches_are_kept_longer_than_the_selections_around_them() {
    let records = LogLimits {
        records: 3,
        candidates: 100,
        switches: 2,
    };
    let mut timeline = Timeline::new(
        Hierarchy::default(),
        Keep {
            records,
            ..Keep::LIVE
        },
    );
    for number in 1..=12 {
        let choice = if number < 4 { "a" } else { "b" };
        let selection = Decision {
            changed: [1, 2, 4].contains(&number),
            ..decision(number, number as f64, "roots", &["a", "b"], Some(choice))
        };
        timeline.add(&RunRecord::Decision(selection));
    }
    let decisions = timeline.log().decisions();
    let kept: Vec<_> = (0..decisions.len())
        .filter_map(|place| decisions.get(place))
        .collect();
    let numbers: Vec<_> = kept.iter().map(|decision| decision.number).collect();
    assert_eq!(numbers, [2, 4, 10, 11, 12]);
    assert_eq!(timeline.log().switches(), &[2, 4]);
    assert!(decisions.find(4).is_some() && decisions.find(11).is_some() && decisions.find(5).is_none());
    let until = |time_s: f64| decisions.partition_point(|decision| decision.time_s <= time_s);
    assert_eq!([1.0, 3.0, 9.0, 10.0, 20.0].map(until), [0, 1, 2, 3, 5]);
    timeline.add_snapshot(&Snapshot {
        time: 20_000 * MS,
        ..timeline.snapshot()
    });
    timeline.add_snapshot(&Snapshot {
        time: 3_000 * MS,
        ..timeline.snapshot()
    });
    assert_eq!(timeline.log().switches(), &[2]);
    assert_eq!(timeline.log().decisions().len(), 1);
}

#[test]
fn a_selection_whose_takeover_is_known_later_is_found_all_the_same() {
    let mut timeline = Timeline::new(Hierarchy::default(), Keep::ALL);
    for number in [1, 3, 4, 2, 5] {
        let selection = decision(number, number as f64, "roots", &["a", "b"], Some("a"));
        timeline.add(&RunRecord::Decision(selection));
    }
    let decisions = timeline.log().decisions();
    let found = (1..=5).filter_map(|number| decisions.find(number));
    assert_eq!(
        found.map(|found| found.number).collect::<Vec<_>>(),
        [1, 2, 3, 4, 5]
    );
    assert_eq!(timeline.log().switches(), &[1, 2, 3, 4, 5]);
    assert_eq!(timeline.log().since(3).len(), 2);
}

#[test]
fn the_end_of_a_run_is_known_and_its_time_stands_still() {
    let mut timeline = begun();
    assert_eq!(timeline.ending(), None);
    let outcome = Outcome::Done;
    timeline.add(&RunRecord::Other(What::Ended { outcome }.at(7_000 * MS)));
    let later = Snapshot {
        time: 99_000 * MS,
        ..timeline.snapshot()
    };
    timeline.add_snapshot(&later);
    timeline.add_snapshot(&Snapshot {
        time: 99_050 * MS,
        ..later.clone()
    });
    assert_eq!(timeline.ending().map(Ending::word), Some("done"));
    assert_eq!((timeline.now(), timeline.rewinds()), (7_000 * MS, 0));
    // A recording that is played goes back.
    timeline.add_snapshot(&Snapshot {
        time: 6_000 * MS,
        ..later
    });
    assert_eq!((timeline.ending(), timeline.now()), (None, 6_000 * MS));
}

#[test]
fn the_selection_that_leaves_nobody_at_the_end_of_a_mission_is_its_arrival() {
    let mut timeline = Timeline::new(navigation(), Keep::ALL);
    let nobody = |number, time_s| Decision {
        case: Case::Absence,
        ..decision(number, time_s, "example/base", &["goon"], None)
    };
    let (stand, arrival) = (nobody(1, 1.0), nobody(3, 7.0));
    let again = decision(2, 2.0, "example/base", &["goon"], Some("goon"));
    for selection in [&stand, &again, &arrival] {
        timeline.add(&RunRecord::Decision(selection.clone()));
    }
    assert_eq!(timeline.case_word(&arrival), "absence");
    let outcome = Outcome::Done;
    timeline.add(&RunRecord::Other(What::Ended { outcome }.at(7_100 * MS)));
    let words = [&stand, &again, &arrival].map(|selection| timeline.case_word(selection));
    assert_eq!(words, ["absence", "alone", "done"]);
}

#[test]
fn two_switches_of_one_instant_are_two() {
    let mut timeline = Timeline::new(navigation(), Keep::ALL);
    timeline.add(&RunRecord::Decision(decision(
        1,
        0.0,
        "roots",
        &["teleop"],
        Some("teleop"),
    )));
    timeline.add(&RunRecord::Decision(decision(
        2,
        0.0,
        "roots",
        &["example"],
        Some("example"),
    )));
    let roots = timeline.group("roots").expect("it is known");
    let numbers: Vec<_> = roots.switches.iter().map(|switch| switch.number).collect();
    assert_eq!(numbers, [Some(1), Some(2)]);
}

#[test]
fn a_snapshot_with_fewer_schemas_is_that_of_another_application() {
    let mut timeline = begun();
    let mut shorter = timeline.snapshot();
    shorter.schemas.truncate(2);
    shorter.groups.truncate(1);
    timeline.add_snapshot(&shorter);
    assert_eq!(timeline.rewinds(), 1);
    assert_eq!(timeline.schemas().len(), 2);
    assert!(timeline.hierarchy().rows().iter().all(|row| row.is_in(&shorter)));
}

#[test]
fn a_snapshot_does_not_hide_a_fault_that_is_newer() {
    let mut timeline = begun();
    let before = timeline.snapshot();
    let fault = What::HealthChanged {
        schema: "goon".to_owned(),
        health: Health::Faulted("it panicked".to_owned()),
    };
    timeline.add(&RunRecord::Other(Occurrence {
        time: 5 * MS,
        what: fault,
    }));
    timeline.add_snapshot(&Snapshot {
        time: 4 * MS,
        ..before
    });
    let goon = timeline.schema("goon").expect("it is known");
    assert!(matches!(goon.health, Health::Faulted(_)), "{:?}", goon.health);
}

#[test]
fn names_of_all_records_are_known_before_they_are_added() {
    let overrun = What::Overrun {
        schema: "unlisted".to_owned(),
        took: 1,
        budget: 0,
    };
    let record = RunRecord::Other(Occurrence {
        time: MS,
        what: overrun,
    });
    let mut hierarchy = Hierarchy::default();
    hierarchy.add_names(&record);
    let mut timeline = Timeline::new(hierarchy.clone(), Keep::ALL);
    timeline.add(&record);
    assert_eq!(*timeline.hierarchy(), hierarchy);
    assert_eq!(hierarchy.schemas().len(), 1);
}
