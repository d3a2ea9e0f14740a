//! A test that hangs ends with a report of its threads. The test hangs in a separate process.

use std::os::unix::process::CommandExt;
use std::process::Command;
use std::thread;
use std::time::Duration;

use jde_watchdog::Watchdog;

/// How the child process hangs: with a report, or with a report that hangs too.
const MODE: &str = "JDE_TEST_HANGS";

const LIMIT: Duration = Duration::from_millis(50);

#[test]
fn a_process_that_hangs_ends_with_a_report() {
    if let Ok(mode) = std::env::var(MODE) {
        let _watchdog = Watchdog::new(LIMIT, move || {
            if mode == "report-hangs" {
                sleep_for_ever();
            }
            String::from("goon is inside `iterate`")
        });
        let waiting = thread::Builder::new().name(String::from("waiting"));
        let waiting = waiting.spawn(sleep_for_ever).expect("a thread");
        drop(waiting.join());
        return;
    }
    for (mode, expected_report) in [
        ("report", "goon is inside `iterate`"),
        ("report-hangs", "it waits for a lock that another thread holds"),
    ] {
        let hung = Command::new(std::env::current_exe().expect("this program has a file"))
            .args([
                "--exact",
                "a_process_that_hangs_ends_with_a_report",
                "--nocapture",
            ])
            .env(MODE, mode)
            .output()
            .expect("the child process starts");
        let output = String::from_utf8(hung.stderr).expect("UTF-8");
        assert_eq!(hung.status.code(), Some(1), "{output}");
        for expected in [
            "a_process_that_hangs_ends_with_a_report hangs",
            "hangs.rs:",
            "waiting ",
            expected_report,
        ] {
            assert!(output.contains(expected), "`{expected}` is not in {output}");
        }
    }
}

#[test]
fn the_processes_of_a_process_that_hangs_end_with_it() {
    if std::env::var_os(MODE).is_some() {
        let _watchdog = Watchdog::new(LIMIT, String::new);
        let mut shell = Command::new("sh")
            .args(["-c", "tail -f /dev/null & tail -f /dev/null"])
            .process_group(0)
            .spawn()
            .expect("a shell starts");
        let _ = shell.wait();
        sleep_for_ever();
    }
    let _watchdog = Watchdog::for_test();
    // All of them have the same output, whose end comes once all have ended.
    let hung = Command::new(std::env::current_exe().expect("this program has a file"))
        .args(["--exact", "the_processes_of_a_process_that_hangs_end_with_it"])
        .env(MODE, "children")
        .output()
        .expect("the child process starts");
    assert_eq!(hung.status.code(), Some(1), "{hung:?}");
}

fn sleep_for_ever() {
    loop {
        thread::park();
    }
}
