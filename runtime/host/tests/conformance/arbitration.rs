//! A father with its own arbitration, correct and faulty (R4).

#![allow(unsafe_code, reason = "the test builds a table that breaks its contract")]

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc;

use jde_abi::raw;
use jde_app::parse;
use jde_core::{Decider, Health};
use jde_host::Options;
use jde_records::event::{Event, What};
use jde_schema::Describe;
use parking_lot::Mutex;

use crate::common::{Call, Executor, Io, Scenario, TestApp, in_languages, on_every_executor, plugins, text};

on_every_executor!(
    r4_the_fathers_choice_wins_with_its_reason,
    r4_a_father_that_chooses_no_child_brakes,
    r4_a_father_that_panics_is_overruled_by_priority,
    r4_a_father_that_returns_an_error_is_overruled_by_priority,
    r4_a_father_that_names_a_sleeping_child_is_overruled_by_priority,
    r4_a_father_that_names_a_child_out_of_range_is_overruled_by_priority,
    r4_a_valid_choice_clears_the_arbitration_failure,
);

mod hanging {
    use super::r4_a_father_that_hangs_is_overruled_when_its_budget_ends;

    crate::common::in_real_time!(r4_a_father_that_hangs_is_overruled_when_its_budget_ends);
}

in_languages!(Lockstep, [C Cpp Python]:
    r4_the_fathers_choice_wins_with_its_reason,
    r4_a_father_that_chooses_no_child_brakes,
    r4_a_father_that_panics_is_overruled_by_priority,
    r4_a_father_that_returns_an_error_is_overruled_by_priority,
    r4_a_father_that_names_a_sleeping_child_is_overruled_by_priority,
);

const FAMILY: &str = r#"
    roots = ["father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.father]
    type = "FATHER"
    children = { a = "left", b = "right", c = "spare" }
    groups.base = { policy = "father" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.right]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.spare]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn family() -> String {
    FAMILY.replace("FATHER", "test/motor")
}

/// A family in which a busy machine does not make the father late.
fn patient_family() -> String {
    family().replace("\"father\" }", "\"father\", budget = \"100s\" }")
}

/// A father that wakes `a` and `b`, which are always READY, and runs `arbitrate`.
fn scenario(mut arbitrate: impl FnMut(&mut Io<'_>) -> jde_schema::Result + Send + 'static) -> Arc<Scenario> {
    let scenario = Scenario::new();
    for (name, speed) in [("left", 0.1), ("right", 0.2)] {
        scenario.drives(name, &Arc::new(true.into()), speed);
    }
    scenario.on_call("father", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Arbitrate => arbitrate(io)?,
            _ => {}
        }
        Ok(())
    });
    scenario
}

/// Runs until the priority order has decided instead of the father, and checks the reports.
fn overruled(app: &mut TestApp, reason: &str) {
    let left = app.index("left");
    let failed = |event: &Event| {
        matches!(event, Event::Decision(record)
            if record.decider == Decider::ArbitrationFailed
                && record.reason.contains(reason)
                && record.choice == Some(left))
    };
    app.until(|app| app.scenario.has_event(failed));
    app.until_line("robot velocity 0.1");
    let father = app.index("father");
    let reported = |event: &Event| {
        matches!(event.what(), Some(What::HealthChanged { schema, health: Health::ArbitrationFailed(health), .. })
            if *schema == father && health.contains(reason))
    };
    // An event of its own, which may arrive after the selection.
    app.until(|app| app.scenario.has_event(reported));
    assert!(!app.scenario.has_line("father sleep"), "the father stays awake");
}

