//! The values that schemas read, the commands that reach actuators (R8, R9), and numbers that are not finite.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use jde_board::value::Value;
use jde_core::State;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_records::event::Event;

use crate::common::{Call, Executor, MS, Rig, Stage, TEST, on_every_executor};

on_every_executor!(
    r9_when_nobody_wins_the_actuators_brake_at_once,
    r9_a_held_command_stands_for_its_time_and_then_brakes,
    r9_a_command_that_had_run_out_is_not_held,
    r9_the_fallback_wins_when_nobody_is_ready,
    r7_a_command_that_is_not_repeated_runs_out,
    r7_a_command_that_is_not_finite_is_refused_and_the_one_before_runs_out,
    r8_the_period_is_a_modulation,
    r8_who_is_woken_with_a_long_period_has_a_turn_at_once,
    r8_a_father_modulates_its_child,
    r8_a_fixed_modulation_is_taken_at_the_awakening_and_not_when_it_is_read,
    r8_a_fixed_modulation_stays_while_another_build_takes_over,
    r12_a_value_that_was_taken_back_is_none_and_a_trigger,
);

mod real_time {
    use super::{r8_a_command_counts_for_the_whole_call, r8_one_value_stays_through_check_and_iteration};

    crate::common::in_real_time!(
        r8_one_value_stays_through_check_and_iteration,
        r8_a_command_counts_for_the_whole_call,
    );
}

const ONE: &str = r#"
    roots = ["low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity", arm = "robot.reach" }
"#;

