//! A schema's process that ends, however it ends: its level selects again, all other schemas continue, and a
//! new process finds all it needs.

use std::sync::Arc;

use jde_core::{Health, State};
use jde_records::event::{Event, Outcome};

use crate::common::{Executor, Stage, on_every_executor};
use crate::odd;
use crate::stage::Play;

on_every_executor!(
    a_schema_whose_process_dies_is_faulted_and_its_sibling_takes_over,
    a_restarted_schema_has_a_fresh_process_and_finds_its_bindings,
    a_panic_is_caught_and_leaves_no_process_behind,
    an_import_cannot_be_spoilt,
);

/// `high` wins while it is ready; otherwise `low` wins.
pub(crate) const PAIR: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "odd/odd"
    isolate = "process"
    restart = "never"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// A stage on which `low` drives at 0.1.
pub(crate) fn stage() -> Arc<Stage> {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage
}

/// The same application, with `high` restarted after 5 ms instead of never.
pub(crate) fn again(text: &str) -> String {
    text.replace("\"never\"", "{ back-off = \"5ms\", limit = 100 }")
}

fn a_schema_whose_process_dies_is_faulted_and_its_sibling_takes_over(executor: Executor) {
    let troubles = [
        (odd::SEGFAULT, "its process was killed by SIGSEGV"),
        (odd::ABORT, "its process was killed by SIGABRT"),
        (odd::EXIT, "its process exited by itself, with status 3"),
    ];
    for (trouble, words) in troubles {
        let stage = stage();
        let mut play = Play::start(executor, &stage, PAIR);
        play.until_at(0.3);
        assert_ne!(play.process(), std::process::id());
        play.trouble(trouble);
        let reason = play.until_failed(1);
        assert!(reason.starts_with(words), "{reason}");
        play.until_at(0.1);
        let view = play.rig.see("high");
        assert_eq!((view.state, view.faults), (State::Slept, 1));
        let before = stage.count("low iterate");
        play.rig
            .until(|rig| rig.stage.count("low iterate") > before + 5 && rig.see("high").process.is_none());
        assert_eq!(play.rig.see("low").faults + play.rig.see("robot").faults, 0);
        assert_eq!(play.rig.stop(), Outcome::Stopped);
    }
}

fn a_restarted_schema_has_a_fresh_process_and_finds_its_bindings(executor: Executor) {
    let stage = stage();
    let mut play = Play::start(executor, &stage, &again(PAIR));
    play.until_at(0.3);
    let first = play.process();
    play.trouble(odd::SEGFAULT);
    play.until_failed(2);
    play.trouble(0);
    let (high, failed) = (play.rig.place("high"), play.rig.see("high").faults);
    let before = play.rig.see("high").iterations;
    play.rig.until(|rig| rig.see("high").iterations > before + 1);
    play.until_at(0.3);
    assert_ne!(play.process(), first);
    let told = stage.count_events(
        |event| matches!(event, Event::HealthChanged { schema, health: Health::Faulted(_), .. } if *schema == high),
    );
    let faults = play.rig.see("high").faults;
    assert!(
        failed <= faults && faults as usize == told,
        "each death is told once"
    );
    play.rig.stop();
}

fn a_panic_is_caught_and_leaves_no_process_behind(executor: Executor) {
    let stage = stage();
    let mut play = Play::start(executor, &stage, PAIR);
    play.until_at(0.3);
    play.trouble(odd::PANIC);
    let reason = play.until_failed(1);
    assert!(
        reason.starts_with("panicked in iterate: ") && reason.ends_with("as it was told"),
        "{reason}"
    );
    play.until_at(0.1);
    let before = stage.count("low iterate");
    play.rig
        .until(|rig| rig.stage.count("low iterate") > before && rig.see("high").process.is_none());
    play.rig.stop();
}

fn an_import_cannot_be_spoilt(executor: Executor) {
    let body = r#"
        roots = ["high", "source"]
        [schemas.source]
        type = "odd/odd"
        [schemas.high]
        type = "odd/odd"
        isolate = "process"
        restart = "never"
        imports = { scan = "source.seen" }
        speed = 0.3
    "#;
    let stage = stage();
    let mut play = Play::start(executor, &stage, body);
    // `high` sleeps until the source has iterated, so that a scan exists.
    let high = play.rig.place("high");
    let operator = play.rig.operator();
    operator.hold_asleep(high).expect("it is done");
    play.rig.until(|rig| rig.see("source").iterations > 0);
    operator.release(high).expect("it is done");
    play.rig.until(|rig| rig.see("high").iterations > 0);
    play.trouble(odd::SPOIL);
    let reason = play.until_failed(1);
    assert!(
        reason.starts_with("its process was killed by SIGSEGV"),
        "{reason}"
    );
    play.rig.stop();
}