fn r4_the_fathers_choice_wins_with_its_reason(executor: Executor) {
    let scenario = scenario(|io| {
        assert_eq!((io.group().as_str(), io.collides()), ("base", true));
        io.choose("b");
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &patient_family());
    let right = app.index("right");
    app.until(|app| {
        app.scenario.has_event(|event| {
            matches!(event, Event::Decision(record) if record.decider == Decider::Father
                && record.choice == Some(right)
                && record.reason == "father chose b")
        })
    });
    app.until_line("robot velocity 0.2");
    assert_eq!(app.winner("father/base").as_deref(), Some("right"));
    app.stop();
}

fn r4_a_father_that_chooses_no_child_brakes(executor: Executor) {
    let scenario = scenario(|_| Ok(()));
    let mut app = TestApp::start(executor, &scenario, &patient_family());
    let no_choice = |event: &Event| {
        matches!(event, Event::Decision(record) if record.decider == Decider::Father
            && record.choice.is_none() && record.reason == "the scenario chose no child")
    };
    app.until(|app| app.scenario.has_event(no_choice));
    app.until(|app| app.winner("father/base").is_none());
    app.stop();
}

fn r4_a_father_that_panics_is_overruled_by_priority(executor: Executor) {
    let scenario = scenario(|_| panic!("I cannot decide"));
    let mut app = TestApp::start(executor, &scenario, &family());
    overruled(&mut app, "I cannot decide");
    app.stop();
}

fn r4_a_father_that_returns_an_error_is_overruled_by_priority(executor: Executor) {
    let scenario = scenario(|_| Err("I do not know".into()));
    let mut app = TestApp::start(executor, &scenario, &family());
    overruled(&mut app, "I do not know");
    app.stop();
}

fn r4_a_father_that_names_a_sleeping_child_is_overruled_by_priority(executor: Executor) {
    let scenario = scenario(|io| {
        io.choose("c");
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &family());
    overruled(&mut app, "it chose `spare`, whom it was not offered");
    app.stop();
}

fn r4_a_father_that_names_a_child_out_of_range_is_overruled_by_priority(executor: Executor) {
    let scenario = scenario(|_| Ok(()));
    let mut plugins = plugins();
    plugins.link(&WILD).expect("its descriptions are valid");
    let text = text(executor, &scenario, &FAMILY.replace("FATHER", "wild"));
    // The father is the same schema in another plugin.
    let text = text.replace(
        "type = \"wild\"",
        &format!("type = \"wild\"\nscenario = {}", scenario.number()),
    );
    let application =
        parse(&text, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let mut app =
        TestApp::run(executor, &scenario, application, &plugins, Options::default()).expect("it starts");
    overruled(&mut app, "named child 77, and it has 4");
    app.stop();
}

static WILD: raw::Plugin = {
    const SCHEMAS: &[raw::Schema] = &[raw::Schema {
        name: c"wild".as_ptr(),
        arbitrate: Some(wild),
        ..<crate::common::Motor as Describe>::TABLE
    }];
    raw::Plugin {
        magic: raw::MAGIC,
        abi_major: raw::ABI_MAJOR,
        abi_minor: raw::ABI_MINOR,
        size: size_of::<raw::Plugin>() as u32,
        flags: 0,
        name: c"wild".as_ptr(),
        version: c"1".as_ptr(),
        doc: c"A father that names a child out of range.".as_ptr(),
        schemas: SCHEMAS.as_ptr(),
        schema_count: 1,
        reserved: 0,
    }
};

unsafe extern "C" fn wild(
    _: *mut core::ffi::c_void,
    _: *mut raw::Context,
    _: *const raw::Level,
    verdict: *mut raw::Verdict,
) -> i32 {
    // SAFETY: the host gives room for a verdict.
    unsafe { (*verdict).child = 77 };
    raw::OK
}

fn r4_a_valid_choice_clears_the_arbitration_failure(executor: Executor) {
    let mut arbitrations = 0;
    let scenario = scenario(move |io| {
        arbitrations += 1;
        if arbitrations == 1 {
            return Err("not yet".into());
        }
        io.choose("b");
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &patient_family());
    let failed = |event: &Event| {
        matches!(
            event.what(),
            Some(What::HealthChanged {
                health: Health::ArbitrationFailed(_),
                ..
            })
        )
    };
    app.until(|app| app.scenario.has_event(failed));
    app.until(|app| !matches!(app.schema("father").health, Health::ArbitrationFailed(_)));
    app.until_line("robot velocity 0.2");
    app.stop();
}

fn r4_a_father_that_hangs_is_overruled_when_its_budget_ends(executor: Executor) {
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    let scenario = scenario(move |io| {
        // Until the test drops the sender.
        let _ = held.lock().recv();
        io.choose("b");
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &family());
    overruled(&mut app, "no answer within 5000 us");
    drop(release);
    // The father decides the newest selection in time.
    app.until_line("robot velocity 0.2");
    app.stop();
}
