//! The application that results from a file without faults.
//!
//! long because one application is looked at from every side.

use std::time::Duration;

use jde_app::{Application, Binding, ChildTarget, Executor, ImportSource, InstancePort, RoleId};
use jde_core::{Absence, GroupId, Kind, Policy, Restart, SchemaId};

use crate::catalogue::{self, application, application_with, check, read};

const ROOTS: GroupId = GroupId(0);
const BASE: GroupId = GroupId(1);

fn at(application: &Application, name: &str) -> SchemaId {
    application
        .instance(name)
        .unwrap_or_else(|| panic!("no instance `{name}`"))
}

fn port(application: &Application, instance: &str, name: &str) -> InstancePort {
    let instance = at(application, instance);
    let ports = &application.instances[instance].schema.ports;
    let port = ports.iter().position(|port| port.name == name).expect(name);
    InstancePort { instance, port }
}

fn binding<'a>(application: &'a Application, instance: &str, name: &str) -> &'a Binding {
    let found = port(application, instance, name);
    &application.instances[found.instance].bindings[found.port]
}

fn initial<'a>(application: &'a Application, instance: &str, name: &str) -> &'a [u8] {
    match binding(application, instance, name) {
        Binding::Modulation { initial, .. } => initial,
        other => panic!("{instance}.{name} is {other:?}"),
    }
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes
        .chunks(8)
        .map(|bytes| f64::from_ne_bytes(bytes.try_into().expect("eight bytes")))
        .collect()
}

fn text(bytes: &[u8]) -> &str {
    let length = u32::from_ne_bytes(bytes[..4].try_into().expect("four bytes")) as usize;
    std::str::from_utf8(&bytes[4..4 + length]).expect("UTF-8")
}

#[test]
fn names_are_resolved_to_numbers() {
    let application = application(&[]);
    assert_eq!(application.name, "safe-navigation");
    assert!(application.path.is_absolute());
    assert_eq!((application.seed, application.executor), (0, Executor::Threads));
    assert_eq!(
        application.mission,
        Some(port(&application, "example", "mission"))
    );
    assert_eq!(
        *binding(&application, "example", "laser"),
        Binding::Import {
            source: Some(source(&application, "pioneer", "laser")),
            trigger: true,
            stale_ns: None,
        }
    );
    assert_eq!(
        *binding(&application, "example", "heading"),
        Binding::Import {
            source: Some(source(&application, "pioneer", "heading")),
            trigger: false,
            stale_ns: None,
        }
    );
    assert_eq!(
        *binding(&application, "stop", "base"),
        Binding::Actuator {
            target: Some(port(&application, "pioneer", "velocity"))
        }
    );
    assert_eq!(
        *binding(&application, "example", "base"),
        Binding::Actuator { target: None }
    );
    assert_eq!(*binding(&application, "pioneer", "velocity"), Binding::Command);
    assert_eq!(application.instances[at(&application, "stop")].line, 23);
}

#[test]
fn r4_the_order_of_the_children_is_that_of_the_file() {
    let application = application(&[]);
    let example = &application.instances[at(&application, "example")];
    let children = ["stop", "vff", "goon", "look"].map(|name| at(&application, name));
    assert_eq!(example.child_order, [0, 1, 2, 4].map(RoleId));
    assert_eq!(
        *example.children,
        [
            Some(children[0]),
            Some(children[1]),
            Some(children[2]),
            None,
            Some(children[3])
        ]
    );
    assert_eq!(application.groups.len(), 2);
    assert_eq!(application.groups[BASE].name, "example/base");
    assert_eq!(application.groups[BASE].members, children[..3]);
    let base = Some(BASE);
    assert_eq!(*example.child_groups, [base, base, base, None, None]);

    let reordered = application_with_order("cruise = \"goon\", brake = \"stop\", avoid = \"vff\"");
    let members: Vec<_> = reordered.groups[BASE]
        .members
        .iter()
        .map(|member| reordered.instances[*member].name.as_str())
        .collect();
    assert_eq!(members, ["goon", "stop", "vff"]);
}

