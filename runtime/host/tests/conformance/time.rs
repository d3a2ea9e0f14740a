//! Deadlines, triggers and contracts (R11, R12, R17).

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, mpsc};

use jde_board::value::Value;
use jde_core::{GroupId, Health, Id, SchemaId, State};
use jde_host::Options;
use jde_records::event::{Event, Occurrence, What};
use parking_lot::Mutex;

use crate::common::{Call, Executor, MS, Scenario, TestApp, on_every_executor};

on_every_executor!(
    r12_a_trigger_checks_without_waiting_for_the_period,
    r12_values_published_together_are_checked_together,
    r12_schemas_that_trigger_each_other_through_checks_rest_and_their_triggers_are_counted,
    r12_a_trigger_does_not_make_a_winner_iterate_early,
    r17_a_takeover_is_measured_against_the_contract,
    r17_the_contract_follows_the_period,
    a_schema_knows_whether_time_is_real,
);

mod real_time {
    use super::{
        a_shorter_period_is_not_a_missed_deadline, overruns_are_counted_and_reported_until_a_call_is_in_time,
        r11_a_late_schema_skips_missed_periods, r17_a_takeover_beyond_its_contract_is_reported_as_late,
    };

    crate::common::in_real_time!(
        r11_a_late_schema_skips_missed_periods,
        overruns_are_counted_and_reported_until_a_call_is_in_time,
        a_shorter_period_is_not_a_missed_deadline,
        r17_a_takeover_beyond_its_contract_is_reported_as_late,
    );
}

const HOUR: u64 = 3_600_000 * MS;

const ONE: &str = r#"
    roots = ["low"]
    [schemas.low]
    type = "test/motor"
"#;

/// Defines a schema that is READY and runs `act` in each iteration.
fn acts(scenario: &Scenario, name: &str, mut act: impl FnMut(&mut crate::common::Io<'_>) + Send + 'static) {
    scenario.on_call(name, move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => act(io),
            _ => {}
        }
        Ok(())
    });
}

#[test]
fn r11_deadlines_do_not_drift() {
    let scenario = Scenario::new();
    let times = Arc::new(Mutex::new(Vec::new()));
    let recorder = Arc::clone(&times);
    acts(&scenario, "low", move |io| recorder.lock().push(io.now()));
    let mut app = TestApp::start(
        Executor::Lockstep,
        &scenario,
        &ONE.replace("\"test/motor\"", "\"test/motor\"\n period = \"7ms\""),
    );
    assert_eq!(app.advance(7_000 * MS), None);
    let expected: Vec<u64> = (0..=1000).map(|count| count * 7 * MS).collect();
    assert_eq!(*times.lock(), expected);
    app.stop();
}

