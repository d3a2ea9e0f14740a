//! Tests of valid and invalid conditions, and of the times at which they fire.

mod expressions;
mod signals;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_core::{Case, State};
use jde_records::event::StateChange;
use jde_records::wire::{EventMessage, state_named};
use jde_records::{DecidedBy, Decision, RunRecord};
use jde_types::{Flag, LaserScan, Mission, Odometry, Seq, Text, Value};

use super::*;

fn names() -> Names {
    let variable = |name: &str, value_type| (name.to_owned(), Arc::new(value_type));
    Names {
        schemas: vec!["goon".to_owned(), "stop".to_owned()],
        groups: vec!["roots".to_owned(), "example/base".to_owned()],
        variables: BTreeMap::from([
            variable("pioneer.laser", LaserScan::describe()),
            variable("pioneer.odometry", Odometry::describe()),
            variable("pioneer.stalled", Flag::describe()),
            variable("goon.fast", f64::describe()),
            variable("goon.count", u32::describe()),
            variable("guide.mission", Mission::describe()),
            variable("left-eye.laser", LaserScan::describe()),
            variable("robot2:pioneer.odometry", Odometry::describe()),
        ]),
        seed: Some(7),
    }
}

fn triggers(conditions: &[&str]) -> Triggers {
    let conditions = conditions
        .iter()
        .map(|text| Condition::new(text, &names()).unwrap())
        .collect();
    Triggers::new(names(), conditions)
}

/// Returns the indices of the values at which a condition fires, while a value arrives every 20 ms.
fn fires<T: Value>(condition: &str, variable: &str, values: &[T]) -> Vec<usize> {
    let mut triggers = triggers(&[condition]);
    let mut fired = Vec::new();
    for (index, value) in values.iter().enumerate() {
        triggers.process_value(index as u64 * 20_000_000, variable, value.as_bytes(), &mut fired);
    }
    assert!(fired.iter().all(|firing| firing.text == condition));
    fired
        .iter()
        .map(|firing| (firing.time / 20_000_000) as usize)
        .collect()
}

/// Returns the message about an invalid condition.
fn error(condition: &str) -> String {
    let invalid = Condition::new(condition, &names()).unwrap_err();
    assert_eq!(invalid.condition, condition);
    format!("{}: {}", invalid.column, invalid.reason)
}

fn scan(ranges: &[f32]) -> LaserScan {
    LaserScan {
        ranges: Seq::from_slice(ranges).unwrap(),
        ..LaserScan::default()
    }
}

fn drive(speed: f64) -> Odometry {
    let mut odometry = Odometry::default();
    odometry.twist.twist.linear.x = speed;
    odometry
}

#[test]
fn an_expression_fires_when_it_goes_from_false_to_true() {
    let speeds = [0.1, 0.5, 0.6, 0.3, 0.41, f64::NAN, 0.5].map(drive);
    assert_eq!(
        fires(
            "pioneer.odometry.twist.twist.linear.x > 0.4",
            "pioneer.odometry",
            &speeds
        ),
        [1, 4, 6],
        "NaN is not greater"
    );
    let scans = [&[][..], &[1.0, 0.2], &[0.1], &[f32::INFINITY, 2.0], &[0.29]].map(scan);
    assert_eq!(
        fires("pioneer.laser.ranges.exists(r, r < 0.3)", "pioneer.laser", &scans),
        [1, 4]
    );
    assert_eq!(
        fires(
            "size(pioneer.laser.ranges) > 0 && math.least(pioneer.laser.ranges) < 0.15",
            "pioneer.laser",
            &scans
        ),
        [2]
    );
    assert_eq!(
        fires("pioneer.laser.ranges[1] < 1.0", "pioneer.laser", &scans),
        [1],
        "an index after the end makes the condition false"
    );
    assert_eq!(
        fires(
            "pioneer.laser.ranges.filter(r, r < 1.0).size() == 1",
            "pioneer.laser",
            &scans
        ),
        [1, 4],
        "the condition stays true from 0.2 to 0.1"
    );
    assert_eq!(fires("goon.fast > 1", "goon.fast", &[1.0, 1.5]), [1]);
    assert_eq!(
        fires("goon.count % 2u == 1u", "goon.count", &[1_u32, 2, 3]),
        [0, 2]
    );
    assert_eq!(
        fires(
            "pioneer.stalled",
            "pioneer.stalled",
            &[Flag::from(false), Flag::from(true)]
        ),
        [1]
    );
    let mission = |note: &str| Mission {
        note: Text::truncated(note),
        ..Mission::default()
    };
    assert_eq!(
        fires(
            "guide.mission.note.contains('stuck')",
            "guide.mission",
            &[mission("on the way"), mission("stuck in the door"),]
        ),
        [1]
    );
}