fn source(application: &Application, instance: &str, name: &str) -> ImportSource {
    ImportSource::Local(port(application, instance, name))
}

fn application_with_order(order: &str) -> Application {
    application(&[("brake = \"stop\", avoid = \"vff\", cruise = \"goon\"", order)])
}

#[test]
fn r13_the_roots_are_the_first_group() {
    let application = application(&[]);
    let roots = &application.groups[ROOTS];
    assert_eq!((roots.name.as_str(), roots.father), ("roots", None));
    assert_eq!(
        roots.members,
        [at(&application, "teleop"), at(&application, "example")]
    );
    assert_eq!(
        application.instances[at(&application, "example")].group,
        Some(ROOTS)
    );
    assert_eq!(
        application.instances[at(&application, "stop")].father,
        Some(at(&application, "example"))
    );
    assert_eq!(application.instances[at(&application, "look")].father, None);
}

#[test]
fn values_are_converted_to_the_units_of_their_ports() {
    let application = application(&[]);
    assert_eq!(
        floats(initial(&application, "pioneer", "start")),
        [1.0, 2.0, std::f64::consts::FRAC_PI_2]
    );
    assert_eq!(floats(initial(&application, "goon", "speed")), [0.4]);
    assert_eq!(floats(initial(&application, "pioneer", "noise")), [0.0]);
    assert_eq!(
        application.instances[at(&application, "example")].period_ns,
        75_000_000
    );
}

#[test]
fn a_structure_may_be_a_table_and_missing_fields_keep_their_defaults() {
    let application = application(&[("[1.0, 2.0, \"90deg\"]", "{ theta = \"180 deg\", x = \"25 cm\" }")]);
    assert_eq!(
        floats(initial(&application, "pioneer", "start")),
        [0.25, 0.0, std::f64::consts::PI]
    );
}

#[test]
fn sequences_booleans_and_integers_are_encoded() {
    let values = "world = \"office.toml\"\nweights = [1, \"20 cm\"]\nquiet = true\nbeams = 0xff";
    let application = application(&[("world = \"office.toml\"", values)]);
    let weights = initial(&application, "pioneer", "weights");
    assert_eq!(weights[..4], 2u32.to_ne_bytes());
    assert_eq!(weights[4..8], 1f32.to_ne_bytes());
    assert_eq!(weights[8..12], 0.2f32.to_ne_bytes());
    assert_eq!(initial(&application, "pioneer", "quiet"), [1]);
    assert_eq!(initial(&application, "pioneer", "beams"), [255]);
}

#[test]
fn paths_are_relative_to_the_file_and_to_the_working_directory_in_options() {
    let working_directory = std::env::current_dir().expect("a working directory");
    let world = |application: &Application| text(initial(application, "pioneer", "world")).to_owned();
    // Short, because the port holds at most 64 bytes.
    let absolute = "/office.toml";
    assert_eq!(
        world(&application(&[("\"office.toml\"", &format!("\"{absolute}\""))])),
        absolute
    );
    let read = |path: &str, options: &[jde_app::Override]| {
        jde_app::parse(
            catalogue::GOOD,
            std::path::Path::new(path),
            options,
            &catalogue::DescribedPlugins,
        )
        .unwrap_or_else(|faults| panic!("{faults}"))
    };
    assert_eq!(
        world(&read("/robot/apps/nav.toml", &[])),
        "/robot/apps/office.toml"
    );
    let option = "pioneer.world=x".parse().expect("an option");
    assert_eq!(
        world(&read("/robot/apps/nav.toml", &[option])),
        working_directory.join("x").to_string_lossy()
    );
}

