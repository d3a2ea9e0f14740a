//! An application as a node of ROS 2, seen by another node: parameters, life cycle, services, log and health.

use std::collections::BTreeMap;
use std::time::Duration;

use jde_ros_node::interface::standard;
use jde_ros_node::{Client, Node, NodeConfig, Quality, Service, Settings, Topic};
use serde_json::{Value, json};

use crate::attached::{Running, Sandbox};
use crate::support::jde_with_plugins;

const SERVICES: [(&str, &str); 10] = [
    ("list_parameters", "rcl_interfaces/srv/ListParameters"),
    ("get_parameters", "rcl_interfaces/srv/GetParameters"),
    ("describe_parameters", "rcl_interfaces/srv/DescribeParameters"),
    ("set_parameters", "rcl_interfaces/srv/SetParameters"),
    (
        "set_parameters_atomically",
        "rcl_interfaces/srv/SetParametersAtomically",
    ),
    ("get_state", "lifecycle_msgs/srv/GetState"),
    ("change_state", "lifecycle_msgs/srv/ChangeState"),
    ("stop", "std_srvs/srv/Trigger"),
    ("release", "std_srvs/srv/Trigger"),
    ("enable", "std_srvs/srv/SetBool"),
];
const TOPICS: [(&str, &str, Quality); 5] = [
    (
        "/parameter_events",
        "rcl_interfaces/msg/ParameterEvent",
        Quality::PARAMETERS,
    ),
    (
        "/fleet/health",
        "diagnostic_msgs/msg/DiagnosticArray",
        Quality::DEFAULT,
    ),
    (
        "/fleet/scout/transition_event",
        "lifecycle_msgs/msg/TransitionEvent",
        Quality::DEFAULT,
    ),
    ("/rosout", "rcl_interfaces/msg/Log", Quality::LOG),
    ("/fleet/bond", "bond/msg/Status", Quality::DEFAULT),
];

/// Another node, which is also the router.
pub(crate) struct Peer {
    pub(crate) node: Node,
    pub(crate) services: BTreeMap<&'static str, usize>,
}

impl Peer {
    /// `middleware` comes before the addresses of a driver.
    pub(crate) fn open(sandbox: &Sandbox, address: &str, middleware: &str) -> Self {
        let file = sandbox.folder().join("router.json5");
        let config = format!(
            "{{ mode: \"router\", listen: {{ endpoints: [\"{address}\"] }}, scouting: {{ multicast: {{ enabled: false }} }} }}"
        );
        std::fs::write(&file, config).expect("a file");
        let settings = Settings {
            config: file.to_str().expect("a path"),
            connect: &format!("{middleware}tcp/localhost:7447"),
            listen: "",
            domain: 7,
            namespace: "",
            node: "peer",
            owner: "",
            remap: "",
        };
        let clients = SERVICES.map(|(name, kind)| Client {
            service: Service::new(format!("/fleet/scout/{name}"), kind, standard()).expect("a service"),
            timeout: Duration::from_secs(60),
        });
        let topics = TOPICS.map(|(name, kind, quality)| {
            Topic::of_interface(name.to_owned(), kind, standard(), quality).expect("a topic")
        });
        let config = NodeConfig {
            clients: clients.to_vec(),
            subscriptions: topics.to_vec(),
            ..settings.node_config().expect("the address is valid")
        };
        let names = SERVICES.iter().enumerate();
        Self {
            node: Node::start(config).expect("a thread"),
            services: names.map(|(number, (name, _))| (*name, number)).collect(),
        }
    }

    /// Sends a request to a service of the application, as soon as it is there. Returns its number.
    pub(crate) fn request(&self, name: &str, request: &Value) -> i64 {
        let number = self.services[name];
        let kind = SERVICES[number].1;
        let message = standard()
            .encode(&format!("{kind}_Request"), request)
            .expect("a request");
        while !self.node.has_server(number) {
            std::thread::yield_now();
        }
        self.node.call(number, message)
    }

    /// Calls a service of the application, as soon as it is there.
    pub(crate) fn call(&self, name: &str, request: Value) -> Value {
        let sequence = self.request(name, &request);
        let number = self.services[name];
        let kind = SERVICES[number].1;
        let response = loop {
            match self.node.take_response(number) {
                Some(response) => break response,
                None => std::thread::yield_now(),
            }
        };
        assert_eq!(response.sequence, sequence);
        standard()
            .decode(&format!("{kind}_Response"), &response.outcome.expect("an answer"))
            .expect("a response")
    }

