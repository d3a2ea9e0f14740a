//! Many calls that hang, take long or fail at the same time, and their effect on other schemas. There are more
//! such calls than a pool has workers.
//!
//! Where time is counted, only calls take time, so a single missed period is a failure. Where a test holds
//! the calls until it has seen the others run, time is the machine's.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use jde_core::{Nanos, SchemaId};
use jde_host::{Handle, Options};
use jde_records::event::{Event, Occurrence, What};
use jde_types::Twist;
use parking_lot::Mutex;

use crate::common::{Call, Executor, Io, MS, Scenario, TestApp, in_real_time};

in_real_time!(
    r11_a_call_that_hangs_makes_no_other_schema_late,
    r11_many_calls_that_hang_at_once_make_no_other_schema_late,
    r11_many_long_iterations_make_no_other_schema_late,
    r11_many_panics_at_once_make_no_other_schema_late,
    r1_everything_stops_while_many_calls_hang,
);

/// More than a pool's workers on most machines.
const MANY: usize = 12;
/// How long the application runs, where time is counted, ns.
const RUN: Nanos = 2_500 * MS;
/// A call that takes this long is given up long before, ns.
const FOR_EVER: Nanos = 10 * RUN;

/// What each of the many schemas does in a call.
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

/// The others and `count` schemas, each alone in its group. If they arbitrate, each has two children.
fn body(count: usize, arbitrates: bool, keys: &str) -> String {
    let mut body = String::from(OTHERS);
    for number in 0..count {
        let father = if arbitrates {
            format!(
                "children = {{ a = \"a-{number}\", b = \"b-{number}\" }}\ngroups.base = {{ policy = \"father\" }}\n"
            )
        } else {
            String::new()
        };
        body += &format!(
            "[roots.many-{number}]\nmembers = [\"many-{number}\"]\n\
             [schemas.many-{number}]\ntype = \"test/motor\"\nperiod = \"50ms\"\n{keys}\n{father}"
        );
        for child in ["a", "b"].into_iter().filter(|_| arbitrates) {
            body += &format!("[schemas.{child}-{number}]\ntype = \"test/motor\"\nperiod = \"50ms\"\n");
        }
    }
    body
}

fn spend(io: &Io<'_>, time: Nanos) {
    if let Some(handle) = io.scenario.handle() {
        handle.spend(time);
    }
}

