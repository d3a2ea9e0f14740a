//! An application as a node of ROS 2 under requests that are too many, and its clock.

use std::thread;

use serde_json::{Value, json};

use crate::attached::Sandbox;
use crate::ros_node::{Peer, double, open, unused_address};
use crate::support::jde_with_plugins;

#[test]
fn r14_a_stop_waits_for_no_other_request() {
    let sandbox = Sandbox::new();
    let (peer, _robot) = open(&sandbox, &[]);
    assert_eq!(peer.state(), "active");
    // As many as wait at most, of each of some services. Each takes at least 10 ms.
    let settings: Vec<_> = (0..900).map(|_| double("goon.fast", 0.2)).collect();
    let requests = [
        ("set_parameters", json!({ "parameters": settings })),
        (
            "set_parameters_atomically",
            json!({ "parameters": [double("goon.fast", 0.2)] }),
        ),
        ("get_parameters", json!({ "names": [] })),
        ("list_parameters", json!({})),
        ("describe_parameters", json!({ "names": [] })),
        ("get_state", json!({})),
    ];
    for (service, request) in &requests {
        for _ in 0..10 {
            peer.request(service, request);
        }
    }
    let stopped = peer.call("stop", json!({}));
    let taken = |service: &str| {
        let number = peer.services[service];
        std::iter::from_fn(|| peer.node.take_response(number)).count()
    };
    let answered: usize = requests.iter().map(|(service, _)| taken(service)).sum();
    assert_eq!(stopped, json!({ "success": true, "message": "" }));
    assert!(answered < 30, "{answered} of 60 requests were answered before");
    assert_eq!(sandbox.json(&["ps"])["groups"][0]["winner"], Value::Null);
}

#[test]
fn r14_each_parameter_of_a_request_counts_as_an_action() {
    let sandbox = Sandbox::new();
    let (peer, _robot) = open(&sandbox, &[]);
    let names = peer.call("list_parameters", json!({}))["result"]["names"].take();
    let burst = names.as_array().expect("names").len().max(100);
    // As many as fit into a request.
    let most = 900;
    assert!(burst < most);
    let many = |count: usize| -> Vec<_> { (0..count).map(|_| double("goon.fast", 0.2)).collect() };
    let set = peer.call("set_parameters", json!({ "parameters": many(most) }));
    let results = set["results"].as_array().expect("results");
    let accepted = results
        .iter()
        .filter(|result| result["successful"] == true)
        .count();
    assert!((100..most).contains(&accepted), "{accepted} of {}", results.len());
    let refused = results.last().expect("results");
    assert_eq!(
        refused["reason"],
        "more than 100 parameters are set in a second: it keeps its value; set it again later"
    );
    let atomically = peer.call(
        "set_parameters_atomically",
        json!({ "parameters": many(burst + 1) }),
    );
    assert_eq!(atomically["result"]["reason"], refused["reason"]);
    // Later it is possible again.
    let one = json!({ "parameters": many(1) });
    while peer.call("set_parameters", one.clone())["results"][0]["successful"] != true {
        thread::yield_now();
    }
}

#[test]
fn the_clock_of_the_drivers_is_a_parameter_as_of_every_node() {
    let sandbox = Sandbox::new();
    let address = unused_address();
    let peer = Peer::open(&sandbox, &address, "");
    let mut command = jde_with_plugins(&["run", "apps/ros2.toml", "--plain"]);
    command
        .args(["--set", &format!("topics.connect={address}")])
        .env("ROS_DOMAIN_ID", "7")
        .env("ROS_DISTRO", "jazzy")
        .env(
            "ZENOH_CONFIG_OVERRIDE",
            format!("connect/endpoints=[\"{address}\"]"),
        );
    let _robot = sandbox.spawn(
        command,
        &["--ros-args", "-r", "__node:=scout", "-r", "__ns:=/fleet"],
    );
    let listed = peer.call("list_parameters", json!({}))["result"]["names"].take();
    assert_eq!(listed[0], "use_sim_time");
    assert_eq!(peer.get("use_sim_time")["bool_value"], false);
    let set = |value: Value| {
        let parameter = json!({ "name": "use_sim_time", "value": value });
        peer.call("set_parameters", json!({ "parameters": [parameter] }))["results"][0].take()
    };
    for (is_simulated, clock) in [(true, "follow"), (false, "wall")] {
        let set = set(json!({ "type": 1, "bool_value": is_simulated }));
        assert_eq!(set["successful"], true, "{set}");
        assert_eq!(peer.get("use_sim_time")["bool_value"], is_simulated);
        assert_eq!(sandbox.run_ok(&["get", "topics.clock"]).trim(), clock);
    }
    assert_eq!(
        set(json!({ "type": 2, "integer_value": 1 }))["reason"],
        "`use_sim_time` is a bool"
    );
}
