//! A father (0) with two children (1, 2), and a driver (3) outside the hierarchy.

use std::borrow::Cow;

use jde_core::{Case, Cause, Decider, GroupId, Policy};

use super::*;

const ROOTS: usize = 0;
const BASE: usize = 1;

fn tally() -> Statistics {
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
fn time_as_winner_is_added_up_and_goes_on_while_it_lasts() {
    let mut tally = tally();
    tally.add(&changed(10, 1, State::Ready, State::Winner));
    tally.add(&changed(30, 1, State::Winner, State::Ready));
    tally.add(&changed(50, 1, State::Ready, State::Winner));
    assert_eq!(tally.winner_time(1, 60), 30);
    assert_eq!(tally.winner_time(1, 70), 40);
    assert_eq!(tally.winner_time(2, 70), 0);
}

#[test]
fn a_takeover_is_complete_when_the_winner_begins() {
    let mut tally = tally();
    assert_eq!(tally.add(&decided(1, 10, None, Some(1))), None);
    let takeover = tally.add(&took(1, 14, 1, 4)).unwrap();
    assert_eq!((takeover.from, takeover.to, takeover.time), (None, Some(1), 14));
    assert_eq!(
        (takeover.latency, takeover.reason.as_str()),
        (Some((4, 100)), "the first")
    );
    assert_eq!((tally.takeovers(1), tally.total_takeovers()), (1, 1));
    assert_eq!((tally.worst(BASE), tally.worst(ROOTS)), (Some(4), None));
}

#[test]
fn a_choice_that_was_never_carried_out_is_no_takeover() {
    let mut tally = tally();
    tally.add(&decided(1, 10, None, Some(1)));
    tally.add(&decided(2, 11, Some(1), Some(2)));
    let takeover = tally.add(&took(2, 12, 2, 1)).unwrap();
    assert_eq!((takeover.from, takeover.to), (Some(1), Some(2)));
    assert_eq!((tally.takeovers(1), tally.takeovers(2)), (0, 1));
}

#[test]
fn nobody_taking_over_is_told_at_once_and_not_counted() {
    let mut tally = tally();
    let takeover = tally.add(&decided(1, 10, Some(1), None)).unwrap();
    assert_eq!(
        (takeover.from, takeover.to, takeover.latency),
        (Some(1), None, None)
    );
    assert_eq!(tally.total_takeovers(), 0);
}

#[test]
fn a_selection_that_changes_nothing_is_no_takeover() {
    assert_eq!(tally().add(&decided(1, 10, Some(1), Some(1))), None);
}

#[test]
fn who_acts_is_the_winner_at_the_bottom() {
    let mut tally = tally();
    assert_eq!(tally.acting_schemas(), [0; 0]);
    tally.add(&changed(0, 3, State::Slept, State::Winner));
    tally.add(&changed(0, 0, State::Checking, State::Winner));
    assert_eq!(
        tally.acting_schemas(),
        [0; 0],
        "a father whose children stand by does not act"
    );
    tally.add(&changed(1, 2, State::Ready, State::Winner));
    assert_eq!(tally.acting_schemas(), [2]);
    tally.add(&changed(2, 2, State::Winner, State::Slept));
    tally.add(&changed(2, 1, State::Ready, State::Winner));
    assert_eq!(tally.acting_schemas(), [1]);
    assert_eq!(tally.actors().collect::<Vec<_>>(), [1, 2]);
}