    /// Waits for a message on a topic that fulfils a condition.
    fn until(&self, topic: &str, mut condition: impl FnMut(&Value) -> bool) -> Value {
        let number = TOPICS
            .iter()
            .position(|(name, ..)| *name == topic)
            .expect("a topic");
        loop {
            for message in self.node.take_all(number) {
                let value = standard().decode(TOPICS[number].1, &message.message.to_bytes());
                let value = value.expect("a message");
                if condition(&value) {
                    return value;
                }
            }
            std::thread::yield_now();
        }
    }

    pub(crate) fn get(&self, name: &str) -> Value {
        self.call("get_parameters", json!({ "names": [name] }))["values"][0].take()
    }

    pub(crate) fn state(&self) -> Value {
        self.call("get_state", json!({}))["current_state"]["label"].take()
    }

    /// Requests a transition, which succeeds, and returns the state then.
    fn change(&self, transition: u8) -> Value {
        let request = json!({ "transition": { "id": transition } });
        assert_eq!(self.call("change_state", request), json!({ "success": true }));
        self.state()
    }
}

/// Starts a peer, and an application with these options.
pub(crate) fn open(sandbox: &Sandbox, options: &[&str]) -> (Peer, Running) {
    open_with(sandbox, options, "jazzy", "")
}

/// As `open`, in a terminal of this distribution.
fn open_with(sandbox: &Sandbox, options: &[&str], distribution: &str, middleware: &str) -> (Peer, Running) {
    let address = unused_address();
    let peer = Peer::open(sandbox, &address, middleware);
    (peer, start(sandbox, &address, options, distribution))
}

pub(crate) fn unused_address() -> String {
    let socket = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    format!("tcp/{}", socket.local_addr().expect("the socket has an address"))
}

fn start(sandbox: &Sandbox, address: &str, options: &[&str], distribution: &str) -> Running {
    let mut command = jde_with_plugins(&["run", "apps/safe-navigation.toml", "--plain"]);
    command.args(options);
    command
        .env("ROS_DOMAIN_ID", "7")
        .env("ROS_DISTRO", distribution)
        .env(
            "ZENOH_CONFIG_OVERRIDE",
            format!("connect/endpoints=[\"{address}\"]"),
        );
    let file = sandbox.folder().join("parameters.yaml");
    let parameters =
        "/fleet/*: { ros__parameters: { goon.slow: 0.15 } }\nother: { ros__parameters: { none: 1 } }";
    std::fs::write(&file, parameters).expect("a file");
    let names = [
        "-r",
        "__node:=scout",
        "-r",
        "__ns:=/fleet",
        "-r",
        "/diagnostics:=health",
        "-p",
        "goon.fast:=0.3",
        "--params-file",
        file.to_str().expect("a path"),
        "--log-level",
        "fleet.scout.goon:=debug",
    ];
    sandbox.spawn(command, &[&["--ros-args"][..], &names].concat())
}

pub(crate) fn double(name: &str, value: f64) -> Value {
    json!({ "name": name, "value": { "type": 3, "double_value": value } })
}

