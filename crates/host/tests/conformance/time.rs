//! Deadlines, triggers and contracts (R11, R12, R17).

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex, mpsc};

use jde_board::value::Value;
use jde_core::{Health, State};
use jde_host::Options;
use jde_records::event::Event;

use crate::common::{Call, Executor, MS, Rig, Stage, on_every_executor};

on_every_executor!(
    r12_a_trigger_checks_without_waiting_for_the_period,
    r12_values_that_come_together_are_judged_together,
    r12_a_trigger_makes_no_winner_iterate_out_of_turn,
    r17_a_takeover_is_measured_against_the_contract,
    r17_the_contract_follows_the_period,
    a_schema_knows_whether_time_is_everybodys,
);

mod real_time {
    use super::{
        a_shorter_period_is_no_missed_deadline, overruns_are_counted_and_shown_and_pass,
        r11_a_late_schema_skips_and_does_not_pile_up,
        r17_a_takeover_beyond_its_contract_is_an_event_of_its_own,
    };

    crate::common::in_real_time!(
        r11_a_late_schema_skips_and_does_not_pile_up,
        overruns_are_counted_and_shown_and_pass,
        a_shorter_period_is_no_missed_deadline,
        r17_a_takeover_beyond_its_contract_is_an_event_of_its_own,
    );
}

const HOUR: u64 = 3_600_000 * MS;

const ONE: &str = r#"
    roots = ["low"]
    [schemas.low]
    type = "test/motor"
"#;

