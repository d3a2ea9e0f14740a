//! The faults of times out of range, the warnings about improbable periods, and how long values and commands are valid.

use crate::catalogue::{application, check};

/// The types of two schemas in the good application.
const ROBOT: &str = "type  = \"sim/robot\"\n";
const STOP: &str = "type      = \"stop\"\n";
/// The period of a schema in the good application.
const PERIOD: &str = r#"period      = "75ms""#;

#[test]
fn a_time_that_is_invalid_or_out_of_range_is_refused() {
    check(
        &[(PERIOD, "period = 0")],
        r#"
apps/good.toml:17:10: `period` of schema `example` is not a time above 0
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check(
        &[(PERIOD, "period = -0.1")],
        r#"
apps/good.toml:17:10: `period` of schema `example` is not a time above 0
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check(
        &[(PERIOD, r#"period = "50us""#)],
        r#"
apps/good.toml:17:10: `period` of schema `example` is shorter than 100 us
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check(
        &[(PERIOD, "period = 75_000_000")],
        r#"
apps/good.toml:17:10: `period` of schema `example` is longer than a day
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check(
        &[(PERIOD, "period = nan")],
        r#"
apps/good.toml:17:10: `period` of schema `example` is not a time above 0
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check(
        &[(PERIOD, r#"period = "75 mm""#)],
        r#"
apps/good.toml:17:10: `period` of schema `example` must be a time, and `mm` is no unit of time
    help: write a time such as "75ms", a frequency such as "10 Hz", or a number of seconds
"#,
    );
    check(
        &[(PERIOD, r#"period = "75 milli""#)],
        r#"
apps/good.toml:17:10: `period` of schema `example` is `75 milli`, and `milli` is no unit of time
    help: write a time such as "75ms", a frequency such as "10 Hz", or a number of seconds
"#,
    );
    check(
        &[(PERIOD, r#"period = "soon""#)],
        r#"
apps/good.toml:17:10: `period` of schema `example` is `soon`, which is not a time
    help: write a time such as "75ms", a frequency such as "10 Hz", or a number of seconds
"#,
    );
    check(
        &[(PERIOD, "period = true")],
        r#"
apps/good.toml:17:10: `period` of schema `example` must be a time such as "75ms", a frequency such as "10 Hz", or a number of seconds, not true or false
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
budget = "0s""#,
        )],
        r#"
apps/good.toml:25:10: `budget` of schema `stop` is not a time above 0
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
budget = "10 Hz""#,
        )],
        r#"
apps/good.toml:25:10: `budget` of schema `stop` must be a time, and `Hz` is no unit of time
    help: write a time such as "75ms", or a number of seconds
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
budget = "20ms"
hang = "20ms""#,
        )],
        r#"
apps/good.toml:26:8: `hang` of schema `stop` is not longer than its budget, which is 20 ms
    help: give several budgets, or leave it out for ten of them and at least a second
"#,
    );
    check(
        &[(
            r#"{ policy = "sticky", dwell = "500ms" }"#,
            r#"{ patience = 0, budget = "1us" }"#,
        )],
        r#"
apps/good.toml:21:28: `patience` of group `base` of schema `example` is not a time above 0
    help: give a time from 100 us to a day; a bare number counts seconds
apps/good.toml:21:40: `budget` of group `base` of schema `example` is shorter than 100 us
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
}

#[test]
fn a_period_far_from_that_of_the_type_causes_a_warning_with_the_probable_one() {
    let warnings = |period: &str| application(&[(PERIOD, period)]).warnings();
    for (period, warning) in [
        (
            "period = 75",
            "75 s, and 100 ms in its type; if 75 ms is meant, write period = \"75 ms\"",
        ),
        (
            "period = \"0.1ms\"",
            "100 µs, and 100 ms in its type; if 100 ms is meant, write period = \"100 ms\"",
        ),
        ("period = 10", "10 s, and 100 ms in its type"),
        ("period = 3600", "3600 s, and 100 ms in its type"),
    ] {
        let expected = format!("line 15: `period` of schema `example` is {warning}");
        assert_eq!(warnings(period), [expected]);
    }
    assert!(warnings("period = 5").is_empty() && warnings("period = \"2ms\"").is_empty());
}

#[test]
fn r19_a_value_is_valid_for_three_periods_of_the_file_at_least_60_ms() {
    let validity = |period: &str| {
        let application = application(&[(ROBOT, &format!("{ROBOT}{period}"))]);
        let robot = &application.instances[application.instance("pioneer").expect("an instance")];
        let laser = robot.schema.ports.iter().position(|port| port.name == "laser");
        robot.validity_ns(laser.expect("an export"))
    };
    assert_eq!(validity("period = \"200ms\"\n"), 600_000_000);
    assert_eq!(validity("period = \"1ms\"\n"), 60_000_000);
}

#[test]
fn r7_a_command_that_outlasts_what_its_driver_states_causes_a_warning() {
    let warnings =
        |period: &str| application(&[(STOP, &format!("{STOP}period = \"{period}\"\n"))]).warnings();
    assert_eq!(
        warnings("250ms"),
        [""; 0],
        "two periods are what the driver states"
    );
    let found = warnings("1s");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].contains(
            "a command of schema `stop` to `pioneer.velocity` is in force for 2 s, two of its periods, and for 500 ms by its driver"
        ),
        "{found:?}"
    );
}
