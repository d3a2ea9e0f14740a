//! A test that hangs ends with a report of its threads. It hangs in a process of its own.

use std::process::Command;
use std::thread;
use std::time::Duration;

use jde_watchdog::Watchdog;

/// How the child process hangs: with a report, or with a report that hangs too.
const HOW: &str = "JDE_TEST_HANGS";

const SOON: Duration = Duration::from_millis(50);

#[test]
fn what_hangs_is_ended_and_named() {
    if let Ok(how) = std::env::var(HOW) {
        let _watchdog = Watchdog::new(SOON, move || {
            if how == "mute" {
                sleep_for_ever();
            }
            String::from("goon is inside `iterate`")
        });
        let waits = thread::Builder::new().name(String::from("waits"));
        let waits = waits.spawn(sleep_for_ever).expect("a thread");
        drop(waits.join());
        return;
    }
    for (how, said) in [
        ("aloud", "goon is inside `iterate`"),
        ("mute", "a lock that it needs is taken"),
    ] {
        let hung = Command::new(std::env::current_exe().expect("this program has a file"))
            .args(["--exact", "what_hangs_is_ended_and_named", "--nocapture"])
            .env(HOW, how)
            .output()
            .expect("it starts");
        let words = String::from_utf8(hung.stderr).expect("it says UTF-8");
        assert_eq!(hung.status.code(), Some(1), "{words}");
        for wanted in ["what_hangs_is_ended_and_named hangs", "hangs.rs:", "waits ", said] {
            assert!(words.contains(wanted), "`{wanted}` is not in {words}");
        }
    }
}

fn sleep_for_ever() {
    loop {
        thread::park();
    }
}
