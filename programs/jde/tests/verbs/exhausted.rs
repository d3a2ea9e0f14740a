//! An application whose process has no descriptor, thread or memory left stops in every way.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{ChildStdout, Stdio};

use jde_watchdog::Watchdog;
use rustix::process::{Pid, Resource, Rlimit, getrlimit, prlimit};

use crate::attached::{Running, Sandbox};
use crate::support::{jde_with_plugins, pair};

/// A resource, and how much of it a process uses.
type InUse = (Resource, fn(u32) -> u64);

/// The system refuses a thread for lack of its stack's memory too. It has no limit of threads for the superuser.
const EXHAUSTED: [InUse; 3] = [
    (Resource::Nofile, descriptors),
    (Resource::Nproc, |_| 1),
    (Resource::As, address_space),
];

/// The first number that no descriptor has.
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

/// Starts an application, and waits until all its threads have obtained what they need to run: its first selection says
/// that they exist. It ends when nobody reads its output.
fn start(sandbox: &Sandbox) -> (Running, BufReader<ChildStdout>) {
    let mut robot = sandbox.spawn_printing(jde_with_plugins(&["run", &pair(), "--plain"]), Stdio::piped());
    let mut output = BufReader::new(robot.take_output().expect("the output is piped"));
    let mut line = String::new();
    while !line.contains("listener") {
        line.clear();
        assert_ne!(output.read_line(&mut line).expect("the output is text"), 0);
    }
    while !all_asleep(robot.id()) {}
    (robot, output)
}

/// Whether each thread of a process sleeps. A new one that has no stack for signals yet does not.
fn all_asleep(process: u32) -> bool {
    let tasks = fs::read_dir(format!("/proc/{process}/task")).expect("the process runs");
    let mut states = tasks.map(|task| fs::read_to_string(task?.path().join("stat")));
    states.all(|stat| {
        stat.is_ok_and(|stat| {
            stat.rsplit_once(')')
                .is_some_and(|(_, rest)| rest.trim_start().starts_with('S'))
        })
    })
}

/// Lets a running application obtain nothing more of a resource. Returns the limit that it had.
fn exhaust(robot: &Running, (resource, in_use): InUse) -> Rlimit {
    let current = Some(in_use(robot.id()));
    let limit = getrlimit(resource);
    set_limit(robot, resource, Rlimit { current, ..limit })
}

fn set_limit(robot: &Running, resource: Resource, limit: Rlimit) -> Rlimit {
    let process = Pid::from_raw(robot.id().cast_signed());
    prlimit(process, resource, limit).expect("a limit of a process of one's own")
}

/// Runs a verb until it succeeds: on a busy machine a reply may come late.
fn run_until_ok(sandbox: &Sandbox, args: &[&str]) -> String {
    loop {
        let output = sandbox.run(args);
        if output.status == Some(0) {
            return output.out;
        }
        let said = format!("{}{}", output.out, output.err);
        assert!(said.contains("did not reply within"), "{args:?}: {output:?}");
    }
}

#[test]
fn r14_everything_stops_by_the_panic_key_though_nothing_is_left_and_clients_still_connect() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    for resource in EXHAUSTED {
        let (mut robot, _output) = start(&sandbox);
        let limit = exhaust(&robot, resource);
        let stopped = run_until_ok(&sandbox, &["stop", "--all"]);
        assert!(stopped.contains("stopped, every command is neutral"), "{stopped}");
        // A client takes a descriptor, and which ones are free below the limit is chance.
        set_limit(&robot, resource.0, limit);
        run_until_ok(&sandbox, &["ps"]);
        assert_eq!(sandbox.motors_awake(), [""; 0]);
        robot.signal("TERM");
        assert_eq!(robot.wait(), Some(0), "{resource:?}");
    }
}

#[test]
fn r10_an_application_ends_in_order_by_a_signal_though_nothing_is_left() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    for resource in EXHAUSTED {
        for signal in ["TERM", "INT"] {
            let (mut robot, _output) = start(&sandbox);
            exhaust(&robot, resource);
            robot.signal(signal);
            assert_eq!(robot.wait(), Some(0), "{resource:?} {signal}");
        }
    }
}
