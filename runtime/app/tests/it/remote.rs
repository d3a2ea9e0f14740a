//! Imports of other applications' exports, as application files name them.

use jde_app::{Binding, ImportSource};

use crate::catalogue::{application, check};

/// The line of the good application that binds one import.
const HEADING: &str = r#"heading = "pioneer.heading""#;

#[test]
fn an_import_may_name_a_variable_of_another_application() {
    let application = application(&[(HEADING, r#"heading = "robot2:pioneer.heading""#)]);
    let [remote] = &application.remotes[..] else {
        panic!("{:?}", application.remotes);
    };
    assert_eq!(remote.peer, "robot2");
    assert_eq!(remote.variable, "pioneer.heading");
    assert_eq!(remote.local, "robot2:pioneer.heading");
    assert_eq!(remote.parts(), ("robot2:pioneer", "heading"));
    assert_eq!(remote.stale_ns, application.link.stale_ns);
    let example = &application.instances[application.instance("example").expect("the name is known")];
    let port = example
        .schema
        .ports
        .iter()
        .position(|port| port.name == "heading");
    let port = port.expect("the name is known");
    assert!(remote.value_type.same_as(&example.schema.ports[port].value_type));
    let source = ImportSource::Remote(0);
    assert_eq!(
        example.bindings[port],
        Binding::Import {
            source: Some(source),
            trigger: false,
            stale_ns: None,
        }
    );
    assert_eq!(application.source_name(source), "robot2:pioneer.heading");
}

#[test]
fn r6_an_import_from_another_application_keeps_no_schema_awake() {
    let local = application(&[]);
    let remote = application(&[(HEADING, r#"heading = "robot2:pioneer.heading""#)]);
    let needs = |application: &jde_app::Application| {
        let example = application.instance("example").expect("the name is known");
        application.spec().schemas[example].needs.len()
    };
    // The laser is still imported from the application's own robot.
    assert_eq!((needs(&local), needs(&remote)), (1, 1));
    assert_eq!(remote.spec().validate(), Ok(()));
}

#[test]
fn the_age_limit_of_the_import_overrides_that_of_the_link() {
    let link = "[link]\nstale = \"2s\"\n[schemas.pioneer]";
    let stale = |import: &str| {
        let application = application(&[(HEADING, import), ("[schemas.pioneer]", link)]);
        application.remotes[0].stale_ns
    };
    assert_eq!(stale(r#"heading = "robot2:pioneer.heading""#), 2_000_000_000);
    assert_eq!(
        stale(r#"heading = { from = "robot2:pioneer.heading" }"#),
        2_000_000_000
    );
    assert_eq!(
        stale(r#"heading = { from = "robot2:pioneer.heading", stale = "300ms" }"#),
        300_000_000
    );
}

#[test]
fn an_invalid_name_of_a_remote_variable_is_refused() {
    for wrong in [
        "robot 2:pioneer.heading",
        ":pioneer.heading",
        "robot2:pioneer",
        "robot2:pioneer.",
        "a:b:c.d",
        "robot2:",
    ] {
        check(
            &[(HEADING, &format!("heading = \"{wrong}\""))],
            &format!(
                "apps/good.toml:18:52: `heading` in `imports` of schema `example` is `{wrong}`, which names no variable of another application\n    help: write NAME:SCHEMA.VARIABLE, such as \"robot2:pioneer.odometry\""
            ),
        );
    }
}

#[test]
fn an_application_cannot_import_from_itself_over_the_link() {
    check(
        &[(HEADING, r#"heading = "safe-navigation:pioneer.heading""#)],
        r#"
apps/good.toml:18:52: `heading` in `imports` of schema `example` is `safe-navigation:pioneer.heading`, and `safe-navigation` is this application itself
    help: write "pioneer.heading", or give the link another `name`
"#,
    );
}

#[test]
fn an_import_over_a_link_that_is_off_is_refused() {
    check(
        &[
            (HEADING, r#"heading = "robot2:pioneer.heading""#),
            (
                "mission = \"example.mission\"",
                "mission = \"example.mission\"\nlink.off = true",
            ),
        ],
        r#"
apps/good.toml:19:52: `heading` in `imports` of schema `example` is `robot2:pioneer.heading`, and the link is off
    help: remove off = true from `[link]`, or import a variable of this application
"#,
    );
}

#[test]
fn a_command_to_another_application_is_refused() {
    check(
        &[(
            "[schemas.teleop]\ntype      = \"teleop\"\nactuators = { base = \"pioneer.velocity\" }",
            "[schemas.teleop]\ntype      = \"teleop\"\nactuators = { base = \"robot2:pioneer.velocity\" }",
        )],
        r#"
apps/good.toml:13:22: `base` in `actuators` of schema `teleop` is `robot2:pioneer.velocity`, and commands do not leave an application
    help: let a schema of the other application command, and import what it is to do
"#,
    );
}

#[test]
fn an_import_table_requires_from_and_allows_stale_of_what_ages() {
    check(
        &[(
            HEADING,
            r#"heading = { form = "robot2:pioneer.heading", stale = "1s" }"#,
        )],
        r#"
apps/good.toml:18:42: `heading` of `imports` of schema `example` has no `from`
    help: name the variable, as in from = "robot2:pioneer.odometry"
apps/good.toml:18:54: unknown key `form` in `heading` of `imports` of schema `example`
    help: did you mean `from`?
"#,
    );
    check(
        &[(HEADING, r#"heading = { from = "look.tilt", stale = "1s" }"#)],
        r#"
apps/good.toml:18:52: `heading` has `stale`, and `look.tilt` is a modulation, whose value does not age
    help: remove `stale`
"#,
    );
    check(
        &[(HEADING, "heading = 7")],
        r#"
apps/good.toml:18:52: `heading` of `imports` of schema `example` must be a text, or a table such as { from = "robot2:pioneer.odometry", stale = "300ms" }, not a whole number
"#,
    );
}

#[test]
fn imports_of_one_remote_variable_must_agree_on_type_and_age_limit() {
    check(
        &[(
            r#"imports     = { laser = "pioneer.laser", heading = "pioneer.heading" }"#,
            r#"imports     = { laser = "robot2:pioneer.laser", heading = "robot2:pioneer.laser" }"#,
        )],
        r#"
apps/good.toml:18:59: `heading` in `imports` of schema `example` takes `robot2:pioneer.laser` as `std_msgs/msg/Float64`, and another import takes it as `sensor_msgs/msg/LaserScan`
    help: one variable has one type: one of the two means another variable
"#,
    );
    let laser = r#"imports   = { laser = "pioneer.laser" }
actuators = { base = "pioneer.velocity" }

[schemas.vff]"#;
    let edits = |stop: &str, look: &str| {
        let stop = laser.replace("\"pioneer.laser\"", stop);
        let look = format!("imports = {{ laser = {look} }}");
        [(laser, stop), (r#"imports = { laser = "pioneer.laser" }"#, look)]
    };
    let limit = |ms: u32| format!("{{ from = \"robot2:pioneer.laser\", stale = \"{ms}ms\" }}");
    let plain = "\"robot2:pioneer.laser\"";
    for edits in [
        edits(plain, &limit(300)),
        edits(&limit(300), plain),
        edits(&limit(300), &limit(300)),
    ] {
        let application = application(&edits.each_ref().map(|(from, to)| (*from, to.as_str())));
        assert_eq!(application.remotes.len(), 1);
        assert_eq!(application.remotes[0].stale_ns, 300_000_000);
    }
    let edits = edits(&limit(300), &limit(400));
    check(
        &edits.each_ref().map(|(from, to)| (*from, to.as_str())),
        r#"
apps/good.toml:40:62: `laser` in `imports` of schema `look` and another import of `robot2:pioneer.laser` state different `stale`
    help: state it once; it holds for all that import the variable
"#,
    );
}
