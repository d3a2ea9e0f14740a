//! The faults of values that do not fit their ports, in files and in options.

use jde_app::Application;

use crate::catalogue::{application, application_with, check, check_with, faults};

#[test]
fn a_value_of_another_type_is_reported_with_the_expected_one() {
    check(
        &[(r#"world = "office.toml""#, "world = 3")],
        r#"
apps/good.toml:8:9: `world` of schema `pioneer` must be a text, not a whole number
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "quiet = 1")],
        r#"
apps/good.toml:8:9: `quiet` of schema `pioneer` must be true or false, not a whole number
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "noise = true")],
        r#"
apps/good.toml:8:9: `noise` of schema `pioneer` must be a number, not true or false
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "beams = 3.5")],
        r#"
apps/good.toml:8:9: `beams` of schema `pioneer` must be a whole number, not a number
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "beams = 256")],
        r#"
apps/good.toml:8:9: `beams` of schema `pioneer` is not a whole number from 0 to 255
"#,
    );
    check(
        &[(r#"world = "office.toml""#, r#"beams = "-1""#)],
        r#"
apps/good.toml:8:9: `beams` of schema `pioneer` is not a whole number from 0 to 255
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "weights = 3")],
        r#"
apps/good.toml:8:11: `weights` of schema `pioneer` must be a list, not a whole number
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "weights = [1, 2, 3, 4]")],
        r#"
apps/good.toml:8:11: `weights` of schema `pioneer` has 4 values, and at most 3 fit
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "places = [1, 2]")],
        r#"
apps/good.toml:8:10: `places` of schema `pioneer` must be a list of lists
    help: each value is a list itself: [[x, y, theta]]
