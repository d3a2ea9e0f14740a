//! Panels: drawn only while somebody looks, on the schema's own turn, changing nothing; touched between iterations, as an
//! operator's doing (R14).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use jde_core::Health;
use jde_host::event::{Event, OperatorAction};
use jde_host::{Drawn, Look, Refusal};
use jde_panel::{Button, Gesture, Item, Touch};
use jde_schema::types::Twist;

use crate::common::{Call, Executor, MS, Rig, Stage, on_every_executor};

on_every_executor!(
    a_panel_is_drawn_only_while_somebody_looks,
    a_panel_shows_what_the_iteration_saw,
    a_schema_without_a_panel_says_so,
    a_schema_that_sleeps_is_drawn_too,
    a_panel_that_panics_shows_why_and_leaves_its_schema_running,
    a_panel_that_cannot_be_shows_why,
    a_panel_that_writes_is_refused_and_says_what,
    r10_gestures_are_handed_in_between_iterations_in_their_order_and_once,
    r14_a_gesture_is_told_as_an_operators_doing,
    a_drag_that_moved_on_is_told_where_it_is,
    gestures_that_nobody_takes_up_are_refused_after_some,
    a_gesture_that_fails_is_a_fault_like_any_other,
    the_panel_of_an_instance_that_is_gone_says_so,
    several_may_look_and_the_most_wanted_rate_counts,
);

/// Where calls take time.
mod real {
    use super::{a_panel_is_drawn_no_more_often_than_is_wanted, a_slow_panel_takes_a_twentieth_of_the_time};

    crate::common::in_real_time!(
        a_slow_panel_takes_a_twentieth_of_the_time,
        a_panel_is_drawn_no_more_often_than_is_wanted,
    );
}

const APP: &str = r#"
    roots = ["easel"]
    [schemas.easel]
    type = "test/easel"
    imports = { input = "eye.out" }
    [schemas.eye]
    type = "test/eye"
"#;

