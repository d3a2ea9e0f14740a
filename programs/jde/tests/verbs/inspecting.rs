//! `jde check`, `jde describe` and `jde plugins`, which start nothing.

use std::fs;
use std::path::Path;

use crate::support::{app, jde, jde_with_plugins, json, output_of, root};

#[test]
fn r17_check_shows_the_tree_the_bindings_and_the_contract_of_every_group() {
    let check = output_of(&mut jde_with_plugins(&["check", &app("room.toml")]));
    assert_eq!(check.status, Some(0), "{}", check.err);
    let positions: Vec<_> = [
        "roots:",
        "guide  example/example",
        "base:",
        "stop as brake",
        "vff as avoid",
        "goon as cruise",
        "pioneer  sim/robot",
    ]
    .map(|part| {
        check
            .out
            .find(part)
            .unwrap_or_else(|| panic!("{part}: {}", check.out))
    })
    .into();
    assert!(positions.is_sorted(), "{}", check.out);
    for part in [
        "laser <- pioneer.laser, which triggers",
        "base -> pioneer.velocity",
        "avoid.target -> vff.target",
    ] {
        assert!(check.out.contains(part), "{part}: {}", check.out);
    }
    for contract in [
        "roots: guide takes over within",
        "guide/base: ",
        "\n    guide/base, by urgency alone: ",
    ] {
        assert!(check.out.contains(contract), "{contract}: {}", check.out);
    }
    assert!(
        check.out.contains("patience with the loser 5 ms"),
        "{}",
        check.out
    );
    assert!(!check.out.contains('\u{1b}'), "no colours in a pipe");
    assert!(!check.out.contains("defaults:"), "{}", check.out);
}

#[test]
fn check_lists_the_modulations_with_default_values_on_request() {
    let room = app("room.toml");
    let check = output_of(&mut jde_with_plugins(&[
        "check",
        &room,
        "--defaults",
        "--set",
        "goon.fast=0.4",
        "--set",
        "goon.slow=0.3",
    ]));
    assert_eq!(check.status, Some(0), "{}", check.err);
    let (_, defaults) = check
        .out
        .split_once("\ndefaults: ")
        .expect("the defaults are listed");
    assert!(
        defaults.contains("fast = 0.4 m/s (set without effect), turn = "),
        "{defaults}"
    );
}

#[test]
fn check_reports_every_fault_with_its_line_a_caret_and_help() {
    let check = output_of(&mut jde_with_plugins(&["check", &app("faulty.toml")]));
    assert_eq!(check.status, Some(2));
    for part in [
        "faulty.toml:7:1",
        "perod = \"10ms\"",
        "^^^^^",
        "did you mean `period`?",
        "faulty.toml:11:",
        "talker.cuont",
    ] {
        assert!(check.err.contains(part), "{part}: {}", check.err);
    }
    assert_eq!(check.err.matches("error: ").count(), 2, "{}", check.err);
    assert!(check.out.is_empty());
}

#[test]
fn check_reports_a_missing_application_and_suggests_the_nearest() {
    let check = output_of(&mut jde(&["check", "safe-navigatoin"]));
    assert_eq!(check.status, Some(2));
    assert!(
        check.err.contains("did you mean `safe-navigation`?"),
        "{}",
        check.err
    );
    let folder = tempfile::tempdir().unwrap();
    for (given, said) in [
        (".", "this is a folder"),
        ("nope.toml", "nope.toml: there is no such file"),
        ("odd", "this is a folder"),
    ] {
        std::fs::create_dir_all(folder.path().join("odd")).unwrap();
        let check = output_of(jde(&["check", given]).current_dir(&folder));
        assert_eq!(check.status, Some(2), "{given}: {}", check.err);
        let err = &check.err;
        assert!(err.contains(said) && err.contains("help: "), "{given}: {err}");
        assert!(!err.contains(": :") && !err.ends_with("\n\n"), "{given}: {err}");
    }
    let check = output_of(&mut jde(&["check", "no/such.toml"]));
    assert_eq!(check.status, Some(2));
    assert!(
        check
            .err
            .starts_with("error: no/such.toml: there is no such file"),
        "{}",
        check.err
    );
}

#[test]
fn check_reports_faults_in_options() {
    let check = output_of(&mut jde_with_plugins(&[
        "check",
        &app("room.toml"),
        "--set",
        "goon.sped=1",
    ]));
    assert_eq!(check.status, Some(2));
    assert!(check.err.contains("--set goon.sped=1"), "{}", check.err);
}

