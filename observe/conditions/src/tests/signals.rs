//! Tests of the signals: their names, their values, and the moments at which conditions on them fire.

use jde_core::{GroupId, Health, SchemaId, State};
use jde_records::event::{Event, StateChange, What};
use jde_types::Truth;

use super::*;

/// Two simulated robots beside the other variables, and a variable that hides a signal.
fn names() -> Names {
    let mut names = super::names();
    for robot in ["pioneer.truth", "other.truth"] {
        names
            .variables
            .insert(robot.to_owned(), Arc::new(Truth::describe()));
    }
    names
        .variables
        .insert("stop.ready".to_owned(), Arc::new(f64::describe()));
    names
}

fn state(time_s: f64, schema: &str, to: &str) -> RunRecord {
    RunRecord::State(StateChange {
        time: (time_s * 1e9).round() as u64,
        schema: schema.to_owned(),
        from: State::Checking,
        to: state_named(to).unwrap(),
    })
}

fn truth(clearance: f64, collisions: u64) -> Truth {
    Truth {
        clearance,
        collisions,
        ..Truth::default()
    }
}

/// Returns the value of an expression over signals alone.
#[track_caller]
fn value(signals: &Signals, text: &str) -> Option<f64> {
    let mut expression = Expression::new(text, &names()).unwrap();
    let inputs: Vec<_> = expression.inputs().map(|name| signals.find(name)).collect();
    for (place, signal) in inputs.into_iter().enumerate() {
        expression.set(place, signals.value(signal.expect("it names signals only")));
    }
    expression.value()
}

#[test]
fn records_and_events_have_the_same_effect_on_signals() {
    let records = [
        state(1.0, "goon", "ready"),
        took_over(decision(1.0, "roots", "alone", Some("goon"), true)),
        state(1.0, "goon", "winner"),
        event(2.0, "overrun", "goon"),
        event(2.0, "overrun", "goon"),
        event(3.0, "ok", "goon"),
        event(4.0, "overrun", "goon"),
        event(5.0, "faulted", "stop"),
        event(5.0, "refused", "goon"),
        event(5.0, "late", "goon"),
        event(5.0, "operator", "goon"),
    ];
    const GOON: SchemaId = SchemaId(0);
    const STOP: SchemaId = SchemaId(1);
    let health = |time, schema, health| Event::Other(What::HealthChanged { schema, health }.at(time));
    let changed = |time, to| {
        Event::State(StateChange {
            time,
            schema: GOON,
            from: State::Checking,
            to,
        })
    };
    let late = Event::Other(
        What::TookOver {
            group: GroupId(0),
            record: 1,
            schema: GOON,
            latency: 2,
            allowed: 1,
            machine: 0,
        }
        .at(5),
    );
    let events = [
        changed(1, State::Ready),
        changed(1, State::Winner),
        health(2, GOON, Health::Overrun),
        Event::Other(
            What::Overrun {
                schema: GOON,
                took: 2,
                budget: 1,
            }
            .at(2),
        ),
        health(3, GOON, Health::Ok),
        health(4, GOON, Health::Overrun),
        health(5, STOP, Health::Faulted("it panicked".to_owned())),
        Event::Other(
            What::Refused {
                schema: GOON,
                description: String::new(),
                retry: None,
            }
            .at(5),
        ),
        late,
    ];
    let mut of_records = Signals::new(&names());
    records
        .iter()
        .for_each(|record| of_records.process_record(record));
    let mut of_events = Signals::new(&names());
    events.iter().for_each(|event| of_events.process_event(event));
    for signals in [&of_records, &of_events] {
        for (text, expected) in [
            ("goon.won", 1.0),
            ("goon.ready", 1.0),
            ("stop.won", 0.0),
            ("overruns", 2.0),
            ("faults", 1.0),
            ("refused", 1.0),
            ("late_takeovers", 1.0),
            ("takeovers", 1.0),
        ] {
            assert_eq!(value(signals, text), Some(expected), "{text}");
        }
    }
}

