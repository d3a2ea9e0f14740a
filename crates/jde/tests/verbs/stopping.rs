//! Stopping everything at once, on this machine and on robots at given addresses (R14).

use serde_json::Value;

use crate::attached::{Place, navigation};
use crate::support::{pair, root};

#[test]
fn r14_everything_is_stopped_at_once_in_all_applications_and_let_go_on() {
    let place = Place::new();
    let none = place.says(&["stop", "--all"]);
    assert_eq!(none.status, Some(1), "{none:?}");
    let _navigation = navigation(&place);
    let other = place.start(&pair(), &[]);
    let winners = |app: &str| -> Vec<Value> {
        let groups = place.json(&["ps", "--app", app]);
        let groups = groups["groups"].as_array().expect("groups").iter();
        groups.map(|group| group["winner"].clone()).collect()
    };
    while winners("safe-navigation").iter().any(Value::is_null) {}
    let said = place.told(&["stop", "--all"]);
    assert!(
        said.contains("safe-navigation: teleop, example stopped, every command is neutral"),
        "{said}"
    );
    assert!(said.contains("pair: "), "{said}");
    assert!(winners("safe-navigation").iter().all(Value::is_null));
    assert!(winners("pair").iter().all(Value::is_null));
    let twist = place.told(&["get", "--app", "safe-navigation", "pioneer.velocity"]);
    assert_eq!(
        twist.trim(),
        "{linear: {x: 0, y: 0, z: 0}, angular: {x: 0, y: 0, z: 0}}"
    );
    let said = place.told(&["release", "--all", "--app", "safe-navigation"]);
    assert!(
        said.contains("safe-navigation: teleop, example released"),
        "{said}"
    );
    while winners("safe-navigation").iter().any(Value::is_null) {}
    assert!(winners("pair").iter().all(Value::is_null), "only what was named");
    // An application that does not respond is named, and the others are stopped all the same.
    other.signal("STOP");
    let said = place.says(&["stop", "--all"]);
    assert_eq!(said.status, Some(1), "{said:?}");
    assert!(said.err.contains("pair did not do it"), "{said:?}");
    assert!(
        said.out.contains("safe-navigation: teleop, example stopped"),
        "{said:?}"
    );
    let slip = place.says(&["stop", "--all", "--for", "1s"]);
    assert_eq!(slip.status, Some(2), "{slip:?}");
}

#[test]
fn r14_a_robot_that_is_switched_off_is_named_and_keeps_nobody_else_from_being_stopped() {
    let place = Place::new();
    let free = || {
        let socket = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        format!("tcp/{}", socket.local_addr().expect("it has one"))
    };
    let (live, off) = (free(), free());
    let text = std::fs::read_to_string(root().join(pair())).expect("it is there");
    let file = place.folder().join("open.toml");
    std::fs::write(
        &file,
        format!("{text}\n[link]\nlisten = [\"{live}\"]\ninsecure = true\n"),
    )
    .expect("it can be written");
    let _robot = place.start(&file.display().to_string(), &[]);
    let said = place.says(&["stop", "--all", "--at", &off, "--at", &live]);
    assert_eq!(said.status, Some(1), "{said:?}");
    assert!(
        said.out.contains("pair: ") && said.out.contains("stopped, every command is neutral"),
        "{said:?}"
    );
    assert!(said.err.contains(&format!("{off} did not do it")), "{said:?}");
    let said = place.says(&["stop", "--all", "--at", &live]);
    assert_eq!(said.status, Some(0), "{said:?}");
}
