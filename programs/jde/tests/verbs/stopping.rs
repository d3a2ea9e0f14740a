//! `jde stop --all`, on this machine and on robots at given addresses (R14).

use serde_json::Value;

use crate::attached::{Sandbox, navigation};
use crate::support::{pair, root};

#[test]
fn r14_stop_all_stops_every_application_and_release_all_lets_them_continue() {
    let sandbox = Sandbox::new();
    let none = sandbox.run(&["stop", "--all"]);
    assert_eq!(none.status, Some(1), "{none:?}");
    let _navigation = navigation(&sandbox);
    let other = sandbox.start(&pair(), &[]);
    let winners = |app: &str| -> Vec<Value> {
        let groups = sandbox.json(&["ps", "--app", app]);
        let groups = groups["groups"].as_array().expect("groups").iter();
        groups.map(|group| group["winner"].clone()).collect()
    };
    while winners("safe-navigation").iter().any(Value::is_null) {}
    let output = sandbox.run_ok(&["stop", "--all"]);
    assert!(
        output.contains("safe-navigation: teleop, example stopped, every command is neutral"),
        "{output}"
    );
    assert!(output.contains("pair: "), "{output}");
    let apps = sandbox.run_ok(&["apps"]);
    assert!(apps.contains("nobody: all stopped by ana@"), "{apps}");
    assert!(winners("safe-navigation").iter().all(Value::is_null));
    assert!(winners("pair").iter().all(Value::is_null));
    let twist = sandbox.run_ok(&["get", "--app", "safe-navigation", "pioneer.velocity"]);
    assert_eq!(
        twist.trim(),
        "{linear: {x: 0, y: 0, z: 0}, angular: {x: 0, y: 0, z: 0}}"
    );
    let output = sandbox.run_ok(&["release", "--all", "--app", "safe-navigation"]);
    assert!(
        output.contains("safe-navigation: teleop, example released from the stop of everything"),
        "{output}"
    );
    let again = sandbox.run_ok(&["release", "--all", "--app", "safe-navigation"]);
    assert!(
        again.contains("safe-navigation: nothing was stopped with everything"),
        "{again}"
    );
    while winners("safe-navigation").iter().any(Value::is_null) {}
    assert!(
        winners("pair").iter().all(Value::is_null),
        "only the named application continues"
    );
    // An application that does not respond is reported, and the others are stopped.
    other.signal("STOP");
    let output = sandbox.run(&["stop", "--all"]);
    assert_eq!(output.status, Some(1), "{output:?}");
    assert!(output.err.contains("pair did not do it"), "{output:?}");
    assert!(
        output.out.contains("safe-navigation: teleop, example stopped"),
        "{output:?}"
    );
    let unsupported = sandbox.run(&["stop", "--all", "--for", "1s"]);
    assert_eq!(unsupported.status, Some(2), "{unsupported:?}");
}

#[test]
fn r14_the_end_of_a_lease_leaves_a_stop_and_a_lease_disarms_none() {
    let sandbox = Sandbox::new();
    let _navigation = navigation(&sandbox);
    let schema = |name: &str| -> Value {
        let schemas = sandbox.json(&["ps"])["schemas"].clone();
        let mut schemas = schemas.as_array().expect("schemas").iter();
        let found = schemas.find(|schema| schema["name"] == name);
        found.expect("it is in the application").clone()
    };
    while schema("goon")["state"] == "slept" {}
    // The laser that the navigation reads: allowed, and said.
    let stopped = sandbox.run_ok(&["stop", "pioneer"]);
    assert!(stopped.contains("pioneer is stopped; "), "{stopped}");
    assert!(stopped.contains(" loses its laser"), "{stopped}");
    sandbox.run_ok(&["release", "pioneer"]);

    sandbox.run_ok(&["stop", "example"]);
    sandbox.run_ok(&["stop", "example", "--for", "200ms"]);
    assert_eq!(schema("example")["state"], "slept", "{}", schema("example"));
    for verb in ["force", "play"] {
        let refused = sandbox.run(&[verb, "example", "--for", "200ms"]);
        assert_eq!(refused.status, Some(2), "{refused:?}");
        assert!(refused.err.contains("`example` is stopped by "), "{refused:?}");
        assert!(
            refused.err.contains("`jde release example` ends that"),
            "{refused:?}"
        );
    }
    assert_eq!(schema("example")["state"], "slept", "{}", schema("example"));
    // Every hold is shown, and the operator still sees.
    sandbox.run_ok(&["stop", "--all"]);
    let table = sandbox.run_ok(&["ps"]);
    assert!(table.contains("stopped with everything by "), "{table}");
    assert!(table.contains(", stopped by "), "{table}");
    assert_eq!(schema("pioneer")["state"], "winner", "{table}");
    let refused = sandbox.run(&["play", "teleop", "--for", "200ms"]);
    assert!(refused.err.contains("`jde release --all`"), "{refused:?}");
    sandbox.run_ok(&["release", "--all"]);
    assert_eq!(schema("example")["state"], "slept", "a stop of its own stays");
    sandbox.run_ok(&["release", "example"]);
    while schema("example")["state"] != "winner" {}
}

#[test]
fn r14_stop_all_reports_an_unreachable_robot_and_stops_the_others() {
    let sandbox = Sandbox::new();
    let free_address = || {
        let socket = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        format!("tcp/{}", socket.local_addr().expect("the socket has an address"))
    };
    let (live, off) = (free_address(), free_address());
    let text = std::fs::read_to_string(root().join(pair())).expect("the application exists");
    let file = sandbox.folder().join("open.toml");
    std::fs::write(
        &file,
        format!("{text}\n[link]\nlisten = [\"{live}\"]\ninsecure = true\n"),
    )
    .expect("the folder is writable");
    let _robot = sandbox.start(&file.display().to_string(), &[]);
    let output = sandbox.run(&["stop", "--all", "--at", &off, "--at", &live]);
    assert_eq!(output.status, Some(1), "{output:?}");
    assert!(
        output.out.contains("pair: ") && output.out.contains("stopped, every command is neutral"),
        "{output:?}"
    );
    assert!(output.err.contains(&format!("{off} did not do it")), "{output:?}");
    let output = sandbox.run(&["stop", "--all", "--at", &live]);
    assert_eq!(output.status, Some(0), "{output:?}");
}
