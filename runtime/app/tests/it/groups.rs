//! The faults of group settings, and of actuators that two schemas could command at the same time.

use jde_app::InstancePort;
use jde_core::GroupId;

use crate::catalogue::{application, check};

/// The settings of the group of the good application.
const SETTINGS: &str = r#"{ policy = "sticky", dwell = "500ms" }"#;

#[test]
fn a_key_of_another_policy_is_refused() {
    check(
        &[(SETTINGS, r#"{ dwell = "500ms" }"#)],
        r#"
apps/good.toml:21:17: `dwell` of group `base` of schema `example` has an effect only with policy = "sticky"
    help: remove it, or write policy = "sticky"
"#,
    );
    check(
        &[(
            SETTINGS,
            r#"{ policy = "priority", hysteresis = 0.1, turn = "1s" }"#,
        )],
        r#"
apps/good.toml:21:38: `hysteresis` of group `base` of schema `example` has an effect only with policy = "sticky"
    help: remove it, or write policy = "sticky"
apps/good.toml:21:56: `turn` of group `base` of schema `example` has an effect only with policy = "round-robin"
    help: remove it, or write policy = "round-robin"
"#,
    );
    check(
        &[(
            SETTINGS,
            r#"{ absence = "brake", hold = "1s", fallback = "brake" }"#,
        )],
        r#"
apps/good.toml:21:36: `hold` of group `base` of schema `example` has an effect only with absence = "hold"
    help: remove it, or write absence = "hold"
apps/good.toml:21:49: `fallback` of group `base` of schema `example` has an effect only with absence = "fallback"
    help: remove it, or write absence = "fallback"
"#,
    );
}

#[test]
fn a_policy_without_its_required_key_is_refused() {
    check(
        &[(SETTINGS, r#"{ policy = "sticky" }"#)],
        r#"
apps/good.toml:21:26: `policy` of group `base` of schema `example` is "sticky", which requires `dwell`
    help: add dwell = "500ms"
"#,
    );
    check(
        &[(SETTINGS, r#"{ policy = "round-robin" }"#)],
        r#"
apps/good.toml:21:26: `policy` of group `base` of schema `example` is "round-robin", which requires `turn`
    help: add turn = "5s"
"#,
    );
    check(
        &[(SETTINGS, r#"{ absence = "hold" }"#)],
        r#"
apps/good.toml:21:27: `absence` of group `base` of schema `example` is "hold", which requires `hold`
    help: add hold = "300ms"
"#,
    );
    check(
        &[(SETTINGS, r#"{ absence = "fallback" }"#)],
        r#"
apps/good.toml:21:27: `absence` of group `base` of schema `example` is "fallback", which requires `fallback`
    help: add fallback = "brake"
"#,
    );
}

#[test]
fn an_unknown_policy_is_reported_with_the_nearest_name() {
    check(
        &[(SETTINGS, r#"{ policy = "stiky" }"#)],
        r#"
apps/good.toml:21:26: group `base` of schema `example` has no policy `stiky`
    help: did you mean `sticky`?
"#,
    );
    check(
        &[(SETTINGS, r#"{ absence = "break" }"#)],
        r#"
apps/good.toml:21:27: group `base` of schema `example` has no absence policy `break`
    help: absence policies: `brake`, `hold` and `fallback`
"#,
    );
    check(
        &[(SETTINGS, "{ policy = 3 }")],
        r#"
apps/good.toml:21:26: `policy` of group `base` of schema `example` must be a text, not a whole number
"#,
    );
}

#[test]
fn r9_a_fallback_must_be_a_member_of_the_group() {
    check(
        &[(SETTINGS, r#"{ absence = "fallback", fallback = "cruse" }"#)],
        r#"
apps/good.toml:21:50: `fallback` of group `base` of schema `example` is `cruse`, which is not a member of the group
    help: did you mean `cruise`?
"#,
    );
    check(
        &[(SETTINGS, r#"{ absence = "fallback", fallback = "lookout" }"#)],
        r#"
apps/good.toml:21:50: `fallback` of group `base` of schema `example` is `lookout`, which is not a member of the group
    help: roles of this group: `brake`, `avoid` and `cruise`
"#,
    );
    check(
        &[(
            r#"roots   = ["teleop", "example"]"#,
            r#"roots   = ["teleop", "example"]
root = { absence = "fallback", fallback = "stop" }"#,
        )],
        r#"
apps/good.toml:4:43: `fallback` of `root` is `stop`, which is not a member of the group
    help: schemas in `roots`: `teleop` and `example`
"#,
    );
}

#[test]
fn a_hysteresis_must_be_a_finite_number() {
    check(
        &[(
            SETTINGS,
            r#"{ policy = "sticky", dwell = "1s", hysteresis = -1 }"#,
        )],
        r#"
apps/good.toml:21:63: `hysteresis` of group `base` of schema `example` is not a finite number of 0 or more
    help: give the urgency by which a rival must exceed the winner
"#,
    );
    check(
        &[(
            SETTINGS,
            r#"{ policy = "sticky", dwell = "1s", hysteresis = nan }"#,
        )],
        r#"
apps/good.toml:21:63: `hysteresis` of group `base` of schema `example` is not a finite number of 0 or more
    help: give the urgency by which a rival must exceed the winner
"#,
    );
    check(
        &[(
            SETTINGS,
            r#"{ policy = "sticky", dwell = "1s", hysteresis = "much" }"#,
        )],
        r#"
apps/good.toml:21:63: `hysteresis` of group `base` of schema `example` must be a number, 0 or more, not a text
"#,
    );
}

#[test]
fn r4_the_policy_father_requires_a_father_with_an_arbitration() {
    check(
        &[(SETTINGS, r#"{ policy = "father" }"#)],
        r#"
apps/good.toml:21:26: `policy` of group `base` of schema `example` is "father", and the group has no father with an arbitration
    help: choose `priority`, `urgency`, `sticky` or `round-robin`
"#,
    );
    check(
        &[(
            r#"roots   = ["teleop", "example"]"#,
            r#"roots   = ["teleop", "example"]
root.policy = "father""#,
        )],
        r#"
apps/good.toml:4:15: `policy` of `root` is "father", and the group has no father with an arbitration
    help: choose `priority`, `urgency`, `sticky` or `round-robin`
"#,
    );
}

#[test]
fn r7_members_of_different_groups_must_not_share_an_actuator() {
    check(
        &[(
            r#"{ brake = "stop", avoid = "vff", cruise = "goon", lookout = "look" }"#,
            r#"{ brake = "stop", avoid = "vff", gaze = "goon", lookout = "look" }"#,
        )],
        r#"
apps/good.toml:36:22: `stop` and `goon` could command `pioneer.velocity` at the same time: the groups `example/base` and `example/head` have a winner each
    help: bind the command in only one of them, or let them compete in one group
"#,
    );
}

#[test]
fn r7_a_father_and_its_child_must_not_share_an_actuator() {
    check(
        &[(
            r#"period      = "75ms""#,
            r#"actuators = { base = "pioneer.velocity" }"#,
        )],
        r#"
apps/good.toml:26:22: `example` and `stop` could command `pioneer.velocity` at the same time: `example` is above the other
    help: bind the command in only one of them, or let them compete in one group
apps/good.toml:31:22: `example` and `vff` could command `pioneer.velocity` at the same time: `example` is above the other
    help: bind the command in only one of them, or let them compete in one group
apps/good.toml:36:22: `example` and `goon` could command `pioneer.velocity` at the same time: `example` is above the other
    help: bind the command in only one of them, or let them compete in one group
"#,
    );
}

#[test]
fn r7_one_schema_must_not_command_an_actuator_twice() {
    check(
        &[(
            r#"type      = "teleop"
actuators = { base = "pioneer.velocity" }"#,
            r#"type = "twin"
actuators = { base = "pioneer.velocity", spare = "pioneer.velocity" }"#,
        )],
        r#"
apps/good.toml:13:50: `teleop` commands `pioneer.velocity` by two of its actuators
    help: bind each of its actuators to a different command
"#,
    );
}

/// A guard, before another schema of the good application.
const NEAR: (&str, &str) = (
    "[schemas.look]\n",
    "[schemas.near]\ntype = \"near\"\nimports = { laser = \"pioneer.laser\" }\n\n[schemas.look]\n",
);

#[test]
fn r18_a_guard_judges_the_commands_of_its_group_and_below_and_is_awake_with_them() {
    let application = application(&[
        NEAR,
        (
            "[schemas.pioneer]",
            "root = { guard = \"near\", retry = \"1s\" }\n\n[schemas.pioneer]",
        ),
    ]);
    let number = |name| application.instance(name).expect("a schema");
    let command = InstancePort {
        instance: number("pioneer"),
        port: 4,
    };
    let spec = application.spec();
    for name in ["teleop", "goon", "stop"] {
        assert_eq!(
            application.guards(number(name), command),
            [number("near")],
            "{name}"
        );
        assert!(
            spec.schemas[number(name)].needs.contains(&number("near")),
            "{name}"
        );
    }
    assert_eq!(spec.groups[GroupId(0)].retry, 1_000_000_000);
}

#[test]
fn r18_a_guard_must_exist_and_judge() {
    check(
        &[(SETTINGS, "{ guard = \"nera\" }"), NEAR],
        r#"
apps/good.toml:21:25: `guard` of group `base` of schema `example` names `nera`, and there is no such schema
    help: did you mean `near`?
"#,
    );
    check(
        &[(SETTINGS, "{ guard = \"look\" }"), NEAR],
        r#"
apps/good.toml:21:25: `guard` of group `base` of schema `example` is `look`, whose type `look` judges no commands
    help: name a guard: near
"#,
    );
    check(
        &[(SETTINGS, "{ guard = \"look\" }")],
        r#"
apps/good.toml:21:25: `guard` of group `base` of schema `example` is `look`, whose type `look` judges no commands
    help: add a schema whose type is a guard, such as "guard/footprint", and name it
"#,
    );
}

#[test]
fn r18_a_guard_runs_in_the_host() {
    let isolated = ("type = \"near\"\n", "type = \"near\"\nisolate = \"process\"\n");
    check(
        &[(SETTINGS, "{ guard = \"near\" }"), NEAR, isolated],
        r#"
apps/good.toml:40:1: schema `near` is a guard, and its judgement runs in the host
    help: remove `isolate`; the schemas that it guards may be isolated
"#,
    );
}

#[test]
fn r18_a_guard_judges_the_commands_of_one_actuator() {
    let second = (
        "[schemas.stop]\ntype      = \"stop\"\nimports   = { laser = \"pioneer.laser\" }\nactuators = { base = \"pioneer.velocity\" }",
        "[schemas.other]\ntype = \"sim/robot\"\nworld = \"office.toml\"\n\n[schemas.stop]\ntype      = \"stop\"\nimports   = { laser = \"pioneer.laser\" }\nactuators = { base = \"other.velocity\" }",
    );
    check(
        &[(SETTINGS, "{ guard = \"near\" }"), second, NEAR],
        r#"
apps/good.toml:42:10: the group `example/base` has the guard `near`, which judges geometry_msgs/msg/Twist, and schemas of the group command `pioneer.velocity` and `other.velocity`
    help: name the guard in the group whose schemas command one robot
"#,
    );
}
