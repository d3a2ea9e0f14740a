//! An application whose process has no descriptor, thread or memory left stops in every way.

use std::fs;

use rustix::process::{Pid, Resource, Rlimit, prlimit};

use crate::attached::{Running, Sandbox};
use crate::support::pair;

/// A resource, and how much of it a process uses.
type InUse = (Resource, fn(u32) -> u64);

/// The system refuses a thread for lack of its stack's memory too. It has no limit of threads for the superuser.
const EXHAUSTED: [InUse; 3] = [
    (Resource::Nofile, descriptors),
    (Resource::Nproc, |_| 1),
    (Resource::As, address_space),
];

/// The first number that no descriptor has: one that is freed below it can be used again.
fn descriptors(process: u32) -> u64 {
    let folder = format!("/proc/{process}/fd");
    let free = (0_u64..).find(|number| fs::symlink_metadata(format!("{folder}/{number}")).is_err());
    free.expect("some number is free")
}

fn address_space(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).expect("the process runs");
    let size = status
        .lines()
        .find_map(|line| line.strip_prefix("VmSize:"))
        .expect("its size");
    let kilobytes = size.trim().trim_end_matches(" kB");
    1024 * kilobytes.parse::<u64>().expect("a number")
}

/// Lets a running application obtain nothing more of a resource.
fn exhaust(robot: &Running, (resource, in_use): InUse) {
    let process = robot.id();
    let limit = Some(in_use(process));
    let limit = Rlimit {
        current: limit,
        maximum: limit,
    };
    let pid = Pid::from_raw(process.cast_signed());
    prlimit(pid, resource, limit).expect("a limit of a process of one's own");
}

#[test]
fn r14_everything_stops_by_the_panic_key_though_nothing_is_left_and_clients_still_connect() {
    let sandbox = Sandbox::new();
    for resource in EXHAUSTED {
        let mut robot = sandbox.start(&pair(), &[]);
        exhaust(&robot, resource);
        let stopped = sandbox.run_ok(&["stop", "--all"]);
        assert!(stopped.contains("stopped, every command is neutral"), "{stopped}");
        assert_eq!(sandbox.motors_awake(), [""; 0]);
        robot.signal("TERM");
        assert_eq!(robot.wait(), Some(0), "{resource:?}");
    }
}

#[test]
fn r10_an_application_ends_in_order_by_a_signal_though_nothing_is_left() {
    let sandbox = Sandbox::new();
    for resource in EXHAUSTED {
        for signal in ["TERM", "INT"] {
            let mut robot = sandbox.start(&pair(), &[]);
            exhaust(&robot, resource);
            robot.signal(signal);
            assert_eq!(robot.wait(), Some(0), "{resource:?} {signal}");
        }
    }
}
