//! The faults that are reported for wrong keys, types and shapes in an application file.

use crate::catalogue::{check, check_text};

/// The roots of the good application.
const ROOTS: &str = r#"roots   = ["teleop", "example"]"#;

#[test]
fn a_file_without_roots_or_schemas_is_refused_with_an_example() {
    check_text(
        "",
        &[],
        r#"
apps/good.toml: there is no `roots`, so nothing would ever start
    help: name the motor schemas of the top level, such as roots = ["teleop", "example"]; the first wins a collision
apps/good.toml: there is no `schemas`, so the application has nothing to run
    help: define each schema in its own table: [schemas.NAME] with type = "PLUGIN/SCHEMA"
"#,
    );
    check_text(
        "# nothing yet\n",
        &[],
        r#"
apps/good.toml: there is no `roots`, so nothing would ever start
    help: name the motor schemas of the top level, such as roots = ["teleop", "example"]; the first wins a collision
apps/good.toml: there is no `schemas`, so the application has nothing to run
    help: define each schema in its own table: [schemas.NAME] with type = "PLUGIN/SCHEMA"
"#,
    );
    check_text(
        "roots = []\nschemas = 3\n",
        &[],
        r#"
apps/good.toml:1:1: `roots` is empty, so nothing would ever start
    help: name the motor schemas of the top level, such as roots = ["teleop", "example"]; the first wins a collision
apps/good.toml:2:11: `schemas` of the application must be a table, not a whole number
"#,
    );
}

#[test]
fn an_unknown_key_is_reported_with_the_nearest_name_at_every_level() {
    check(
        &[(r#"name    = "safe-navigation""#, r#"nmae = "x""#)],
        r#"
apps/good.toml:2:1: unknown key `nmae` in the application
    help: did you mean `name`?
"#,
    );
    check(
        &[("period      =", "perod =")],
        r#"
apps/good.toml:17:1: unknown key `perod` in schema `example`
    help: did you mean `period`?
"#,
    );
    check(
        &[("speed     =", "sped =")],
        r#"
apps/good.toml:35:1: unknown key `sped` in schema `goon`
    help: did you mean `speed`?
"#,
    );
    check(
        &[(
            r#"imports   = { laser = "pioneer.laser" }
actuators = { base = "pioneer.velocity" }

[schemas.vff]"#,
            r#"imports = { lasr = "pioneer.laser" }
actuators = { bse = "pioneer.velocity" }

[schemas.vff]"#,
        )],
        r#"
apps/good.toml:25:1: schema `stop` leaves `laser` of its imports unbound; it takes `sensor_msgs/msg/LaserScan`
    help: add imports.laser = "pioneer.laser"
apps/good.toml:25:13: `imports` of schema `stop`: there is no `lasr`
    help: did you mean `laser`?
apps/good.toml:26:1: schema `stop` leaves `base` of its actuators unbound; it takes `geometry_msgs/msg/Twist`
    help: add actuators.base = "pioneer.velocity"
apps/good.toml:26:15: `actuators` of schema `stop`: there is no `bse`
    help: did you mean `base`?
"#,
    );
    check(
        &[(
            r#"{ brake = "stop", avoid = "vff", cruise = "goon", lookout = "look" }"#,
            r#"{ brake = "stop", avod = "vff", cruise = "goon", lookout = "look" }"#,
        )],
        r#"
apps/good.toml:20:33: `children` of schema `example`: there is no role `avod`
    help: did you mean `avoid`?
"#,
    );
    check(
        &[("groups.base =", "groups.bas =")],
        r#"
apps/good.toml:21:8: schema `example` has no group `bas`
    help: did you mean `base`?
"#,
    );
    check(
        &[(
            r#"{ policy = "sticky", dwell = "500ms" }"#,
            r#"{ polcy = "sticky" }"#,
        )],
        r#"
apps/good.toml:21:17: unknown key `polcy` in group `base` of schema `example`
    help: did you mean `policy`?
"#,
    );
    check(
        &[(
            ROOTS,
            r#"roots   = ["teleop", "example"]
root = { patient = "5ms" }"#,
        )],
        r#"
apps/good.toml:4:10: unknown key `patient` in `root`
    help: did you mean `patience`?
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
restart = { backoff = "1s" }"#,
        )],
        r#"
apps/good.toml:25:13: unknown key `backoff` in `restart` of schema `stop`
    help: did you mean `back-off`?
"#,
    );
    check(
        &[
            (
                r#"world = "office.toml""#,
                r#"start.z = 1
world = "office.toml""#,
            ),
            (
                r#"start = [1.0, 2.0, "90deg"]
"#,
                "",
            ),
        ],
        r#"
apps/good.toml:8:7: `start` of schema `pioneer` has no field `z`
    help: fields: `x`, `y` and `theta`
"#,
    );
}

#[test]
fn a_port_used_as_a_key_is_reported_with_its_table() {
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
laser = "pioneer.laser""#,
        )],
        r#"
apps/good.toml:25:1: unknown key `laser` in schema `stop`
    help: bind it in `imports`
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
base = "pioneer.velocity""#,
        )],
        r#"
apps/good.toml:25:1: unknown key `base` in schema `stop`
    help: bind it in `actuators`
