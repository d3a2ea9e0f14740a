//! Gestures on panels are delivered between iterations (R10), as an operator's action (R14).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_core::Health;
use jde_host::{Options, PanelError, PanelViewGuard};
use jde_panel::{Button, Touch};
use jde_records::event::{Event, OperatorAction};
use jde_records::{RecordBuilder, RunRecord};

use crate::common::{Executor, MS, Rig, Stage, on_every_executor};
use crate::panels::{APP, look, touch};

on_every_executor!(
    r10_gestures_are_handed_in_between_iterations_in_their_order_and_once,
    r14_a_gesture_is_told_as_an_operators_doing,
    a_drag_that_moved_on_is_told_where_it_is,
    what_was_done_between_two_moves_stays_between_them,
    only_what_a_panel_shows_can_be_touched,
    gestures_that_nobody_takes_up_are_refused_after_some,
    gestures_that_nobody_can_take_up_any_more_are_told,
    a_gesture_that_fails_is_a_fault_like_any_other,
);

mod hanging {
    use super::r17_of_gestures_that_pile_up_no_more_than_one_delays_a_turn;

    crate::common::in_real_time!(r17_of_gestures_that_pile_up_no_more_than_one_delays_a_turn);
}

fn r17_of_gestures_that_pile_up_no_more_than_one_delays_a_turn(executor: Executor) {
    let stage = Stage::new();
    let (begun, clock) = (AtomicBool::new(false), Arc::clone(&stage));
    stage.paints("easel", move |_, _, _| {
        if !begun.swap(true, Ordering::SeqCst) {
            clock.note(|| String::from("it draws"));
            clock.wait_until(|| clock.did("go"));
            // Its next turn is due at the end of this time.
            clock.handle().expect("it was opened before").spend(20 * MS);
        }
    });
    let options = Options {
        counted: true,
        ..Options::default()
    };
    let mut rig = Rig::start_with(executor, &stage, APP, options);
    let _look = look(&rig, "easel");
    rig.until_did("it draws");
    for number in 0..5 {
        touch(&rig, &format!("button-{number}"), Touch::Pressed).expect("it takes them");
    }
    stage.note(|| String::from("go"));
    rig.until_did("ana@laptop pressed `button-4` of easel");
    rig.stop();
    let since = stage.lines().split_off(stage.first("go"));
    let place = |wanted: &str| since.iter().position(|line| line.contains(wanted));
    assert!(place("easel iterate") < place("button-1"), "{since:#?}");
    let pressed = since.iter().filter(|line| line.contains("pressed"));
    assert_eq!(pressed.count(), 5, "each once");
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
                    && format!("{by} {}", action.description("easel")) == wanted
            }
            _ => false,
        })
    };
    assert_eq!(told("ana@laptop clicked `field` of easel at (1.20, 3.40)"), 1);
    rig.stop();
}

