//! The faults that are reported for impossible fathers, children and roots.

use crate::catalogue::check;

/// The children of the good application.
const CHILDREN: &str = r#"{ brake = "stop", avoid = "vff", cruise = "goon", lookout = "look" }"#;
/// The roots of the good application.
const ROOTS: &str = r#"roots   = ["teleop", "example"]"#;

#[test]
fn a_schema_has_one_father() {
    check(
        &[
            (
                "[schemas.stop]",
                r#"[schemas.judge]
type = "judge"
children = { one = "stop" }
[schemas.stop]"#,
            ),
            (ROOTS, r#"roots = ["teleop", "example", "judge"]"#),
        ],
        r#"
apps/good.toml:25:20: `stop` has two fathers, `example` and `judge`
    help: define a second instance of the same type for the other
"#,
    );
    check(
        &[
            (
                CHILDREN,
                r#"{ brake = "stop", avoid = "goon", cruise = "goon", lookout = "look" }"#,
            ),
            (ROOTS, r#"roots = ["teleop", "example", "vff"]"#),
        ],
        r#"
apps/good.toml:20:58: `cruise` in `children` of schema `example` names `goon` a second time
    help: a schema can have only one role: define a second instance of the same type
"#,
    );
}

#[test]
fn a_schema_that_is_its_own_father_is_refused_with_the_cycle() {
    check(
        &[
            (
                CHILDREN,
                r#"{ brake = "stop", avoid = "vff", cruise = "one", lookout = "look" }"#,
            ),
            (
                "[schemas.goon]",
                r#"[schemas.one]
type = "judge"
children = { one = "two" }
[schemas.two]
type = "judge"
children = { one = "example" }
[schemas.goon]"#,
            ),
            (ROOTS, r#"roots = ["teleop", "goon"]"#),
        ],
        r#"
apps/good.toml:20:57: `speed` that schema `example` writes to `cruise` is a modulation, and `one` has none of that name
apps/good.toml:38:20: `example` is its own father: example -> one -> two -> example
    help: remove one of them from its father's `children`
"#,
    );
}

#[test]
fn r13_roots_are_motor_schemas_without_a_father() {
    check(
        &[(ROOTS, r#"roots = ["teleop", "example", "stop"]"#)],
        r#"
apps/good.toml:3:31: the root `stop` has a father, `example`
    help: remove it from `roots`, or from its father's `children`
"#,
    );
    check(
        &[(ROOTS, r#"roots = ["teleop", "example", "pioneer", "look"]"#)],
        r#"
apps/good.toml:3:31: the root `pioneer` is a driver, and only motor schemas compete
    help: remove it from `roots`; it is awake while a schema that needs it is
apps/good.toml:3:42: the root `look` is a perceptive schema, and only motor schemas compete
    help: remove it from `roots`; it is awake while a schema that needs it is
"#,
    );
    check(
        &[(ROOTS, r#"roots = ["teleop", "example", "teleop"]"#)],
        r#"
apps/good.toml:3:31: `roots` of the application names `teleop` twice
    help: remove one
"#,
    );
}

#[test]
fn a_motor_schema_without_a_father_that_is_no_root_is_refused() {
    check(
        &[(
            CHILDREN,
            r#"{ brake = "stop", cruise = "goon", lookout = "look" }"#,
        )],
        r#"
apps/good.toml:28:10: no father wakes the motor schema `vff`, and it is not a root
    help: name it in `roots`, or in the `children` of a father
"#,
    );
}

#[test]
fn a_role_refuses_a_schema_of_another_kind() {
    check(
        &[(
            CHILDREN,
            r#"{ brake = "stop", avoid = "look", cruise = "goon", lookout = "vff" }"#,
        )],
        r#"
apps/good.toml:20:41: `avoid` in `children` of schema `example` takes a motor schema, and `look` is a perceptive schema
apps/good.toml:20:76: `lookout` in `children` of schema `example` takes a perceptive schema, and `vff` is a motor schema
"#,
    );
    check(
        &[
            (
                CHILDREN,
                r#"{ brake = "pioneer", avoid = "vff", cruise = "goon" }"#,
            ),
            (ROOTS, r#"roots = ["teleop", "example", "stop"]"#),
        ],
        r#"
apps/good.toml:20:25: `brake` in `children` of schema `example` takes a motor schema, and `pioneer` is a driver
"#,
    );
}

#[test]
fn an_unknown_type_causes_no_faults_of_fathers_and_children() {
    check(
        &[(r#"type        = "example""#, r#"type = "exampl""#)],
        r#"
apps/good.toml:16:8: schema `example`: plugin `exampl` cannot be used: no folder has it
    help: did you mean `example`?
"#,
    );
}
