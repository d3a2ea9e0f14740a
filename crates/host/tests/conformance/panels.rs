//! Panels: drawn only while they are viewed, in the schema's own turn, without effects.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use jde_core::Health;
use jde_host::{Options, PanelError, PanelViewGuard};
use jde_panel::PanelFrame;
use jde_panel::{Gesture, Item, Touch};
use jde_records::turn::{OnTurn, Turn};
use jde_schema::types::Twist;
use jde_schema::{Context, Pen};

use crate::common::{Call, Easel, Executor, MS, Rig, Stage, on_every_executor};

on_every_executor!(
    a_panel_is_drawn_only_while_somebody_looks,
    r8_a_panel_shows_what_the_iteration_saw,
    a_schema_without_a_panel_says_so,
    a_schema_that_sleeps_is_drawn_too,
    a_panel_that_panics_shows_why_and_leaves_its_schema_running,
    a_panel_that_cannot_be_shows_why,
    a_panel_that_writes_is_refused_and_says_what,
    the_panel_of_an_instance_that_is_gone_says_so,
    whoever_looks_at_what_is_gone_already_is_told_so,
    several_may_look_and_the_most_wanted_rate_counts,
);

pub(crate) const APP: &str = r#"
    roots = ["easel"]
    [schemas.easel]
    type = "test/easel"
    # What a drawing may take: far more than any takes here, whatever else the machine does.
    budget = "100ms"
    imports = { input = "eye.out" }
    [schemas.eye]
    type = "test/eye"
"#;

pub(crate) const TWO: &str = r#"
    roots = ["high", "easel"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    [schemas.easel]
    type = "test/easel"
    budget = "100ms"
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
    children = { child = "below" }
    [schemas.below]
    type = "test/easel"
    budget = "100ms"
    imports = { input = "eye.out" }
    [schemas.eye]
    type = "test/eye"
"#;

/// Views the panel at the highest rate. Each drawing wakes the stage.
pub(crate) fn look(rig: &Rig, name: &str) -> PanelViewGuard {
    let stage = Arc::clone(&rig.stage);
    let look = rig
        .handle
        .view_panel(rig.place(name), 1000.0, move || stage.stir());
    look.expect("it has a panel")
}

pub(crate) fn drawn(rig: &Rig, name: &str) -> Option<Arc<PanelFrame>> {
    rig.handle.panel(rig.place(name))
}

/// Runs until the panel shows this text, or has it in the reason why it shows nothing.
pub(crate) fn until_shown(rig: &mut Rig, name: &str, text: &str) -> Arc<PanelFrame> {
    rig.patiently(|rig| drawn(rig, name).is_some_and(|drawn| says(&drawn).contains(text)));
    drawn(rig, name).expect("it was there")
}

fn says(drawn: &PanelFrame) -> String {
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

pub(crate) fn touch(rig: &Rig, widget: &str, touch: Touch) -> Result<(), PanelError> {
    let gesture = Gesture {
        widget: widget.to_owned(),
        touch,
    };
    rig.handle.touch("ana@laptop", rig.place("easel"), gesture)
}

fn a_panel_is_drawn_only_while_somebody_looks(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |easel, _, pen| {
        pen.text(format!("iteration {}", easel.iterations))
    });
    let mut rig = Rig::start(executor, &stage, APP);
    let iterations = |rig: &Rig| rig.stage.count("easel iterate");
    rig.until(|rig| iterations(rig) >= 5);
    assert_eq!(stage.count("easel draw"), 0);
    assert_eq!(drawn(&rig, "easel"), None);

    let looks = look(&rig, "easel");
    let first = until_shown(&mut rig, "easel", "iteration");
    assert_eq!((first.sequence, first.failed), (1, 0));
    rig.patiently(|rig| drawn(rig, "easel").is_some_and(|drawn| drawn.sequence > 2));

    drop(looks);
    assert_eq!(
        drawn(&rig, "easel"),
        None,
        "nothing old is shown as if it were live"
    );
    let (before, then) = (stage.count("easel draw"), iterations(&rig));
    rig.until(|rig| iterations(rig) >= then + 5);
    // One drawing may have been in progress.
    assert!(stage.count("easel draw") <= before + 1);
    rig.stop();
}

fn r8_a_panel_shows_what_the_iteration_saw(executor: Executor) {
    let stage = Stage::new();
    let values = AtomicU64::new(0);
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            io.publish(values.fetch_add(1, Ordering::Relaxed) as f64);
        }
        Ok(())
    });
    let apart = Arc::new(AtomicBool::new(false));
    let found = Arc::clone(&apart);
    stage.paints("easel", move |easel, cx, pen| {
        let input = easel.input.get(cx).map(|input| *input.value());
        if easel.iterations > 0 && input != easel.seen {
            found.store(true, Ordering::Relaxed);
        }
        pen.value("input", input.unwrap_or(-1.0), "");
    });
    let mut rig = Rig::start(executor, &stage, APP);
    let _look = look(&rig, "easel");
    rig.patiently(|rig| drawn(rig, "easel").is_some_and(|drawn| drawn.sequence > 5));
    assert!(
        !apart.load(Ordering::Relaxed),
        "it showed another value than it acted on"
    );
    rig.stop();
}