/// The record of a selection whose winner has begun.
fn took_over(record: RunRecord) -> RunRecord {
    match record {
        RunRecord::Decision(decision) => RunRecord::Decision(Decision {
            takeover_us: Some(1.0),
            ..decision
        }),
        other => other,
    }
}

#[test]
fn a_takeover_counts_once_it_occurred() {
    let mut signals = Signals::new(&names());
    let mut selection = decision(1.0, "roots", "alone", Some("goon"), true);
    signals.process_record(&selection);
    assert_eq!(value(&signals, "takeovers"), Some(0.0));
    if let RunRecord::Decision(decision) = &mut selection {
        decision.takeover_us = Some(3.0);
    }
    signals.process_record(&selection);
    assert_eq!(value(&signals, "takeovers"), Some(1.0));
}

#[test]
fn a_selection_that_arrives_late_does_not_change_a_newer_state() {
    let mut signals = Signals::new(&names());
    signals.process_record(&state(1.0, "goon", "winner"));
    assert_eq!(value(&signals, "goon.ready"), Some(0.0), "chosen at an absence");
    signals.process_record(&decision(2.0, "roots", "alone", Some("goon"), true));
    assert_eq!(value(&signals, "goon.ready"), Some(1.0));
    signals.process_record(&state(3.0, "goon", "slept"));
    signals.process_record(&decision(3.0, "roots", "alone", Some("goon"), true));
    assert_eq!(value(&signals, "goon.ready"), Some(0.0));
}

#[test]
fn clearance_is_the_least_and_collisions_the_sum_of_all_robots() {
    let mut signals = Signals::new(&names());
    assert_eq!(value(&signals, "clearance < 9.0"), None, "there is no value yet");
    signals.process_value("pioneer.truth", Some(truth(0.5, 1).as_bytes()));
    signals.process_value("other.truth", Some(truth(0.2, 2).as_bytes()));
    signals.process_value("goon.fast", Some(1.0_f64.as_bytes()));
    assert_eq!(value(&signals, "clearance"), Some(0.2));
    assert_eq!(value(&signals, "collisions"), Some(3.0));
    signals.process_value("other.truth", None);
    assert_eq!(value(&signals, "clearance"), Some(0.5));
    signals.process_value("pioneer.truth", None);
    assert_eq!(value(&signals, "collisions"), None);
}

#[test]
fn only_what_changed_is_passed_on() {
    let mut signals = Signals::new(&names());
    let changes = |signals: &mut Signals| {
        let mut changes = Vec::new();
        signals.take_changes(|signal, value| changes.push((signal, value.map(<[u8]>::to_vec))));
        changes
    };
    assert!(changes(&mut signals).len() > 5, "all are new");
    signals.advance(2_000_000_000);
    signals.advance(3_000_000_000);
    signals.process_record(&state(1.0, "goon", "checking"));
    let time = signals.find("time").unwrap();
    assert_eq!(changes(&mut signals), [(time, Some(3.0_f64.as_bytes().to_vec()))]);
    assert_eq!(changes(&mut signals), []);
}

#[test]
fn a_variable_hides_a_signal_and_only_a_simulator_has_a_clearance() {
    assert_eq!(Signals::new(&names()).find("stop.ready"), None);
    let expression = Expression::number("stop.ready", &names()).unwrap();
    assert_eq!(expression.inputs().collect::<Vec<_>>(), ["stop.ready"]);
    assert_eq!(
        error("clearance < 1"),
        "1: no condition or variable is called `clearance`"
    );
    assert_eq!(
        error("goon.wom"),
        "1: no variable is called `goon.wom`; did you mean `goon.won`?"
    );
    assert_eq!(
        error("overruns"),
        "1: the result is a double, not a bool: compare it with something, as in `> 0.5`"
    );
}

#[test]
fn a_condition_over_signals_needs_the_variables_behind_them() {
    let text = "goon.won and clearance < 0.2 and goon.fast > 1";
    let condition = Condition::new(text, &names()).unwrap();
    let triggers = Triggers::new(names(), vec![condition]);
    assert_eq!(
        triggers.variables(),
        BTreeSet::from(["goon.fast", "other.truth", "pioneer.truth"])
    );
}

