//! A father (0) with two children (1, 2), and a driver (3) outside the hierarchy.

use std::borrow::Cow;

use jde_core::{Case, Cause, Decider, GroupId, Policy};

use super::*;

const ROOTS: usize = 0;
const BASE: usize = 1;

fn statistics() -> Statistics {
    Statistics::with_groups(4, [(None, &[0][..]), (Some(0), &[1, 2])].into_iter())
}

fn changed(time: Nanos, schema: usize, from: State, to: State) -> Event {
    Event::StateChanged {
        time,
        schema,
        from,
        to,
    }
}

fn decided(number: u64, time: Nanos, before: Option<u32>, choice: Option<u32>) -> Event {
    Event::Decided(Record {
        number,
        time,
        cause_time: time,
        group: GroupId(BASE as u32),
        case: Case::Alone,
        candidates: [].into(),
        before: before.map(SchemaId),
        choice: choice.map(SchemaId),
        decider: Decider::Policy(Policy::PRIORITY),
        reason: Cow::Borrowed("the first"),
        cause: Cause::Start,
        changed: before != choice,
    })
}

fn took(record: u64, time: Nanos, schema: usize, latency: Nanos) -> Event {
    Event::TookOver {
        time,
        group: BASE,
        record,
        schema,
        latency,
        allowed: 100,
    }
}

#[test]
fn time_as_winner_is_summed_including_the_current_one() {
    let mut statistics = statistics();
    statistics.add(&changed(10, 1, State::Ready, State::Winner));
    statistics.add(&changed(30, 1, State::Winner, State::Ready));
    statistics.add(&changed(50, 1, State::Ready, State::Winner));
    assert_eq!(statistics.winner_time(1, 60), 30);
    assert_eq!(statistics.winner_time(1, 70), 40);
    assert_eq!(statistics.winner_time(2, 70), 0);
}

#[test]
fn a_takeover_is_complete_when_the_winner_starts() {
    let mut statistics = statistics();
    assert_eq!(statistics.add(&decided(1, 10, None, Some(1))), None);
    let takeover = statistics.add(&took(1, 14, 1, 4)).unwrap();
    assert_eq!((takeover.from, takeover.to, takeover.time), (None, Some(1), 14));
    assert_eq!(
        (takeover.latency, takeover.reason.as_str()),
        (Some((4, 100)), "the first")
    );
    assert_eq!((statistics.takeovers(1), statistics.total_takeovers()), (1, 1));
    assert_eq!((statistics.worst(BASE), statistics.worst(ROOTS)), (Some(4), None));
}

#[test]
fn a_choice_that_was_not_carried_out_is_no_takeover() {
    let mut statistics = statistics();
    statistics.add(&decided(1, 10, None, Some(1)));
    statistics.add(&decided(2, 11, Some(1), Some(2)));
    let takeover = statistics.add(&took(2, 12, 2, 1)).unwrap();
    assert_eq!((takeover.from, takeover.to), (Some(1), Some(2)));
    assert_eq!((statistics.takeovers(1), statistics.takeovers(2)), (0, 1));
}

#[test]
fn a_takeover_without_a_winner_is_returned_at_once_and_not_counted() {
    let mut statistics = statistics();
    let takeover = statistics.add(&decided(1, 10, Some(1), None)).unwrap();
    assert_eq!(
        (takeover.from, takeover.to, takeover.latency),
        (Some(1), None, None)
    );
    assert_eq!(statistics.total_takeovers(), 0);
}

#[test]
fn a_selection_that_changes_nothing_is_no_takeover() {
    assert_eq!(statistics().add(&decided(1, 10, Some(1), Some(1))), None);
}

#[test]
fn the_acting_schema_is_the_lowest_winner() {
    let mut statistics = statistics();
    assert_eq!(statistics.acting_schemas(), [0; 0]);
    statistics.add(&changed(0, 3, State::Slept, State::Winner));
    statistics.add(&changed(0, 0, State::Checking, State::Winner));
    assert_eq!(
        statistics.acting_schemas(),
        [0; 0],
        "a father whose children stand by does not act"
    );
    statistics.add(&changed(1, 2, State::Ready, State::Winner));
    assert_eq!(statistics.acting_schemas(), [2]);
    statistics.add(&changed(2, 2, State::Winner, State::Slept));
    statistics.add(&changed(2, 1, State::Ready, State::Winner));
    assert_eq!(statistics.acting_schemas(), [1]);
    assert_eq!(statistics.actors().collect::<Vec<_>>(), [1, 2]);
}
