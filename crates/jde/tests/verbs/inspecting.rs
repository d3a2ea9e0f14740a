//! Verbs that start nothing: check, describe, plugins.

use std::fs;

use crate::support::{app, jde, jde_with_plugins, json, said};

#[test]
fn r17_check_shows_the_tree_the_bindings_and_the_contract_of_every_group() {
    let check = said(&mut jde_with_plugins(&["check", &app("room.toml")]));
    assert_eq!(check.status, Some(0), "{}", check.err);
    let places: Vec<_> = [
        "roots:",
        "guide  example/example",
        "base:",
        "stop as brake",
        "vff as avoid",
        "goon as cruise",
        "pioneer  sim/pioneer",
    ]
    .map(|part| {
        check
            .out
            .find(part)
            .unwrap_or_else(|| panic!("{part}: {}", check.out))
    })
    .into();
    assert!(places.is_sorted(), "{}", check.out);
    for part in [
        "laser <- pioneer.laser, which triggers",
        "base -> pioneer.velocity",
        "avoid.target -> vff.target",
    ] {
        assert!(check.out.contains(part), "{part}: {}", check.out);
    }
    for contract in ["roots: guide takes over within", "guide/base: "] {
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
fn check_lists_on_request_what_has_the_default_of_its_type() {
    let room = app("room.toml");
    let check = said(&mut jde_with_plugins(&[
        "check",
        &room,
        "--defaults",
        "--set",
        "goon.fast=0.4",
        "--set",
        "goon.slow=0.3",
    ]));
    assert_eq!(check.status, Some(0), "{}", check.err);
    let (_, defaults) = check.out.split_once("\ndefaults: ").expect("they are listed");
    assert!(
        defaults.contains("fast = 0.4 m/s (set without effect), turn = "),
        "{defaults}"
    );
}

#[test]
fn check_shows_all_faults_each_with_its_line_a_caret_and_help() {
    let check = said(&mut jde_with_plugins(&["check", &app("faulty.toml")]));
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
fn check_names_a_missing_application_and_the_nearest() {
    let check = said(&mut jde(&["check", "safe-navigatoin"]));
    assert_eq!(check.status, Some(2));
    assert!(
        check.err.contains("did you mean `safe-navigation`?"),
        "{}",
        check.err
    );
    let check = said(&mut jde(&["check", "no/such.toml"]));
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
fn an_option_is_checked_like_the_file() {
    let check = said(&mut jde_with_plugins(&[
        "check",
        &app("room.toml"),
        "--set",
        "goon.sped=1",
    ]));
    assert_eq!(check.status, Some(2));
    assert!(check.err.contains("--set goon.sped=1"), "{}", check.err);
}

#[test]
fn a_plugin_that_cannot_be_used_is_told_from_a_wrong_application() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("libbroken.so"), "no library").unwrap();
    let file = folder.path().join("app.toml");
    std::fs::write(
        &file,
        "name = \"x\"\nroots = [\"it\"]\n[schemas.it]\ntype = \"broken\"\n",
    )
    .unwrap();
    let check = said(&mut jde(&["check", file.to_str().unwrap()]));
    assert_eq!(check.status, Some(3), "{}", check.err);
    assert!(check.err.contains("no ELF header"), "{}", check.err);

    let describe = said(&mut jde(&[
        "describe",
        folder.path().join("libbroken.so").to_str().unwrap(),
    ]));
    assert_eq!(describe.status, Some(3));
    assert!(describe.err.starts_with("error: "), "{}", describe.err);

    let plugins = said(&mut jde(&["plugins", file.to_str().unwrap()]));
    assert_eq!(plugins.status, Some(0), "{}", plugins.err);
    assert!(
        plugins.out.contains("libbroken.so: it is not a shared library"),
        "{}",
        plugins.out
    );
}

#[test]
fn describe_tells_ports_and_what_they_hold() {
    let describe = said(&mut jde_with_plugins(&["describe", "stop"]));
    assert_eq!(describe.status, Some(0), "{}", describe.err);
    for part in [
        "stop/stop  motor, every 200 ms",
        "imports",
        "sensor_msgs/msg/LaserScan, triggers",
        "Float64 = 0.6 m, at least 0",
    ] {
        assert!(describe.out.contains(part), "{part}: {}", describe.out);
    }
    let by_type = said(&mut jde_with_plugins(&["describe", "sim/pioneer"]));
    assert!(by_type.out.contains("in force for 500 ms"), "{}", by_type.out);
}

#[test]
fn describe_tells_tools_the_same() {
    let about = json(&said(&mut jde_with_plugins(&["describe", "stop", "--json"])).out);
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
    let example = json(&said(&mut jde_with_plugins(&["describe", "example", "--json"])).out);
    let children = example["schemas"][0]["children"].as_array().unwrap();
    assert_eq!(
        children.iter().filter(|child| child["group"] == "base").count(),
        3
    );
    assert_eq!(example["schemas"][0]["panel"], true);
    let pair = json(&said(&mut jde_with_plugins(&["describe", "pair", "--json"])).out);
    assert_eq!(pair["schemas"][0]["panel"], false);
    let words = said(&mut jde_with_plugins(&["describe", "example"]));
    assert!(words.out.contains("Draws a panel of its own."), "{}", words.out);
}

#[test]
fn describe_shows_the_fields_of_a_value_and_who_has_it() {
    let describe = |name: &str| said(&mut jde_with_plugins(&["describe", name]));
    let scan = describe("sensor_msgs/msg/LaserScan");
    assert_eq!(scan.status, Some(0), "{}", scan.err);
    for words in [
        "header.stamp.sec",
        "float32[<=1088] m",
        "exports",
        "sim/pioneer",
        "imports",
        "stop/stop",
    ] {
        assert!(scan.out.contains(words), "{words}: {}", scan.out);
    }
    assert_eq!(describe("LaserScan").out, scan.out);
    assert!(describe("Header").out.starts_with("std_msgs/msg/Header"));
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
    let data = json(&said(&mut jde_with_plugins(&["describe", "Twist", "--json"])).out);
    let ports = data["ports"].as_array().unwrap();
    let base = ports.iter().find(|port| port["schema"] == "stop/stop").unwrap();
    assert_eq!(
        (&base["part"], &base["port"]),
        (&"actuators".into(), &"base".into())
    );
}

#[test]
fn describe_says_where_it_looked_for_a_plugin_that_is_not_there() {
    let describe = said(&mut jde(&["describe", "nothing-like-it"]));
    assert_eq!(describe.status, Some(3));
    assert!(
        describe.err.contains("JDE_PLUGIN_PATH") && describe.err.contains("beside the executable"),
        "{}",
        describe.err
    );
}

#[test]
fn plugins_are_listed_with_their_folders_in_the_order_of_the_search() {
    let listing = json(&said(&mut jde_with_plugins(&["plugins", "--json"])).out);
    let folders = listing["folders"].as_array().unwrap();
    let because: Vec<_> = folders
        .iter()
        .map(|folder| folder["because"].as_str().unwrap())
        .collect();
    assert_eq!(because.first(), Some(&"JDE_PLUGIN_PATH"));
    assert_eq!(because.last(), Some(&"installed"));
    let found = folders[0]["plugins"].as_array().unwrap();
    let sim = found
        .iter()
        .find(|plugin| plugin["name"] == "sim")
        .expect("the simulator is found");
    assert_eq!(sim["schemas"][0], "pioneer");
    let words = said(&mut jde_with_plugins(&["plugins"]));
    assert!(
        words.out.contains("(JDE_PLUGIN_PATH)") && words.out.contains("pioneer"),
        "{}",
        words.out
    );
}

#[test]
fn check_says_which_file_is_not_there() {
    let set = "pioneer.world=nowhere.toml";
    let check = said(&mut jde_with_plugins(&["check", &app("room.toml"), "--set", set]));
    assert_eq!(check.status, Some(2), "{check:?}");
    for words in [
        "--set pioneer.world=nowhere.toml",
        "`world` of schema `pioneer` is",
        "there is no such file",
    ] {
        assert!(check.err.contains(words), "`{words}` is not in: {}", check.err);
    }
    let check = said(&mut jde_with_plugins(&["check", &app("room.toml")]));
    assert_eq!(check.status, Some(0), "{check:?}");

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("app.toml");
    let text = fs::read_to_string(app("room.toml")).unwrap();
    fs::write(&file, text).unwrap();
    for verb in ["check", "run"] {
        let told = said(&mut jde_with_plugins(&[verb, file.to_str().unwrap()]));
        assert_eq!(told.status, Some(2), "{told:?}");
        assert!(
            told.err.contains("app.toml:9:"),
            "its world is not beside it: {}",
            told.err
        );
    }
}