#[test]
fn an_unusable_plugin_has_another_exit_status_than_a_wrong_application() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("libbroken.so"), "no library").unwrap();
    let file = folder.path().join("app.toml");
    std::fs::write(
        &file,
        "name = \"x\"\nroots = [\"it\"]\n[schemas.it]\ntype = \"broken\"\n",
    )
    .unwrap();
    let check = output_of(&mut jde(&["check", file.to_str().unwrap()]));
    assert_eq!(check.status, Some(3), "{}", check.err);
    assert!(check.err.contains("no ELF header"), "{}", check.err);

    let describe = output_of(&mut jde(&[
        "describe",
        folder.path().join("libbroken.so").to_str().unwrap(),
    ]));
    assert_eq!(describe.status, Some(3));
    assert!(describe.err.starts_with("error: "), "{}", describe.err);

    let plugins = output_of(&mut jde(&["plugins", file.to_str().unwrap()]));
    assert_eq!(plugins.status, Some(0), "{}", plugins.err);
    assert!(
        plugins.out.contains("libbroken.so: it is not a shared library"),
        "{}",
        plugins.out
    );
}

#[test]
fn describe_refuses_a_type_that_the_plugin_does_not_have() {
    for (name, help) in [
        ("vff/vf", "did you mean `vff`?"),
        ("vff/nonsense", "there are: vff"),
    ] {
        let describe = output_of(&mut jde_with_plugins(&["describe", name]));
        assert_eq!(describe.status, Some(2), "{}", describe.out);
        assert!(
            describe.err.contains("there is no type of schema in `vff`"),
            "{}",
            describe.err
        );
        assert!(describe.err.contains(help), "{}", describe.err);
    }
}

#[test]
fn describe_shows_ports_with_their_types_and_limits() {
    let misspelt = output_of(&mut jde_with_plugins(&["describe", "stopp"]));
    assert_eq!(misspelt.status, Some(2), "{}", misspelt.err);
    assert!(misspelt.err.contains("did you mean `stop`?"), "{}", misspelt.err);
    let describe = output_of(&mut jde_with_plugins(&["describe", "stop"]));
    assert_eq!(describe.status, Some(0), "{}", describe.err);
    for part in [
        "stop/stop  motor, every 200 ms",
        "imports",
        "sensor_msgs/msg/LaserScan, triggers",
        "Float64 = 0.6 m, at least 0",
    ] {
        assert!(describe.out.contains(part), "{part}: {}", describe.out);
    }
    let guide = output_of(&mut jde_with_plugins(&["describe", "guide"])).out;
    let mut rows = guide.lines().filter(|line| line.starts_with("  patrol "));
    assert!(
        rows.any(|row| row.ends_with("always")),
        "a table is a line for each row: {guide}"
    );
    let by_type = output_of(&mut jde_with_plugins(&["describe", "sim/robot"]));
    assert!(by_type.out.contains("in force for 500 ms"), "{}", by_type.out);
}

#[test]
fn describe_prints_ports_children_and_panels_as_json() {
    let about = json(&output_of(&mut jde_with_plugins(&["describe", "stop", "--json"])).out);
    let schema = &about["schemas"][0];
    assert_eq!(
        (&about["name"], &schema["kind"], &schema["period_ns"]),
        (&"stop".into(), &"motor".into(), &200_000_000.into())
    );
    let ports = schema["ports"].as_array().unwrap();
    let ahead = ports.iter().find(|port| port["name"] == "ahead").unwrap();
    assert_eq!(
        (&ahead["role"], &ahead["default"], &ahead["unit"]),
        (&"modulation".into(), &0.6.into(), &"m".into())
    );
    let example = json(&output_of(&mut jde_with_plugins(&["describe", "example", "--json"])).out);
    let children = example["schemas"][0]["children"].as_array().unwrap();
    assert_eq!(
        children.iter().filter(|child| child["group"] == "base").count(),
        3
    );
    assert_eq!(example["schemas"][0]["panel"], true);
    let pair = json(&output_of(&mut jde_with_plugins(&["describe", "pair", "--json"])).out);
    assert_eq!(pair["schemas"][0]["panel"], false);
    let text = output_of(&mut jde_with_plugins(&["describe", "example"]));
    assert!(text.out.contains("Draws a panel of its own."), "{}", text.out);
}

