//! The arbiter of a ROS 2 robot is killed, and its watchdog stops the robot: each is a process.

use std::time::{Duration, Instant};

use jde_ros_node::{Node, NodeConfig, Quality, Settings, Topic};
use jde_types::{Twist, Value};

use crate::attached::{Running, Sandbox};
use crate::ros_node::unused_address;
use crate::support::jde_with_plugins;

/// What each message begins with: numbers have their least significant byte first.
const HEAD: [u8; 4] = [0, 1, 0, 0];
/// Between two velocities of the program that drives.
const PERIOD: Duration = Duration::from_millis(20);
/// The watchdog's, longer than a loaded machine lets the arbiter wait.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The router, a program that drives, and a robot that keeps its last velocity.
struct Robot {
    node: Node,
    sent: Instant,
    address: String,
}

impl Robot {
    fn open(sandbox: &Sandbox) -> Self {
        let address = unused_address();
        let file = sandbox.folder().join("router.json5");
        let config = format!(
            "{{ mode: \"router\", listen: {{ endpoints: [\"{address}\"] }}, scouting: {{ multicast: {{ enabled: false }} }} }}"
        );
        std::fs::write(&file, config).expect("a file");
        let settings = Settings {
            config: file.to_str().expect("a path"),
            connect: "tcp/localhost:7447",
            listen: "",
            domain: 7,
            namespace: "",
            node: "robot",
            owner: "",
            remap: "",
        };
        let topic = |name: &str| Topic::new(name.to_owned(), &Twist::describe(), Quality::DEFAULT);
        let config = NodeConfig {
            publications: vec![topic("/teleop/cmd_vel")],
            subscriptions: vec![topic("/cmd_vel")],
            ..settings.node_config().expect("the address is valid")
        };
        Self {
            node: Node::start(config).expect("a thread"),
            sent: Instant::now(),
            address,
        }
    }

    /// Starts an application whose schemas connect to it.
    fn start(&self, sandbox: &Sandbox, application: &str, schemas: &[&str], options: &[&str]) -> Running {
        let mut command = jde_with_plugins(&["run", application, "--plain"]);
        command.env("ROS_DOMAIN_ID", "7").env_remove("ROS_DISTRO");
        for schema in schemas {
            command.args(["--set", &format!("{schema}.connect={}", self.address)]);
        }
        sandbox.spawn(command, options)
    }

    /// Lets the program drive at 0.3 m/s until such a speed comes to the robot.
    fn until(&mut self, is_expected: impl Fn(f64) -> bool) {
        loop {
            if self.sent.elapsed() >= PERIOD {
                self.sent = Instant::now();
                let numbers = [0.3_f64, 0.0, 0.0, 0.0, 0.0, 0.0].map(f64::to_le_bytes);
                self.node.append(0, [&HEAD, numbers.as_flattened()].concat());
            }
            for message in self.node.take_all(0) {
                let bytes = message.message.to_bytes();
                let ahead = bytes[HEAD.len()..].first_chunk().expect("a velocity");
                if is_expected(f64::from_le_bytes(*ahead)) {
                    return;
                }
            }
            std::thread::yield_now();
        }
    }
}

/// How often the watchdog has published, and its state.
fn watchdog(sandbox: &Sandbox) -> (u64, String) {
    let now = sandbox.json(&["ps", "ros2-watchdog"]);
    let schema = &now["schemas"][0];
    let state = schema["state"].as_str().expect("a state").to_owned();
    (schema["iterations"].as_u64().expect("a number"), state)
}

#[test]
fn a_watchdog_stops_the_robot_of_an_arbiter_that_is_killed() {
    const ARBITER: (&str, [&str; 4]) = (
        "apps/ros2-arbiter.toml",
        ["robot", "teleop", "docking", "navigation"],
    );
    let sandbox = Sandbox::new();
    let mut robot = Robot::open(&sandbox);
    let timeout = format!("watchdog.timeout={} s", TIMEOUT.as_secs());
    let _watchdog = robot.start(
        &sandbox,
        "apps/ros2-watchdog.toml",
        &["watchdog"],
        &["--set", &timeout],
    );
    // It drives on by the last velocity while the test asks the watchdog.
    let patience = ["--set", "teleop.patience=3600 s"];
    let mut arbiter = robot.start(&sandbox, ARBITER.0, &ARBITER.1, &patience);
    for _ in 0..40 {
        robot.until(|speed| speed == 0.3);
    }
    let hears = ["get", "watchdog.velocity", "--app", "ros2-watchdog"];
    while sandbox.run(&hears).status != Some(0) {
        robot.until(|speed| speed == 0.3);
    }
    assert_eq!(watchdog(&sandbox), (0, "checking".to_owned()));

    arbiter.signal("KILL");
    assert_eq!(arbiter.wait(), None, "nothing stopped the robot");
    let killed = Instant::now();
    for _ in 0..3 {
        robot.until(|speed| speed == 0.0);
    }
    assert!(killed.elapsed() >= TIMEOUT / 2, "by its timeout");
    let (zeros, state) = watchdog(&sandbox);
    assert!(zeros > 0 && state == "winner", "{zeros} {state}");

    while sandbox.apps().len() > 1 {}
    let _again = robot.start(&sandbox, ARBITER.0, &ARBITER.1, &patience);
    robot.until(|speed| speed == 0.3);
    while watchdog(&sandbox).1 != "checking" {
        robot.until(|speed| speed == 0.3);
    }
    let (zeros, _) = watchdog(&sandbox);
    for _ in 0..40 {
        robot.until(|speed| speed == 0.3);
    }
    assert_eq!(watchdog(&sandbox), (zeros, "checking".to_owned()));
}