fn a_schema_without_a_panel_says_so(executor: Executor) {
    let stage = Stage::new();
    let rig = Rig::start(executor, &stage, APP);
    let (easel, eye) = (rig.place("easel"), rig.place("eye"));
    assert_eq!(rig.handle.panels(), [easel]);
    assert!(rig.see("easel").panel && !rig.see("eye").panel);
    let refused = rig.handle.view_panel(eye, 10.0, || {}).err();
    assert_eq!(refused, Some(PanelError::NoPanel("eye".to_owned())));
    let refused = rig.handle.view_panel(99, 10.0, || {}).err();
    assert_eq!(refused, Some(PanelError::NoSuchSchema(99, 2)));
    let pressed = Gesture {
        widget: "go".to_owned(),
        touch: Touch::Pressed,
    };
    let refused = rig.handle.touch("ana@laptop", eye, pressed);
    assert_eq!(refused, Err(PanelError::NoPanel("eye".to_owned())));
    assert_eq!(rig.handle.panel(99), None);
    rig.stop();
}

fn a_schema_that_sleeps_is_drawn_too(executor: Executor) {
    let stage = Stage::new();
    stage.play("high", |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
    stage.paints("below", |easel, _, pen| {
        pen.text(format!("iteration {}", easel.iterations))
    });
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until_did("high iterate");
    let looks = look(&rig, "below");
    until_shown(&mut rig, "below", "iteration 0");
    rig.patiently(|rig| drawn(rig, "below").is_some_and(|drawn| drawn.sequence > 3));
    assert_eq!(rig.see("below").state, jde_core::State::Slept);
    assert_eq!(stage.count("below iterate"), 0, "to be looked at wakes nobody");
    drop(looks);
    rig.stop();
}

fn a_panel_that_panics_shows_why_and_leaves_its_schema_running(executor: Executor) {
    let stage = Stage::new();
    let broken = Arc::new(AtomicBool::new(true));
    let breaks = Arc::clone(&broken);
    stage.paints("easel", move |_, _, pen| {
        pen.text("all is well");
        assert!(!breaks.load(Ordering::Relaxed), "the paint is out");
    });
    let mut rig = Rig::start(executor, &stage, APP);
    let _look = look(&rig, "easel");
    let shown = until_shown(&mut rig, "easel", "the paint is out");
    assert!(says(&shown).starts_with("panicked in draw: "), "{}", says(&shown));
    assert_eq!(shown.failed, shown.sequence);
    let before = stage.count("easel iterate");
    rig.until(|rig| rig.stage.count("easel iterate") > before + 3);
    let view = rig.see("easel");
    assert_eq!(view.faults, 0);
    assert!(!matches!(view.health, Health::Faulted(_)), "{:?}", view.health);
    broken.store(false, Ordering::Relaxed);
    let shown = until_shown(&mut rig, "easel", "all is well");
    assert!(shown.failed > 0 && shown.failed < shown.sequence);
    rig.stop();
}

fn a_panel_that_cannot_be_shows_why(executor: Executor) {
    let stage = Stage::new();
    let step = Arc::new(AtomicU64::new(0));
    let at = Arc::clone(&step);
    stage.paints("easel", move |_, _, pen| match at.load(Ordering::Relaxed) {
        0 => pen.value("speed", f64::NAN, "m/s"),
        1 => {
            pen.button("go", "Go");
            pen.button("go", "Go too");
        }
        2 => {
            for _ in 0..30_000 {
                pen.text("again");
            }
        }
        _ => pen.text("all is well"),
    });
    let mut rig = Rig::start(executor, &stage, APP);
    let _look = look(&rig, "easel");
    for reason in [
        "`speed`: a number is NaN",
        "`go`: two widgets have this id",
        "it has more than 20000 widgets and shapes",
        "all is well",
    ] {
        until_shown(&mut rig, "easel", reason);
        step.fetch_add(1, Ordering::Relaxed);
    }
    assert_eq!(rig.see("easel").faults, 0);
    rig.stop();
}

fn a_panel_that_writes_is_refused_and_says_what(executor: Executor) {
    let stage = Stage::new();
    let step = Arc::new(AtomicU64::new(0));
    let at = Arc::clone(&step);
    stage.paints("easel", move |easel, cx, pen| {
        pen.text("all is well");
        match at.load(Ordering::Relaxed) {
            0 => drop(easel.base.command(cx, Twist::planar(0.3, 0.0))),
            1 => drop(easel.child.wake(cx)),
            2 => drop(easel.child.sleep(cx)),
            3 => drop(easel.child.set_policy(cx, jde_schema::Policy::URGENCY)),
            _ => {}
        }
    });
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until_did("easel iterate");
    let _look = look(&rig, "easel");
    for what in [
        "it tried to write `base` while its panel was drawn",
        "it tried to wake a child while its panel was drawn",
        "it tried to put a child to sleep while its panel was drawn",
        "it tried to change a policy while its panel was drawn",
        "all is well",
    ] {
        until_shown(&mut rig, "easel", what);
        step.fetch_add(1, Ordering::Relaxed);
    }
    assert!(!stage.did("robot velocity 0.3"));
    assert_eq!(rig.see("below").state, jde_core::State::Slept);
    let view = rig.see("easel");
    assert_eq!((view.faults, view.refused), (0, 0));
    rig.stop();
}

fn the_panel_of_an_instance_that_is_gone_says_so(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| pen.text("all is well"));
    let mut rig = Rig::start(executor, &stage, APP);
    let _look = look(&rig, "easel");
    until_shown(&mut rig, "easel", "all is well");
    let easel = rig.place("easel");
    rig.operator().unload(easel).expect("it can be");
    until_shown(&mut rig, "easel", "it is not there: it failed or was unloaded");
    assert_eq!(
        touch(&rig, "go", Touch::Pressed),
        Err(PanelError::NoInstance("easel".to_owned()))
    );
    rig.until(|rig| rig.see("easel").state == jde_core::State::Slept);
    rig.operator().load(easel).expect("it can be");
    until_shown(&mut rig, "easel", "all is well");
    rig.stop();
}