#[test]
fn describe_shows_the_fields_of_a_value_type_and_the_ports_that_use_it() {
    let describe = |name: &str| output_of(&mut jde_with_plugins(&["describe", name]));
    let scan = describe("sensor_msgs/msg/LaserScan");
    assert_eq!(scan.status, Some(0), "{}", scan.err);
    for part in [
        "header.stamp.sec",
        "float32[<=1088] m",
        "exports",
        "sim/robot",
        "imports",
        "stop/stop",
    ] {
        assert!(scan.out.contains(part), "{part}: {}", scan.out);
    }
    assert_eq!(describe("LaserScan").out, scan.out);
    assert!(describe("Header").out.starts_with("std_msgs/msg/Header"));
    // No schema has it; an application file may name it.
    assert!(
        describe("std_srvs/srv/SetBool_Request")
            .out
            .contains("data  bool")
    );
    for (wrong, right) in [
        ("LaserScn", "LaserScan"),
        ("sensor_msgs/msg/LaserScn", "sensor_msgs/msg/LaserScan"),
    ] {
        let unknown = describe(wrong);
        assert_eq!(unknown.status, Some(2));
        assert!(
            unknown.err.contains(&format!("did you mean `{right}`?")),
            "{}",
            unknown.err
        );
    }
    let data = json(&output_of(&mut jde_with_plugins(&["describe", "Twist", "--json"])).out);
    let ports = data["ports"].as_array().unwrap();
    let base = ports.iter().find(|port| port["schema"] == "stop/stop").unwrap();
    assert_eq!(
        (&base["part"], &base["port"]),
        (&"actuators".into(), &"base".into())
    );
}

#[test]
fn describe_lists_the_searched_folders_for_a_missing_plugin() {
    let describe = output_of(&mut jde(&["describe", "nothing-like-it"]));
    assert_eq!(describe.status, Some(3));
    assert!(
        describe.err.contains("JDE_PLUGIN_PATH") && describe.err.contains("beside the executable"),
        "{}",
        describe.err
    );
}

#[test]
fn plugins_lists_the_folders_in_the_order_of_the_search() {
    let listing = json(&output_of(&mut jde_with_plugins(&["plugins", "--json"])).out);
    let folders = listing["folders"].as_array().unwrap();
    let reasons: Vec<_> = folders
        .iter()
        .map(|folder| folder["because"].as_str().unwrap())
        .collect();
    assert_eq!(reasons.first(), Some(&"JDE_PLUGIN_PATH"));
    assert_eq!(reasons.last(), Some(&"installed"));
    let found = folders[0]["plugins"].as_array().unwrap();
    let sim = found
        .iter()
        .find(|plugin| plugin["name"] == "sim")
        .expect("the simulator is found");
    let schemas = sim["schemas"].as_array().expect("a list");
    assert!(schemas.iter().any(|schema| schema == "robot"), "{sim}");
    let text = output_of(&mut jde_with_plugins(&["plugins"]));
    assert!(
        text.out.contains("(JDE_PLUGIN_PATH)") && text.out.contains("robot"),
        "{}",
        text.out
    );
}

#[test]
fn check_refuses_a_width_in_centimetres_and_an_angle_in_degrees() {
    for set in [
        "goon.half_width=28",
        "stop.half_width=28",
        "vff.veer=40",
        "guide.turning=40",
    ] {
        let check = output_of(&mut jde_with_plugins(&["check", &app("room.toml"), "--set", set]));
        assert_eq!(check.status, Some(2), "{set}: {check:?}");
        assert!(check.err.contains(set), "{}", check.err);
    }
}

#[test]
fn check_warns_of_an_import_that_never_has_a_value() {
    let folder = tempfile::tempdir().unwrap();
    let robot = fs::read_to_string(root().join("programs/jde/templates/robot/robot.toml")).unwrap();
    let (blind, _) = robot.split_once("[[lasers]]").unwrap();
    let model = folder.path().join("blind.toml");
    fs::write(&model, blind).unwrap();
    let set = format!("pioneer.model={}", model.display());
    let check = output_of(&mut jde_with_plugins(&[
        "check",
        &app("room.toml"),
        "--set",
        &set,
    ]));
    assert_eq!(check.status, Some(0), "{check:?}");
    for part in [
        "warning: `laser` of schema `goon` never has a value: `pioneer.laser` is never written",
        "has no laser: its file has no [[lasers]]",
        "room.toml:27",
    ] {
        assert!(check.err.contains(part), "`{part}` is not in: {}", check.err);
    }
}