"#,
    );
    check(
        &[(r#"period      = "75ms""#, r#"brake = "stop""#)],
        r#"
apps/good.toml:17:1: unknown key `brake` in schema `example`
    help: bind it in `children`
"#,
    );
}

#[test]
fn an_unknown_type_is_reported_with_the_nearest_name() {
    check(
        &[(r#""sim/robot""#, r#""sim/robo""#)],
        r#"
apps/good.toml:7:9: plugin `sim` contains no schema `robo`
    help: did you mean `robot`?
"#,
    );
    check(
        &[(r#""sim/robot""#, r#""sim/pioneer""#)],
        r#"
apps/good.toml:7:9: plugin `sim` contains no schema `pioneer`
    help: its schemas: `robot`
"#,
    );
    check(
        &[(r#""sim/robot""#, r#""simm/robot""#)],
        r#"
apps/good.toml:7:9: schema `pioneer`: plugin `simm` cannot be used: no folder has it
    help: did you mean `sim/robot`?
"#,
    );
    check(
        &[(r#""sim/robot""#, r#""robot""#)],
        r#"
apps/good.toml:7:9: schema `pioneer`: plugin `robot` cannot be used: no folder has it
    help: did you mean `sim/robot`?
"#,
    );
    check(
        &[(r#""nav/goon""#, r#""nav""#)],
        r#"
apps/good.toml:34:13: plugin `nav` contains `vff` and `goon`; state which one
    help: write type = "nav/vff"
"#,
    );
    check(
        &[(r#""nav/goon""#, r#""nav2/goon""#)],
        r#"
apps/good.toml:34:13: schema `goon`: plugin `nav2` cannot be used: it was built for ABI 2.0, newer than this host's 1.0
"#,
    );
    check(
        &[(
            r#"type      = "nav/goon"
"#,
            "",
        )],
        r#"
apps/good.toml:33:10: schema `goon` has no `type`
    help: add type = "nav/goon"
"#,
    );
    check(
        &[(r#""nav/goon""#, "7")],
        r#"
apps/good.toml:34:13: `type` of schema `goon` must be a text, not a whole number
"#,
    );
}

#[test]
fn a_value_of_another_shape_is_reported_with_the_expected_one() {
    check(
        &[(r#"name    = "safe-navigation""#, "name = 7")],
        r#"
apps/good.toml:2:8: `name` of the application must be a text, not a whole number
"#,
    );
    check(
        &[(ROOTS, r#"roots = "example""#)],
        r#"
apps/good.toml:3:9: `roots` of the application must be a list of texts, not a text
"#,
    );
    check(
        &[(ROOTS, r#"roots = ["teleop", 3]"#)],
        r#"
apps/good.toml:3:20: each of `roots` of the application must be a text, not a whole number
"#,
    );
    check(
        &[(r#"name    = "safe-navigation""#, "seed = -1")],
        r#"
apps/good.toml:2:8: `seed` of the application is not a whole number from 0 to 2^64 - 1
    help: write a number such as seed = 7
"#,
    );
    check(
        &[(r#"name    = "safe-navigation""#, r#"seed = "seven""#)],
        r#"
apps/good.toml:2:8: `seed` of the application is not a whole number from 0 to 2^64 - 1
    help: write a number such as seed = 7
"#,
    );
    check(
        &[(r#"name    = "safe-navigation""#, r#"executor = "thread""#)],
        r#"
apps/good.toml:2:12: there is no executor `thread`
    help: did you mean `threads`?
"#,
    );
    check(
        &[(
            r#"imports   = { laser = "pioneer.laser" }
actuators = { base = "pioneer.velocity" }

[schemas.vff]"#,
            r#"imports = ["pioneer.laser"]
actuators = { base = true }

[schemas.vff]"#,
        )],
        r#"
apps/good.toml:25:11: `imports` of schema `stop` must be a table, not a list
apps/good.toml:26:22: `base` of `actuators` of schema `stop` must be a text, not true or false
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
doc = 1979-05-27"#,
        )],
        r#"
apps/good.toml:25:7: `doc` of schema `stop` must be a text, not a date
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
restart = "always""#,
        )],
        r#"
apps/good.toml:25:11: `restart` of schema `stop` is `always`, which is not a way to restart
    help: ways: `never` and `on-fault`
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
restart = 3"#,
        )],
        r#"
apps/good.toml:25:11: `restart` of schema `stop` must be "never", "on-fault" or a table such as { back-off = "500ms", limit = 5, within = "60s" }, not a whole number
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
restart.limit = 0"#,
        )],
        r#"
apps/good.toml:25:17: `limit` of `restart` of schema `stop` is not a whole number above 0
    help: state the number of restarts, or write restart = "never"
"#,
    );
    check(
        &[(
            r#"type      = "stop""#,
            r#"type      = "stop"
isolate = true"#,
        )],
        r#"
apps/good.toml:25:11: `isolate` of schema `stop` must be "process", or a table of its limits such as { memory = "200 MB", network = false }, not true or false
"#,
    );
    check(
        &[("[schemas.look]", r#"[schemas."look out"]"#)],
        r#"
apps/good.toml:20:75: `lookout` in `children` of schema `example` names `look`, and there is no such schema
    help: did you mean `look out`?
apps/good.toml:38:10: `look out` cannot be the name of a schema
    help: use 1 to 64 letters, digits, `_` and `-`
"#,
    );
    check(
        &[(r#"name    = "safe-navigation""#, "schemas.x = 1")],
        r#"
apps/good.toml:2:13: schema `x` must be a table, not a whole number
"#,
    );
}