/// Holds the easel inside a drawing. In lockstep it holds nothing: there no gesture is delivered until time
/// advances.
pub(crate) fn held(executor: Executor, stage: &Arc<Stage>) -> (Rig, Option<PanelViewGuard>, Arc<AtomicBool>) {
    let hold = Arc::new(AtomicBool::new(true));
    let holds = Arc::clone(&hold);
    let weak = Arc::downgrade(stage);
    stage.paints("easel", move |_, _, pen| {
        pen.button("go", "Go");
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

pub(crate) fn release(stage: &Stage, hold: &AtomicBool) {
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
        drag("other", f64::from(step) / 3.0, false);
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
            "`other` of easel from (0.00, 0.00) to (66.33, 0.00)",
            "`field` of easel from (0.00, 0.00) to (200.00, 0.00)",
            "`field` of easel from (0.00, 0.00) to (7.00, 0.00)",
        ]
    );
    let told = |mut story: RecordBuilder| -> Vec<RunRecord> {
        let lines = stage.events().into_iter().flat_map(|event| story.process(&event));
        let touched =
            |line: &RunRecord| matches!(line, RunRecord::Event(happening) if happening.touched.is_some());
        lines.filter(touched).collect()
    };
    let application = rig.handle.application();
    assert_eq!(
        told(RecordBuilder::new(application)).len(),
        2,
        "those that are over"
    );
    let whole = told(RecordBuilder::with_all_drags(application));
    assert_eq!(whole.len(), 3, "what a replay needs");
    for line in whole {
        let read = RunRecord::parse(line.kind(), &line.to_json()).expect("it is one");
        assert_eq!(read, line, "to the last digit");
    }
    drop(looks);
    rig.stop();
}

fn what_was_done_between_two_moves_stays_between_them(executor: Executor) {
    let stage = Stage::new();
    let (mut rig, looks, hold) = held(executor, &stage);
    let done = |widget: &str, touch: Touch| crate::panels::touch(&rig, widget, touch).expect("it takes them");
    for to in [4.0, 5.0] {
        done("speed", Touch::Moved(to));
        done("gain", Touch::Moved(to / 10.0));
    }
    done("apply", Touch::Pressed);
    for to in [6.0, 7.0] {
        done("speed", Touch::Moved(to));
    }
    release(&stage, &hold);
    rig.until_did("ana@laptop moved `speed` of easel to 7");
    let lines = stage.lines();
    let done = lines.iter().filter_map(|line| line.strip_prefix("ana@laptop "));
    let done: Vec<_> = done.collect();
    assert_eq!(
        done,
        [
            "moved `speed` of easel to 5",
            "moved `gain` of easel to 0.5",
            "pressed `apply` of easel",
            "moved `speed` of easel to 7",
        ]
    );
    drop(looks);
    rig.stop();
}

fn only_what_a_panel_shows_can_be_touched(executor: Executor) {
    let stage = Stage::new();
    stage.paints("easel", |_, _, pen| {
        pen.text("all is well");
        pen.button("go", "Go");
    });
    let mut rig = Rig::start(executor, &stage, APP);
    let looks = look(&rig, "easel");
    crate::panels::until_shown(&mut rig, "easel", "all is well");
    let refused = touch(&rig, "gone", Touch::Pressed).expect_err("it shows none");
    assert_eq!(
        refused.to_string(),
        "the gesture is wrong: `gone`: the panel shows no such widget now"
    );
    let refused = touch(&rig, "go", Touch::Toggled(true)).expect_err("it is a button");
    assert!(matches!(refused, PanelError::InvalidGesture(_)), "{refused}");
    touch(&rig, "go", Touch::Pressed).expect("it shows it");
    rig.until_did("ana@laptop pressed `go` of easel");
    drop(looks);
    touch(&rig, "hidden", Touch::Pressed).expect("nobody looks, so nobody knows");
    rig.until_did("ana@laptop pressed `hidden` of easel");
    rig.stop();
}

fn gestures_that_nobody_can_take_up_any_more_are_told(executor: Executor) {
    let told = |stage: &Stage, what: &str| {
        stage
            .told(|event| matches!(event, Event::Refused { description: said, .. } if said.starts_with(what)))
    };
    let unloads = |rig: &Rig| rig.operator().unload(rig.place("easel")).expect("it can be");
    let fails = |rig: &Rig| touch(rig, "fail", Touch::Pressed).expect("it takes it");
    // In virtual time an unload follows everything that was done before it.
    /// Whether the end is caused before the gestures, and how it is caused.
    type End<'a> = (bool, &'a dyn Fn(&Rig));
    let ends: &[End<'_>] = match executor {
        Executor::Lockstep => &[(true, &fails)],
        Executor::Threads | Executor::Pool => &[(true, &fails), (false, &unloads)],
    };
    for (first, ends) in ends {
        let first = *first;
        let stage = Stage::new();
        let (mut rig, looks, hold) = held(executor, &stage);
        if first {
            ends(&rig);
        }
        for number in 0..3 {
            touch(&rig, &format!("button-{number}"), Touch::Pressed).expect("it takes them");
        }
        if !first {
            ends(&rig);
        }
        release(&stage, &hold);
        rig.until(|_| told(&stage, "3 gestures on its panel: "));
        assert!(!stage.did("ana@laptop pressed `button-0` of easel"));
        assert_eq!(rig.see("easel").refused, 3);
        drop(looks);
        rig.stop();
    }
}

fn gestures_that_nobody_takes_up_are_refused_after_some(executor: Executor) {
    let stage = Stage::new();
    let (mut rig, looks, hold) = held(executor, &stage);
    for number in 0..64 {
        touch(&rig, &format!("button-{number}"), Touch::Pressed).expect("it takes so many");
    }
    let refused = touch(&rig, "go", Touch::Pressed).expect_err("that is too many");
    assert_eq!(refused, PanelError::QueueFull("easel".to_owned()));
    assert_eq!(
        refused.to_string(),
        "`easel` has 64 gestures to take up yet; try again"
    );
    release(&stage, &hold);
    rig.until_did("ana@laptop pressed `button-63` of easel");
    touch(&rig, "go", Touch::Pressed).expect("it took them up");
    rig.until_did("ana@laptop pressed `go` of easel");
    let nonsense = touch(&rig, "speed", Touch::Moved(f64::INFINITY)).expect_err("it is no number");
    assert!(matches!(nonsense, PanelError::InvalidGesture(_)), "{nonsense}");
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
        // An event may follow its snapshot a moment later.
        rig.until(|_| {
            stage.told(
                |event| matches!(event, Event::HealthChanged { health: Health::Faulted(said), .. } if said.starts_with(reason)),
            )
        });
        rig.stop();
    }
}