#[test]
fn check_reports_a_missing_file_that_a_modulation_names() {
    let set = "pioneer.world=nowhere.toml";
    let check = output_of(&mut jde_with_plugins(&["check", &app("room.toml"), "--set", set]));
    assert_eq!(check.status, Some(2), "{check:?}");
    for part in [
        "--set pioneer.world=nowhere.toml",
        "`world` of schema `pioneer` is",
        "there is no such file",
    ] {
        assert!(check.err.contains(part), "`{part}` is not in: {}", check.err);
    }
    let check = output_of(&mut jde_with_plugins(&["check", &app("room.toml")]));
    assert_eq!(check.status, Some(0), "{check:?}");

    let shipped = output_of(&mut jde_with_plugins(&[
        "check",
        &app("room.toml"),
        "--set",
        "pioneer.model=turtlebot4",
    ]));
    assert!(
        shipped.status == Some(0) && shipped.out.contains("turtlebot4") && !shipped.out.contains("missing"),
        "{shipped:?}"
    );
    let unknown = output_of(&mut jde_with_plugins(&[
        "check",
        &app("room.toml"),
        "--set",
        "pioneer.model=turtlebot5",
    ]));
    assert!(unknown.err.contains("`turtlebot4`"), "{unknown:?}");

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("app.toml");
    let text = fs::read_to_string(app("room.toml")).unwrap();
    fs::write(&file, text).unwrap();
    for verb in ["check", "run"] {
        let output = output_of(&mut jde_with_plugins(&[verb, file.to_str().unwrap()]));
        assert_eq!(output.status, Some(2), "{output:?}");
        assert!(
            output.err.contains("app.toml:9:"),
            "the world is missing: {}",
            output.err
        );
    }
    let world = Path::new(&app("room.toml")).with_file_name("room-world.toml");
    let world = format!("pioneer.world={}", world.display());
    let replaced = output_of(&mut jde_with_plugins(&[
        "check",
        file.to_str().unwrap(),
        "--set",
        &world,
    ]));
    assert_eq!(
        replaced.status,
        Some(0),
        "an option replaces the missing one: {replaced:?}"
    );
}

/// Two robots and a scanner on neither, a guard of bases, and a head that no guard judges.
const UNWATCHED: &str = r#"
roots = ["teleop", "gaze"]
root  = { guard = "guard" }
[schemas.left]
type  = "sim/robot"
world = "WORLD"
[schemas.right]
type  = "sim/robot"
world = "WORLD"
[schemas.scanner]
type  = "hokuyo/scip2"
port  = "tcp:192.168.0.10:10940"
[schemas.guard]
type    = "guard/footprint"
imports = { laser = "scanner.laser", pose = "left.odometry" }
[schemas.teleop]
type      = "teleop/base"
actuators = { base = "left.velocity" }
[schemas.gaze]
type      = "teleop/head"
imports   = { pan_tilt = "left.pan_tilt" }
actuators = { head = "left.head" }
"#;

#[test]
fn r18_r19_check_names_what_no_guard_judges_and_what_nobody_notices() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("app.toml");
    let world = root().join("worlds/two-robots.toml");
    fs::write(&file, UNWATCHED.replace("WORLD", world.to_str().unwrap())).unwrap();
    let check = output_of(&mut jde_with_plugins(&["check", file.to_str().unwrap()]));
    assert_eq!(check.status, Some(0), "{}", check.err);
    for warning in [
        "warning: no guard judges `left.head`, which `gaze` may command: the guard `guard` judges geometry_msgs/msg/Twist",
        "warning: nothing notices if `scanner.laser` repeats itself while the base moves: no driver, or more than one, exports",
        "app.toml:4:1\n",
        "app.toml:10:1\n",
        "[schemas.scanner]",
    ] {
        assert!(check.err.contains(warning), "{warning}: {}", check.err);
    }
    // With the only odometry, the scanner is on that base.
    let single = fs::read_to_string(&file).unwrap();
    let (before, after) = single.split_once("[schemas.right]").unwrap();
    let after = after.split_once("[schemas.scanner]").unwrap().1;
    fs::write(&file, format!("{before}[schemas.scanner]{after}")).unwrap();
    let check = output_of(&mut jde_with_plugins(&["check", file.to_str().unwrap()]));
    assert_eq!(check.status, Some(0), "{}", check.err);
    assert!(!check.err.contains("nothing notices"), "{}", check.err);
}