#[test]
fn r14_a_node_of_ros_operates_the_application() {
    let sandbox = Sandbox::new();
    let (peer, _robot) = open(&sandbox, &[]);

    let listed = peer.call("list_parameters", json!({ "prefixes": ["goon"] }));
    let names = listed["result"]["names"].as_array().expect("names");
    assert!(names.contains(&json!("goon.fast")), "{listed}");
    assert!(
        names
            .iter()
            .all(|name| name.as_str().is_some_and(|name| name.starts_with("goon."))),
        "{listed}"
    );
    assert_eq!(peer.get("goon.fast")["double_value"], 0.3);
    assert_eq!(peer.get("goon.slow")["double_value"], 0.15);
    assert_eq!(peer.get("goon.none")["type"], 0);
    let described = peer.call("describe_parameters", json!({ "names": ["goon.fast"] }));
    let descriptor = &described["descriptors"][0];
    assert!(
        descriptor["description"]
            .as_str()
            .is_some_and(|text| text.ends_with(" [m/s]")),
        "{descriptor}"
    );
    assert!(
        descriptor["floating_point_range"][0]["to_value"].is_number(),
        "{descriptor}"
    );

    let set = peer.call(
        "set_parameters",
        json!({ "parameters": [double("goon.fast", 0.25)] }),
    );
    assert_eq!(set["results"][0], json!({ "successful": true, "reason": "" }));
    assert_eq!(sandbox.json(&["get", "goon.fast"])["value"], 0.25);
    peer.until("/parameter_events", |event| {
        let mut changed = event["changed_parameters"].as_array().expect("a list").iter();
        event["node"] == "/fleet/scout"
            && changed.any(|parameter| {
                parameter["name"] == "goon.fast" && parameter["value"]["double_value"] == 0.25
            })
    });
    let wrong = json!({ "parameters": [
        double("goon.fast", 0.2),
        { "name": "goon.fst", "value": { "type": 3, "double_value": 0.1 } },
    ] });
    let refused = peer.call("set_parameters_atomically", wrong);
    assert_eq!(
        refused["result"]["reason"],
        "there is no parameter `goon.fst`; did you mean `goon.fast`?"
    );
    assert_eq!(peer.get("goon.fast")["double_value"], 0.25);
    let text = json!({ "name": "goon.fast", "value": { "type": 4, "string_value": "a" } });
    let refused = peer.call(
        "set_parameters",
        json!({ "parameters": [text, double("goon.fast", -1.0)] }),
    );
    assert_eq!(
        refused["results"][0]["reason"],
        "`goon.fast` is a double, not a text"
    );
    assert_eq!(refused["results"][1]["successful"], false, "{refused}");

    assert_eq!(peer.state(), "active");
    let change = |label: &str| peer.call("change_state", json!({ "transition": { "label": label } }));
    assert_eq!(change("deactivate"), json!({ "success": true }));
    assert_eq!(peer.state(), "inactive");
    let event = peer.until("/fleet/scout/transition_event", |event| {
        event["goal_state"]["label"] == "inactive"
    });
    assert_eq!(event["transition"]["label"], "deactivate");
    let groups = sandbox.json(&["ps"])["groups"].take();
    let mut groups = groups.as_array().expect("groups").iter();
    assert!(groups.all(|group| group["winner"].is_null()), "nobody wins");
    assert_eq!(change("deactivate"), json!({ "success": false }));
    // What another operator does is the same life cycle.
    sandbox.run_ok(&["release", "--all"]);
    assert_eq!(peer.state(), "active");
    sandbox.run_ok(&["stop", "--all"]);
    assert_eq!(peer.state(), "inactive");
    assert_eq!(peer.call("release", json!({}))["success"], true);
    assert_eq!(peer.state(), "active");
    for (data, state) in [(false, "inactive"), (true, "active")] {
        assert_eq!(peer.call("enable", json!({ "data": data }))["success"], true);
        assert_eq!(peer.state(), state);
    }

    peer.until("/fleet/health", |array| {
        let mut statuses = array["status"].as_array().expect("a list").iter();
        statuses.any(|status| status["name"] == "scout: goon" && status["level"] == 0)
    });
    assert_eq!(
        peer.call("change_state", json!({ "transition": { "id": 7 } })),
        json!({ "success": true })
    );
    let event = peer.until("/fleet/scout/transition_event", |event| {
        event["goal_state"]["label"] == "finalized"
    });
    assert_eq!(event["transition"]["label"], "shutdown");
    while !sandbox.apps().is_empty() {}
}

