//! Two machines that discover each other by multicast, and two whose cable is cut and restored. Each machine
//! is a network namespace with an application; a virtual link connects them. Needs a system that permits
//! their creation.

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::until;
use crate::processes::Actor;

/// Two namespaces with a cable between them; removed when dropped.
struct Machines {
    base: String,
    robot: String,
}

fn ip(arguments: &str) -> bool {
    Command::new("ip")
        .args(arguments.split_whitespace())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

impl Machines {
    /// None if the system refuses.
    fn new() -> Option<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = std::process::id();
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let machines = Self {
            base: format!("jde-base-{number}-{count}"),
            robot: format!("jde-robot-{number}-{count}"),
        };
        let Self { base, robot } = &machines;
        let steps = [
            format!("netns add {base}"),
            format!("netns add {robot}"),
            format!("-n {base} link add cable type veth peer name cable netns {robot}"),
            format!("-n {base} addr add 10.77.0.1/24 dev cable"),
            format!("-n {robot} addr add 10.77.0.2/24 dev cable"),
            format!("-n {base} link set lo up"),
            format!("-n {robot} link set lo up"),
            format!("-n {base} link set cable up"),
            format!("-n {robot} link set cable up"),
            format!("-n {base} route add 224.0.0.0/4 dev cable"),
            format!("-n {robot} route add 224.0.0.0/4 dev cable"),
        ];
        let made = steps.iter().all(|step| ip(step));
        if !made {
            println!(
                "skipped: this system lets us make no network namespaces (root and the tool `ip` are needed)"
            );
        }
        made.then_some(machines)
    }

    fn cable(&self, state: &str) {
        assert!(ip(&format!("-n {} link set cable {state}", self.robot)));
    }
}

impl Drop for Machines {
    fn drop(&mut self) {
        ip(&format!("netns del {}", self.base));
        ip(&format!("netns del {}", self.robot));
    }
}

#[test]
fn an_import_is_taken_back_when_the_cable_is_pulled_and_comes_back_with_it() {
    let Some(machines) = Machines::new() else { return };
    let files = tempfile::tempdir().unwrap();
    let _robot = Actor::on(&machines.robot, "robot", &files.path().join("robot"));
    let mut base = Actor::on(&machines.base, "base", &files.path().join("base"));
    let first = base.number("shows ");
    until("values go on", || base.number("shows ") > first);
    machines.cable("down");
    base.hears("nothing");
    machines.cable("up");
    let again = base.number("shows ");
    assert!(again > first, "it is not an old one");
    until("values go on", || base.number("shows ") > again);
}

#[test]
fn two_that_were_not_told_of_each_other_meet_by_multicast() {
    let Some(machines) = Machines::new() else { return };
    let files = tempfile::tempdir().unwrap();
    // The base searches before the robot exists.
    let mut base = Actor::on(&machines.base, "base to meet", &files.path().join("base"));
    let _robot = Actor::on(&machines.robot, "robot to meet", &files.path().join("robot"));
    let first = base.number("shows ");
    until("values go on", || base.number("shows ") > first);
}