/// A schema that is READY while `ready` is true, and runs `act`.
fn acts(
    stage: &Stage,
    name: &str,
    ready: &Arc<AtomicBool>,
    mut act: impl FnMut(&mut crate::common::Io<'_>) + Send + 'static,
) {
    let ready = Arc::clone(ready);
    stage.play(name, move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => act(io),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
}

/// Records at each iteration of the robot the time and its last line about its first command.
fn watch(stage: &Stage) -> Arc<Mutex<Vec<(u64, String)>>> {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let sees = Arc::clone(&seen);
    stage.play("robot", move |call, io| {
        if call == Call::Iterate {
            let lines = io.stage.lines();
            let last = lines.iter().rfind(|line| line.starts_with("robot velocity"));
            sees.lock()
                .unwrap()
                .push((io.now(), last.cloned().unwrap_or_default()));
        }
        Ok(())
    });
    seen
}

fn r9_when_nobody_wins_the_actuators_brake_at_once(executor: Executor) {
    let stage = Stage::new();
    let ready = Arc::new(true.into());
    stage.drives("low", &ready, 0.1);
    let mut rig = Rig::start(executor, &stage, ONE);
    rig.until_did("robot velocity 0.1");
    // The robot's own period is one hour: the brake does not wait for it.
    rig.operator()
        .set_period(rig.place("robot"), 3_600_000 * MS)
        .expect("a period");
    rig.until(|rig| rig.see("robot").period == 3_600_000 * MS);
    ready.store(false, SeqCst);
    rig.until_did("robot velocity 0");
    assert_eq!(rig.see("low").state, State::Checking);
    rig.stop();
}

fn r9_a_held_command_stands_for_its_time_and_then_brakes(executor: Executor) {
    let stage = Stage::new();
    let ready = Arc::new(true.into());
    stage.drives("low", &ready, 0.1);
    let seen = watch(&stage);
    let body = format!("root = {{ absence = \"hold\", hold = \"200ms\" }}\n{ONE}");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("robot velocity 0.1");
    ready.store(false, SeqCst);
    rig.until_did("robot velocity 0");
    rig.stop();
    let lost = stage.events().iter().find_map(|event| match event {
        Event::Decided(record) if record.changed && record.choice.is_none() => Some(record.time),
        _ => None,
    });
    let lost = lost.expect("nobody won");
    let mut held = 0;
    for (time, line) in seen.lock().unwrap().iter().filter(|(time, _)| *time >= lost) {
        // The line was recorded before `time`.
        if *time < lost + 200 * MS {
            assert_eq!(line, "robot velocity 0.1", "{time} ns, lost at {lost}");
            held += 1;
        }
    }
    if executor == Executor::Lockstep {
        assert_eq!(held, 20, "200 ms of 10 ms each");
    }
}

fn r9_a_command_that_had_run_out_is_not_held(executor: Executor) {
    let stage = Stage::new();
    let ready = Arc::new(true.into());
    let mut commanded = false;
    acts(&stage, "low", &ready, move |io| {
        if !std::mem::replace(&mut commanded, true) {
            io.reach(0.1);
        }
    });
    let body = format!("root = {{ absence = \"hold\", hold = \"1000s\" }}\n{ONE}");
    let mut rig = Rig::start(executor, &stage, &body);
    // By then its validity of 50 ms has expired, and the arm has stopped.
    rig.until(|rig| rig.handle.now() > 200 * MS && rig.stage.count("low iterate") > 3);
    ready.store(false, SeqCst);
    let held = |event: &Event| matches!(event, Event::Decided(record) if record.reason.contains("hold the last command"));
    rig.until(|rig| rig.stage.told(held));
    let seen = stage.count("robot reach 0.1");
    let before = stage.count("robot iterate");
    rig.until(|rig| rig.stage.count("robot iterate") > before + 5);
    assert_eq!(stage.count("robot reach 0.1"), seen, "it did not move again");
    rig.stop();
}

fn r9_the_fallback_wins_when_nobody_is_ready(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &Arc::new(false.into()), 0.3);
    stage.drives("low", &Arc::new(false.into()), 0.1);
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.1");
    assert_eq!(rig.winner("roots").as_deref(), Some("low"));
    rig.stop();
}

fn r7_a_command_that_is_not_repeated_runs_out(executor: Executor) {
    let stage = Stage::new();
    let mut commanded = false;
    acts(&stage, "low", &Arc::new(true.into()), move |io| {
        if !std::mem::replace(&mut commanded, true) {
            io.reach(0.1);
            io.command(0.2);
        }
    });
    let mut rig = Rig::start(executor, &stage, ONE);
    rig.until_did("robot velocity 0.2");
    // The long command stays in force, whether or not the short one was seen on a busy machine.
    let over = |stage: &Stage| stage.count("robot reach 0.1") == stage.count("robot reach 0");
    rig.until(|rig| rig.handle.now() > 200 * MS && over(&rig.stage));
    assert!(!stage.did("robot velocity 0"));
    if executor == Executor::Lockstep {
        assert_eq!(stage.count("robot reach 0.1"), 1);
    }
    rig.stop();
}

fn r7_a_command_that_is_not_finite_is_refused_and_the_one_before_runs_out(executor: Executor) {
    let stage = Stage::new();
    let mut count = 0;
    acts(&stage, "low", &Arc::new(true.into()), move |io| {
        count += 1;
        let outcome = match count {
            1 => io.reach(0.1),
            odd if odd % 2 == 1 => io.reach(f64::NAN),
            _ => io.reach(f64::INFINITY),
        };
        io.say(format!("{outcome:?}"));
    });
    let mut rig = Rig::start(executor, &stage, ONE);
    rig.until(|rig| rig.stage.count("low NotFinite") > 10);
    rig.until(|rig| {
        rig.handle.now() > 200 * MS && rig.stage.count("robot reach 0.1") == rig.stage.count("robot reach 0")
    });
    assert_eq!(stage.count("low Accepted"), 1);
    assert!(rig.see("low").refused > 10);
    let told = stage.events();
    let told: Vec<_> = told
        .iter()
        .filter_map(|event| match event {
            Event::Refused {
                description: what, ..
            } => Some(what.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].starts_with("command `arm` refused: "), "{told:?}");
    rig.stop();
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

fn r8_who_is_woken_with_a_long_period_has_a_turn_at_once(executor: Executor) {
    let stage = Stage::new();
    acts(&stage, "father", &Arc::new(true.into()), |io| {
        // Both are set before the child checks.
        io.retime_a(3_600.0);
        io.wake("a");
    });
    acts(&stage, "left", &Arc::new(true.into()), |_| {});
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("left iterate");
    assert_eq!(rig.see("left").period, 3_600_000 * MS);
    rig.stop();
}

fn r8_the_period_is_a_modulation(executor: Executor) {
    let stage = Stage::new();
    acts(&stage, "father", &Arc::new(true.into()), |io| {
        io.retime_a(0.03);
        io.wake("a");
    });
    let times = Arc::new(Mutex::new(Vec::new()));
    let notes = Arc::clone(&times);
    acts(&stage, "left", &Arc::new(true.into()), move |io| {
        notes.lock().unwrap().push(io.now())
    });
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until(|rig| rig.stage.count("left iterate") > 5);
    assert_eq!(rig.see("left").period, 30 * MS);
    rig.stop();
    if executor == Executor::Lockstep {
        let times = times.lock().unwrap();
        assert!(
            times.windows(2).all(|pair| pair[1] - pair[0] == 30 * MS),
            "{times:?}"
        );
    }
}

fn r8_a_father_modulates_its_child(executor: Executor) {
    let stage = Stage::new();
    acts(&stage, "father", &Arc::new(true.into()), |io| {
        io.wake("a");
        io.modulate_a(0.25);
    });
    acts(&stage, "left", &Arc::new(true.into()), |io| {
        io.command(io.gain());
    });
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.25");
    rig.stop();
}

fn r8_one_value_stays_through_check_and_iteration(executor: Executor) {
    let stage = Stage::new();
    let mut count = 0.0;
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1.0;
            io.publish(count);
        }
        Ok(())
    });
    let mut looked = None;
    stage.play("low", move |call, io| {
        match (call, io.stage.handle()) {
            (Call::Check, Some(handle)) => {
                looked = io.input();
                if let Some((_, sequence)) = looked {
                    // By the end of the check a newer value is there.
                    let out = handle.board().get("eye.out").expect("it is exported");
                    out.wait_newer(sequence, Duration::MAX);
                    assert_eq!(io.input(), looked);
                    io.ready(true);
                }
            }
            (Call::Iterate, _) => {
                assert_eq!(io.input(), looked, "what was checked is what is acted upon");
                io.say("saw the same");
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until(|rig| rig.stage.count("low saw the same") > 20 || rig.see("low").faults > 0);
    assert_eq!(rig.see("low").faults, 0);
    rig.stop();
}

fn r8_a_command_counts_for_the_whole_call(executor: Executor) {
    let stage = Stage::new();
    acts(&stage, "low", &Arc::new(true.into()), |io| {
        io.reach(0.1);
    });
    let mut rig = Rig::start(executor, &stage, ONE);
    // The robot reads its command before and after its part; see `Robot::iterate`.
    stage.play("robot", |call, io| {
        if call == Call::Iterate {
            let end = io.now() + 60 * MS;
            while io.now() < end {
                std::thread::yield_now();
            }
        }
        Ok(())
    });
    rig.until(|rig| rig.stage.count("robot iterate") > 5 && rig.stage.did("robot reach 0.1"));
    assert!(!stage.did("robot changed its mind"));
    rig.stop();
}

fn r12_a_value_that_was_taken_back_is_none_and_a_trigger(executor: Executor) {
    let stage = Stage::new();
    stage.play("eye", |call, io| {
        match (call, io.stage.did("low iterate"), io.stage.did("low blind")) {
            (Call::Iterate, false, _) => io.publish(1.0),
            (Call::Iterate, true, false) => io.retract(),
            (Call::Iterate, true, true) => io.publish(2.0),
            _ => {}
        }
        Ok(())
    });
    stage.play("low", |call, io| {
        if call == Call::Check {
            match io.input() {
                Some((value, number)) => io.say(format!("sees {value} {}", number > 1)),
                None if io.stage.did("low iterate") => io.say("blind"),
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("low blind");
    rig.until_did("low sees 2 true");
    rig.until(|rig| rig.see("low").state == State::Winner);
    rig.stop();
}

fn r8_a_fixed_modulation_is_taken_at_the_awakening_and_not_when_it_is_read(executor: Executor) {
    let stage = Stage::new();
    stage.play("low", |call, io| {
        match call {
            Call::Awake => {
                if let Some(handle) = io.stage.handle() {
                    let place = handle.application().instance(io.name).expect("it is there");
                    let grip = Value::Float(1.0);
                    handle.operator("ana@laptop").modulate(place, "grip", &grip)?;
                    io.say("is modulated");
                }
            }
            Call::Check => io.ready(true),
            Call::Iterate => io.say(format!("grip {}", io.grip())),
            Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, ONE);
    let low = rig.place("low");
    // At its first awakening, the modulation may come too late.
    for _ in 0..2 {
        let [iterated, slept] = ["low iterate", "low sleep"].map(|line| stage.count(line));
        rig.until(|rig| rig.stage.count("low iterate") > iterated);
        rig.operator()
            .hold_asleep(low)
            .expect("nothing keeps it from that");
        rig.until(|rig| rig.stage.count("low sleep") > slept);
        rig.operator().play(low).expect("nothing keeps it from that");
    }
    rig.until_did("low grip 1");
    rig.stop();
    let after = stage.lines().split_off(stage.first("low is modulated"));
    let grips: Vec<_> = after.iter().filter(|line| line.starts_with("low grip")).collect();
    assert_eq!(grips[0], "low grip 0", "{after:#?}");
}

fn r8_a_fixed_modulation_stays_while_another_build_takes_over(executor: Executor) {
    let stage = Stage::new();
    stage.play("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => io.say(format!("grip {}", io.grip())),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, ONE);
    rig.until_did("low grip 0");
    let low = rig.place("low");
    let operator = rig.operator();
    operator
        .modulate(low, "grip", &Value::Float(1.0))
        .expect("a modulation");
    let build = LoadedPlugin::linked_in(&TEST).expect("its tables are right");
    let order = operator
        .replace(low, &build, ReloadOptions::default())
        .expect("it fits");
    rig.until(|_| order.outcome().is_some());
    assert_eq!(stage.count("low awake"), 2);
    let iterated = stage.count("low iterate");
    rig.until(|rig| rig.stage.count("low iterate") > iterated);
    rig.stop();
    assert!(!stage.did("low grip 1"), "it was awake all the time");
}