#[test]
fn r14_a_manager_of_life_cycles_brings_the_application_up_and_down() {
    let (configure, cleanup, activate, deactivate, shutdown) = (1, 2, 3, 4, 5);
    let sandbox = Sandbox::new();
    let (peer, mut robot) = open(&sandbox, &["--stopped"]);
    assert_eq!(peer.state(), "unconfigured");
    let schemas = sandbox.json(&["ps"])["schemas"].take();
    let mut schemas = schemas.as_array().expect("schemas").iter();
    assert!(
        schemas.all(|schema| schema["iterations"] == 0),
        "nothing has been awake"
    );
    assert_eq!(peer.change(configure), "inactive");
    assert_eq!(peer.change(activate), "active");
    let heartbeat = |active: bool| {
        peer.until("/fleet/bond", |status| {
            status["id"] == "scout" && status["active"] == active
        })
    };
    let instance = heartbeat(true)["instance_id"].take();
    assert_ne!(instance, "");
    assert_eq!(peer.change(deactivate), "inactive");
    assert_eq!(heartbeat(false)["instance_id"], instance);
    assert_eq!(peer.change(cleanup), "unconfigured");
    sandbox.run_ok(&["release", "--all"]);
    assert_eq!(peer.state(), "active");
    sandbox.run_ok(&["stop", "--all"]);
    assert_eq!(peer.state(), "inactive");
    assert_eq!(peer.change(cleanup), "unconfigured");
    let request = json!({ "transition": { "id": shutdown } });
    assert_eq!(peer.call("change_state", request), json!({ "success": true }));
    let up_and_down = ["configure", "activate", "deactivate", "cleanup"];
    let mut transitions = Vec::new();
    peer.until("/fleet/scout/transition_event", |event| {
        transitions.push(event["transition"]["label"].clone());
        event["goal_state"]["label"] == "finalized"
    });
    let expected = [&up_and_down[..], &up_and_down, &["shutdown"]].concat();
    assert_eq!(transitions, expected, "each has its event");
    assert_eq!(
        robot.wait(),
        Some(0),
        "it ended as requested, whatever its mission"
    );
}

#[test]
fn a_node_in_a_terminal_of_humble_speaks_to_nodes_of_humble() {
    let sandbox = Sandbox::new();
    let (peer, _robot) = open_with(&sandbox, &[], "humble", "humble/");
    assert_eq!(peer.get("goon.fast")["double_value"], 0.3);
}

#[test]
fn a_run_without_a_router_is_the_same_and_says_so_once() {
    let sandbox = Sandbox::new();
    let address = unused_address();
    let mut command = sandbox.command(jde_with_plugins(&[
        "run",
        "apps/safe-navigation.toml",
        "--plain",
        "--for",
        "6s",
        "--ros-args",
    ]));
    command.env(
        "ZENOH_CONFIG_OVERRIDE",
        format!("connect/endpoints=[\"{address}\"]"),
    );
    let output = crate::support::output_of(&mut command);
    assert_eq!(output.status, Some(1), "its time was up: {output:?}");
    let said = output.err.matches("is the router running?").count();
    assert_eq!(said, 1, "{output:?}");
}

#[test]
fn simulated_time_is_the_clock_of_each_driver_that_states_none() {
    let sandbox = Sandbox::new();
    for (options, parameter, expected) in [
        (&[][..], "use_sim_time:=true", "follow"),
        (&[], "use_sim_time:=false", "wall"),
        (
            &["--set", "topics.clock=publish"],
            "use_sim_time:=true",
            "publish",
        ),
    ] {
        let mut command = jde_with_plugins(&["run", "apps/ros2.toml", "--plain"]);
        // Nothing answers there.
        command
            .args(["--set", "topics.connect=tcp/127.0.0.1:9"])
            .args(options);
        command.env("ZENOH_CONFIG_OVERRIDE", "connect/endpoints=[\"tcp/127.0.0.1:9\"]");
        let _robot = sandbox.spawn(command, &["--ros-args", "-p", parameter]);
        let clock = sandbox.run_ok(&["get", "topics.clock"]);
        assert_eq!(clock.trim(), expected, "{options:?} {parameter}");
    }
}

#[test]
fn wrong_arguments_of_ros_are_usage() {
    let sandbox = Sandbox::new();
    for (arguments, expected) in [
        (&["-r", "scan:=front/"][..], "`front/` is not a valid name"),
        (&["-r", "__node:=a b"], "node = \"a b\""),
        (&["-p", "goon.fst:=1"], "did you mean `fast`?"),
    ] {
        let mut command = sandbox.command(jde_with_plugins(&[
            "run",
            "apps/safe-navigation.toml",
            "--ros-args",
        ]));
        let output = crate::support::output_of(command.args(arguments));
        assert_eq!(output.status, Some(2), "{output:?}");
        assert!(output.err.contains(expected), "{arguments:?}: {output:?}");
    }
}