/// A schema that is READY, and runs `act` in each iteration.
fn acts(stage: &Stage, name: &str, mut act: impl FnMut(&mut crate::common::Io<'_>) + Send + 'static) {
    stage.play(name, move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => act(io),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
}

#[test]
fn r11_deadlines_do_not_drift() {
    let stage = Stage::new();
    let times = Arc::new(Mutex::new(Vec::new()));
    let notes = Arc::clone(&times);
    acts(&stage, "low", move |io| notes.lock().unwrap().push(io.now()));
    let mut rig = Rig::start(
        Executor::Lockstep,
        &stage,
        &ONE.replace("\"test/motor\"", "\"test/motor\"\n period = \"7ms\""),
    );
    assert_eq!(rig.advance(7_000 * MS), None);
    let expected: Vec<u64> = (0..=1000).map(|count| count * 7 * MS).collect();
    assert_eq!(*times.lock().unwrap(), expected);
    rig.stop();
}

fn r11_a_late_schema_skips_and_does_not_pile_up(executor: Executor) {
    let stage = Stage::new();
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    let times = Arc::new(Mutex::new(Vec::new()));
    let notes = Arc::clone(&times);
    let mut count = 0;
    acts(&stage, "low", move |io| {
        let begin = io.now();
        count += 1;
        if count == 5 {
            let _ = held.lock().unwrap().recv();
        }
        notes.lock().unwrap().push((begin, io.now()));
    });
    acts(&stage, "clock", |_| {});
    let body = r#"
        roots = ["low"]
        [schemas.clock]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        imports = { input = "clock.out" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until(|rig| rig.stage.count("low iterate") == 5 && rig.stage.count("clock iterate") > 30);
    release.send(()).expect("it waits");
    rig.until(|rig| rig.stage.count("low iterate") > 20);
    rig.stop();
    let times = times.lock().unwrap();
    let (begin, end) = times[4];
    assert!(end - begin >= 200 * MS, "it was held for many periods");
    let (last, _) = *times.last().unwrap();
    // One iteration for each period outside of the long one, and one for each of its ends.
    let most = (last - (end - begin)) / (10 * MS) + 3;
    assert!(
        times.len() as u64 <= most,
        "{} iterations, at most {most}",
        times.len()
    );
}

fn overruns_are_counted_and_shown_and_pass(executor: Executor) {
    let stage = Stage::new();
    let slow = Arc::new(AtomicBool::new(true));
    let dawdles = Arc::clone(&slow);
    acts(&stage, "low", move |io| {
        let end = io.now() + 12 * MS;
        while dawdles.load(SeqCst) && io.now() < end {
            std::thread::yield_now();
        }
    });
    let mut rig = Rig::start(executor, &stage, ONE);
    let low = rig.place("low");
    rig.until(|rig| rig.see("low").overruns > 2);
    let overrun = |event: &Event| {
        matches!(event, Event::Overrun { schema, took, budget, .. }
            if *schema == low && *took > *budget && *budget == 10 * MS)
    };
    assert!(stage.told(overrun));
    assert!(stage.told(|event| matches!(
        event,
        Event::HealthChanged {
            health: Health::Overrun,
            ..
        }
    )));
    slow.store(false, SeqCst);
    rig.until(|rig| rig.see("low").health == Health::Ok);
    assert!(rig.see("low").longest >= 12 * MS);
    rig.stop();
}

fn a_shorter_period_is_no_missed_deadline(executor: Executor) {
    let stage = Stage::new();
    acts(&stage, "low", |_| {});
    let body = r#"
        roots = ["low"]
        [schemas.clock]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        period = "3600s"
        imports = { input = "clock.out" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until(|rig| rig.stage.did("low iterate") && rig.handle.now() > 2_500 * MS);
    // By the new period, two iterations would have been due before now.
    rig.operator()
        .set_period(rig.place("low"), 1_000 * MS)
        .expect("a period");
    rig.until(|rig| rig.see("low").iterations == 2);
    assert_eq!(rig.see("low").overruns, 0);
    rig.stop();
}

fn r12_a_trigger_checks_without_waiting_for_the_period(executor: Executor) {
    let stage = Stage::new();
    stage.play("low", |call, io| {
        if call == Call::Check {
            io.ready(io.input().is_some_and(|(value, _)| value > 0.5));
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        period = "3600s"
        imports = { input = "eye.gain" }
        triggers = ["input"]
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until(|rig| rig.see("low").state == State::Checking && rig.stage.did("low awake"));
    rig.operator()
        .modulate(rig.place("eye"), "gain", &Value::Float(1.0))
        .expect("a modulation");
    rig.until_did("low iterate");
    rig.operator()
        .modulate(rig.place("eye"), "gain", &Value::Float(0.0))
        .expect("a modulation");
    rig.until(|rig| rig.see("low").state == State::Checking);
    assert!(rig.handle.now() < HOUR);
    rig.stop();
}

fn r12_values_that_come_together_are_judged_together(executor: Executor) {
    let stage = Stage::new();
    for name in ["left", "right"] {
        let mut count = 0.0;
        stage.play(name, move |call, io| {
            if call == Call::Iterate {
                count += 1.0;
                io.publish(count);
            }
            Ok(())
        });
    }
    stage.play("low", |call, io| {
        if call == Call::Check {
            let seen = (io.input().map(|(value, _)| value), io.other());
            io.ready(seen.0.is_some() && seen.0 == seen.1);
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.left]
        type = "test/eye"
        [schemas.right]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        period = "3600s"
        imports = { input = "left.out", other = "right.out" }
        triggers = ["input", "other"]
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("low iterate");
    assert!(rig.handle.now() < HOUR);
    rig.stop();
}

fn r12_a_trigger_makes_no_winner_iterate_out_of_turn(executor: Executor) {
    let stage = Stage::new();
    stage.play("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    stage.play("low", |call, io| {
        if call == Call::Check {
            io.say("check");
            io.ready(true);
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        period = "3600s"
        imports = { input = "eye.out" }
        triggers = ["input"]
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until(|rig| rig.stage.count("low check") > 10);
    assert_eq!(stage.count("low iterate"), 1);
    rig.stop();
}

#[test]
fn r12_schemas_that_trigger_each_other_in_a_circle_do_not_stop_virtual_time() {
    let stage = Stage::new();
    for (name, other) in [("high", 1), ("low", 0)] {
        stage.play(name, move |call, io| {
            if let (Call::Check, Some(handle)) = (call, io.stage.handle()) {
                io.say("check");
                // The write triggers the other schema at once, which then does the same.
                handle
                    .operator("ana@laptop")
                    .modulate(other, "gain", &Value::Float(1.0))
                    .expect("a modulation");
            }
            Ok(())
        });
    }
    let body = r#"
        roots = ["high", "low"]
        [schemas.high]
        type = "test/motor"
        imports = { input = "high.gain" }
        triggers = ["input"]
        [schemas.low]
        type = "test/motor"
        imports = { input = "low.gain" }
        triggers = ["input"]
    "#;
    let mut rig = Rig::start(Executor::Lockstep, &stage, body);
    rig.advance(100 * MS);
    assert_eq!(rig.handle.now(), 100 * MS);
    assert!(
        stage.count("high check") > 20,
        "it is triggered beside its period"
    );
    rig.stop();
}

const TWO: &str = r#"
    roots = ["high", "low"]
    [schemas.high]
    type = "test/motor"
    [schemas.low]
    type = "test/motor"
"#;

fn r17_a_takeover_is_measured_against_the_contract(executor: Executor) {
    let stage = Stage::new();
    let ready = Arc::new(AtomicBool::new(false));
    stage.play("high", {
        let ready = Arc::clone(&ready);
        move |call, io| {
            if call == Call::Check {
                io.ready(ready.load(SeqCst));
            }
            Ok(())
        }
    });
    acts(&stage, "low", |_| {});
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until_did("low iterate");
    ready.store(true, SeqCst);
    rig.until_did("high iterate");
    // Two periods, since a turn may take a whole one; a check, the patience with the loser, and a check
    // before it acts.
    let contract = (2 * 10 + 10 + 5 + 10) * MS;
    let high = rig.place("high");
    let took = |event: &Event| match event {
        Event::TookOver {
            schema,
            latency,
            allowed,
            ..
        } if *schema == high => Some((*latency, *allowed)),
        _ => None,
    };
    let (latency, allowed) = stage.events().iter().find_map(took).expect("it took over");
    assert_eq!(allowed, contract);
    let group = rig.group("roots");
    assert_eq!(group.allowed, contract);
    assert!(group.worst >= latency);
    let last = group.last.expect("a switch");
    assert_eq!((last.to, last.latency), (Some(high), Some(latency)));
    if executor == Executor::Lockstep {
        assert!(latency <= contract);
    }
    rig.stop();
}

fn r17_the_contract_follows_the_period(executor: Executor) {
    let stage = Stage::new();
    acts(&stage, "low", |_| {});
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until_did("low iterate");
    rig.operator()
        .set_period(rig.place("high"), 500 * MS)
        .expect("a period");
    rig.until(|rig| rig.group("roots").allowed == (500 + 10 + 5 + 10) * MS);
    rig.stop();
}

fn r17_a_takeover_beyond_its_contract_is_an_event_of_its_own(executor: Executor) {
    let stage = Stage::new();
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(Some(held));
    stage.play("high", move |call, io| {
        if call == Call::Check {
            io.ready(true);
            if let Some(held) = held.lock().unwrap().take() {
                io.say("looks");
                // An error means that the sender was dropped.
                let _ = held.recv();
            }
        }
        Ok(())
    });
    acts(&stage, "low", |_| {});
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until_did("high looks");
    let contract = rig.group("roots").allowed;
    let then = rig.handle.now() + 2 * contract;
    rig.until(|rig| rig.handle.now() > then);
    drop(release);
    let high = rig.place("high");
    let late = |event: &Event| {
        matches!(event, Event::TookOverLate { group: 0, schema, latency, allowed, .. }
            if *schema == high && *allowed == contract && latency > allowed)
    };
    rig.until(|rig| rig.stage.told(late));
    assert!(rig.group("roots").late >= 1);
    rig.stop();
}

fn a_schema_knows_whether_time_is_everybodys(executor: Executor) {
    let real = match executor {
        Executor::Threads | Executor::Pool => "low follows",
        Executor::Lockstep => "low is hurried",
    };
    for (speed, line) in [(1.0, real), (2.0, "low is hurried")] {
        let stage = Stage::new();
        stage.play("low", |call, io| {
            io.ready(true);
            if call == Call::Iterate {
                let real = io.cx().require_real_time().is_ok();
                io.say(if real { "follows" } else { "is hurried" });
            }
            Ok(())
        });
        let options = Options {
            speed,
            ..Options::default()
        };
        let mut rig = Rig::start_with(executor, &stage, ONE, options);
        rig.until_did(line);
        rig.stop();
    }
}
