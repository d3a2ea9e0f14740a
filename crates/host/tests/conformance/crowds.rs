//! Many calls that hang, take long or fail at the same time, more of them than a pool has workers, and their
//! effect on other schemas.
//!
//! Where time is counted, only calls take time, so a single missed period is a failure. Where a test holds
//! the calls until it has seen the others run, time is the machine's.

use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

use jde_core::Nanos;
use jde_host::{Handle, Options};
use jde_records::event::Event;
use jde_types::Twist;

use crate::common::{Call, Executor, Io, MS, Rig, Stage, in_real_time};

in_real_time!(
    r11_nobody_is_late_for_a_call_that_hangs,
    r11_nobody_is_late_for_many_calls_that_hang_at_once,
    r11_nobody_is_late_for_many_iterations_that_take_long,
    r11_nobody_is_late_for_many_that_panic_at_once,
    r1_everything_stops_while_many_calls_hang,
);

/// More than a pool's workers on most machines.
const MANY: usize = 12;
/// How long the application runs, where time is counted, ns.
const RUN: Nanos = 2_500 * MS;
/// A call that takes this long is given up long before, ns.
const FOR_EVER: Nanos = 10 * RUN;

/// What a schema of the crowd does in a call.
type Act = fn(Call, &mut Io<'_>) -> jde_schema::Result;

/// The schemas that must not be affected: a motor schema and its driver.
const OTHERS: &str = r#"
    [roots.other]
    members = ["low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// The others and `crowd` schemas, each alone in its group; fathers of two if they arbitrate.
fn body(crowd: usize, arbitrates: bool, keys: &str) -> String {
    let mut body = String::from(OTHERS);
    for number in 0..crowd {
        let father = if arbitrates {
            format!(
                "children = {{ a = \"a-{number}\", b = \"b-{number}\" }}\ngroups.base = {{ policy = \"father\" }}\n"
            )
        } else {
            String::new()
        };
        body += &format!(
            "[roots.crowd-{number}]\nmembers = [\"crowd-{number}\"]\n\
             [schemas.crowd-{number}]\ntype = \"test/motor\"\nperiod = \"50ms\"\n{keys}\n{father}"
        );
        for child in ["a", "b"].into_iter().filter(|_| arbitrates) {
            body += &format!("[schemas.{child}-{number}]\ntype = \"test/motor\"\nperiod = \"50ms\"\n");
        }
    }
    body
}

fn spend(io: &Io<'_>, time: Nanos) {
    if let Some(handle) = io.stage.handle() {
        handle.spend(time);
    }
}

/// The crowd does `act` in each call. The others run where time is counted, and must miss none of their
/// periods.
#[track_caller]
fn others_are_in_time(
    executor: Executor,
    what: &str,
    (crowd, arbitrates, keys): (usize, bool, &str),
    act: Act,
) -> (Arc<Stage>, Handle) {
    let stage = Stage::new();
    let times = Arc::new(Mutex::new(Vec::new()));
    let begins = Arc::clone(&times);
    stage.play("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                begins.lock().unwrap().push(io.now());
                io.command(0.1);
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    for number in 0..crowd {
        stage.play(&format!("crowd-{number}"), act);
        for child in ["a", "b"] {
            stage.play(&format!("{child}-{number}"), |call, io| {
                io.ready(call == Call::Check);
                Ok(())
            });
        }
    }
    let options = Options {
        counted: true,
        limit: Some(RUN),
        ..Options::default()
    };
    let rig = Rig::start_with(executor, &stage, &body(crowd, arbitrates, keys), options);
    let handle = rig.handle.clone();
    rig.wait();
    let times = times.lock().unwrap().clone();
    // The first period is shortened intentionally (R11).
    let longest = times.windows(2).skip(1).map(|two| two[1] - two[0]).max();
    let others = ["low", "robot"].map(|other| handle.schema_indices(other)[0]);
    // After the end no thread waits for the counted time.
    let late = stage.count_events(|event| match event {
        Event::Overrun { time, schema, .. } => *time < RUN && others.contains(schema),
        _ => false,
    });
    assert_eq!(late, 0, "{crowd} that {what}, longest cycle {longest:?} ns");
    assert!(
        times.len() as u64 >= RUN / (10 * MS) - 1,
        "{} iterations, {crowd} that {what}",
        times.len()
    );
    (stage, handle)
}

/// Hangs in the call `wanted`, some periods after the start.
fn hang(wanted: Call, call: Call, io: &mut Io<'_>) -> jde_schema::Result {
    match call {
        Call::Check => io.ready(true),
        // Time cannot be spent before the handle is there.
        Call::Iterate if io.stage.handle().is_some() => {
            io.wake("a");
            io.wake("b");
        }
        Call::Awake | Call::Iterate | Call::Sleep | Call::Arbitrate | Call::Drop => {}
    }
    let fails = matches!(wanted, Call::Awake | Call::Sleep | Call::Drop);
    let begins = match wanted {
        Call::Awake => io.memory > 20 || io.stage.did(&format!("{} fails", io.name)),
        Call::Check | Call::Iterate | Call::Sleep | Call::Drop => io.memory > 20,
        Call::Arbitrate => true,
    };
    let begins = begins && io.stage.handle().is_some();
    if call == wanted && begins {
        io.then(|io| spend(io, FOR_EVER));
    } else if call == Call::Iterate && begins && fails {
        // After the fault it sleeps and ends, and awakes again.
        io.say("fails");
        return Err("a fault".into());
    }
    Ok(())
}

fn hang_in_each_call(executor: Executor, crowd: usize) {
    let restart = |policy: &str| format!("restart = {policy}");
    let never = restart("\"never\"");
    let once = restart("{ back-off = \"5ms\", limit = 1 }");
    let rows: [(&str, &str, Act); 6] = [
        ("hang in `awake`", &once, |call, io| hang(Call::Awake, call, io)),
        ("hang in `check`", &never, |call, io| hang(Call::Check, call, io)),
        ("hang in `iterate`", &never, |call, io| {
            hang(Call::Iterate, call, io)
        }),
        ("hang in `sleep`", &never, |call, io| hang(Call::Sleep, call, io)),
        ("hang in their end", &never, |call, io| hang(Call::Drop, call, io)),
        ("hang in `arbitrate`", &never, |call, io| {
            hang(Call::Arbitrate, call, io)
        }),
    ];
    for (what, keys, act) in rows {
        let arbitrates = what.contains("arbitrate");
        let (stage, handle) = others_are_in_time(executor, what, (crowd, arbitrates, keys), act);
        let named = |schema: usize| &handle.application().instances[schema].name;
        let left = stage.count_events(|event| match event {
            Event::CallAbandoned { schema, .. } => named(*schema).starts_with("crowd-"),
            _ => false,
        });
        assert_eq!(left, crowd, "all {what}");
    }
}

fn r11_nobody_is_late_for_a_call_that_hangs(executor: Executor) {
    hang_in_each_call(executor, 1);
}

fn r11_nobody_is_late_for_many_calls_that_hang_at_once(executor: Executor) {
    hang_in_each_call(executor, MANY);
}

fn r11_nobody_is_late_for_many_iterations_that_take_long(executor: Executor) {
    others_are_in_time(
        executor,
        "take long",
        (MANY, false, "budget = \"40ms\""),
        |call, io| {
            match call {
                Call::Check => io.ready(true),
                // Four periods of the others.
                Call::Iterate => spend(io, 40 * MS),
                Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
            }
            Ok(())
        },
    );
}

fn r11_nobody_is_late_for_many_that_panic_at_once(executor: Executor) {
    let panics = |call: Call, io: &mut Io<'_>| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => assert!(io.memory < 20, "a fault"),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    };
    let keys = "restart = { back-off = \"5ms\", limit = 3 }";
    let (_, handle) = others_are_in_time(executor, "panic", (MANY, false, keys), panics);
    let views = handle.snapshot().schemas.into_iter();
    let failed = views.filter(|view| view.name.starts_with("crowd") && view.faults == 4);
    assert_eq!(failed.count(), MANY);
}

fn r1_everything_stops_while_many_calls_hang(executor: Executor) {
    let stage = Stage::new();
    let inside = Arc::new(AtomicUsize::new(0));
    let (release, held) = std::sync::mpsc::channel::<()>();
    let held = Arc::new(Mutex::new(held));
    for number in 0..MANY {
        let (inside, held) = (Arc::clone(&inside), Arc::clone(&held));
        stage.play(&format!("crowd-{number}"), move |call, io| {
            match call {
                Call::Check => io.ready(true),
                Call::Iterate => {
                    inside.fetch_add(1, SeqCst);
                    io.stage.stir();
                    // An error means that the sender was dropped.
                    let _ = held.lock().unwrap().recv();
                }
                Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
            }
            Ok(())
        });
    }
    stage.drives("low", &Arc::new(true.into()), 0.1);
    // With this budget no call is given up.
    let mut rig = Rig::start(executor, &stage, &body(MANY, false, "budget = \"1000s\""));
    rig.until(|_| inside.load(SeqCst) == MANY);
    rig.until_did("robot velocity 0.1");
    let before = (stage.count("low iterate"), stage.count("robot iterate"));
    rig.until(|rig| {
        rig.stage.count("low iterate") > before.0 + 10 && rig.stage.count("robot iterate") > before.1 + 10
    });
    rig.operator().stop_all().expect("nothing keeps it from that");
    let velocity = rig.handle.value::<Twist>("robot.velocity").expect("it is there");
    assert_eq!(velocity, Some(Twist::ZERO));
    rig.until_did("robot sleep");
    rig.until_did("low sleep");
    assert_eq!(inside.load(SeqCst), MANY, "all are inside");
    assert!(!stage.told(|event| matches!(event, Event::CallAbandoned { .. })));
    drop(release);
    rig.stop();
}