#[test]
fn a_model_is_a_name_unless_it_is_a_file() {
    for (written, expected) in [("p3dx", "p3dx"), ("mine.toml", "/robot/apps/mine.toml")] {
        let world = "world = \"office.toml\"";
        let file = catalogue::GOOD.replace(world, &format!("{world}\nmodel = \"{written}\""));
        let path = std::path::Path::new("/robot/apps/nav.toml");
        let application = jde_app::parse(&file, path, &[], &catalogue::DescribedPlugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        assert_eq!(text(initial(&application, "pioneer", "model")), expected);
    }
}

#[test]
fn options_override_the_file() {
    let options = [
        "goon.speed=30 cm/s",
        "goon.period=20 Hz",
        "pioneer.label=7",
        "pioneer.start={ y = 9 }",
    ];
    let application = application_with(&[], &options);
    assert_eq!(floats(initial(&application, "goon", "speed")), [0.3]);
    assert_eq!(
        application.instances[at(&application, "goon")].period_ns,
        50_000_000
    );
    assert_eq!(text(initial(&application, "pioneer", "label")), "7");
    assert_eq!(floats(initial(&application, "pioneer", "start"))[..2], [1.0, 9.0]);
}

#[test]
fn r12_triggers_default_to_those_of_the_type_and_an_empty_list_has_none() {
    let trigger = |application: &Application, instance: &str| match *binding(application, instance, "laser") {
        Binding::Import { trigger, .. } => trigger,
        ref other => panic!("{other:?}"),
    };
    let untouched = application(&[("triggers    = [\"laser\"]\n", "")]);
    assert!(trigger(&untouched, "example"));
    assert!(untouched.spec().schemas[at(&untouched, "example")].triggered);
    let none = application(&[("[\"laser\"]", "[]")]);
    assert!(!trigger(&none, "example"));
    assert!(!none.spec().schemas[at(&none, "example")].triggered);
    let other = application(&[("[\"laser\"]", "[\"heading\"]")]);
    assert!(!trigger(&other, "example"));
    assert!(other.spec().schemas[at(&other, "example")].triggered);
}

#[test]
fn the_modulations_of_a_father_are_bound_to_the_child_in_the_role() {
    let application = application(&[]);
    let speed = port(&application, "goon", "speed");
    assert_eq!(
        *binding(&application, "example", "speed"),
        Binding::ChildModulation {
            target: Some(ChildTarget::Port(speed))
        }
    );
    assert_eq!(
        *binding(&application, "example", "period"),
        Binding::ChildModulation {
            target: Some(ChildTarget::Period(speed.instance))
        }
    );
}

#[test]
fn the_modulations_of_an_unbound_role_are_unbound() {
    let edits = [
        (", cruise = \"goon\"", ""),
        ("\"teleop\", \"example\"", "\"teleop\", \"example\", \"goon\""),
    ];
    let application = application(&edits);
    assert_eq!(
        *binding(&application, "example", "speed"),
        Binding::ChildModulation { target: None }
    );
    assert_eq!(
        *binding(&application, "example", "period"),
        Binding::ChildModulation { target: None }
    );
}

#[test]
fn r9_groups_state_what_happens_without_a_winner() {
    let group = |settings: &str| {
        let application = application(&[("{ policy = \"sticky\", dwell = \"500ms\" }", settings)]);
        let goon = at(&application, "goon");
        (application.groups[BASE].clone(), goon)
    };
    let (fallback, goon) =
        group("{ absence = \"fallback\", fallback = \"cruise\", patience = \"2ms\", budget = 0.003 }");
    assert_eq!(fallback.absence, Absence::Fallback(goon));
    assert_eq!((fallback.patience_ns, fallback.budget_ns), (2_000_000, 3_000_000));
    assert_eq!(fallback.policy, Policy::PRIORITY);
    let (hold, _) = group("{ absence = \"hold\", hold = \"300ms\", policy = \"urgency\" }");
    assert_eq!(hold.absence, Absence::Hold { for_: 300_000_000 });
    assert_eq!(hold.policy, Policy::URGENCY);
    let (turns, _) = group("{ policy = \"round-robin\", turn = \"5s\" }");
    assert_eq!(
        (turns.policy, turns.absence),
        (Policy::round_robin(Duration::from_secs(5)), Absence::Brake)
    );
    let (sticky, _) = group("{ policy = \"sticky\", dwell = 0.5, hysteresis = 0.1 }");
    assert_eq!(sticky.policy, Policy::sticky(Duration::from_millis(500), 0.1));
}

#[test]
fn r4_a_father_with_an_arbitration_uses_it_unless_the_file_sets_another_policy() {
    let edits = [
        (
            "roots   = [\"teleop\", \"example\"]",
            "roots = [\"teleop\", \"judge\"]",
        ),
        ("mission = \"example.mission\"\n", ""),
        (
            "[schemas.teleop]",
            "[schemas.judge]\ntype = \"judge\"\nchildren = { one = \"example\" }\n[schemas.teleop]",
        ),
    ];
    let own = application(&edits);
    assert_eq!(own.groups[BASE].name, "judge/base");
    assert_eq!(own.groups[BASE].policy, Policy::FATHER);
    let other = (
        "{ one = \"example\" }",
        "{ one = \"example\" }\ngroups.base.policy = \"priority\"",
    );
    let text = catalogue::edited(&edits).replace(other.0, other.1);
    let ready_made = read(&text, &[]).unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(ready_made.groups[BASE].policy, Policy::PRIORITY);
}

#[test]
fn a_restart_has_a_default_and_may_be_a_text_or_a_table() {
    let restart = |line: &str| {
        let application = application(&[("type      = \"stop\"", &format!("type = \"stop\"\n{line}"))]);
        application.instances[at(&application, "stop")].restart
    };
    let default = Restart::OnFault {
        backoff: 500_000_000,
        limit: 5,
        within: 60_000_000_000,
    };
    assert_eq!(restart(""), default);
    assert_eq!(restart("restart = \"on-fault\""), default);
    assert_eq!(restart("restart = \"never\""), Restart::Never);
    assert_eq!(
        restart("restart.limit = 3"),
        Restart::OnFault {
            backoff: 500_000_000,
            limit: 3,
            within: 60_000_000_000,
        }
    );
    assert_eq!(
        restart("restart = { back-off = \"200ms\", limit = 1, within = \"1s\" }"),
        Restart::OnFault {
            backoff: 200_000_000,
            limit: 1,
            within: 1_000_000_000,
        }
    );
}

#[test]
fn the_budget_defaults_to_the_period() {
    let budget = |line: &str| {
        let application = application(&[("period      = \"75ms\"", line)]);
        application.instances[at(&application, "example")].budget_ns
    };
    assert_eq!(budget(""), 100_000_000);
    assert_eq!(budget("period = \"50ms\""), 50_000_000);
    assert_eq!(budget("period = \"50ms\"\nbudget = \"2ms\""), 2_000_000);
}

#[test]
fn r6_the_spec_contains_the_schemas_that_each_schema_needs() {
    let application = application(&[(
        "laser = \"pioneer.laser\", heading = \"pioneer.heading\"",
        "laser = \"pioneer.laser\", heading = \"look.heading\"",
    )]);
    let spec = application.spec();
    let id = |name| at(&application, name);
    let needs = |name| spec.schemas[at(&application, name)].needs.clone();
    assert_eq!(spec.schemas[at(&application, "pioneer")].kind, Kind::Perceptive);
    assert_eq!(spec.schemas[at(&application, "stop")].kind, Kind::Motor);
    assert_eq!(needs("stop"), [id("pioneer")]);
    assert_eq!(needs("example"), [id("pioneer"), id("look")]);
    assert_eq!(needs("look"), [id("pioneer")]);
    assert_eq!(needs("pioneer"), []);
    assert_eq!(spec.groups[BASE].father, Some(id("example")));
    assert_eq!(spec.validate(), Ok(()));
}

#[test]
fn an_imported_modulation_does_not_keep_its_schema_awake() {
    let other = "[schemas.other]\ntype = \"look\"\nimports = { laser = \"pioneer.laser\", bearing = \"look.tilt\" }\n";
    let application = application(&[("[schemas.stop]", &format!("{other}[schemas.stop]"))]);
    assert_eq!(
        *binding(&application, "other", "bearing"),
        Binding::Import {
            source: Some(source(&application, "look", "tilt")),
            trigger: true,
            stale_ns: None,
        }
    );
    let pioneer = at(&application, "pioneer");
    assert_eq!(
        application.spec().schemas[at(&application, "other")].needs,
        [pioneer]
    );
}

#[test]
fn r6_every_root_needs_what_the_application_keeps_awake() {
    let first = "[schemas.pioneer]";
    let other = "[schemas.other]\ntype = \"look\"\nimports = { laser = \"pioneer.laser\" }\n";
    let application = application(&[
        ("mission =", "awake = [\"other\"]\nmission ="),
        (first, &format!("{other}{first}")),
    ]);
    let (spec, other) = (application.spec(), at(&application, "other"));
    let needing: Vec<_> = spec
        .schemas
        .iter()
        .filter(|schema| schema.needs.contains(&other))
        .map(|schema| schema.name.as_str())
        .collect();
    assert_eq!(needing, ["teleop", "example"]);
    assert_eq!(spec.validate(), Ok(()));
    check(
        &[("mission =", "awake = [\"other\", \"stop\"]\nmission =")],
        r#"
apps/good.toml:4:10: `awake` of the application names `other`, and there is no such schema
    help: schemas: `pioneer`, `teleop`, `example`, `stop`, `vff`, `goon` and `look`
apps/good.toml:4:19: `awake` names `stop`, which is a motor schema
    help: name it among the `roots`, or as the child of a father
"#,
    );
}

#[test]
fn a_type_may_be_the_plugin_alone_if_that_is_unambiguous() {
    let resolved = |ty: &str| {
        let application = application(&[("type    = \"look\"", &format!("type = \"{ty}\""))]);
        let look = &application.instances[at(&application, "look")];
        (
            application.plugins[look.plugin].name.clone(),
            look.schema.name.clone(),
            look.number,
        )
    };
    assert_eq!(resolved("look"), ("look".to_owned(), "look".to_owned(), 0));
    assert_eq!(resolved("look/look"), ("look".to_owned(), "look".to_owned(), 0));
}

#[test]
fn plugin_folders_are_relative_to_the_file() {
    let edits = [
        ("name    = \"safe-navigation\"", "plugins = [\"more\"]"),
        ("type      = \"teleop\"", "type = \"extra\""),
    ];
    let application = application(&edits);
    assert_eq!(application.name, "good");
    assert_eq!(
        application.instances[at(&application, "teleop")].schema.name,
        "only"
    );
}

#[test]
fn the_top_level_sets_seed_executor_and_policy_of_the_roots() {
    let more = "seed = 7\nexecutor = \"pool\"\ndoc = \"Drives.\"\nroot = { policy = \"urgency\", absence = \"fallback\", fallback = \"teleop\" }\nmission";
    let application = application(&[("mission =", &format!("{more} ="))]);
    assert_eq!((application.seed, application.executor), (7, Executor::Pool));
    assert_eq!(application.doc, "Drives.");
    assert_eq!(application.groups[ROOTS].policy, Policy::URGENCY);
    let teleop = at(&application, "teleop");
    assert_eq!(application.groups[ROOTS].absence, Absence::Fallback(teleop));
}

#[test]
fn r7_members_of_one_group_and_their_descendants_may_share_an_actuator() {
    let application = application(&[]);
    let velocity = Binding::Actuator {
        target: Some(port(&application, "pioneer", "velocity")),
    };
    // One root, and three children of another root.
    for user in ["teleop", "stop", "vff", "goon"] {
        assert_eq!(*binding(&application, user, "base"), velocity, "{user}");
    }
}
