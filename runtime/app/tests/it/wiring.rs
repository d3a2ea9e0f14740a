//! The faults of variables that are unknown, missing or of another type.

use jde_app::Binding;

use crate::catalogue::{self, check};

/// The roots of the good application.
const ROOTS: &str = r#"roots   = ["teleop", "example"]"#;

#[test]
fn an_unknown_name_is_reported_with_the_nearest() {
    check(
        &[
            (ROOTS, r#"roots = ["teleop", "exampel"]"#),
            (r#""example.mission""#, r#""exmple.mission""#),
        ],
        r#"
apps/good.toml:3:20: `roots` of the application names `exampel`, and there is no such schema
    help: did you mean `example`?
apps/good.toml:4:11: `mission` of the application names `exmple`, and there is no such schema
    help: did you mean `example`?
"#,
    );
    check(
        &[(r#""example.mission""#, r#""example.mision""#)],
        r#"
apps/good.toml:4:11: `mission` of the application: `example` has no `mision`
    help: did you mean `mission`?
"#,
    );
    check(
        &[(r#"heading = "pioneer.heading""#, r#"heading = "pionee.heading""#)],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` names `pionee`, and there is no such schema
    help: did you mean `pioneer`?
"#,
    );
    check(
        &[(r#"heading = "pioneer.heading""#, r#"heading = "pioneer.headng""#)],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example`: `pioneer` has no `headng`
    help: did you mean `heading`?
"#,
    );
    check(
        &[(r#"heading = "pioneer.heading""#, r#"heading = "pioneer""#)],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` names `pioneer`, and no variable of it
    help: write "pioneer.heading"
"#,
    );
    check(
        &[(r#"heading = "pioneer.heading""#, r#"heading = "stop""#)],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` names `stop`, and no variable of it
    help: exports and modulations of `stop`: none
"#,
    );
    check(
        &[(
            r#"heading = "pioneer.heading""#,
            r#"heading = "pioneer.velocity""#,
        )],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` is `pioneer.velocity`, which is a command
    help: exports of `pioneer`: `laser`, `odometry`, `heading` and `travelled`
"#,
    );
    check(
        &[
            (
                r#"{ brake = "stop", avoid = "vff", cruise = "goon", lookout = "look" }"#,
                r#"{ brake = "stop", avoid = "vff", cruise = "gon", lookout = "look" }"#,
            ),
            (r#"roots   = ["teleop", "#, r#"roots   = ["goon", "#),
        ],
        r#"
apps/good.toml:20:57: `cruise` in `children` of schema `example` names `gon`, and there is no such schema
    help: did you mean `goon`?
"#,
    );
    check(
        &[(
            r#"[schemas.teleop]
type      = "teleop"
actuators = { base = "pioneer.velocity" }"#,
            r#"[schemas.teleop]
type      = "teleop"
actuators = { base = "pioneer.laser" }"#,
        )],
        r#"
apps/good.toml:13:22: `base` in `actuators` of schema `teleop` is `pioneer.laser`, which is an export
    help: commands of `pioneer`: `velocity`
"#,
    );
    check(
        &[(r#"["laser"]"#, r#"["lasr"]"#)],
        r#"
apps/good.toml:19:16: `triggers` of schema `example` names `lasr`, which is not an import of it
    help: did you mean `laser`?
"#,
    );
}

#[test]
fn a_variable_of_another_type_or_unit_is_reported_with_both() {
    check(
        &[(
            r#"heading = "pioneer.heading""#,
            r#"heading = "pioneer.odometry""#,
        )],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` is `std_msgs/msg/Float64`, and `pioneer.odometry` is `nav_msgs/msg/Odometry`
    help: these fit: `pioneer.heading`, `goon.heading` and `look.heading`
"#,
    );
    check(
        &[(
            r#"heading = "pioneer.heading""#,
            r#"heading = "pioneer.travelled""#,
        )],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` is in `rad`, and `pioneer.travelled` is in `m`
    help: these fit: `pioneer.heading`, `goon.heading` and `look.heading`
"#,
    );
    check(
        &[(r#"heading = "pioneer.heading""#, r#"heading = "pioneer.noise""#)],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` is in `rad`, and `pioneer.noise` has no unit
    help: these fit: `pioneer.heading`, `goon.heading` and `look.heading`
"#,
    );
    check(
        &[(r#""example.mission""#, r#""pioneer.laser""#)],
        r#"
apps/good.toml:4:11: `mission` of the application takes `jde_msgs/msg/Mission`, and `pioneer.laser` is `sensor_msgs/msg/LaserScan`
    help: name the export that states whether the mission is done
"#,
    );
    check(
        &[(
            r#""example.mission""#,
            r#"{ form = "example.mission", stalls = "soon" }"#,
        )],
        r#"
apps/good.toml:4:1: `mission` does not name an export
    help: add from = "SCHEMA.mission"
apps/good.toml:4:13: unknown key `form` in `mission`
    help: did you mean `from`?
apps/good.toml:4:48: `stalls` of `mission` is `soon`, which is not a time
    help: write a time such as "75ms", or a number of seconds
"#,
    );
    check(
        &[(r#""example.mission""#, r#""goon.speed""#)],
        r#"
apps/good.toml:4:11: `mission` of the application is `goon.speed`, which is a modulation
    help: exports of `goon`: `heading`
"#,
    );
}

#[test]
fn an_unbound_required_port_is_reported_with_a_candidate() {
    check(
        &[(r#", heading = "pioneer.heading""#, "")],
        r#"
apps/good.toml:18:1: schema `example` leaves `heading` of its imports unbound; it takes `std_msgs/msg/Float64`
    help: add imports.heading = "pioneer.heading"
"#,
    );
    check(
        &[(
            r#"type    = "look"
imports = { laser = "pioneer.laser" }
"#,
            r#"type    = "look"
"#,
        )],
        r#"
apps/good.toml:38:10: schema `look` leaves `laser` of its imports unbound; it takes `sensor_msgs/msg/LaserScan`
    help: add imports.laser = "pioneer.laser"
"#,
    );
    check(
        &[(
            r#"speed     = "400 mm/s"
actuators = { base = "pioneer.velocity" }
"#,
            "",
        )],
        r#"
apps/good.toml:33:10: schema `goon` leaves `base` of its actuators unbound; it takes `geometry_msgs/msg/Twist`
    help: add actuators.base = "pioneer.velocity"
"#,
    );
    check(
        &[
            (r#"brake = "stop", "#, ""),
            (ROOTS, r#"roots = ["teleop", "example", "stop"]"#),
        ],
        r#"
apps/good.toml:20:1: schema `example` has no child in its role `brake`
    help: add children.brake = "NAME", naming a motor schema
"#,
    );
}

#[test]
fn a_trigger_must_be_a_bound_import() {
    check(
        &[(
            r#"type      = "teleop""#,
            r#"type = "teleop"
triggers = ["laser"]"#,
        )],
        r#"
apps/good.toml:13:13: `triggers` of schema `teleop` names `laser`, which is not bound
    help: bind it in `imports`, or remove it from `triggers`
"#,
    );
}

#[test]
fn a_child_without_the_modulation_that_its_father_writes_is_refused() {
    check(
        &[(
            r#"{ brake = "stop", avoid = "vff", cruise = "goon", lookout = "look" }"#,
            r#"{ brake = "stop", avoid = "goon", cruise = "vff", lookout = "look" }"#,
        )],
        r#"
apps/good.toml:20:58: `speed` that schema `example` writes to `cruise` is a modulation, and `vff` has none of that name
"#,
    );
}

#[test]
fn r12_a_schema_that_would_trigger_itself_is_refused() {
    let bound = |from: &str| {
        (
            r#"imports = { laser = "pioneer.laser" }
"#,
            format!("imports = {{ laser = \"pioneer.laser\", bearing = \"{from}\" }}\n"),
        )
    };
    let edit = |from| {
        let (old, new) = bound(from);
        (
            format!("[schemas.look]\ntype    = \"look\"\n{old}"),
            format!("[schemas.look]\ntype = \"look\"\n{new}"),
        )
    };
    let (old, new) = edit("look.heading");
    check(
        &[(&old, &new)],
        r#"
apps/good.toml:40:48: schema `look` would trigger itself without end: `bearing` is its own export, and triggers it
    help: bind it to another schema's export, or leave it out of `triggers`
"#,
    );
    // A schema may import its own export without a trigger. A modulation may trigger it, because other schemas
    // write the modulation.
    for accepted in [new.clone() + "triggers = []\n", edit("look.tilt").1] {
        catalogue::application(&[(&old, &accepted)]);
    }
    let text = edit("pioneer.heading").1 + "triggers = [\"laser\"]\n";
    let application = catalogue::application(&[(&old, &text)]);
    let look = application
        .instance("look")
        .map(|index| &application.instances[index]);
    let triggers: Vec<bool> = look.map_or(Vec::new(), |look| {
        look.bindings
            .iter()
            .filter_map(|binding| match binding {
                Binding::Import { trigger, .. } => Some(*trigger),
                _ => None,
            })
            .collect()
    });
    assert_eq!(triggers, [true, false], "a perceptive schema has triggers, too");
}

#[test]
fn r12_schemas_that_trigger_each_other_through_a_motor_schema_cause_a_warning() {
    let warnings = |triggers: &str| {
        catalogue::application(&[
            ("type      = \"nav/goon\"\n", "type = \"nav/goon\"\nimports = { near = \"look.heading\" }\n"),
            (
                "type    = \"look\"\nimports = { laser = \"pioneer.laser\" }\n",
                &format!(
                    "type = \"look\"\nimports = {{ laser = \"pioneer.laser\", bearing = \"goon.heading\" }}\n{triggers}"
                ),
            ),
        ])
        .warnings()
    };
    let expected = "line 33: these schemas trigger each other: goon -> look -> goon. If each exports in its check, they check \
                    without end, for up to half of the time. Leave one of these imports out of `triggers`";
    assert_eq!(warnings(""), [expected]);
    assert_eq!(warnings("triggers = []\n"), [""; 0]);
}

#[test]
fn r6_perceptive_schemas_that_need_each_other_are_refused() {
    check(
        &[(
            r#"type    = "look"
imports = { laser = "pioneer.laser" }
"#,
            r#"type = "look"
imports = { laser = "pioneer.laser", bearing = "peer.heading" }
[schemas.peer]
type = "look"
imports = { laser = "pioneer.laser", bearing = "look.heading" }
"#,
        )],
        r#"
apps/good.toml:43:48: these schemas would keep each other awake for ever: look -> peer -> look
    help: break the cycle: let one of them read another variable, or none; of a driver, a second one can take what they export
"#,
    );
}

#[test]
fn a_type_of_the_same_name_and_another_layout_is_refused() {
    check(
        &[
            (
                "[schemas.stop]",
                r#"[schemas.odd]
type = "odd"
[schemas.stop]"#,
            ),
            (
                r#"type    = "look"
imports = { laser = "pioneer.laser" }"#,
                r#"type    = "look"
imports = { laser = "odd.laser" }"#,
            ),
        ],
        r#"
apps/good.toml:42:21: `laser` in `imports` of schema `look`: `odd.laser` is `sensor_msgs/msg/LaserScan` too, but of another layout: it has 8 bytes here and 16 there
    help: build both plugins with the same definition of the type, from a crate or a header that both use
"#,
    );
}

#[test]
fn a_father_must_write_the_type_that_the_child_takes() {
    check(
        &[
            (
                "[schemas.goon]",
                r#"[schemas.boss]
type = "boss"
children = { work = "goon" }
[schemas.goon]"#,
            ),
            (r#", cruise = "goon""#, ""),
            (ROOTS, r#"roots = ["teleop", "example", "boss"]"#),
        ],
        r#"
apps/good.toml:35:21: `speed` that schema `boss` writes to `work` is `geometry_msgs/msg/Pose2D`, and `goon.speed` is `std_msgs/msg/Float64`
apps/good.toml:35:21: `pace` that schema `boss` writes to `work` is `geometry_msgs/msg/Pose2D`, and `goon.speed` is `std_msgs/msg/Float64`
apps/good.toml:35:21: `period` that schema `boss` writes to `work` is `std_msgs/msg/UInt8`, and a period is `std_msgs/msg/Float64`
"#,
    );
}
