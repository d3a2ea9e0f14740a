//! Panels: drawn only while they are viewed, in the schema's own turn, without effects.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use jde_core::{Health, SchemaId};
use jde_host::{Options, PanelError, PanelViewGuard};
use jde_panel::PanelFrame;
use jde_panel::{Gesture, Item, Touch};
use jde_records::turn::{OnTurn, Turn, TurnKind};
use parking_lot::Mutex;

use crate::common::{Call, Executor, Io, Language, MS, Scenario, TestApp, in_languages, on_every_executor};

on_every_executor!(
    a_panel_is_drawn_only_while_it_is_viewed,
    r8_a_panel_shows_the_inputs_of_the_last_iteration,
    a_schema_without_a_panel_refuses_viewers,
    the_panel_of_a_sleeping_schema_is_drawn,
    a_panel_that_panics_shows_why_and_leaves_its_schema_running,
    an_invalid_panel_shows_why,
    a_panel_that_writes_is_refused_and_shows_what,
    the_panel_of_an_instance_that_ended_shows_why,
    a_new_viewer_of_an_instance_that_ended_sees_why,
    with_several_viewers_the_highest_rate_counts,
);

in_languages!(Lockstep, [C Cpp Python]:
    r8_a_panel_shows_the_inputs_of_the_last_iteration,
    a_panel_that_panics_shows_why_and_leaves_its_schema_running,
    a_panel_that_writes_is_refused_and_shows_what,
);
// Each widget of the tests in Python is a message to this process, and this test draws far more than a panel may have.
in_languages!(Lockstep, [C Cpp]:
    an_invalid_panel_shows_why,
);

pub(crate) const APP: &str = r#"
    roots = ["motor"]
    [schemas.motor]
    type = "test/able-motor"
    # Far more than any drawing of these tests takes, even on a busy machine.
    budget = "100ms"
    gain = 1
    imports = { input = "eye.out" }
    [schemas.eye]
    type = "test/eye"
"#;

