//! An operator's actions are shown as such, and undone when the operator releases them (R14).

use std::sync::Arc;

use jde_board::value::Value;
use jde_core::State;
use jde_records::event::{Event, OperatorAction};
use jde_records::snapshot::SchemaView;

use crate::common::{Call, Executor, MS, Rig, Stage, on_every_executor};

on_every_executor!(
    r14_a_schema_that_is_stopped_sleeps_until_it_is_released,
    r14_a_father_whose_child_is_stopped_is_refused_nothing,
    r14_a_schema_that_is_forced_wins_until_it_is_released,
    r14_a_child_that_is_played_is_awake_until_it_is_released,
    r14_a_period_is_given_back,
    r14_a_modulation_is_given_back_unless_a_father_wrote_it_since,
    r14_who_lets_go_undoes_nothing_of_others,
    r14_what_does_not_exist_is_refused_in_words,
);

const APP: &str = r#"
    roots = ["high", "father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.father]
    type = "test/motor"
    gain = 0.5
    children = { a = "left" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn held(view: &SchemaView) -> Option<String> {
    let hold = view.operator.as_ref()?;
    Some(format!("{} by {}", hold.kind.word(), hold.by))
}

fn start(executor: Executor, high: bool) -> Rig {
    let stage = Stage::new();
    stage.drives("high", &Arc::new(high.into()), 0.3);
    stage.drives("left", &Arc::new(true.into()), 0.1);
    stage.play("father", |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, APP);
    let first = if high { "high iterate" } else { "father iterate" };
    rig.until_did(first);
    rig
}

fn r14_a_schema_that_is_stopped_sleeps_until_it_is_released(executor: Executor) {
    let mut rig = start(executor, true);
    let high = rig.place("high");
    rig.operator().hold_asleep(high).expect("it can be stopped");
    rig.until_did("high sleep");
    rig.until_did("father iterate");
    let view = rig.see("high");
    assert_eq!(
        (view.state, held(&view).as_deref()),
        (State::Slept, Some("stopped by ana@laptop"))
    );
    assert!(rig.stage.told(|event| matches!(
        event,
        Event::Operator {
            by,
            action: OperatorAction::Hierarchy(_),
            ..
        } if by == "ana@laptop"
    )));
    let before = rig.stage.count("high iterate");
    rig.operator().release(high).expect("it can be released");
    rig.until(|rig| rig.stage.count("high iterate") > before);
    assert_eq!(rig.see("high").operator, None);
    rig.stop();
}

fn r14_a_father_whose_child_is_stopped_is_refused_nothing(executor: Executor) {
    let mut rig = start(executor, false);
    rig.stage.play("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => drop(io.wake("a")),
            _ => {}
        }
        Ok(())
    });
    rig.until_did("left iterate");
    let left = rig.place("left");
    rig.operator().hold_asleep(left).expect("it can be stopped");
    rig.until_did("left sleep");
    let before = rig.stage.count("father iterate");
    rig.until(|rig| rig.stage.count("father iterate") > before + 3);
    assert_eq!(rig.see("father").refused, 0);
    assert!(!rig.stage.told(|event| matches!(event, Event::Refused { .. })));
    let before = rig.stage.count("left iterate");
    rig.operator().release(left).expect("it can be released");
    rig.until(|rig| rig.stage.count("left iterate") > before);
    rig.stop();
}

fn r14_a_schema_that_is_forced_wins_until_it_is_released(executor: Executor) {
    let mut rig = start(executor, false);
    let high = rig.place("high");
    rig.operator().force(high).expect("it can be forced");
    rig.until_did("robot velocity 0.3");
    assert_eq!(rig.winner("roots").as_deref(), Some("high"));
    assert_eq!(held(&rig.see("high")).as_deref(), Some("forced by ana@laptop"));
    rig.operator().release(high).expect("it can be released");
    rig.until(|rig| rig.winner("roots").as_deref() == Some("father"));
    assert_eq!(rig.see("high").operator, None);
    rig.stop();
}

fn r14_a_child_that_is_played_is_awake_until_it_is_released(executor: Executor) {
    let mut rig = start(executor, false);
    let left = rig.place("left");
    rig.operator().play(left).expect("it can be played");
    rig.until_did("robot velocity 0.1");
    assert_eq!(held(&rig.see("left")).as_deref(), Some("played by ana@laptop"));
    rig.operator().release(left).expect("it can be released");
    rig.until_did("left sleep");
    rig.until_did("robot velocity 0");
    let view = rig.see("left");
    assert_eq!((view.state, view.operator), (State::Slept, None));
    rig.stop();
}

fn r14_a_period_is_given_back(executor: Executor) {
    let mut rig = start(executor, false);
    let father = rig.place("father");
    rig.operator().set_period(father, 3 * MS).expect("a period");
    rig.operator().set_period(father, 2 * MS).expect("a period");
    rig.until(|rig| rig.see("father").period == 2 * MS);
    assert_eq!(
        held(&rig.see("father")).as_deref(),
        Some("re-timed by ana@laptop")
    );
    assert!(rig.stage.told(
        |event| matches!(event, Event::Operator { action: OperatorAction::Period { period, .. }, .. }
        if *period == 2 * MS)
    ));
    rig.operator().release(father).expect("it can be released");
    rig.until(|rig| rig.see("father").period == 10 * MS);
    assert_eq!(rig.see("father").operator, None);
    rig.stop();
}

