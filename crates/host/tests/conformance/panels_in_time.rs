//! The cost of panels where calls take time: a bounded share of their schema's time, and no higher rate than
//! requested. A drawing that never returns is a call that hangs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use jde_core::Health;
use jde_records::event::Event;
use jde_schema::Pen;

use crate::common::{Call, Executor, MS, Rig, Stage, in_real_time};
use crate::gestures::{held, release};
use crate::panels::{APP, TWO, drawn, look, until_shown};

in_real_time!(
    a_slow_panel_takes_a_twentieth_of_the_time,
    a_panel_is_drawn_no_more_often_than_is_wanted,
    a_panel_that_hangs_is_a_schema_that_hangs,
    r17_a_drawing_beyond_the_budget_is_an_overrun_and_is_not_shown,
    r17_a_sleeper_that_drew_too_late_is_well_once_nobody_looks,
);

/// The duration of a slow drawing, in the machine's time.
const SLOW: Duration = Duration::from_millis(20);

fn draw_slowly(pen: &mut Pen) {
    let start = Instant::now();
    while start.elapsed() < SLOW {
        std::hint::spin_loop();
    }
    pen.text("at last");
}

fn a_slow_panel_takes_a_twentieth_of_the_time(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| draw_slowly(pen));
    let mut rig = Rig::start(executor, &stage, APP);
    let _look = look(&rig, "easel");
    let first = until_shown(&mut rig, "easel", "at last");
    rig.patiently(|rig| drawn(rig, "easel").is_some_and(|drawn| drawn.sequence > first.sequence));
    let second = drawn(&rig, "easel").expect("it was there");
    assert!(first.took >= SLOW);
    let apart = Duration::from_nanos(second.time - first.time);
    // Both times are those of the ends of drawings.
    assert!(
        apart + second.took >= 19 * first.took,
        "{apart:?} after {:?}",
        first.took
    );
    rig.stop();
}

fn a_panel_is_drawn_no_more_often_than_is_wanted(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| pen.text("all is well"));
    let mut rig = Rig::start(executor, &stage, APP);
    let stirs = Arc::clone(&stage);
    let _look = rig
        .handle
        .view_panel(rig.place("easel"), 20.0, move || stirs.stir())
        .expect("it has a panel");
    let first = until_shown(&mut rig, "easel", "all is well");
    rig.patiently(|rig| drawn(rig, "easel").is_some_and(|drawn| drawn.sequence >= first.sequence + 6));
    let last = drawn(&rig, "easel").expect("it was there");
    let drawings = last.sequence - first.sequence;
    // One drawing may have been late, so that the next followed early.
    assert!(
        last.time - first.time >= (drawings - 1) * 50 * MS,
        "{drawings} in {} ms",
        (last.time - first.time) / MS
    );
    rig.stop();
}

fn a_panel_that_hangs_is_a_schema_that_hangs(executor: Executor) {
    let stage = Stage::new();
    let (mut rig, looks, hold) = held(executor, &stage);
    rig.until(|rig| rig.see("easel").faults == 1);
    // An event may follow its snapshot a moment later.
    rig.until(|_| stage.told(|event| matches!(event, Event::Hung { .. })));
    rig.until(|_| {
        stage.told(
            |event| matches!(event, Event::HealthChanged { health: Health::Faulted(said), .. } if said.contains("has not returned"))
        )
    });
    release(&stage, &hold);
    drop(looks);
    rig.stop();
}

/// An easel whose budget is a quarter of a slow drawing.
fn hurried() -> String {
    APP.replace("100ms", "5ms")
}

fn r17_a_drawing_beyond_the_budget_is_an_overrun_and_is_not_shown(executor: Executor) {
    let slow = Arc::new(AtomicBool::new(true));
    let is_slow = Arc::clone(&slow);
    let stage = Stage::new();
    stage.paints("easel", move |_, _, pen| match is_slow.load(Ordering::SeqCst) {
        true => draw_slowly(pen),
        false => pen.text("all is well"),
    });
    let mut rig = Rig::start(executor, &stage, &hurried());
    let looks = look(&rig, "easel");
    let shown = until_shown(&mut rig, "easel", "more than the schema's budget of 5.0ms");
    assert!(shown.took >= SLOW && shown.failed > 0);
    let easel = rig.see("easel");
    assert!(easel.overruns > 0);
    assert_eq!(easel.health, Health::Overrun, "until a drawing is in time");
    let least = SLOW.as_nanos() as u64;
    rig.until(|_| stage.told(|event| matches!(event, Event::Overrun { took, .. } if *took >= least)));
    slow.store(false, Ordering::SeqCst);
    until_shown(&mut rig, "easel", "all is well");
    rig.until(|rig| rig.see("easel").health == Health::Ok);
    drop(looks);
    rig.stop();
}

fn r17_a_sleeper_that_drew_too_late_is_well_once_nobody_looks(executor: Executor) {
    let stage = Stage::new();
    stage.play("high", |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
    stage.paints("below", |_, _, pen| draw_slowly(pen));
    let mut rig = Rig::start(executor, &stage, &TWO.replace("100ms", "5ms"));
    rig.until_did("high iterate");
    let looks = look(&rig, "below");
    rig.until(|rig| rig.see("below").health == Health::Overrun);
    drop(looks);
    rig.until(|rig| rig.see("below").health == Health::Ok);
    assert_eq!(rig.see("below").state, jde_core::State::Slept);
    rig.stop();
}

#[test]
fn r16_in_lockstep_a_drawing_takes_no_time_however_slow() {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| draw_slowly(pen));
    let mut rig = Rig::start(Executor::Lockstep, &stage, &hurried());
    let looks = look(&rig, "easel");
    let shown = until_shown(&mut rig, "easel", "at last");
    assert!(shown.took >= SLOW);
    assert_eq!(rig.see("easel").overruns, 0);
    drop(looks);
    rig.stop();
}