pub(crate) const TWO: &str = r#"
    roots = ["high", "motor"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    [schemas.motor]
    type = "test/able-motor"
    budget = "100ms"
    gain = 1
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
    children = { a = "below" }
    [schemas.below]
    type = "test/able-motor"
    budget = "100ms"
    gain = 1
    imports = { input = "eye.out" }
    [schemas.eye]
    type = "test/eye"
"#;

/// Views the panel at the highest rate. Each drawing notifies the scenario.
pub(crate) fn view(app: &TestApp, name: &str) -> PanelViewGuard {
    let scenario = Arc::clone(&app.scenario);
    let viewer = app
        .handle
        .view_panel(app.index(name), 1000.0, move || scenario.notify());
    viewer.expect("it has a panel")
}

pub(crate) fn drawn(app: &TestApp, name: &str) -> Option<Arc<PanelFrame>> {
    app.handle.panel(app.index(name))
}

/// Runs until the panel shows this text, either as an item or in the reason for its failure.
pub(crate) fn until_shown(app: &mut TestApp, name: &str, text: &str) -> Arc<PanelFrame> {
    app.until_unbounded(|app| drawn(app, name).is_some_and(|drawn| text_of(&drawn).contains(text)));
    drawn(app, name).expect("it was drawn")
}

fn text_of(drawn: &PanelFrame) -> String {
    match &drawn.list {
        Err(reason) => reason.clone(),
        Ok(list) => list
            .items
            .iter()
            .map(|item| match item {
                Item::Text { text, .. } => format!("{text}\n"),
                _ => String::new(),
            })
            .collect(),
    }
}

pub(crate) fn touch(app: &TestApp, widget: &str, touch: Touch) -> Result<(), PanelError> {
    let gesture = Gesture {
        widget: widget.to_owned(),
        touch,
    };
    app.handle.touch("ana@laptop", app.index("motor"), gesture)
}

fn a_panel_is_drawn_only_while_it_is_viewed(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_draw("motor", |io| {
        io.text(format!("iteration {}", io.scenario.count("motor iterate")))
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    let iterations = |app: &TestApp| app.scenario.count("motor iterate");
    app.until(|app| iterations(app) >= 5);
    assert_eq!(scenario.count("motor draw"), 0);
    assert_eq!(drawn(&app, "motor"), None);

    let viewer = view(&app, "motor");
    let first = until_shown(&mut app, "motor", "iteration");
    assert_eq!((first.sequence, first.failed), (1, 0));
    app.until_unbounded(|app| drawn(app, "motor").is_some_and(|drawn| drawn.sequence > 2));

    drop(viewer);
    assert_eq!(drawn(&app, "motor"), None, "an old drawing is not shown as live");
    let (drawings, start) = (scenario.count("motor draw"), iterations(&app));
    app.until(|app| iterations(app) >= start + 5);
    // One drawing may have been in progress.
    assert!(scenario.count("motor draw") <= drawings + 1);
    app.stop();
}

fn r8_a_panel_shows_the_inputs_of_the_last_iteration(executor: Executor) {
    let scenario = Scenario::new();
    let values = AtomicU64::new(0);
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            io.publish(values.fetch_add(1, Ordering::Relaxed) as f64);
        }
        Ok(())
    });
    let last = Arc::new(Mutex::new(None));
    let read = Arc::clone(&last);
    scenario.on_call("motor", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => *read.lock() = Some(io.input()),
            _ => {}
        }
        Ok(())
    });
    let differs = Arc::new(AtomicBool::new(false));
    let found = Arc::clone(&differs);
    scenario.on_draw("motor", move |io| {
        let input = io.input();
        if last.lock().is_some_and(|last| last != input) {
            found.store(true, Ordering::Relaxed);
        }
        io.value("input", input.map_or(-1.0, |(value, _)| value));
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    let _viewer = view(&app, "motor");
    app.until_unbounded(|app| drawn(app, "motor").is_some_and(|drawn| drawn.sequence > 5));
    assert!(
        !differs.load(Ordering::Relaxed),
        "the panel showed another value than the iteration used"
    );
    app.stop();
}

fn a_schema_without_a_panel_refuses_viewers(executor: Executor) {
    let scenario = Scenario::new();
    let app = TestApp::start(executor, &scenario, APP);
    let (motor, eye) = (app.index("motor"), app.index("eye"));
    assert_eq!(app.handle.panels(), [motor]);
    assert!(app.schema("motor").panel && !app.schema("eye").panel);
    let refused = app.handle.view_panel(eye, 10.0, || {}).err();
    assert_eq!(refused, Some(PanelError::NoPanel("eye".to_owned())));
    let absent = SchemaId(99);
    let refused = app.handle.view_panel(absent, 10.0, || {}).err();
    assert_eq!(
        refused,
        Some(PanelError::NoSuchSchema {
            schema: absent,
            count: 2
        })
    );
    let pressed = Gesture {
        widget: "go".to_owned(),
        touch: Touch::Pressed,
    };
    let refused = app.handle.touch("ana@laptop", eye, pressed);
    assert_eq!(refused, Err(PanelError::NoPanel("eye".to_owned())));
    assert_eq!(app.handle.panel(absent), None);
    app.stop();
}

fn the_panel_of_a_sleeping_schema_is_drawn(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("high", |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
    scenario.on_draw("below", |io| {
        io.text(format!("iteration {}", io.scenario.count("below iterate")))
    });
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("high iterate");
    let viewer = view(&app, "below");
    until_shown(&mut app, "below", "iteration 0");
    app.until_unbounded(|app| drawn(app, "below").is_some_and(|drawn| drawn.sequence > 3));
    assert_eq!(app.schema("below").state, jde_core::State::Slept);
    assert_eq!(scenario.count("below iterate"), 0, "a viewer wakes no schema");
    drop(viewer);
    app.stop();
}

fn a_panel_that_panics_shows_why_and_leaves_its_schema_running(executor: Executor) {
    let scenario = Scenario::new();
    let broken = Arc::new(AtomicBool::new(true));
    let breaks = Arc::clone(&broken);
    scenario.on_draw("motor", move |io| {
        io.text("ok");
        assert!(!breaks.load(Ordering::Relaxed), "drawing failed");
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    let _viewer = view(&app, "motor");
    let shown = until_shown(&mut app, "motor", "drawing failed");
    let reason = text_of(&shown);
    assert!(
        Language::of_test().is_panic(&reason, "draw", "drawing failed"),
        "{reason}"
    );
    assert_eq!(shown.failed, shown.sequence);
    let before = scenario.count("motor iterate");
    app.until(|app| app.scenario.count("motor iterate") > before + 3);
    let view = app.schema("motor");
    assert_eq!(view.faults, 0);
    assert!(!matches!(view.health, Health::Faulted(_)), "{:?}", view.health);
    broken.store(false, Ordering::Relaxed);
    let shown = until_shown(&mut app, "motor", "ok");
    assert!(shown.failed > 0 && shown.failed < shown.sequence);
    app.stop();
}

fn an_invalid_panel_shows_why(executor: Executor) {
    let scenario = Scenario::new();
    let step = Arc::new(AtomicU64::new(0));
    let at = Arc::clone(&step);
    scenario.on_draw("motor", move |io| match at.load(Ordering::Relaxed) {
        0 => io.value("speed", f64::NAN),
        1 => {
            io.button("go");
            io.button("go");
        }
        2 => {
            for _ in 0..30_000 {
                io.text("again");
            }
        }
        _ => io.text("ok"),
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    let _viewer = view(&app, "motor");
    for reason in [
        "`speed`: a number is NaN",
        "`go`: two widgets have this id",
        "it has more than 20000 widgets and shapes",
        "ok",
    ] {
        until_shown(&mut app, "motor", reason);
        step.fetch_add(1, Ordering::Relaxed);
    }
    assert_eq!(app.schema("motor").faults, 0);
    app.stop();
}

fn a_panel_that_writes_is_refused_and_shows_what(executor: Executor) {
    let scenario = Scenario::new();
    let step = Arc::new(AtomicU64::new(0));
    let at = Arc::clone(&step);
    scenario.on_draw("motor", move |io| {
        io.text("ok");
        match at.load(Ordering::Relaxed) {
            0 => drop(io.command(0.3)),
            1 => drop(io.wake("a")),
            2 => drop(io.sleep("a")),
            3 => drop(io.urgency_decides("a")),
            _ => {}
        }
    });
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("motor iterate");
    let _viewer = view(&app, "motor");
    for what in [
        "it tried to write `base` while its panel was drawn",
        "it tried to wake a child while its panel was drawn",
        "it tried to put a child to sleep while its panel was drawn",
        "it tried to change a policy while its panel was drawn",
        "ok",
    ] {
        until_shown(&mut app, "motor", what);
        step.fetch_add(1, Ordering::Relaxed);
    }
    assert!(!scenario.has_line("robot velocity 0.3"));
    assert_eq!(app.schema("below").state, jde_core::State::Slept);
    let view = app.schema("motor");
    assert_eq!((view.faults, view.refused), (0, 0));
    app.stop();
}

fn the_panel_of_an_instance_that_ended_shows_why(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_draw("motor", |io| io.text("ok"));
    let mut app = TestApp::start(executor, &scenario, APP);
    let _viewer = view(&app, "motor");
    until_shown(&mut app, "motor", "ok");
    let motor = app.index("motor");
    app.operator().unload(motor).expect("the operator may");
    until_shown(
        &mut app,
        "motor",
        "there is no instance: it failed or was unloaded",
    );
    assert_eq!(
        touch(&app, "go", Touch::Pressed),
        Err(PanelError::NoInstance("motor".to_owned()))
    );
    app.until(|app| app.schema("motor").state == jde_core::State::Slept);
    app.operator().load(motor).expect("the operator may");
    until_shown(&mut app, "motor", "ok");
    app.stop();
}

fn a_new_viewer_of_an_instance_that_ended_sees_why(executor: Executor) {
    let scenario = Scenario::new();
    let mut app = TestApp::start(executor, &scenario, APP);
    app.operator()
        .unload(app.index("motor"))
        .expect("the operator may");
    let no_instance = Err(PanelError::NoInstance("motor".to_owned()));
    app.until(|app| touch(app, "go", Touch::Pressed) == no_instance);
    let _viewer = view(&app, "motor");
    let shown = drawn(&app, "motor").expect("the reason is shown at once");
    assert_eq!(text_of(&shown), "there is no instance: it failed or was unloaded");
    app.stop();
}

fn with_several_viewers_the_highest_rate_counts(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_draw("motor", |io| io.text("ok"));
    let mut app = TestApp::start(executor, &scenario, APP);
    let slow = app
        .handle
        .view_panel(app.index("motor"), 0.0, || {})
        .expect("it has a panel");
    let fast = view(&app, "motor");
    app.until_unbounded(|app| drawn(app, "motor").is_some_and(|drawn| drawn.sequence > 3));
    drop(fast);
    let shown = drawn(&app, "motor").expect("a viewer remains").sequence;
    let before = scenario.count("motor iterate");
    app.until(|app| app.scenario.count("motor iterate") > before + 20);
    let now = drawn(&app, "motor").expect("a viewer remains").sequence;
    assert!(now <= shown + 1, "{shown} became {now}");
    drop(slow);
    assert_eq!(drawn(&app, "motor"), None);
    app.stop();
}

#[test]
fn r16_viewers_change_no_decision() {
    let run = |viewed: bool| {
        let scenario = Scenario::new();
        let draw = |io: &Io<'_>| {
            io.value("now", io.now() as f64);
            io.value("input", io.input().map_or(-1.0, |(value, _)| value));
        };
        scenario.on_draw("motor", draw);
        scenario.on_draw("below", draw);
        scenario.on_call("eye", |call, io| {
            if call == Call::Iterate {
                io.publish(io.now() as f64);
            }
            Ok(())
        });
        scenario.on_call("high", |call, io| {
            if call == Call::Check {
                io.ready((io.now() / (70 * MS)).is_multiple_of(2));
            }
            Ok(())
        });
        let turns = Arc::new(Mutex::new(Vec::new()));
        let recorder = Arc::clone(&turns);
        let on_turn: OnTurn = Arc::new(move |turn: &Turn| recorder.lock().push(*turn));
        let options = Options {
            on_turn: Some(on_turn),
            ..Options::default()
        };
        let mut app = TestApp::start_with(Executor::Lockstep, &scenario, TWO, options);
        let viewers = viewed.then(|| (view(&app, "motor"), view(&app, "below")));
        for step in 1..200 {
            assert_eq!(app.advance(step * 5 * MS), None);
        }
        let drawings = scenario.count("motor draw");
        drop(viewers);
        let mut lines = scenario.lines();
        lines.retain(|line| !line.ends_with(" draw"));
        let events = format!("{:?}", scenario.events());
        app.stop();
        let turns = std::mem::take(&mut *turns.lock());
        (drawings, lines, events, turns)
    };
    let (drawings, lines, events, turns) = run(false);
    let (viewed_drawings, viewed_lines, viewed_events, viewed_turns) = run(true);
    assert!(
        drawings == 0 && viewed_drawings > 0,
        "{drawings} and {viewed_drawings} drawings"
    );
    assert_eq!(lines, viewed_lines);
    assert_eq!(events, viewed_events);
    let reads_input = |turn: &Turn| {
        matches!(turn.kind(), TurnKind::Cycled(_)) && turn.inputs.iter().any(|input| *input != Turn::NO_VALUE)
    };
    assert!(viewed_turns.iter().any(reads_input), "some turns read imports");
    assert_eq!(turns, viewed_turns, "viewers do not change the inputs of a turn");
}
