//! Failures that appear only in real time: a process that dies between calls, and a call that does not
//! return.

use jde_records::event::{Event, Outcome};

use crate::common::{Executor, in_real_time};
use crate::crashes::{PAIR, again, stage};
use crate::odd;
use crate::stage::Play;

in_real_time!(
    a_process_that_is_killed_between_calls_is_missed_at_once,
    a_process_that_hangs_is_ended_and_no_thread_is_lost,
);

fn a_process_that_is_killed_between_calls_is_missed_at_once(executor: Executor) {
    let stage = stage();
    let body = PAIR.replace("restart = \"never\"", "restart = \"never\"\nperiod = \"1000s\"");
    let mut play = Play::start(executor, &stage, &body);
    play.until_at(0.3);
    // The period of 1000 s leaves the process without calls after the first iteration.
    play.rig.until(|rig| rig.see("high").iterations == 1);
    let killed = std::process::Command::new("kill")
        .args(["-9", &play.process().to_string()])
        .status()
        .expect("kill runs");
    assert!(killed.success());
    let reason = play.until_failed(1);
    assert!(
        reason.starts_with("its process was killed by SIGKILL"),
        "{reason}"
    );
    play.until_at(0.1);
    assert_eq!(play.rig.see("high").faults, 1);
    play.rig.stop();
}

fn a_process_that_hangs_is_ended_and_no_thread_is_lost(executor: Executor) {
    let stage = stage();
    let mut play = Play::start(executor, &stage, &again(PAIR));
    play.until_at(0.3);
    let first = play.process();
    play.trouble(odd::HANG);
    let reason = play.until_failed(1);
    assert!(
        reason.starts_with("has not returned from a call for "),
        "{reason}"
    );
    play.trouble(0);
    let before = play.rig.see("high").iterations;
    play.rig.until(|rig| rig.see("high").iterations > before + 1);
    play.until_at(0.3);
    assert_ne!(play.process(), first);
    let failed = play.rig.see("high").faults as usize;
    assert_eq!(play.rig.stop(), Outcome::Stopped);
    // An instance that is left behind at the end would cause one more `Hung` event.
    let hung = |event: &Event| matches!(event, Event::Hung { .. });
    assert_eq!(stage.count_events(hung), failed, "nobody stayed behind");
}