#[test]
fn names_with_special_characters_are_accepted_and_columns_are_right() {
    let far = LaserScan {
        range_max: 30.0,
        ..LaserScan::default()
    };
    assert_eq!(
        fires(
            "left-eye.laser.range_max > 8",
            "left-eye.laser",
            &[LaserScan::default(), far]
        ),
        [1]
    );
    assert_eq!(
        fires(
            "robot2:pioneer.odometry.twist.twist.linear.x > 0.4",
            "robot2:pioneer.odometry",
            &[drive(0.5)]
        ),
        [0]
    );
    assert_eq!(
        error("left-eye.laser.range_max > 3 && left-eye.laser.ranje_max > 2"),
        "47: a sensor_msgs/msg/LaserScan has no field `ranje_max`; did you mean `range_max`?"
    );
}

#[test]
fn a_missing_or_retracted_value_makes_a_condition_false() {
    let mut triggers = triggers(&["goon.fast < 1.0 || goon.count > 5u", "!(goon.fast > 1.0)"]);
    assert_eq!(triggers.variables(), BTreeSet::from(["goon.count", "goon.fast"]));
    let mut fired = Vec::new();
    triggers.process_value(0, "goon.count", &9_u32.to_ne_bytes(), &mut fired);
    assert_eq!(fired.len(), 1, "the second side of `||` has no value");
    triggers.process_value(20_000_000, "goon.fast", &0.5_f64.to_ne_bytes(), &mut fired);
    assert_eq!(fired.len(), 2);
    triggers.process_retraction(40_000_000, "goon.fast", &mut fired);
    triggers.process_value(60_000_000, "goon.fast", &0.5_f64.to_ne_bytes(), &mut fired);
    assert_eq!(fired.len(), 3, "the retraction made the condition false");
    assert_eq!(fired[2].condition, 1);
}

#[test]
fn an_expression_is_evaluated_a_hundred_times_a_second_and_postponed_values_later() {
    let mut triggers = triggers(&["goon.fast > 1.0"]);
    let mut fired = Vec::new();
    let mut value = |time: u64, value: f64, fired: &mut Vec<Firing>| {
        triggers.process_value(time, "goon.fast", &value.to_ne_bytes(), fired);
    };
    value(0, 0.0, &mut fired);
    value(1_000_000, 2.0, &mut fired);
    assert_eq!(fired, [], "too soon after the last evaluation");
    value(10_000_000, 0.0, &mut fired);
    assert_eq!(fired.len(), 1, "the postponed value is evaluated before the next");
    value(20_000_000, 0.0, &mut fired);
    value(21_000_000, 2.0, &mut fired);
    triggers.advance(29_999_999, &mut fired);
    assert_eq!(fired.len(), 1);
    triggers.advance(30_000_000, &mut fired);
    assert_eq!(
        fired.len(),
        2,
        "the postponed value is evaluated without a new one"
    );
    triggers.advance(40_000_000, &mut fired);
    assert_eq!(fired.len(), 2);
}