fn r11_a_late_schema_skips_missed_periods(executor: Executor) {
    let scenario = Scenario::new();
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    let times = Arc::new(Mutex::new(Vec::new()));
    let recorder = Arc::clone(&times);
    let mut count = 0;
    acts(&scenario, "low", move |io| {
        let begin = io.now();
        count += 1;
        if count == 5 {
            let _ = held.lock().recv();
        }
        recorder.lock().push((begin, io.now()));
    });
    acts(&scenario, "clock", |_| {});
    let body = r#"
        roots = ["low"]
        [schemas.clock]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        imports = { input = "clock.out" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until(|app| app.scenario.count("low iterate") == 5 && app.scenario.count("clock iterate") > 30);
    release.send(()).expect("the schema waits");
    app.until(|app| app.scenario.count("low iterate") > 20);
    app.stop();
    let times = times.lock();
    let (begin, end) = times[4];
    assert!(end - begin >= 200 * MS, "the iteration took many periods");
    let (last, _) = *times.last().unwrap();
    // One iteration for each period outside the long one, and one more at each of its ends.
    let most = (last - (end - begin)) / (10 * MS) + 3;
    assert!(
        times.len() as u64 <= most,
        "{} iterations, at most {most}",
        times.len()
    );
}

fn overruns_are_counted_and_reported_until_a_call_is_in_time(executor: Executor) {
    let scenario = Scenario::new();
    let slow = Arc::new(AtomicBool::new(true));
    let is_slow = Arc::clone(&slow);
    acts(&scenario, "low", move |io| {
        let end = io.now() + 12 * MS;
        while is_slow.load(SeqCst) && io.now() < end {
            std::thread::yield_now();
        }
    });
    let mut app = TestApp::start(executor, &scenario, ONE);
    let low = app.index("low");
    app.until(|app| app.schema("low").overruns > 2);
    let overrun = |event: &Event| {
        matches!(event.what(), Some(What::Overrun { schema, took, budget, .. })
            if *schema == low && *took > *budget && *budget == 10 * MS)
    };
    assert!(scenario.has_event(overrun));
    assert!(scenario.has_event(|event| matches!(
        event.what(),
        Some(What::HealthChanged {
            health: Health::Overrun,
            ..
        })
    )));
    slow.store(false, SeqCst);
    app.until(|app| app.schema("low").health == Health::Ok);
    assert!(app.schema("low").longest >= 12 * MS);
    app.stop();
}

fn a_shorter_period_is_not_a_missed_deadline(executor: Executor) {
    let scenario = Scenario::new();
    acts(&scenario, "low", |_| {});
    let body = r#"
        roots = ["low"]
        [schemas.clock]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        period = "3600s"
        imports = { input = "clock.out" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until(|app| app.scenario.has_line("low iterate") && app.handle.now() > 2_500 * MS);
    // With the new period, two iterations would already have been due.
    app.operator()
        .set_period(app.index("low"), 1_000 * MS)
        .expect("a period");
    app.until(|app| app.schema("low").iterations == 2);
    assert_eq!(app.schema("low").overruns, 0);
    app.stop();
}

fn r12_a_trigger_checks_without_waiting_for_the_period(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("low", |call, io| {
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
    let mut app = TestApp::start(executor, &scenario, body);
    app.until(|app| app.schema("low").state == State::Checking && app.scenario.has_line("low awake"));
    app.operator()
        .modulate(app.index("eye"), "gain", &Value::Float(1.0))
        .expect("a modulation");
    app.until_line("low iterate");
    app.operator()
        .modulate(app.index("eye"), "gain", &Value::Float(0.0))
        .expect("a modulation");
    app.until(|app| app.schema("low").state == State::Checking);
    assert!(app.handle.now() < HOUR);
    app.stop();
}

fn r12_values_published_together_are_checked_together(executor: Executor) {
    let scenario = Scenario::new();
    for name in ["left", "right"] {
        let mut count = 0.0;
        scenario.on_call(name, move |call, io| {
            if call == Call::Iterate {
                count += 1.0;
                io.publish(count);
            }
            Ok(())
        });
    }
    scenario.on_call("low", |call, io| {
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
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("low iterate");
    assert!(app.handle.now() < HOUR);
    app.stop();
}

fn r12_schemas_that_trigger_each_other_through_checks_rest_and_their_triggers_are_counted(
    executor: Executor,
) {
    let scenario = Scenario::new();
    let times: Arc<Mutex<Vec<u64>>> = Arc::default();
    for (name, other) in [("high", 1), ("low", 0)] {
        let times = Arc::clone(&times);
        scenario.on_call(name, move |call, io| {
            if let (Call::Check, Some(handle)) = (call, io.scenario.handle()) {
                times.lock().push(handle.now());
                io.record("check");
                // The write triggers the other schema at once, and that schema does the same.
                handle
                    .operator("ana@laptop")
                    .modulate(SchemaId(other), "gain", &Value::Float(1.0))
                    .expect("a modulation");
            }
            Ok(())
        });
    }
    let body = r#"
        roots = ["high", "low"]
        [schemas.high]
        type = "test/motor"
        period = "3600s"
        imports = { input = "high.gain" }
        triggers = ["input"]
        [schemas.low]
        type = "test/motor"
        period = "3600s"
        imports = { input = "low.gain" }
        triggers = ["input"]
    "#;
    const CHECKS: usize = 400;
    // Turns take no time, so that a machine under load does not rest in their place.
    let options = Options {
        counted: true,
        ..Options::default()
    };
    let mut app = TestApp::start_with(executor, &scenario, body, options);
    // The first checks may precede the handle.
    app.operator()
        .modulate(SchemaId(0), "gain", &Value::Float(1.0))
        .expect("a modulation");
    app.until(|app| app.schema("high").triggers_dropped + app.schema("low").triggers_dropped > 0);
    if executor != Executor::Lockstep {
        app.until(|_| times.lock().len() >= CHECKS);
        let times = times.lock();
        // Of two rounds of both schemas at least one has a rest, but the first ones.
        let rests = (CHECKS / 4 - 10) as u64;
        let took = times[CHECKS - 1] - times[0];
        assert!(took >= rests * MS / 5, "{took} ns");
    }
    app.stop();
}

fn r12_a_trigger_does_not_make_a_winner_iterate_early(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            io.record("check");
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
    let mut app = TestApp::start(executor, &scenario, body);
    app.until(|app| app.scenario.count("low check") > 10);
    assert_eq!(scenario.count("low iterate"), 1);
    app.stop();
}

#[test]
fn r12_schemas_that_trigger_each_other_in_a_cycle_do_not_stop_virtual_time() {
    let scenario = Scenario::new();
    for (name, other) in [("high", 1), ("low", 0)] {
        scenario.on_call(name, move |call, io| {
            if let (Call::Check, Some(handle)) = (call, io.scenario.handle()) {
                io.record("check");
                // The write triggers the other schema at once, and that schema does the same.
                handle
                    .operator("ana@laptop")
                    .modulate(SchemaId(other), "gain", &Value::Float(1.0))
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
    let mut app = TestApp::start(Executor::Lockstep, &scenario, body);
    app.advance(100 * MS);
    assert_eq!(app.handle.now(), 100 * MS);
    assert!(
        scenario.count("high check") > 20,
        "triggers come in addition to the period"
    );
    app.stop();
}

const TWO: &str = r#"
    roots = ["high", "low"]
    [schemas.high]
    type = "test/motor"
    [schemas.low]
    type = "test/motor"
"#;

fn r17_a_takeover_is_measured_against_the_contract(executor: Executor) {
    let scenario = Scenario::new();
    let ready = Arc::new(AtomicBool::new(false));
    scenario.on_call("high", {
        let ready = Arc::clone(&ready);
        move |call, io| {
            if call == Call::Check {
                io.ready(ready.load(SeqCst));
            }
            Ok(())
        }
    });
    acts(&scenario, "low", |_| {});
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("low iterate");
    ready.store(true, SeqCst);
    app.until_line("high iterate");
    // Two periods, because a turn may take a whole one; a check; the patience with the loser; and a check
    // before the winner acts.
    let contract = (2 * 10 + 10 + 5 + 10) * MS;
    let high = app.index("high");
    let took = |event: &Event| match event {
        Event::Other(Occurrence {
            what:
                What::TookOver {
                    schema,
                    latency,
                    allowed,
                    ..
                },
            ..
        }) if *schema == high => Some((*latency, *allowed)),
        _ => None,
    };
    let (latency, allowed) = scenario.events().iter().find_map(took).expect("`high` took over");
    assert_eq!(allowed, contract);
    let group = app.group("roots");
    assert_eq!(group.allowed, contract);
    assert!(group.worst >= latency);
    let last = group.last.expect("a switch");
    assert_eq!((last.to, last.latency), (Some(high.index()), Some(latency)));
    if executor == Executor::Lockstep {
        assert!(latency <= contract);
    }
    app.stop();
}

fn r17_the_contract_follows_the_period(executor: Executor) {
    let scenario = Scenario::new();
    acts(&scenario, "low", |_| {});
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("low iterate");
    app.operator()
        .set_period(app.index("high"), 500 * MS)
        .expect("a period");
    app.until(|app| app.group("roots").allowed == (500 + 10 + 5 + 10) * MS);
    app.stop();
}

fn r17_a_takeover_beyond_its_contract_is_reported_as_late(executor: Executor) {
    let scenario = Scenario::new();
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(Some(held));
    scenario.on_call("high", move |call, io| {
        if call == Call::Check {
            io.ready(true);
            if let Some(held) = held.lock().take() {
                io.record("checks");
                // An error means that the sender was dropped.
                let _ = held.recv();
            }
        }
        Ok(())
    });
    acts(&scenario, "low", |_| {});
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("high checks");
    let contract = app.group("roots").allowed;
    let end = app.handle.now() + 2 * contract;
    app.until(|app| app.handle.now() > end);
    drop(release);
    let high = app.index("high");
    let late = |event: &Event| {
        matches!(event.what(), Some(What::TookOver { group: GroupId(0), schema, latency, allowed, .. })
            if *schema == high && *allowed == contract && latency > allowed)
    };
    app.until(|app| app.scenario.has_event(late));
    assert!(app.group("roots").late >= 1);
    app.stop();
}

fn a_schema_knows_whether_time_is_real(executor: Executor) {
    let real = match executor {
        Executor::Threads | Executor::Pool => "low has real time",
        Executor::Lockstep => "low has other time",
    };
    for (speed, line) in [(1.0, real), (2.0, "low has other time")] {
        let scenario = Scenario::new();
        scenario.on_call("low", |call, io| {
            io.ready(true);
            if call == Call::Iterate {
                let real = io.is_real_time();
                io.record(if real { "has real time" } else { "has other time" });
            }
            Ok(())
        });
        let options = Options {
            speed,
            ..Options::default()
        };
        let mut app = TestApp::start_with(executor, &scenario, ONE, options);
        app.until_line(line);
        app.stop();
    }
}