/// Many schemas do `act` in each call. The others run where time is counted, and must miss none of their
/// periods.
#[track_caller]
fn others_are_in_time(
    executor: Executor,
    what: &str,
    (count, arbitrates, keys): (usize, bool, &str),
    act: Act,
) -> (Arc<Scenario>, Handle) {
    let scenario = Scenario::new();
    let times = Arc::new(Mutex::new(Vec::new()));
    let record = Arc::clone(&times);
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                record.lock().push(io.now());
                io.command(0.1);
            }
            _ => {}
        }
        Ok(())
    });
    for number in 0..count {
        scenario.on_call(&format!("many-{number}"), act);
        for child in ["a", "b"] {
            scenario.on_call(&format!("{child}-{number}"), |call, io| {
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
    let app = TestApp::start_with(executor, &scenario, &body(count, arbitrates, keys), options);
    let handle = app.handle.clone();
    app.wait();
    let times = times.lock().clone();
    // The first period is shortened intentionally (R11).
    let longest = times.windows(2).skip(1).map(|pair| pair[1] - pair[0]).max();
    let others = ["low", "robot"].map(|other| handle.schemas_named(other)[0]);
    // After the end no thread waits for the counted time.
    let late = scenario.count_events(|event| match event {
        Event::Other(Occurrence {
            time,
            what: What::Overrun { schema, .. },
        }) => *time < RUN && others.contains(schema),
        _ => false,
    });
    assert_eq!(late, 0, "{count} that {what}, longest cycle {longest:?} ns");
    assert!(
        times.len() as u64 >= RUN / (10 * MS) - 1,
        "{} iterations, {count} that {what}",
        times.len()
    );
    (scenario, handle)
}

/// Hangs in the call `at`, some periods after the start.
fn hang(at: Call, call: Call, io: &mut Io<'_>) -> jde_schema::Result {
    match call {
        Call::Check => io.ready(true),
        // Time cannot be spent before the handle exists.
        Call::Iterate if io.scenario.handle().is_some() => {
            io.wake("a");
            io.wake("b");
        }
        _ => {}
    }
    let fails = matches!(at, Call::Awake | Call::Sleep | Call::Drop);
    let begins = match at {
        Call::Awake => io.memory > 20 || io.scenario.has_line(&format!("{} fails", io.name)),
        Call::Arbitrate => true,
        _ => io.memory > 20,
    };
    let begins = begins && io.scenario.handle().is_some();
    if call == at && begins {
        io.then(|io| spend(io, FOR_EVER));
    } else if call == Call::Iterate && begins && fails {
        // After the fault, the instance sleeps and ends, and a new one awakes.
        io.record("fails");
        return Err("a fault".into());
    }
    Ok(())
}

fn hang_in_each_call(executor: Executor, count: usize) {
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
        ("hang in `drop`", &never, |call, io| hang(Call::Drop, call, io)),
        ("hang in `arbitrate`", &never, |call, io| {
            hang(Call::Arbitrate, call, io)
        }),
    ];
    for (what, keys, act) in rows {
        let arbitrates = what.contains("arbitrate");
        let (scenario, handle) = others_are_in_time(executor, what, (count, arbitrates, keys), act);
        let named = |schema: SchemaId| &handle.application().instances[schema].name;
        let abandoned = scenario.count_events(|event| match event {
            Event::Other(Occurrence {
                what: What::CallAbandoned { schema, .. },
                ..
            }) => named(*schema).starts_with("many-"),
            _ => false,
        });
        assert_eq!(abandoned, count, "all {what}");
    }
}

fn r11_a_call_that_hangs_makes_no_other_schema_late(executor: Executor) {
    hang_in_each_call(executor, 1);
}

fn r11_many_calls_that_hang_at_once_make_no_other_schema_late(executor: Executor) {
    hang_in_each_call(executor, MANY);
}

fn r11_many_long_iterations_make_no_other_schema_late(executor: Executor) {
    others_are_in_time(
        executor,
        "take long",
        (MANY, false, "budget = \"40ms\""),
        |call, io| {
            match call {
                Call::Check => io.ready(true),
                // Four periods of the others.
                Call::Iterate => spend(io, 40 * MS),
                _ => {}
            }
            Ok(())
        },
    );
}

fn r11_many_panics_at_once_make_no_other_schema_late(executor: Executor) {
    let panics = |call: Call, io: &mut Io<'_>| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => assert!(io.memory < 20, "a fault"),
            _ => {}
        }
        Ok(())
    };
    let keys = "restart = { back-off = \"5ms\", limit = 3 }";
    let (_, handle) = others_are_in_time(executor, "panic", (MANY, false, keys), panics);
    let views = handle.snapshot().schemas.into_iter();
    let failed = views.filter(|view| view.name.starts_with("many-") && view.faults == 4);
    assert_eq!(failed.count(), MANY);
}

fn r1_everything_stops_while_many_calls_hang(executor: Executor) {
    let scenario = Scenario::new();
    let inside = Arc::new(AtomicUsize::new(0));
    let (release, held) = std::sync::mpsc::channel::<()>();
    let held = Arc::new(Mutex::new(held));
    for number in 0..MANY {
        let (inside, held) = (Arc::clone(&inside), Arc::clone(&held));
        scenario.on_call(&format!("many-{number}"), move |call, io| {
            match call {
                Call::Check => io.ready(true),
                Call::Iterate => {
                    inside.fetch_add(1, SeqCst);
                    io.scenario.notify();
                    // An error means that the sender was dropped.
                    let _ = held.lock().recv();
                }
                _ => {}
            }
            Ok(())
        });
    }
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    // With this budget no call is given up.
    let mut app = TestApp::start(executor, &scenario, &body(MANY, false, "budget = \"1000s\""));
    app.until(|_| inside.load(SeqCst) == MANY);
    app.until_line("robot velocity 0.1");
    let before = (scenario.count("low iterate"), scenario.count("robot iterate"));
    app.until(|app| {
        app.scenario.count("low iterate") > before.0 + 10
            && app.scenario.count("robot iterate") > before.1 + 10
    });
    app.operator().stop_all().expect("it is allowed");
    let velocity = app
        .handle
        .value::<Twist>("robot.velocity")
        .expect("it is a command");
    assert_eq!(velocity, Some(Twist::ZERO));
    app.until_line("robot sleep");
    app.until_line("low sleep");
    assert_eq!(inside.load(SeqCst), MANY, "all are inside");
    assert!(!scenario.has_event(|event| matches!(event.what(), Some(What::CallAbandoned { .. }))));
    drop(release);
    app.stop();
}