#[test]
fn an_invalid_condition_is_reported_with_its_column() {
    for (condition, expected) in [
        ("pioneer.laser.ranges >> 3", "23: extraneous input '>'"),
        ("(goon.fast > 1", "15: missing ')' at the end"),
        ("goon.fast > ", "13: mismatched input the end"),
        ("", "1: mismatched input the end"),
        (
            "goon.fast > 0.3 && pioneer.lasr.range_max > 1.0",
            "20: no variable is called `pioneer.lasr`; did you mean `pioneer.laser`?",
        ),
        (
            "pioneer.odometry.twist.linear.x > 0.4",
            "23: a geometry_msgs/msg/TwistWithCovariance has no field `linear`",
        ),
        (
            "pioneer.laser.range.exists(r, r < 0.3)",
            "14: a sensor_msgs/msg/LaserScan has no field `range`; did you mean `ranges`?",
        ),
        (
            "pioneer.laser.ranges.x > 1",
            "21: a list has no field `x`; choose an element, as in `[0]`, or test all of them with `exists`",
        ),
        ("goon.fast.data > 1.0", "10: a double has no fields, so no `data`"),
        (
            "goon.fast * 2 > 1.0",
            "11: `*` takes two numbers of one kind (write 2.0 for a double, 2u for a uint), not a double and an int",
        ),
        (
            "goon.fast + 1.0",
            "1: the result is a double, not a bool: compare it with something, as in `> 0.5`",
        ),
        (
            "pioneer.laser",
            "1: the result is a sensor_msgs/msg/LaserScan, not a bool: compare it with something, as in `> 0.5`",
        ),
        (
            "goon.fast > 'a'",
            "11: `>` compares numbers, or texts, not a double and a text",
        ),
        (
            "goon.fast && goon.count > 1u",
            "11: `&&` takes bools, not a double and a bool",
        ),
        (
            "pioneer.laser.ranges.exists(r, r.x < 0.3)",
            "33: a double has no fields, so no `x`",
        ),
        ("goon.fast.exists(r, r < 0.3)", "5: a double is not a list"),
        (
            "abs(goon.fast) > 1.0",
            "4: no function is called `abs`; did you mean `math.abs`?",
        ),
        (
            "math.cos(goon.fast) > 1.0",
            "9: no function is called `math.cos`; did you mean `math.abs`?",
        ),
        ("1 > 0", "1: it names no variable, so it would never change"),
        (
            "conflct",
            "1: no condition or variable is called `conflct`; did you mean `conflict`?",
        ),
        (
            "conflict:exmple/base",
            "10: no group is called `exmple/base`; did you mean `example/base`?",
        ),
        (
            "overrun: gon",
            "10: no schema is called `gon`; did you mean `goon`?",
        ),
        (
            "chatter",
            "8: write how many switches in a second are allowed, as in `chatter>5`",
        ),
        (
            "chatter>many",
            "9: the number of switches in a second must be a whole number, as in `chatter>5`",
        ),
        ("absence>3", "8: `absence` takes no number"),
        ("refused:goon", "9: `refused` takes no name"),
    ] {
        assert_eq!(error(condition), expected, "{condition}");
    }
    assert!(error(&"(".repeat(900)).contains("too many nested brackets"));
    assert!(error(&"x".repeat(2000)).contains("at most 1000"));
}

fn decision(time_s: f64, group: &str, case: &str, choice: Option<&str>, changed: bool) -> RunRecord {
    RunRecord::Decision(Decision {
        number: 1,
        time_s,
        group: group.to_owned(),
        case: Case::named(case).unwrap(),
        candidates: vec![jde_records::CandidateRecord {
            name: "goon".to_owned(),
            state: State::Ready,
            ready: true,
            urgency: None,
        }],
        before: None,
        choice: choice.map(str::to_owned),
        decider: DecidedBy::Nobody,
        reason: String::new(),
        cause: String::new(),
        changed,
        takeover_us: None,
        refused: Vec::new(),
    })
}

