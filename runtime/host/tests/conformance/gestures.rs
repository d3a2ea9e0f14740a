//! Gestures on panels are delivered between iterations (R10), as an operator's action (R14).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_core::Health;
use jde_host::{Options, PanelError, PanelViewGuard};
use jde_panel::{Button, Touch};
use jde_records::event::What;
use jde_records::{RecordBuilder, RunRecord};

use crate::common::{Call, Executor, Language, MS, Scenario, TestApp, in_languages, on_every_executor};
use crate::panels::{APP, touch, view};

on_every_executor!(
    r10_gestures_are_delivered_once_and_in_order_between_iterations,
    r14_a_gesture_is_reported_as_an_operator_action,
    drags_of_one_widget_are_merged_into_the_newest,
    moves_are_not_merged_across_another_gesture,
    only_widgets_that_a_panel_shows_can_be_touched,
    gestures_are_refused_when_the_queue_is_full,
    gestures_for_an_instance_that_ended_are_reported_as_refused,
    a_gesture_that_fails_is_a_fault_like_any_other,
);

in_languages!(Lockstep, [C Cpp Python]:
    r10_gestures_are_delivered_once_and_in_order_between_iterations,
    a_gesture_that_fails_is_a_fault_like_any_other,
);

mod hanging {
    use super::r17_queued_gestures_delay_a_turn_by_at_most_one_gesture;

    crate::common::in_real_time!(r17_queued_gestures_delay_a_turn_by_at_most_one_gesture);
}

fn r17_queued_gestures_delay_a_turn_by_at_most_one_gesture(executor: Executor) {
    let scenario = Scenario::new();
    let (begun, recorder) = (AtomicBool::new(false), Arc::clone(&scenario));
    scenario.on_draw("motor", move |_| {
        if !begun.swap(true, Ordering::SeqCst) {
            recorder.record(|| String::from("drawing"));
            recorder.wait_until(|| recorder.has_line("go"));
            // The next turn is due at the end of this time.
            recorder
                .handle()
                .expect("the application has started")
                .spend(20 * MS);
        }
    });
    let options = Options {
        counted: true,
        ..Options::default()
    };
    let mut app = TestApp::start_with(executor, &scenario, APP, options);
    let _view = view(&app, "motor");
    app.until_line("drawing");
    for number in 0..5 {
        touch(&app, &format!("button-{number}"), Touch::Pressed).expect("the queue has room");
    }
    scenario.record(|| String::from("go"));
    app.until_line("ana@laptop pressed `button-4` of motor");
    app.stop();
    let since = scenario.lines().split_off(scenario.first("go"));
    let position = |text: &str| since.iter().position(|line| line.contains(text));
    assert!(position("motor iterate") < position("button-1"), "{since:#?}");
    let pressed = since.iter().filter(|line| line.contains("pressed"));
    assert_eq!(pressed.count(), 5, "each once");
}

