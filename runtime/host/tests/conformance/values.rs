//! The values that schemas read, the commands that reach actuators (R8, R9), and numbers that are not finite.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::time::Duration;

use jde_board::value::Value;
use jde_core::State;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_records::event::{Event, Occurrence, What};
use parking_lot::Mutex;

use crate::common::{Call, Executor, MS, Scenario, TEST, TestApp, in_languages, on_every_executor};

on_every_executor!(
    r9_actuators_brake_at_once_when_no_schema_wins,
    r9_a_held_command_stays_in_force_for_its_time_and_then_brakes,
    r9_an_expired_command_is_not_held,
    r9_the_fallback_wins_when_no_schema_is_ready,
    r7_a_command_that_is_not_repeated_expires,
    r7_a_command_that_is_not_finite_is_refused_and_the_previous_one_expires,
    r8_the_period_is_a_modulation,
    r8_a_schema_woken_with_a_long_period_is_checked_at_once,
    r8_a_father_modulates_its_child,
    r8_a_fixed_modulation_is_read_at_the_awakening_only,
    r8_a_fixed_modulation_keeps_its_value_through_a_reload,
    r12_a_retracted_value_is_absent_and_triggers,
);

mod real_time {
    use super::{
        r8_a_driver_reads_the_same_command_during_a_whole_call, r8_check_and_iteration_read_the_same_value,
    };

    crate::common::in_real_time!(
        r8_check_and_iteration_read_the_same_value,
        r8_a_driver_reads_the_same_command_during_a_whole_call,
    );
}

in_languages!(Lockstep, [C Cpp Python]:
    r7_a_command_that_is_not_repeated_expires,
    r7_a_command_that_is_not_finite_is_refused_and_the_previous_one_expires,
    r8_a_schema_woken_with_a_long_period_is_checked_at_once,
    r8_a_father_modulates_its_child,
    r8_a_fixed_modulation_is_read_at_the_awakening_only,
    r12_a_retracted_value_is_absent_and_triggers,
);
in_languages!(Threads, [C Cpp Python]:
    r8_check_and_iteration_read_the_same_value,
    r8_a_driver_reads_the_same_command_during_a_whole_call,
);

const ONE: &str = r#"
    roots = ["low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity", arm = "robot.reach" }
"#;

/// Defines a schema that is READY while `ready` is true and runs `act` in each iteration.
fn acts(
    scenario: &Scenario,
    name: &str,
    ready: &Arc<AtomicBool>,
    mut act: impl FnMut(&mut crate::common::Io<'_>) + Send + 'static,
) {
    let ready = Arc::clone(ready);
    scenario.on_call(name, move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => act(io),
            _ => {}
        }
        Ok(())
    });
}

/// Records, at each iteration of the robot, the time and its last line about its velocity.
fn watch(scenario: &Scenario) -> Arc<Mutex<Vec<(u64, String)>>> {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let recorder = Arc::clone(&seen);
    scenario.on_call("robot", move |call, io| {
        if call == Call::Iterate {
            let lines = io.scenario.lines();
            let last = lines.iter().rfind(|line| line.starts_with("robot velocity"));
            recorder
                .lock()
                .push((io.now(), last.cloned().unwrap_or_default()));
        }
        Ok(())
    });
    seen
}

fn r9_actuators_brake_at_once_when_no_schema_wins(executor: Executor) {
    let scenario = Scenario::new();
    let ready = Arc::new(true.into());
    scenario.drives("low", &ready, 0.1);
    let mut app = TestApp::start(executor, &scenario, ONE);
    app.until_line("robot velocity 0.1");
    // The brake does not wait for the robot's period of one hour.
    app.operator()
        .set_period(app.index("robot"), 3_600_000 * MS)
        .expect("a period");
    app.until(|app| app.schema("robot").period == 3_600_000 * MS);
    ready.store(false, SeqCst);
    app.until_line("robot velocity 0");
    assert_eq!(app.schema("low").state, State::Checking);
    app.stop();
}

