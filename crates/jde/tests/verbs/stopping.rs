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
