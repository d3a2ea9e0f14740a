//! Two machines that discover each other by multicast, and two whose cable is cut and restored. Each machine
//! is a network namespace with one application; a virtual Ethernet link connects them. The tests are skipped
//! on a system that does not permit network namespaces.

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::until;
use crate::processes::ChildProcess;

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
    /// Returns `None` if the system does not permit network namespaces.
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
        let created = steps.iter().all(|step| ip(step));
        if !created {
            println!("skipped: this system permits no network namespaces (they need root and the tool `ip`)");
        }
        created.then_some(machines)
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
fn an_import_is_retracted_when_the_cable_is_pulled_and_resumes_when_it_is_restored() {
    let Some(machines) = Machines::new() else { return };
    let files = tempfile::tempdir().unwrap();
    let _robot = ChildProcess::in_namespace(&machines.robot, "robot", &files.path().join("robot"));
    let mut base = ChildProcess::in_namespace(&machines.base, "base", &files.path().join("base"));
    let first = base.number("value ");
    until("further values arrive", || base.number("value ") > first);
    machines.cable("down");
    base.wait_for_line("none");
    machines.cable("up");
    let restored = base.number("value ");
    assert!(restored > first, "the value is new");
    until("further values arrive", || base.number("value ") > restored);
}

#[test]
fn two_unconfigured_applications_discover_each_other_by_multicast() {
    let Some(machines) = Machines::new() else { return };
    let files = tempfile::tempdir().unwrap();
    // The base searches before the robot exists.
    let mut base =
        ChildProcess::in_namespace(&machines.base, "base by multicast", &files.path().join("base"));
    let _robot =
        ChildProcess::in_namespace(&machines.robot, "robot by multicast", &files.path().join("robot"));
    let first = base.number("value ");
    until("further values arrive", || base.number("value ") > first);
}