fn r9_a_held_command_stays_in_force_for_its_time_and_then_brakes(executor: Executor) {
    let scenario = Scenario::new();
    let ready = Arc::new(true.into());
    scenario.drives("low", &ready, 0.1);
    let seen = watch(&scenario);
    let body = format!("root = {{ absence = \"hold\", hold = \"200ms\" }}\n{ONE}");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.1");
    ready.store(false, SeqCst);
    app.until_line("robot velocity 0");
    app.stop();
    let lost = scenario.events().iter().find_map(|event| match event {
        Event::Decision(record) if record.changed && record.choice.is_none() => Some(record.time),
        _ => None,
    });
    let lost = lost.expect("the group lost its winner");
    let mut held = 0;
    for (time, line) in seen.lock().iter().filter(|(time, _)| *time >= lost) {
        // The line was recorded before `time`.
        if *time < lost + 200 * MS {
            assert_eq!(line, "robot velocity 0.1", "{time} ns, lost at {lost}");
            held += 1;
        }
    }
    if executor == Executor::Lockstep {
        assert_eq!(held, 20, "200 ms hold 20 periods of 10 ms");
    }
}

fn r9_an_expired_command_is_not_held(executor: Executor) {
    let scenario = Scenario::new();
    let ready = Arc::new(true.into());
    let mut commanded = false;
    acts(&scenario, "low", &ready, move |io| {
        if !std::mem::replace(&mut commanded, true) {
            io.reach(0.1);
        }
    });
    let body = format!("root = {{ absence = \"hold\", hold = \"1000s\" }}\n{ONE}");
    let mut app = TestApp::start(executor, &scenario, &body);
    // After 200 ms, the validity of 50 ms has expired and the arm has stopped.
    app.until(|app| app.handle.now() > 200 * MS && app.scenario.count("low iterate") > 3);
    ready.store(false, SeqCst);
    let held = |event: &Event| matches!(event, Event::Decision(record) if record.reason.contains("hold the last command"));
    app.until(|app| app.scenario.has_event(held));
    let seen = scenario.count("robot reach 0.1");
    let before = scenario.count("robot iterate");
    app.until(|app| app.scenario.count("robot iterate") > before + 5);
    assert_eq!(
        scenario.count("robot reach 0.1"),
        seen,
        "the arm does not move again"
    );
    app.stop();
}

fn r9_the_fallback_wins_when_no_schema_is_ready(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(false.into()), 0.3);
    scenario.drives("low", &Arc::new(false.into()), 0.1);
    let body = r#"
        roots = ["high", "low"]
        root = { absence = "fallback", fallback = "low" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot velocity 0.1");
    assert_eq!(app.winner("roots").as_deref(), Some("low"));
    app.stop();
}

fn r7_a_command_that_is_not_repeated_expires(executor: Executor) {
    let scenario = Scenario::new();
    let mut commanded = false;
    acts(&scenario, "low", &Arc::new(true.into()), move |io| {
        if !std::mem::replace(&mut commanded, true) {
            io.reach(0.1);
            io.command(0.2);
        }
    });
    let mut app = TestApp::start(executor, &scenario, ONE);
    app.until_line("robot velocity 0.2");
    // The long command stays in force, whether or not the short one was seen on a busy machine.
    let expired = |scenario: &Scenario| scenario.count("robot reach 0.1") == scenario.count("robot reach 0");
    app.until(|app| app.handle.now() > 200 * MS && expired(&app.scenario));
    assert!(!scenario.has_line("robot velocity 0"));
    if executor == Executor::Lockstep {
        assert_eq!(scenario.count("robot reach 0.1"), 1);
    }
    app.stop();
}