fn whoever_looks_at_what_is_gone_already_is_told_so(executor: Executor) {
    let stage = Stage::new();
    let mut rig = Rig::start(executor, &stage, APP);
    rig.operator().unload(rig.place("easel")).expect("it can be");
    let gone = Err(PanelError::NoInstance("easel".to_owned()));
    rig.until(|rig| touch(rig, "go", Touch::Pressed) == gone);
    let _look = look(&rig, "easel");
    let shown = drawn(&rig, "easel").expect("it says so at once");
    assert_eq!(says(&shown), "it is not there: it failed or was unloaded");
    rig.stop();
}

fn several_may_look_and_the_most_wanted_rate_counts(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| pen.text("all is well"));
    let mut rig = Rig::start(executor, &stage, APP);
    let seldom = rig
        .handle
        .view_panel(rig.place("easel"), 0.0, || {})
        .expect("it has a panel");
    let often = look(&rig, "easel");
    rig.patiently(|rig| drawn(rig, "easel").is_some_and(|drawn| drawn.sequence > 3));
    drop(often);
    let shown = drawn(&rig, "easel").expect("somebody still looks").sequence;
    let before = stage.count("easel iterate");
    rig.until(|rig| rig.stage.count("easel iterate") > before + 20);
    let now = drawn(&rig, "easel").expect("somebody still looks").sequence;
    assert!(now <= shown + 1, "{shown} became {now}");
    drop(seldom);
    assert_eq!(drawn(&rig, "easel"), None);
    rig.stop();
}

#[test]
fn r16_who_looks_changes_nothing_of_what_is_decided() {
    let run = |looks: bool| {
        let stage = Stage::new();
        let paint = |easel: &Easel, cx: &Context, pen: &mut Pen| {
            pen.value("now", cx.now().as_secs_f64(), "s");
            let input = easel.input.get(cx).map_or(-1.0, |input| *input.value());
            pen.value("input", input, "");
        };
        stage.paints("easel", paint);
        stage.paints("below", paint);
        stage.play("eye", |call, io| {
            if call == Call::Iterate {
                io.publish(io.now() as f64);
            }
            Ok(())
        });
        stage.play("high", |call, io| {
            if call == Call::Check {
                io.ready((io.now() / (70 * MS)).is_multiple_of(2));
            }
            Ok(())
        });
        let turns = Arc::new(Mutex::new(Vec::new()));
        let tells = Arc::clone(&turns);
        let on_turn: OnTurn = Arc::new(move |turn: &Turn| tells.lock().expect("no turn panics").push(*turn));
        let options = Options {
            on_turn: Some(on_turn),
            ..Options::default()
        };
        let mut rig = Rig::start_with(Executor::Lockstep, &stage, TWO, options);
        let eyes = looks.then(|| (look(&rig, "easel"), look(&rig, "below")));
        for step in 1..200 {
            assert_eq!(rig.advance(step * 5 * MS), None);
        }
        let drawings = stage.count("easel draw");
        drop(eyes);
        let mut lines = stage.lines();
        lines.retain(|line| !line.ends_with(" draw"));
        let events = format!("{:?}", stage.events());
        rig.stop();
        let turns = std::mem::take(&mut *turns.lock().expect("no turn panics"));
        (drawings, lines, events, turns)
    };
    let ((none, blind, untold, unseen), (some, seen, told, turns)) = (run(false), run(true));
    assert!(none == 0 && some > 0, "{none} and {some} drawings");
    assert_eq!(blind, seen);
    assert_eq!(untold, told);
    let looked =
        |turn: &Turn| turn.kind == Turn::CYCLED && turn.inputs.iter().any(|input| *input != Turn::NO_VALUE);
    assert!(turns.iter().any(looked), "their imports were looked at");
    assert_eq!(unseen, turns, "nor what each turn looked at");
}