/// Returns the times in ms at which a condition fires.
fn times(condition: &str, act: impl FnOnce(&mut Triggers, &mut Vec<Firing>)) -> Vec<u64> {
    let condition = Condition::new(condition, &names()).unwrap();
    let mut triggers = Triggers::new(names(), vec![condition]);
    let mut fired = Vec::new();
    act(&mut triggers, &mut fired);
    fired.iter().map(|firing| firing.time / 1_000_000).collect()
}

#[test]
fn an_expression_over_states_is_not_evaluated_within_an_instant() {
    let handover = |triggers: &mut Triggers, fired: &mut Vec<Firing>| {
        triggers.advance(0, fired);
        triggers.process_record(&state(1.0, "goon", "winner"), fired);
        triggers.process_record(&state(2.0, "goon", "ready"), fired);
        triggers.process_record(&state(2.0, "stop", "winner"), fired);
        triggers.process_record(&state(2.001, "stop", "checking"), fired);
        triggers.advance(2_002_000_000, fired);
    };
    assert_eq!(times("stop.won", handover), [2000]);
    assert_eq!(
        times("not goon.won and not stop.won and takeovers == 0.0", handover),
        [0, 2001],
        "at the beginning and at the end, and never during the handover"
    );
}

#[test]
fn a_signal_of_an_event_is_evaluated_at_its_instant_and_values_at_most_each_10_ms() {
    let fired = times("goon.won and clearance < 0.2", |triggers, fired| {
        let near = truth(0.1, 0);
        triggers.process_value(0, "pioneer.truth", truth(1.0, 0).as_bytes(), fired);
        triggers.process_record(&state(0.003, "goon", "winner"), fired);
        triggers.process_value(5_000_000, "pioneer.truth", near.as_bytes(), fired);
        triggers.advance(12_000_000, fired);
        triggers.advance(13_000_000, fired);
        triggers.process_record(&state(0.015, "goon", "ready"), fired);
        triggers.process_record(&state(0.016, "goon", "winner"), fired);
        triggers.advance(17_000_000, fired);
    });
    assert_eq!(fired, [13, 16]);
}

#[test]
fn an_expression_over_the_time_is_evaluated_while_the_time_advances() {
    let fired = times("time > 0.05 and time < 0.061", |triggers, fired| {
        for ms in 0..100 {
            triggers.advance(ms * 1_000_000, fired);
        }
    });
    assert_eq!(fired, [60], "at most each 10 ms");
    let fired = times("time > 0.05 and goon.fast > 1.0", |triggers, fired| {
        triggers.process_value(60_000_000, "goon.fast", 2.0_f64.as_bytes(), fired);
    });
    assert_eq!(fired, [60]);
}

#[test]
fn refused_is_a_condition_and_compared_a_signal() {
    let refusals = |triggers: &mut Triggers, fired: &mut Vec<Firing>| {
        for time in 1..5 {
            triggers.process_record(&event(f64::from(time), "refused", "goon"), fired);
        }
        triggers.advance(5_000_000_000, fired);
    };
    assert_eq!(times("refused", refusals), [1000, 2000, 3000, 4000]);
    assert_eq!(times("refused > 2", refusals), [3000]);
    assert_eq!(times("refused>=2 or not goon.won and time > 9", refusals), [2000]);
}

#[test]
fn what_counts_since_the_start_or_waits_for_an_event_is_unknown_to_who_comes_later() {
    for (text, unknown) in [
        ("goon.fast > 1.0 && faults < 1.0", Some("faults")),
        ("late_takeovers > 2.0", Some("late_takeovers")),
        ("fault:goon", Some("fault:goon")),
        ("conflict", Some("conflict")),
        ("collisions < 1.0 && goon.won", None),
        ("goon.fast > 1.0 && time > 3.0", None),
    ] {
        let condition = Condition::new(text, &names()).unwrap();
        let triggers = Triggers::new(names(), vec![condition]);
        assert_eq!(triggers.unknown_to_late(), unknown, "{text}");
    }
}