const TWO: &str = r#"
    roots = ["high", "easel"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    [schemas.easel]
    type = "test/easel"
    actuators = { base = "robot.velocity" }
    children = { child = "below" }
    [schemas.below]
    type = "test/easel"
"#;

/// Looks as often as may be; each drawing is something that happened.
fn look(rig: &Rig, name: &str) -> Look {
    let stage = Arc::clone(&rig.stage);
    let look = rig.handle.look(rig.place(name), 1000.0, move || stage.stir());
    look.expect("it has a panel")
}

fn drawn(rig: &Rig, name: &str) -> Option<Arc<Drawn>> {
    rig.handle.panel(rig.place(name))
}

/// Goes on until it shows this text, or the reason why it shows nothing has it.
fn until_shown(rig: &mut Rig, name: &str, text: &str) -> Arc<Drawn> {
    rig.patiently(|rig| drawn(rig, name).is_some_and(|drawn| says(&drawn).contains(text)));
    drawn(rig, name).expect("it was there")
}

fn says(drawn: &Drawn) -> String {
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

fn touch(rig: &Rig, widget: &str, touch: Touch) -> Result<(), Refusal> {
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
    // One was perhaps under way.
    assert!(stage.count("easel draw") <= before + 1);
    rig.stop();
}

fn a_panel_shows_what_the_iteration_saw(executor: Executor) {
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
    let refused = rig.handle.look(eye, 10.0, || {}).err();
    assert_eq!(refused, Some(Refusal::NoPanel("eye".to_owned())));
    let refused = rig.handle.look(99, 10.0, || {}).err();
    assert_eq!(refused, Some(Refusal::Nobody(99, 2)));
    let pressed = Gesture {
        widget: "go".to_owned(),
        touch: Touch::Pressed,
    };
    let refused = rig.handle.touch("ana@laptop", eye, pressed);
    assert_eq!(refused, Err(Refusal::NoPanel("eye".to_owned())));
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
            3 => drop(easel.child.set_policy(cx, jde_schema::Policy::Urgency)),
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

fn r10_gestures_are_handed_in_between_iterations_in_their_order_and_once(executor: Executor) {
    let stage = Stage::new();
    let mut rig = Rig::start(executor, &stage, APP);
    rig.until_did("easel iterate");
    for number in 0..5 {
        touch(&rig, &format!("button-{number}"), Touch::Pressed).expect("it takes them");
    }
    touch(&rig, "ready", Touch::Toggled(false)).expect("it takes it");
    rig.until_did("ana@laptop switched `ready` of easel off");
    rig.until(|rig| rig.see("easel").state == jde_core::State::Checking);
    let lines = stage.lines();
    let pressed: Vec<_> = lines.iter().filter(|line| line.contains("pressed")).collect();
    let wanted = [0, 1, 2, 3, 4].map(|number| format!("ana@laptop pressed `button-{number}` of easel"));
    assert_eq!(pressed, wanted.iter().collect::<Vec<_>>());
    let last = stage.last("easel iterate");
    assert!(
        last < stage.first("ana@laptop switched `ready` of easel off"),
        "what was touched counts at the next check"
    );
    rig.stop();
}

fn r14_a_gesture_is_told_as_an_operators_doing(executor: Executor) {
    let stage = Stage::new();
    let mut rig = Rig::start(executor, &stage, APP);
    rig.until_did("easel iterate");
    let clicked = Touch::Clicked {
        at: [1.2, 3.4, 0.0],
        button: Button::Primary,
    };
    touch(&rig, "field", clicked).expect("it takes it");
    rig.until_did("ana@laptop clicked `field` of easel at (1.20, 3.40)");
    let told = |wanted: &str| {
        rig.stage.count_events(|event| match event {
            Event::Operator { by, action, .. } => {
                matches!(action, OperatorAction::Touch { number: 1, .. })
                    && format!("{by} {}", action.words("easel")) == wanted
            }
            _ => false,
        })
    };
    assert_eq!(told("ana@laptop clicked `field` of easel at (1.20, 3.40)"), 1);
    rig.stop();
}

/// Holds the easel inside a drawing, or in lockstep nowhere: there nothing is taken up until time goes on.
fn held(executor: Executor, stage: &Arc<Stage>) -> (Rig, Option<Look>, Arc<AtomicBool>) {
    let hold = Arc::new(AtomicBool::new(true));
    let holds = Arc::clone(&hold);
    let weak = Arc::downgrade(stage);
    stage.paints("easel", move |_, _, _| {
        if let Some(stage) = weak.upgrade() {
            stage.note(|| "it is held".to_owned());
            stage.wait_until(|| !holds.load(Ordering::SeqCst));
        }
    });
    let mut rig = Rig::start(executor, stage, APP);
    rig.until_did("easel iterate");
    if executor == Executor::Lockstep {
        return (rig, None, hold);
    }
    let looks = look(&rig, "easel");
    rig.until_did("it is held");
    (rig, Some(looks), hold)
}

fn release(stage: &Stage, hold: &AtomicBool) {
    hold.store(false, Ordering::SeqCst);
    stage.stir();
}

fn a_drag_that_moved_on_is_told_where_it_is(executor: Executor) {
    let stage = Stage::new();
    let (mut rig, looks, hold) = held(executor, &stage);
    let drag = |widget: &str, to: f64, ended: bool| {
        let dragged = Touch::Dragged {
            from: [0.0; 3],
            to: [to, 0.0, 0.0],
            button: Button::Primary,
            ended,
        };
        touch(&rig, widget, dragged).expect("it takes them");
    };
    for step in 0..200 {
        drag("field", f64::from(step), false);
        drag("other", f64::from(step), false);
    }
    drag("field", 200.0, true);
    drag("field", 7.0, true);
    release(&stage, &hold);
    rig.until_did("ana@laptop dragged `field` of easel from (0.00, 0.00) to (7.00, 0.00)");
    let lines = stage.lines();
    let dragged = lines
        .iter()
        .filter_map(|line| line.strip_prefix("ana@laptop dragged "));
    let dragged: Vec<_> = dragged.collect();
    assert_eq!(
        dragged,
        [
            "`other` of easel from (0.00, 0.00) to (199.00, 0.00)",
            "`field` of easel from (0.00, 0.00) to (200.00, 0.00)",
            "`field` of easel from (0.00, 0.00) to (7.00, 0.00)",
        ]
    );
    drop(looks);
    rig.stop();
}

fn gestures_that_nobody_takes_up_are_refused_after_some(executor: Executor) {
    let stage = Stage::new();
    let (mut rig, looks, hold) = held(executor, &stage);
    for number in 0..64 {
        touch(&rig, &format!("button-{number}"), Touch::Pressed).expect("it takes so many");
    }
    let refused = touch(&rig, "go", Touch::Pressed).expect_err("that is too many");
    assert_eq!(refused, Refusal::Busy("easel".to_owned()));
    assert_eq!(
        refused.to_string(),
        "`easel` has 64 gestures to take up yet; try again"
    );
    release(&stage, &hold);
    rig.until_did("ana@laptop pressed `button-63` of easel");
    touch(&rig, "go", Touch::Pressed).expect("it took them up");
    rig.until_did("ana@laptop pressed `go` of easel");
    let nonsense = touch(&rig, "speed", Touch::Moved(f64::INFINITY)).expect_err("it is no number");
    assert!(matches!(nonsense, Refusal::Wrong(_)), "{nonsense}");
    drop(looks);
    rig.stop();
}

fn a_gesture_that_fails_is_a_fault_like_any_other(executor: Executor) {
    for (widget, reason) in [
        ("fail", "somebody pressed `fail`"),
        ("panic", "panicked in touch: "),
    ] {
        let stage = Stage::new();
        let mut rig = Rig::start(executor, &stage, APP);
        rig.until_did("easel iterate");
        touch(&rig, widget, Touch::Pressed).expect("it takes it");
        rig.until(|rig| rig.see("easel").faults == 1);
        assert!(stage.told(
            |event| matches!(event, Event::Health { health: Health::Faulted(said), .. } if said.starts_with(reason))
        ));
        rig.stop();
    }
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
        Err(Refusal::Gone("easel".to_owned()))
    );
    rig.until(|rig| rig.see("easel").state == jde_core::State::Slept);
    rig.operator().load(easel).expect("it can be");
    until_shown(&mut rig, "easel", "all is well");
    rig.stop();
}

fn several_may_look_and_the_most_wanted_rate_counts(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| pen.text("all is well"));
    let mut rig = Rig::start(executor, &stage, APP);
    let seldom = rig
        .handle
        .look(rig.place("easel"), 0.0, || {})
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

fn a_slow_panel_takes_a_twentieth_of_the_time(executor: Executor) {
    const SLOW: Duration = Duration::from_millis(20);
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| {
        let start = Instant::now();
        while start.elapsed() < SLOW {
            std::hint::spin_loop();
        }
        pen.text("at last");
    });
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
        .look(rig.place("easel"), 20.0, move || stirs.stir())
        .expect("it has a panel");
    let first = until_shown(&mut rig, "easel", "all is well");
    rig.patiently(|rig| drawn(rig, "easel").is_some_and(|drawn| drawn.sequence >= first.sequence + 6));
    let last = drawn(&rig, "easel").expect("it was there");
    let drawings = last.sequence - first.sequence;
    // One may have been late, so that the next came early.
    assert!(
        last.time - first.time >= (drawings - 1) * 50 * MS,
        "{drawings} in {} ms",
        (last.time - first.time) / MS
    );
    rig.stop();
}

#[test]
fn r16_who_looks_changes_nothing_of_what_is_decided() {
    let run = |looks: bool| {
        let stage = Stage::new();
        stage.paints("easel", |easel, cx, pen| {
            pen.value("now", cx.now().as_secs_f64(), "s");
            pen.value("iterations", easel.iterations as f64, "");
        });
        stage.play("high", |call, io| {
            if call == Call::Check {
                io.ready((io.now() / (70 * MS)).is_multiple_of(2));
            }
            Ok(())
        });
        let mut rig = Rig::start(Executor::Lockstep, &stage, TWO);
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
        (drawings, lines, events)
    };
    let ((none, blind, untold), (some, seen, told)) = (run(false), run(true));
    assert!(none == 0 && some > 0, "{none} and {some} drawings");
    assert_eq!(blind, seen);
    assert_eq!(untold, told);
}