fn event(time_s: f64, kind: &str, schema: &str) -> RunRecord {
    let message = EventMessage {
        time_s,
        kind: kind.to_owned(),
        schema: Some(schema.to_owned()),
        text: match kind {
            "operator" => format!("ana played {schema}"),
            "late" => "took over in roots after 3.000 ms, and its contract allows 1.000 ms".to_owned(),
            _ => "why".to_owned(),
        },
        by: Some("ana".to_owned()),
        ..EventMessage::default()
    };
    RunRecord::Other(message.try_into().expect("a record"))
}

/// Returns the times and texts of the firings of a condition.
fn firings(condition: &str, records: &[RunRecord]) -> Vec<String> {
    let mut triggers = triggers(&[condition]);
    let mut fired = Vec::new();
    for record in records {
        triggers.process_record(record, &mut fired);
    }
    fired
        .iter()
        .map(|firing| format!("{} {}", firing.time as f64 / 1e9, firing.text))
        .collect()
}

#[test]
fn r3_a_conflict_and_an_absence_fire_when_they_begin() {
    let records = [
        decision(1.0, "roots", "alone", Some("goon"), true),
        decision(2.0, "example/base", "collision", Some("stop"), true),
        decision(2.1, "example/base", "collision", Some("stop"), false),
        decision(3.0, "example/base", "absence", None, true),
        decision(3.1, "example/base", "absence", Some("goon"), true),
        decision(4.0, "example/base", "collision", Some("stop"), true),
        decision(5.0, "roots", "collision", Some("goon"), false),
        RunRecord::State(StateChange {
            time: 6_000_000_000,
            schema: "goon".to_owned(),
            from: State::Ready,
            to: State::Winner,
        }),
    ];
    assert_eq!(
        firings("conflict", &records),
        [
            "2 conflict in example/base",
            "4 conflict in example/base",
            "5 conflict in roots"
        ]
    );
    assert_eq!(firings("conflict:roots", &records), ["5 conflict in roots"]);
    assert_eq!(firings("absence", &records), ["3 nobody wins in example/base"]);
    assert_eq!(firings("absence:roots", &records), Vec::<String>::new());
}

#[test]
fn chatter_fires_once_until_it_pauses() {
    let switch = |time| decision(time, "roots", "alone", Some("goon"), true);
    let stay = |time| decision(time, "roots", "alone", Some("goon"), false);
    let records = [
        switch(1.0),
        stay(1.1),
        switch(1.4),
        switch(1.8),
        switch(1.9),
        switch(2.0),
        decision(2.05, "example/base", "alone", Some("stop"), true),
        switch(9.0),
        switch(9.1),
        switch(9.2),
    ];
    assert_eq!(
        firings("chatter > 2", &records),
        [
            "1.8 chattering: 3 switches within a second in roots",
            "9.2 chattering: 3 switches within a second in roots"
        ]
    );
    assert_eq!(firings("chatter>5:roots", &records), Vec::<String>::new());
}

#[test]
fn overruns_faults_refusals_and_operator_actions_fire() {
    let records = [
        event(1.0, "overrun", "goon"),
        event(1.0, "overrun", "goon"),
        event(2.0, "ok", "goon"),
        event(3.0, "overrun", "goon"),
        event(4.0, "faulted", "stop"),
        event(5.0, "refused", "goon"),
        event(6.0, "refused", "goon"),
        event(7.0, "operator", "goon"),
        event(8.0, "ended", "goon"),
    ];
    assert_eq!(
        firings("overrun", &records),
        ["1 overrun of goon", "3 overrun of goon"]
    );
    assert_eq!(firings("overrun:stop", &records), Vec::<String>::new());
    assert_eq!(firings("fault", &records), ["4 fault of stop: why"]);
    assert_eq!(
        firings("refused", &records),
        ["5 refused to goon: why", "6 refused to goon: why"]
    );
    assert_eq!(firings("operator", &records), ["7 operator: ana acted on goon"]);
}
