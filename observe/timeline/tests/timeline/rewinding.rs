//! Time that goes back takes back all that was later, but for counts.

use jde_core::Health;
use jde_records::event::{Occurrence, What};
use jde_timeline::Keep;
use proptest::prelude::*;

use super::*;

/// The schemas of `navigation` that compete, each with its group.
const COMPETITORS: [(&str, &str); 5] = [
    ("teleop", "roots"),
    ("example", "roots"),
    ("goon", "example/base"),
    ("vff", "example/base"),
    ("left", "goon/base"),
];

/// What happens to a competitor, by the number of its kind.
fn record(number: u64, time: Nanos, competitor: usize, kind: usize) -> RunRecord {
    let (schema, group) = COMPETITORS[competitor];
    let name = schema.to_owned();
    let what = match kind {
        0..4 => return change(time, schema, State::Slept, State::ALL[kind]),
        4 => {
            let decided = decision(number, time as f64 / 1e9, group, &[schema], Some(schema));
            return RunRecord::Decision(Decision {
                takeover_us: Some(number as f64),
                ..decided
            });
        }
        5 => What::Overrun {
            schema: name,
            took: 2,
            budget: 1,
        },
        6 => What::Refused {
            schema: name,
            description: format!("command {number}"),
            retry: None,
        },
        7 => What::HealthChanged {
            schema: name,
            health: Health::Faulted(format!("fault {number}")),
        },
        8 => What::Hung {
            schema: name,
            since: time,
        },
        _ => What::HealthChanged {
            schema: name,
            health: Health::Ok,
        },
    };
    RunRecord::Other(Occurrence { time, what })
}

fn begun(keep: Keep) -> Timeline {
    let mut timeline = Timeline::new(navigation(), keep);
    let start = timeline.snapshot();
    timeline.add_snapshot(&start);
    timeline
}

fn assert_same(one: &Timeline, other: &Timeline) -> Result<(), TestCaseError> {
    for (one, other) in one.schemas().iter().zip(other.schemas()) {
        prop_assert_eq!(&one.states, &other.states);
        prop_assert_eq!(&one.faulted, &other.faulted);
        prop_assert_eq!(&one.marks, &other.marks);
    }
    for (one, other) in one.groups().iter().zip(other.groups()) {
        prop_assert_eq!(&one.winners, &other.winners);
        prop_assert_eq!(&one.switches, &other.switches);
    }
    prop_assert_eq!(one.log().since(0), other.log().since(0));
    prop_assert_eq!(one.now(), other.now());
    Ok(())
}

proptest! {
    #[test]
    fn to_go_back_and_to_go_on_again_equals_never_having_gone_on(
        steps in prop::collection::vec((1..50_u64, 0..COMPETITORS.len(), 0..10_usize), 1..60),
        turn in 0..60_usize,
    ) {
        let mut time = 0;
        let records: Vec<_> = (1..).zip(&steps).map(|(number, (wait, competitor, kind))| {
            time += wait * MS;
            record(number, time, *competitor, *kind)
        }).collect();
        let turn = turn % records.len();
        let mut straight = begun(Keep::ALL);
        records[..turn].iter().for_each(|record| straight.add(record));
        let then = straight.snapshot();
        let mut returned = straight.clone();
        straight.add_snapshot(&then);
        returned.add_snapshot(&then);
        records[turn..].iter().for_each(|record| returned.add(record));
        let later = returned.snapshot();
        returned.add_snapshot(&later);
        returned.add_snapshot(&then);
        prop_assert_eq!(returned.rewinds(), 1);
        assert_same(&returned, &straight)?;
        for timeline in [&mut straight, &mut returned] {
            records[turn..].iter().for_each(|record| timeline.add(record));
        }
        assert_same(&returned, &straight)?;
    }

    #[test]
    fn the_marks_of_all_schemas_together_are_bounded(
        steps in prop::collection::vec((1..50_u64, 0..COMPETITORS.len(), 5..10_usize), 0..60),
    ) {
        let [mut bounded, mut all] = [7, usize::MAX].map(|marks| begun(Keep { marks, ..Keep::LIVE }));
        let mut time = 0;
        for (number, (wait, competitor, kind)) in (1..).zip(&steps) {
            time += wait * MS;
            let record = record(number, time, *competitor, *kind);
            bounded.add(&record);
            all.add(&record);
        }
        let texts = |timeline: &Timeline| {
            let marks = timeline.schemas().iter().flat_map(|schema| &schema.marks);
            let mut marks: Vec<_> = marks.map(|mark| (mark.time, mark.text.clone())).collect();
            marks.sort();
            marks
        };
        let all = texts(&all);
        prop_assert_eq!(texts(&bounded), &all[all.len().saturating_sub(7)..]);
    }
}