fn r7_a_command_that_is_not_finite_is_refused_and_the_previous_one_expires(executor: Executor) {
    let scenario = Scenario::new();
    let mut count = 0;
    acts(&scenario, "low", &Arc::new(true.into()), move |io| {
        count += 1;
        let outcome = match count {
            1 => io.reach(0.1),
            count if count % 2 == 1 => io.reach(f64::NAN),
            _ => io.reach(f64::INFINITY),
        };
        io.record(format!("{outcome:?}"));
    });
    let mut app = TestApp::start(executor, &scenario, ONE);
    app.until(|app| app.scenario.count("low NotFinite") > 10);
    app.until(|app| {
        app.handle.now() > 200 * MS
            && app.scenario.count("robot reach 0.1") == app.scenario.count("robot reach 0")
    });
    assert_eq!(scenario.count("low Accepted"), 1);
    assert!(app.schema("low").refused > 10);
    let events = scenario.events();
    let refusals: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::Other(Occurrence {
                what: What::Refused { description, .. },
                ..
            }) => Some(description.as_str()),
            _ => None,
        })
        .collect();
    let words = "command `arm` refused: the value is not finite; values of commands and modulations must be finite: `linear.x`";
    assert_eq!(refusals, [words]);
    app.stop();
}

const FAMILY: &str = r#"
    roots = ["father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.father]
    type = "test/motor"
    children = { a = "left" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn r8_a_schema_woken_with_a_long_period_is_checked_at_once(executor: Executor) {
    let scenario = Scenario::new();
    acts(&scenario, "father", &Arc::new(true.into()), |io| {
        // The father sets the period and wakes the child before the child checks.
        io.retime_a(3_600.0);
        io.wake("a");
    });
    acts(&scenario, "left", &Arc::new(true.into()), |_| {});
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("left iterate");
    assert_eq!(app.schema("left").period, 3_600_000 * MS);
    app.stop();
}

fn r8_the_period_is_a_modulation(executor: Executor) {
    let scenario = Scenario::new();
    acts(&scenario, "father", &Arc::new(true.into()), |io| {
        io.retime_a(0.03);
        io.wake("a");
    });
    let times = Arc::new(Mutex::new(Vec::new()));
    let recorder = Arc::clone(&times);
    acts(&scenario, "left", &Arc::new(true.into()), move |io| {
        recorder.lock().push(io.now())
    });
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until(|app| app.scenario.count("left iterate") > 5);
    assert_eq!(app.schema("left").period, 30 * MS);
    app.stop();
    if executor == Executor::Lockstep {
        let times = times.lock();
        assert!(
            times.windows(2).all(|pair| pair[1] - pair[0] == 30 * MS),
            "{times:?}"
        );
    }
}

fn r8_a_father_modulates_its_child(executor: Executor) {
    let scenario = Scenario::new();
    acts(&scenario, "father", &Arc::new(true.into()), |io| {
        io.wake("a");
        io.modulate_a(0.25);
    });
    acts(&scenario, "left", &Arc::new(true.into()), |io| {
        io.command(io.gain());
    });
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.25");
    app.stop();
}

fn r8_check_and_iteration_read_the_same_value(executor: Executor) {
    let scenario = Scenario::new();
    let mut count = 0.0;
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1.0;
            io.publish(count);
        }
        Ok(())
    });
    let mut checked = None;
    scenario.on_call("low", move |call, io| {
        match (call, io.scenario.handle()) {
            (Call::Check, Some(handle)) => {
                checked = io.input();
                if let Some((_, sequence)) = checked {
                    // A newer value exists before the check ends.
                    let out = handle.board().get("eye.out").expect("it is exported");
                    out.wait_newer(sequence, Duration::MAX);
                    assert_eq!(io.input(), checked);
                    io.ready(true);
                }
            }
            (Call::Iterate, _) => {
                assert_eq!(io.input(), checked, "the iteration reads the value of the check");
                io.record("reads the same");
            }
            _ => {}
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        period = "1ms"
        [schemas.low]
        type = "test/motor"
        imports = { input = "eye.out" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until(|app| app.scenario.count("low reads the same") > 20 || app.schema("low").faults > 0);
    assert_eq!(app.schema("low").faults, 0);
    app.stop();
}

fn r8_a_driver_reads_the_same_command_during_a_whole_call(executor: Executor) {
    let scenario = Scenario::new();
    acts(&scenario, "low", &Arc::new(true.into()), |io| {
        io.reach(0.1);
    });
    let mut app = TestApp::start(executor, &scenario, ONE);
    // The robot reads its command before and after its behaviour; see `Robot::iterate`.
    scenario.on_call("robot", |call, io| {
        if call == Call::Iterate {
            let end = io.now() + 60 * MS;
            while io.now() < end {
                std::thread::yield_now();
            }
        }
        Ok(())
    });
    app.until(|app| app.scenario.count("robot iterate") > 5 && app.scenario.has_line("robot reach 0.1"));
    assert!(!scenario.has_line("robot read another command"));
    app.stop();
}

fn r12_a_retracted_value_is_absent_and_triggers(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("eye", |call, io| {
        match (
            call,
            io.scenario.has_line("low iterate"),
            io.scenario.has_line("low reads nothing"),
        ) {
            (Call::Iterate, false, _) => io.publish(1.0),
            (Call::Iterate, true, false) => io.retract(),
            (Call::Iterate, true, true) => io.publish(2.0),
            _ => {}
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            match io.input() {
                Some((value, number)) => io.record(format!("reads {value} {}", number > 1)),
                None if io.scenario.has_line("low iterate") => io.record("reads nothing"),
                None => {}
            }
            io.ready(io.input().is_some());
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        period = "1000s"
        imports = { input = "eye.out" }
        triggers = ["input"]
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("low reads nothing");
    app.until_line("low reads 2 true");
    app.until(|app| app.schema("low").state == State::Winner);
    app.stop();
}

fn r8_a_fixed_modulation_is_read_at_the_awakening_only(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("low", |call, io| {
        match call {
            Call::Awake => {
                if let Some(handle) = io.scenario.handle() {
                    let index = handle
                        .application()
                        .instance(io.name)
                        .expect("the instance exists");
                    let grip = Value::Float(1.0);
                    handle.operator("ana@laptop").modulate(index, "grip", &grip)?;
                    io.record("is modulated");
                }
            }
            Call::Check => io.ready(true),
            Call::Iterate => io.record(format!("grip {}", io.grip())),
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, ONE);
    let low = app.index("low");
    // At the first awakening, the modulation may be written too late.
    for _ in 0..2 {
        let [iterated, slept] = ["low iterate", "low sleep"].map(|line| scenario.count(line));
        app.until(|app| app.scenario.count("low iterate") > iterated);
        app.operator().hold_asleep(low).expect("the operator may");
        app.until(|app| app.scenario.count("low sleep") > slept);
        app.operator().play(low).expect("the operator may");
    }
    app.until_line("low grip 1");
    app.stop();
    let after = scenario.lines().split_off(scenario.first("low is modulated"));
    let grips: Vec<_> = after.iter().filter(|line| line.starts_with("low grip")).collect();
    assert_eq!(grips[0], "low grip 0", "{after:#?}");
}

fn r8_a_fixed_modulation_keeps_its_value_through_a_reload(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => io.record(format!("grip {}", io.grip())),
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, ONE);
    app.until_line("low grip 0");
    let low = app.index("low");
    let operator = app.operator();
    operator
        .modulate(low, "grip", &Value::Float(1.0))
        .expect("a modulation");
    let build = LoadedPlugin::linked_in(&TEST).expect("its tables are valid");
    let reload = operator
        .replace(low, &build, ReloadOptions::default())
        .expect("it fits");
    app.until_reloaded(&reload).expect("it takes over");
    assert_eq!(scenario.count("low awake"), 2);
    let iterated = scenario.count("low iterate");
    app.until(|app| app.scenario.count("low iterate") > iterated);
    app.stop();
    assert!(
        !scenario.has_line("low grip 1"),
        "the schema was awake all the time"
    );
}