fn r10_gestures_are_delivered_once_and_in_order_between_iterations(executor: Executor) {
    let scenario = Scenario::new();
    let mut ready = true;
    scenario.on_call("motor", move |call, io| {
        match call {
            Call::Check => io.ready(ready),
            Call::Touch => ready = io.gesture != "ana@laptop switched `ready` of motor off",
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    app.until_line("motor iterate");
    for number in 0..5 {
        touch(&app, &format!("button-{number}"), Touch::Pressed).expect("the queue has room");
    }
    touch(&app, "ready", Touch::Toggled(false)).expect("the queue has room");
    app.until_line("ana@laptop switched `ready` of motor off");
    app.until(|app| app.schema("motor").state == jde_core::State::Checking);
    let lines = scenario.lines();
    let pressed: Vec<_> = lines.iter().filter(|line| line.contains("pressed")).collect();
    let expected = [0, 1, 2, 3, 4].map(|number| format!("ana@laptop pressed `button-{number}` of motor"));
    assert_eq!(pressed, expected.iter().collect::<Vec<_>>());
    let last = scenario.last("motor iterate");
    assert!(
        last < scenario.first("ana@laptop switched `ready` of motor off"),
        "a gesture takes effect at the next check"
    );
    app.stop();
}

fn r14_a_gesture_is_reported_as_an_operator_action(executor: Executor) {
    let scenario = Scenario::new();
    let mut app = TestApp::start(executor, &scenario, APP);
    app.until_line("motor iterate");
    let clicked = Touch::Clicked {
        at: [1.2, 3.4, 0.0],
        button: Button::Primary,
    };
    touch(&app, "field", clicked).expect("the queue has room");
    app.until_line("ana@laptop clicked `field` of motor at (1.20, 3.40)");
    let count = |expected: &str| {
        app.scenario.count_events(|event| {
            let what = event.what();
            let by = what.and_then(What::by).unwrap_or_default();
            let gesture = what.and_then(What::gesture);
            gesture.is_some_and(|(number, gesture)| {
                number == 1 && format!("{by} {}", gesture.words("motor")) == expected
            })
        })
    };
    assert_eq!(count("ana@laptop clicked `field` of motor at (1.20, 3.40)"), 1);
    app.stop();
}

/// Blocks the motor schema inside a drawing. In lockstep it blocks nothing, because no gesture is delivered
/// until time advances.
pub(crate) fn blocked_in_draw(
    executor: Executor,
    scenario: &Arc<Scenario>,
) -> (TestApp, Option<PanelViewGuard>, Arc<AtomicBool>) {
    let blocked = Arc::new(AtomicBool::new(true));
    let blocks = Arc::clone(&blocked);
    let weak = Arc::downgrade(scenario);
    scenario.on_draw("motor", move |io| {
        io.button("go");
        if let Some(scenario) = weak.upgrade() {
            scenario.record(|| "blocked".to_owned());
            scenario.wait_until(|| !blocks.load(Ordering::SeqCst));
        }
    });
    let mut app = TestApp::start(executor, scenario, APP);
    app.until_line("motor iterate");
    if executor == Executor::Lockstep {
        return (app, None, blocked);
    }
    let viewer = view(&app, "motor");
    app.until_line("blocked");
    (app, Some(viewer), blocked)
}

pub(crate) fn release(scenario: &Scenario, blocked: &AtomicBool) {
    blocked.store(false, Ordering::SeqCst);
    scenario.notify();
}

fn drags_of_one_widget_are_merged_into_the_newest(executor: Executor) {
    let scenario = Scenario::new();
    let (mut app, viewer, blocked) = blocked_in_draw(executor, &scenario);
    let drag = |widget: &str, to: f64, ended: bool| {
        let dragged = Touch::Dragged {
            from: [0.0; 3],
            to: [to, 0.0, 0.0],
            button: Button::Primary,
            ended,
        };
        touch(&app, widget, dragged).expect("the queue has room");
    };
    for step in 0..200 {
        drag("field", f64::from(step), false);
        drag("other", f64::from(step) / 3.0, false);
    }
    drag("field", 200.0, true);
    drag("field", 7.0, true);
    release(&scenario, &blocked);
    app.until_line("ana@laptop dragged `field` of motor from (0.00, 0.00) to (7.00, 0.00)");
    let lines = scenario.lines();
    let dragged = lines
        .iter()
        .filter_map(|line| line.strip_prefix("ana@laptop dragged "));
    let dragged: Vec<_> = dragged.collect();
    assert_eq!(
        dragged,
        [
            "`other` of motor from (0.00, 0.00) to (66.33, 0.00)",
            "`field` of motor from (0.00, 0.00) to (200.00, 0.00)",
            "`field` of motor from (0.00, 0.00) to (7.00, 0.00)",
        ]
    );
    let touches = |mut builder: RecordBuilder| -> Vec<RunRecord> {
        let lines = scenario
            .events()
            .into_iter()
            .flat_map(|event| builder.process(&event));
        let touched = |line: &RunRecord| line.what().is_some_and(|what| what.gesture().is_some());
        lines.filter(touched).collect()
    };
    let application = app.handle.application();
    assert_eq!(
        touches(RecordBuilder::new(application)).len(),
        2,
        "only the drags that have ended"
    );
    let all = touches(RecordBuilder::with_all_drags(application));
    assert_eq!(all.len(), 3, "a replay needs all drags");
    for line in all {
        let parsed = RunRecord::parse(line.kind(), &line.to_json()).expect("it is a record");
        assert_eq!(parsed, line);
    }
    drop(viewer);
    app.stop();
}

fn moves_are_not_merged_across_another_gesture(executor: Executor) {
    let scenario = Scenario::new();
    let (mut app, viewer, blocked) = blocked_in_draw(executor, &scenario);
    let perform =
        |widget: &str, touch: Touch| crate::panels::touch(&app, widget, touch).expect("the queue has room");
    for to in [4.0, 5.0] {
        perform("speed", Touch::Moved(to));
        perform("gain", Touch::Moved(to / 10.0));
    }
    perform("apply", Touch::Pressed);
    for to in [6.0, 7.0] {
        perform("speed", Touch::Moved(to));
    }
    release(&scenario, &blocked);
    app.until_line("ana@laptop moved `speed` of motor to 7");
    let lines = scenario.lines();
    let done = lines.iter().filter_map(|line| line.strip_prefix("ana@laptop "));
    let done: Vec<_> = done.collect();
    assert_eq!(
        done,
        [
            "moved `speed` of motor to 5",
            "moved `gain` of motor to 0.5",
            "pressed `apply` of motor",
            "moved `speed` of motor to 7",
        ]
    );
    drop(viewer);
    app.stop();
}

fn only_widgets_that_a_panel_shows_can_be_touched(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_draw("motor", |io| {
        io.text("all is well");
        io.button("go");
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    let viewer = view(&app, "motor");
    crate::panels::until_shown(&mut app, "motor", "all is well");
    let refused = touch(&app, "gone", Touch::Pressed).expect_err("the panel shows no such widget");
    assert_eq!(
        refused.to_string(),
        "the gesture is invalid: `gone`: the panel shows no such widget now"
    );
    let refused = touch(&app, "go", Touch::Toggled(true)).expect_err("the widget is a button");
    assert!(matches!(refused, PanelError::InvalidGesture(_)), "{refused}");
    touch(&app, "go", Touch::Pressed).expect("the panel shows it");
    app.until_line("ana@laptop pressed `go` of motor");
    drop(viewer);
    touch(&app, "hidden", Touch::Pressed).expect("without a viewer, any widget is accepted");
    app.until_line("ana@laptop pressed `hidden` of motor");
    app.stop();
}

fn gestures_for_an_instance_that_ended_are_reported_as_refused(executor: Executor) {
    let refused = |scenario: &Scenario, text: &str| {
        scenario.has_event(
            |event| matches!(event.what(), Some(What::Refused { description, .. }) if description.starts_with(text)),
        )
    };
    let unloads = |app: &TestApp| {
        app.operator()
            .unload(app.index("motor"))
            .expect("it can be unloaded")
    };
    let fails = |app: &TestApp| touch(app, "fail", Touch::Pressed).expect("the queue has room");
    // In virtual time, an unload follows all earlier actions.
    /// Whether the instance ends before the gestures, and what ends it.
    type End<'a> = (bool, &'a dyn Fn(&TestApp));
    let ends: &[End<'_>] = match executor {
        Executor::Lockstep => &[(true, &fails)],
        Executor::Threads | Executor::Pool => &[(true, &fails), (false, &unloads)],
    };
    for (first, end) in ends {
        let first = *first;
        let scenario = Scenario::new();
        let (mut app, viewer, blocked) = blocked_in_draw(executor, &scenario);
        if first {
            end(&app);
        }
        for number in 0..3 {
            touch(&app, &format!("button-{number}"), Touch::Pressed).expect("the queue has room");
        }
        if !first {
            end(&app);
        }
        release(&scenario, &blocked);
        app.until(|_| refused(&scenario, "3 gestures on its panel: "));
        assert!(!scenario.has_line("ana@laptop pressed `button-0` of motor"));
        assert_eq!(app.schema("motor").refused, 3);
        drop(viewer);
        app.stop();
    }
}

fn gestures_are_refused_when_the_queue_is_full(executor: Executor) {
    let scenario = Scenario::new();
    let (mut app, viewer, blocked) = blocked_in_draw(executor, &scenario);
    for number in 0..64 {
        touch(&app, &format!("button-{number}"), Touch::Pressed).expect("the queue has room");
    }
    let refused = touch(&app, "go", Touch::Pressed).expect_err("the queue is full");
    assert_eq!(refused, PanelError::QueueFull("motor".to_owned()));
    assert_eq!(
        refused.to_string(),
        "`motor` has 64 gestures waiting; try again later"
    );
    release(&scenario, &blocked);
    app.until_line("ana@laptop pressed `button-63` of motor");
    touch(&app, "go", Touch::Pressed).expect("the queue has room again");
    app.until_line("ana@laptop pressed `go` of motor");
    let infinite = touch(&app, "speed", Touch::Moved(f64::INFINITY)).expect_err("infinity is refused");
    assert!(matches!(infinite, PanelError::InvalidGesture(_)), "{infinite}");
    drop(viewer);
    app.stop();
}

fn a_gesture_that_fails_is_a_fault_like_any_other(executor: Executor) {
    for widget in ["fail", "panic"] {
        let text = format!("ana@laptop pressed `{widget}` of motor");
        let is_reason = |reason: &str| match widget {
            "fail" => Language::of_test().is_error(reason, &text),
            _ => Language::of_test().is_panic(reason, "touch", &text),
        };
        let scenario = Scenario::new();
        let mut app = TestApp::start(executor, &scenario, APP);
        app.until_line("motor iterate");
        touch(&app, widget, Touch::Pressed).expect("the queue has room");
        app.until(|app| app.schema("motor").faults == 1);
        // An event may follow its snapshot a moment later.
        app.until(|_| {
            scenario.has_event(
                |event| matches!(event.what(), Some(What::HealthChanged { health: Health::Faulted(actual), .. }) if is_reason(actual)),
            )
        });
        app.stop();
    }
}