"#,
    );
    check(
        &[(r#"world = "office.toml""#, r#"weights = [1, "two"]"#)],
        r#"
apps/good.toml:8:15: `weights[1]` of schema `pioneer` must be a number in m, not the text `two`
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "weights = [1e39]")],
        r#"
apps/good.toml:8:12: `weights[0]` of schema `pioneer` is beyond what a float32 holds
"#,
    );
    check(
        &[(r#"[1.0, 2.0, "90deg"]"#, "[1.0, 2.0]")],
        r#"
apps/good.toml:9:9: `start` of schema `pioneer` has 2 values, and 3 of them are expected: x, y, theta
"#,
    );
    check(
        &[(r#"[1.0, 2.0, "90deg"]"#, r#""here""#)],
        r#"
apps/good.toml:9:9: `start` of schema `pioneer` must be a table or a list of x, y, theta, not a text
"#,
    );
    check(
        &[(r#"[1.0, 2.0, "90deg"]"#, "{ x = 1, tehta = 2 }")],
        r#"
apps/good.toml:9:18: `start` of schema `pioneer` has no field `tehta`
    help: did you mean `theta`?
"#,
    );
}

#[test]
fn a_unit_that_does_not_fit_is_reported_with_the_expected_one() {
    check(
        &[(r#""400 mm/s""#, r#""400 mm""#)],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` must be a number in m/s, and `mm` does not convert to that
"#,
    );
    check(
        &[(r#""400 mm/s""#, r#""400 parsec/s""#)],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` must be a number in m/s, and `parsec/s` is no known unit
"#,
    );
    check(
        &[(r#""400 mm/s""#, r#""fast""#)],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` must be a number in m/s, not the text `fast`
"#,
    );
    check(
        &[(r#""90deg""#, r#""90 cm""#)],
        r#"
apps/good.toml:9:20: `start.theta` of schema `pioneer` must be a number in rad, and `cm` does not convert to that
"#,
    );
    check(
        &[(r#"world = "office.toml""#, r#"noise = "3 m""#)],
        r#"
apps/good.toml:8:9: `noise` of schema `pioneer` must be a number, and `m` does not convert to that
"#,
    );
}

#[test]
fn a_number_out_of_range_is_reported_with_the_bound() {
    check(
        &[(r#""400 mm/s""#, "7")],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` is 7 m/s, and at most 1.2 m/s is allowed
"#,
    );
    check(
        &[(r#""400 mm/s""#, r#""-1 cm/s""#)],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` is -0.01 m/s, and at least 0 m/s is allowed
"#,
    );
    check(
        &[(r#"world = "office.toml""#, "noise = 1.5")],
        r#"
apps/good.toml:8:9: `noise` of schema `pioneer` is 1.5, and at most 1 is allowed
"#,
    );
}

#[test]
fn a_number_that_is_not_finite_is_refused() {
    check(
        &[(r#""400 mm/s""#, "inf")],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` is not a finite number
"#,
    );
    check(
        &[(r#""400 mm/s""#, "nan")],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` is not a finite number
"#,
    );
    check(
        &[(r#""400 mm/s""#, r#""1e999 m/s""#)],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` is not a finite number
"#,
    );
    check(
        &[(r#"[1.0, 2.0, "90deg"]"#, "[1.0, -inf, 0]")],
        r#"
apps/good.toml:9:15: `start.y` of schema `pioneer` is not a finite number
"#,
    );
}

#[test]
fn a_text_that_is_too_long_is_reported_with_the_limit() {
    check(
        &[(
            r#"world = "office.toml""#,
            r#"label = "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx""#,
        )],
        r#"
apps/good.toml:8:9: `label` of schema `pioneer` has 65 bytes, and at most 64 fit
"#,
    );
}

#[test]
fn a_former_name_is_read_with_a_warning() {
    let former = application(&[("speed     = ", "pace      = ")]);
    let present = application(&[]);
    let goon = |application: &Application| {
        let number = application.instance("goon").expect("it has a goon");
        application.instances[number].bindings.clone()
    };
    assert_eq!(goon(&former), goon(&present));
    assert!(present.concerns.is_none(), "the present name needs no warning");
    let warning =
        "`pace` of schema `goon` is now called `speed`; the next version does not read the former name";
    let warnings = |application: Application| application.concerns.map(|concerns| concerns.to_string());
    let place = warnings(former).expect("there is a warning");
    assert!(
        place.starts_with("apps/good.toml:") && place.ends_with(warning),
        "{place}"
    );
    let option = application_with(&[], &["goon.pace=1"]);
    assert_ne!(goon(&option), goon(&present));
    assert_eq!(warnings(option), Some(format!("--set goon.pace=1: {warning}")));
    let twice = faults(&[("speed     = ", "pace = 0.4\nspeed     = ")]);
    assert!(
        twice.contains("`speed` of schema `goon` is stated twice"),
        "{twice}"
    );
}

#[test]
fn a_fault_of_an_option_has_the_option_as_its_location() {
    check_with(
        &[],
        &["goon.sped=1"],
        r#"
--set goon.sped=1: schema `goon` has no modulation `sped`
    help: did you mean `speed`?
"#,
    );
    check_with(
        &[],
        &["gon.speed=1"],
        r#"
--set gon.speed=1: the option names `gon`, and there is no such schema
    help: did you mean `goon`?
"#,
    );
    check_with(
        &[],
        &["goon.speed=7"],
        r#"
--set goon.speed=7: `speed` of schema `goon` is 7 m/s, and at most 1.2 m/s is allowed
"#,
    );
    check_with(
        &[],
        &["goon.speed=1 m"],
        r#"
--set goon.speed=1 m: `speed` of schema `goon` must be a number in m/s, and `m` does not convert to that
"#,
    );
    check_with(
        &[],
        &["goon.speed=[7"],
        r#"
--set goon.speed=[7: `[7` is no TOML: unclosed array, expected `]`
    help: write a list as [1, 2] and a table as {x = 1, y = 2}, each bracket closed
"#,
    );
    check_with(
        &[],
        &["goon.period=never"],
        r#"
--set goon.period=never: `period` of schema `goon` is `never`, which is not a time
    help: write a time such as "75ms", a frequency such as "10 Hz", or a number of seconds
"#,
    );
    check_with(
        &[],
        &["goon.period=0"],
        r#"
--set goon.period=0: `period` of schema `goon` is not a time above 0
    help: give a time from 100 us to a day; a bare number counts seconds
"#,
    );
    check_with(
        &[],
        &["goon.budget=1"],
        r#"
--set goon.budget=1: schema `goon` has no modulation `budget`
    help: modulations: `speed`, `period` and `type`
"#,
    );
    check_with(
        &[],
        &["stop.laser=pioneer.laser"],
        r#"
--set stop.laser=pioneer.laser: schema `stop` has no modulation `laser`
    help: modulations: `period` and `type`
"#,
    );
    check_with(
        &[(r#""400 mm/s""#, "9")],
        &["goon.speed=0.3"],
        r#"
apps/good.toml:35:13: `speed` of schema `goon` is 9 m/s, and at most 1.2 m/s is allowed
"#,
    );
}

#[test]
fn an_option_may_replace_the_type_of_a_schema() {
    let of = |option: &str| {
        let application = application_with(&[], &[option]);
        let vff = application.instance("vff").expect("it has a schema `vff`");
        application.plugins[application.instances[vff].plugin]
            .name
            .clone()
    };
    assert_eq!(of("vff.period=1s"), "nav");
    assert_eq!(of("vff.type=stop"), "stop");
    // As an experiment writes it.
    assert_eq!(of("vff.type=\"stop\""), "stop");
    check_with(
        &[(r#"type      = "nav/vff""#, r#"type      = "nav/unknown""#)],
        &["vff.type=stop"],
        "no fault",
    );
}

#[test]
fn a_wrong_type_of_an_option_has_the_option_as_its_location() {
    check_with(
        &[],
        &["vff.type=stpo"],
        r#"
--set vff.type=stpo: schema `vff`: plugin `stpo` cannot be used: no folder has it
    help: did you mean `stop`?
"#,
    );
    // What the file says of a schema of another type is a fault of the file.
    check_with(
        &[],
        &["goon.type=stop"],
        r#"
apps/good.toml:20:57: `speed` that schema `example` writes to `cruise` is a modulation, and `goon` has none of that name
apps/good.toml:33:10: schema `goon` leaves `laser` of its imports unbound; it takes `sensor_msgs/msg/LaserScan`
    help: add imports.laser = "pioneer.laser"
apps/good.toml:35:1: unknown key `speed` in schema `goon`
    help: keys: `type`, `period`, `budget`, `hang`, `imports`, `actuators`, `children`, `groups`, `triggers`, `restart`, `isolate` and `doc`
"#,
    );
}
