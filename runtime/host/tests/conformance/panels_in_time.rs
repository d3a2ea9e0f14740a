//! The cost of panels where calls take time: a bounded share of their schema's time, and no higher rate than
//! requested. A drawing that never returns is a call that hangs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use jde_core::Health;
use jde_records::event::What;

use crate::common::{Call, Executor, Io, MS, Scenario, TestApp, in_real_time};
use crate::gestures::{blocked_in_draw, release};
use crate::panels::{APP, TWO, drawn, until_shown, view};

in_real_time!(
    a_slow_panel_takes_a_twentieth_of_the_time,
    a_panel_is_drawn_no_more_often_than_requested,
    a_panel_that_hangs_faults_its_schema,
    r17_a_drawing_beyond_the_budget_is_an_overrun_and_is_not_shown,
    r17_an_overrun_of_a_sleeping_schemas_panel_ends_with_its_last_viewer,
);

/// The duration of a slow drawing, in the machine's time.
const SLOW: Duration = Duration::from_millis(20);

fn draw_slowly(io: &Io<'_>) {
    let start = Instant::now();
    while start.elapsed() < SLOW {
        std::hint::spin_loop();
    }
    io.text("done");
}

fn a_slow_panel_takes_a_twentieth_of_the_time(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_draw("motor", draw_slowly);
    let mut app = TestApp::start(executor, &scenario, APP);
    let _viewer = view(&app, "motor");
    let first = until_shown(&mut app, "motor", "done");
    app.until_unbounded(|app| drawn(app, "motor").is_some_and(|drawn| drawn.sequence > first.sequence));
    let second = drawn(&app, "motor").expect("it was drawn");
    assert!(first.took >= SLOW);
    let interval = Duration::from_nanos(second.time - first.time);
    // Both times are the ends of drawings.
    assert!(
        interval + second.took >= 19 * first.took,
        "{interval:?} after {:?}",
        first.took
    );
    app.stop();
}

fn a_panel_is_drawn_no_more_often_than_requested(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_draw("motor", |io| io.text("ok"));
    let mut app = TestApp::start(executor, &scenario, APP);
    let notifier = Arc::clone(&scenario);
    let _viewer = app
        .handle
        .view_panel(app.index("motor"), 20.0, move || notifier.notify())
        .expect("it has a panel");
    let first = until_shown(&mut app, "motor", "ok");
    app.until_unbounded(|app| drawn(app, "motor").is_some_and(|drawn| drawn.sequence >= first.sequence + 6));
    let last = drawn(&app, "motor").expect("it was drawn");
    let drawings = last.sequence - first.sequence;
    // One drawing may have been late, so that the next followed early.
    assert!(
        last.time - first.time >= (drawings - 1) * 50 * MS,
        "{drawings} in {} ms",
        (last.time - first.time) / MS
    );
    app.stop();
}

fn a_panel_that_hangs_faults_its_schema(executor: Executor) {
    let scenario = Scenario::new();
    let (mut app, viewer, blocked) = blocked_in_draw(executor, &scenario);
    app.until(|app| app.schema("motor").faults == 1);
    // An event may follow its snapshot a moment later.
    app.until(|_| scenario.has_event(|event| matches!(event.what(), Some(What::Hung { .. }))));
    app.until(|_| {
        scenario.has_event(
            |event| matches!(event.what(), Some(What::HealthChanged { health: Health::Faulted(reason), .. }) if reason.contains("has not returned"))
        )
    });
    release(&scenario, &blocked);
    drop(viewer);
    app.stop();
}

/// The application with a budget of a quarter of a slow drawing.
fn app_with_short_budget() -> String {
    APP.replace("100ms", "5ms")
}

fn r17_a_drawing_beyond_the_budget_is_an_overrun_and_is_not_shown(executor: Executor) {
    let slow = Arc::new(AtomicBool::new(true));
    let is_slow = Arc::clone(&slow);
    let scenario = Scenario::new();
    scenario.on_draw("motor", move |io| match is_slow.load(Ordering::SeqCst) {
        true => draw_slowly(io),
        false => io.text("ok"),
    });
    let mut app = TestApp::start(executor, &scenario, &app_with_short_budget());
    let viewer = view(&app, "motor");
    let shown = until_shown(&mut app, "motor", "more than the schema's budget of 5.0ms");
    assert!(shown.took >= SLOW && shown.failed > 0);
    let view = app.schema("motor");
    assert!(view.overruns > 0);
    assert_eq!(
        view.health,
        Health::Overrun,
        "it lasts until a drawing is in time"
    );
    let least = SLOW.as_nanos() as u64;
    app.until(|_| {
        scenario.has_event(|event| matches!(event.what(), Some(What::Overrun { took, .. }) if *took >= least))
    });
    slow.store(false, Ordering::SeqCst);
    until_shown(&mut app, "motor", "ok");
    app.until(|app| app.schema("motor").health == Health::Ok);
    drop(viewer);
    app.stop();
}

fn r17_an_overrun_of_a_sleeping_schemas_panel_ends_with_its_last_viewer(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("high", |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
    scenario.on_draw("below", draw_slowly);
    let mut app = TestApp::start(executor, &scenario, &TWO.replace("100ms", "5ms"));
    app.until_line("high iterate");
    let viewer = view(&app, "below");
    app.until(|app| app.schema("below").health == Health::Overrun);
    drop(viewer);
    app.until(|app| app.schema("below").health == Health::Ok);
    assert_eq!(app.schema("below").state, jde_core::State::Slept);
    app.stop();
}

#[test]
fn r16_in_lockstep_a_drawing_takes_no_time_however_slow() {
    let scenario = Scenario::new();
    scenario.on_draw("motor", draw_slowly);
    let mut app = TestApp::start(Executor::Lockstep, &scenario, &app_with_short_budget());
    let viewer = view(&app, "motor");
    let shown = until_shown(&mut app, "motor", "done");
    assert!(shown.took >= SLOW);
    assert_eq!(app.schema("motor").overruns, 0);
    drop(viewer);
    app.stop();
}
