//! A father with its own arbitration, correct and faulty (R4).

#![allow(unsafe_code, reason = "a table that breaks its contract is made by hand")]

use std::path::Path;
use std::sync::mpsc;
use std::sync::{Arc, Mutex};

use jde_abi::raw;
use jde_app::parse;
use jde_core::{Decider, Health};
use jde_host::Options;
use jde_records::event::Event;
use jde_schema::{Case, Describe};

use crate::common::{Call, Executor, Io, Rig, Stage, on_every_executor, plugins, text};

on_every_executor!(
    r4_the_fathers_choice_wins_with_its_reason,
    r4_a_father_that_chooses_nobody_brakes,
    r4_a_father_that_panics_is_overruled_by_priority,
    r4_a_father_that_errs_is_overruled_by_priority,
    r4_a_father_that_names_a_sleeping_child_is_overruled_by_priority,
    r4_a_father_that_names_a_child_out_of_range_is_overruled_by_priority,
    r4_a_good_answer_clears_the_note,
);

mod hanging {
    use super::r4_a_father_that_hangs_is_overruled_when_its_budget_ends;

    crate::common::in_real_time!(r4_a_father_that_hangs_is_overruled_when_its_budget_ends);
}

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
fn stage(mut arbitrate: impl FnMut(&mut Io<'_>) -> jde_schema::Result + Send + 'static) -> Arc<Stage> {
    let stage = Stage::new();
    for (name, speed) in [("left", 0.1), ("right", 0.2)] {
        stage.drives(name, &Arc::new(true.into()), speed);
    }
    stage.play("father", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Arbitrate => arbitrate(io)?,
            Call::Awake | Call::Sleep | Call::Drop => {}
        }
        Ok(())
    });
    stage
}

/// Runs until the priority order decided in the father's place, and checks the reports of it.
fn overruled(rig: &mut Rig, because: &str) {
    let left = rig.place("left");
    let failed = |event: &Event| {
        matches!(event, Event::Decided(record)
            if record.decider == Decider::ArbitrationFailed
                && record.reason.contains(because)
                && record.choice.map(|id| id.index()) == Some(left))
    };
    rig.until(|rig| rig.stage.told(failed));
    rig.until_did("robot velocity 0.1");
    let father = rig.place("father");
    assert!(rig.stage.told(
        |event| matches!(event, Event::HealthChanged { schema, health: Health::ArbitrationFailed(reason), .. }
        if *schema == father && reason.contains(because))
    ));
    assert!(!rig.stage.did("father sleep"), "it stays awake");
}

fn r4_the_fathers_choice_wins_with_its_reason(executor: Executor) {
    let stage = stage(|io| {
        assert_eq!((io.level().group(), io.level().case()), ("base", Case::Collision));
        io.choose("b");
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, &patient_family());
    let right = rig.place("right");
    rig.until(|rig| {
        rig.stage.told(|event| {
            matches!(event, Event::Decided(record) if record.decider == Decider::Father
                && record.choice.map(|id| id.index()) == Some(right)
                && record.reason == "father chose b")
        })
    });
    rig.until_did("robot velocity 0.2");
    assert_eq!(rig.winner("father/base").as_deref(), Some("right"));
    rig.stop();
}

fn r4_a_father_that_chooses_nobody_brakes(executor: Executor) {
    let stage = stage(|_| Ok(()));
    let mut rig = Rig::start(executor, &stage, &patient_family());
    let nobody = |event: &Event| {
        matches!(event, Event::Decided(record) if record.decider == Decider::Father
            && record.choice.is_none() && record.reason == "its part chose nobody")
    };
    rig.until(|rig| rig.stage.told(nobody));
    rig.until(|rig| rig.winner("father/base").is_none());
    rig.stop();
}

fn r4_a_father_that_panics_is_overruled_by_priority(executor: Executor) {
    let stage = stage(|_| panic!("I cannot decide"));
    let mut rig = Rig::start(executor, &stage, &family());
    overruled(&mut rig, "I cannot decide");
    rig.stop();
}

fn r4_a_father_that_errs_is_overruled_by_priority(executor: Executor) {
    let stage = stage(|_| Err("I do not know".into()));
    let mut rig = Rig::start(executor, &stage, &family());
    overruled(&mut rig, "I do not know");
    rig.stop();
}

fn r4_a_father_that_names_a_sleeping_child_is_overruled_by_priority(executor: Executor) {
    let stage = stage(|io| {
        io.choose("c");
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, &family());
    overruled(&mut rig, "it chose `spare`, whom it was not offered");
    rig.stop();
}

fn r4_a_father_that_names_a_child_out_of_range_is_overruled_by_priority(executor: Executor) {
    let stage = stage(|_| Ok(()));
    let mut plugins = plugins();
    plugins.link(&WILD).expect("its descriptions are right");
    let text = text(executor, &stage, &FAMILY.replace("FATHER", "wild"));
    // The father's part is played by the same schema, in another plugin.
    let text = text.replace(
        "type = \"wild\"",
        &format!("type = \"wild\"\nstage = {}", stage.number()),
    );
    let application =
        parse(&text, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let mut rig = Rig::run(executor, &stage, application, &plugins, Options::default()).expect("it starts");
    overruled(&mut rig, "named child 77, and it has 4");
    rig.stop();
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
        doc: c"A father beyond its role.".as_ptr(),
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

fn r4_a_good_answer_clears_the_note(executor: Executor) {
    let mut asked = 0;
    let stage = stage(move |io| {
        asked += 1;
        if asked == 1 {
            return Err("not yet".into());
        }
        io.choose("b");
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, &patient_family());
    let noted = |event: &Event| {
        matches!(
            event,
            Event::HealthChanged {
                health: Health::ArbitrationFailed(_),
                ..
            }
        )
    };
    rig.until(|rig| rig.stage.told(noted));
    rig.until(|rig| !matches!(rig.see("father").health, Health::ArbitrationFailed(_)));
    rig.until_did("robot velocity 0.2");
    rig.stop();
}

fn r4_a_father_that_hangs_is_overruled_when_its_budget_ends(executor: Executor) {
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    let stage = stage(move |io| {
        // Until the test drops the sender.
        let _ = held.lock().unwrap().recv();
        io.choose("b");
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, &family());
    overruled(&mut rig, "no answer within 5000 us");
    drop(release);
    // The father answers the newest question, in time.
    rig.until_did("robot velocity 0.2");
    rig.stop();
}
