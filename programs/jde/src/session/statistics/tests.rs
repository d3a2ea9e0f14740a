//! A father (0) with two children (1, 2), and a driver (3) outside the hierarchy.

use jde_records::event::StateChange;

use super::*;

const ROOTS: usize = 0;
const BASE: usize = 1;

fn statistics() -> Statistics {
    Statistics::with_groups(4, [(None, &[0][..]), (Some(0), &[1, 2])].into_iter())
}

fn changed(time: Nanos, schema: usize, from: State, to: State) -> Event {
    Event::State(StateChange {
        time,
        schema,
        from,
        to,
    })
}

fn took(record: u64, time: Nanos, schema: usize, latency: Nanos) -> Event {
    Event::Other(
        What::TookOver {
            group: BASE,
            record,
            schema,
            latency,
            allowed: 100,
            machine: 0,
        }
        .at(time),
    )
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
fn takeovers_are_counted_by_schema_and_the_longest_is_kept_by_group() {
    let mut statistics = statistics();
    for (record, schema, latency) in [(1, 1, 4), (2, 2, 9), (3, 1, 2)] {
        statistics.add(&took(record, 10 * record, schema, latency));
    }
    assert_eq!((statistics.takeovers(1), statistics.total_takeovers()), (2, 3));
    assert_eq!((statistics.worst(BASE), statistics.worst(ROOTS)), (Some(9), None));
}

#[test]
fn each_different_refusal_is_kept_once_up_to_a_limit() {
    let mut statistics = statistics();
    let refusals = ["a", "b", "c", "d", "e"];
    for description in ["a", "a"].into_iter().chain(refusals) {
        let (time, schema, description) = (0, 1, description.to_owned());
        statistics.add(&Event::Other(What::Refused { schema, description }.at(time)));
    }
    assert_eq!(statistics.refusals(1), &refusals[..MAX_REFUSALS]);
    assert_eq!(statistics.refusals(2), &[] as &[String]);
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