fn r14_a_modulation_is_given_back_unless_a_father_wrote_it_since(executor: Executor) {
    let mut rig = start(executor, false);
    let [father, left] = ["father", "left"].map(|name| rig.place(name));
    let gain = |rig: &Rig, name: &str| {
        rig.handle
            .value::<f64>(&format!("{name}.gain"))
            .expect("a modulation")
    };
    rig.operator()
        .modulate(father, "gain", &Value::Float(0.75))
        .expect("a modulation");
    assert_eq!(gain(&rig, "father"), Some(0.75));
    assert_eq!(
        held(&rig.see("father")).as_deref(),
        Some("modulated by ana@laptop")
    );
    rig.operator().release(father).expect("it can be released");
    assert_eq!(gain(&rig, "father"), Some(0.5));
    assert_eq!(rig.see("father").operator, None);

    rig.operator()
        .modulate(left, "gain", &Value::Float(0.75))
        .expect("a modulation");
    rig.stage.play("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.modulate_a(0.9);
            }
            _ => {}
        }
        Ok(())
    });
    rig.until(|rig| gain(rig, "left") == Some(0.9));
    assert_eq!(rig.see("left").operator, None);
    rig.operator().release(left).expect("it can be released");
    assert_eq!(gain(&rig, "left"), Some(0.9));
    rig.stop();
}

fn r14_who_lets_go_undoes_nothing_of_others(executor: Executor) {
    let mut rig = start(executor, true);
    let (ana, bob) = (rig.operator(), rig.handle.operator("bob@base"));
    let high = rig.place("high");
    let seen = |rig: &Rig| held(&rig.see("high"));
    let gain = |rig: &Rig| rig.handle.value::<f64>("high.gain").expect("a modulation");
    let before = gain(&rig);
    ana.modulate(high, "gain", &Value::Float(0.75))
        .expect("a modulation");
    bob.hold_asleep(high).expect("it can be stopped");
    bob.set_period(high, 20 * MS).expect("a period");
    assert_eq!(seen(&rig).as_deref(), Some("stopped by bob@base"));

    ana.release_own(high).expect("it holds something");
    assert_eq!(gain(&rig), before);
    assert_eq!(seen(&rig).as_deref(), Some("stopped by bob@base"));
    let acts = |rig: &Rig, who: &str| {
        rig.stage
            .count_events(|event| matches!(event, Event::Operator { by, .. } if by == who))
    };
    assert_eq!(acts(&rig, "ana@laptop"), 2);
    ana.release_own(high).expect("it holds nothing more");
    assert_eq!(
        acts(&rig, "ana@laptop"),
        2,
        "nothing was undone, so nothing is told"
    );

    // An operator that overwrites another's value takes it over, and the value before both is restored.
    ana.modulate(high, "gain", &Value::Float(0.25))
        .expect("a modulation");
    bob.modulate(high, "gain", &Value::Float(0.5))
        .expect("a modulation");
    ana.release_own(high).expect("bob holds it");
    assert_eq!(gain(&rig), Some(0.5));
    let iterated = rig.stage.count("high iterate");
    bob.release_own(high).expect("it holds something");
    assert_eq!((gain(&rig), seen(&rig)), (before, None));
    rig.until(|rig| rig.stage.count("high iterate") > iterated);
    rig.stop();
}

fn r14_what_does_not_exist_is_refused_in_words(executor: Executor) {
    let rig = start(executor, false);
    let operator = rig.operator();
    let nobody = Err(String::from(
        "there is no schema number 99; the application has 4",
    ));
    assert_eq!(operator.set_period(99, MS), nobody);
    assert_eq!(operator.modulate(99, "gain", &Value::Float(1.0)), nobody);
    for refused in [
        operator.play(99),
        operator.hold_asleep(99),
        operator.force(99),
        operator.release(99),
    ] {
        assert!(refused.expect_err("there is none").contains("99"));
    }
    let father = rig.place("father");
    assert_eq!(
        operator.set_period(father, 1),
        Err(String::from(
            "a period of 0.000000001 s is shorter than 100 us; give one from 100 us to a day"
        ))
    );
    let said = operator
        .modulate(father, "gian", &Value::Float(1.0))
        .expect_err("there is none");
    assert!(said.contains("gain"), "{said}");
    let said = operator
        .modulate(father, "gain", &Value::Float(f64::NAN))
        .expect_err("not finite");
    assert!(said.starts_with("`father.gain` stays as it is: "), "{said}");
    let said = operator
        .modulate(father, "mission", &Value::Float(1.0))
        .expect_err("an export");
    assert_eq!(
        said,
        "`father.mission` is no modulation; only modulations can be set"
    );
    let robot = rig.place("robot");
    assert!(operator.force(robot).is_err(), "a driver competes with nobody");
    rig.stop();
}
