//! No process, file or thread remains after crashes, restarts, the end of the application, or the death of the
//! host.

use jde_watchdog::Watchdog;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{Executor, Scenario};
use crate::faulty;
use crate::isolated_app::{BY_NAME, IsolatedApp, RUNNING};

const BODY: &str = r#"
    roots = ["high"]
    [schemas.high]
    type = "faulty/faulty"
    isolate = "process"
    restart = { back-off = "1ms", limit = 1000 }
"#;

/// Counts the children of this process (including zombies), its open files and its threads.
fn count_resources() -> (usize, usize, usize) {
    let list = |path: &str| std::fs::read_dir(path).expect("this is Linux").count();
    let tasks = std::fs::read_dir("/proc/self/task").expect("this is Linux");
    let children = tasks
        .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("children")).ok())
        .map(|children| children.split_whitespace().count())
        .sum();
    (children, list("/proc/self/fd"), list("/proc/self/task"))
}

#[test]
fn crashes_and_restarts_leak_no_process_no_file_and_no_thread() {
    let _alone = RUNNING.write();
    let run = |deaths: u64| {
        let scenario = Scenario::quiet();
        let mut isolated = IsolatedApp::start_unlocked(Executor::Lockstep, &scenario, BODY);
        isolated.trouble(faulty::ABORT);
        isolated.app.until(|app| app.schema("high").faults >= deaths);
        let during = count_resources();
        isolated.app.stop();
        scenario.close();
        (during, count_resources())
    };
    let (_, before) = run(1);
    let (during, after) = run(8);
    assert_eq!(after, before);
    assert_eq!(after.0, 0, "no zombie remains");
    assert!(during.0 <= 1 && during.2 <= before.2 + 1, "{during:?} {before:?}");
}

/// Runs a host in this process until it is killed. It prints the id of its child process. Without the
/// variable `HOSTED` it does nothing.
pub(crate) fn host() {
    if std::env::var_os(HOSTED).is_none() {
        return;
    }
    let scenario = Scenario::quiet();
    let isolated = IsolatedApp::start(Executor::Threads, &scenario, BODY);
    println!("child {}", isolated.process());
    loop {
        std::thread::park();
    }
}

/// The environment variable that makes [`host`] run.
const HOSTED: &str = "JDE_TEST_HOSTED";

#[test]
fn a_host_that_is_killed_leaves_no_process_behind() {
    let _watchdog = Watchdog::for_test();
    let mut host = Command::new(std::env::current_exe().expect("this program has a file"))
        .args([BY_NAME, "hosted", "--nocapture"])
        .env(HOSTED, "yes")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let lines = BufReader::new(host.stdout.take().expect("it is piped")).lines();
    let child = lines
        .map_while(Result::ok)
        .find_map(|line| line.split_once("child ")?.1.parse::<u32>().ok())
        .expect("the host prints its child");
    let process = format!("/proc/{child}");
    assert!(Path::new(&process).exists());
    host.kill().expect("it is killed");
    host.wait().expect("it has ended");
    // A zombie counts as dead: the host does not reap it.
    let is_alive = || {
        let stat = std::fs::read_to_string(format!("{process}/stat")).unwrap_or_default();
        let state = stat.rsplit_once(") ").map(|(_, rest)| rest.chars().next());
        !matches!(state.flatten(), None | Some('Z' | 'X'))
    };
    while is_alive() {
        std::thread::yield_now();
    }
}
