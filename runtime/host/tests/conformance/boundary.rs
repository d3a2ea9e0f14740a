//! What crosses the boundary to the language of a schema and no other test of these suites needs: urgencies, policies and the
//! states of children, values of a type of one's own, memories, and log messages.

use std::fmt::Debug;
use std::sync::Arc;

use jde_core::State;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_schema::Precondition;
use parking_lot::Mutex;
use tracing::field::Field;
use tracing::span::{Attributes, Id, Record};
use tracing::{Metadata, Subscriber};

use crate::common::{Call, Executor, Language, Mark, Scenario, TestApp, in_languages};

in_languages!(Lockstep, [Rust C Cpp Python]:
    r4_a_father_observes_its_children_and_changes_their_policy,
    r4_a_father_arbitrates_by_the_urgency_of_its_children,
    a_value_of_a_type_of_ones_own_keeps_its_form,
    the_next_build_restores_what_one_saved,
    a_build_that_cannot_save_or_restore_leaves_the_previous_one_running,
    a_log_message_has_its_level_its_text_and_the_name_of_its_schema,
);

const FAMILY: &str = r#"
    roots = ["father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.father]
    type = "test/motor"
    children = { a = "left", b = "right" }
    groups.base = { policy = "POLICY", budget = "100s" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.right]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// Starts a father with this policy. `left` drives at 0.1 m/s with an urgency of 1, and `right` at 0.2 m/s with one of 2.
fn family(executor: Executor, policy: &str, scenario: &Arc<Scenario>) -> TestApp {
    for (name, urgency) in [("left", 1.0), ("right", 2.0)] {
        scenario.on_call(name, move |call, io| {
            match call {
                Call::Check => io.ready(Precondition::from(true).urgency(urgency)),
                Call::Iterate => drop(io.command(urgency / 10.0)),
                _ => {}
            }
            Ok(())
        });
    }
    TestApp::start(executor, scenario, &FAMILY.replace("POLICY", policy))
}

fn r4_a_father_observes_its_children_and_changes_their_policy(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
                io.record(format!("{:?} {:?}", io.state("a"), io.state("b")));
                if io.scenario.has_line("robot velocity 0.1") {
                    let outcome = io.urgency_decides("a");
                    io.record(format!("{outcome:?}"));
                }
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = family(executor, "priority", &scenario);
    app.until_line("robot velocity 0.2");
    assert!(scenario.has_line("father Accepted"));
    let states =
        |left: State, right: State| format!("father {:?} {:?}", (left as u64, false), (right as u64, false));
    app.until_line(&states(State::Ready, State::Winner));
    assert!(scenario.has_line(&states(State::Winner, State::Ready)));
    app.stop();
}

fn r4_a_father_arbitrates_by_the_urgency_of_its_children(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Arbitrate => {
                assert!(io.is_ready("a") && io.is_ready("b"));
                let urgencies = (io.urgency("a"), io.urgency("b"));
                io.choose(if urgencies == (1.0, 2.0) { "b" } else { "a" });
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = family(executor, "father", &scenario);
    app.until_line("robot velocity 0.2");
    app.stop();
}

fn a_value_of_a_type_of_ones_own_keeps_its_form(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            io.publish_mark("door", 1.5);
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            io.ready(io.mark("door") == Some((1.5, 1)) && io.mark("wall").is_none());
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        [schemas.low]
        type = "test/motor"
        imports = { mark = "eye.mark" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("low iterate");
    let mark: Option<Mark> = app.handle.value("eye.mark").expect("it is the same type");
    let mark = mark.expect("it was published");
    assert_eq!((mark.label.as_str(), mark.places.as_slice()[0].x), ("door", 1.5));
    app.stop();
}

const ALONE: &str = r#"
    roots = ["low"]
    [schemas.low]
    type = "test/able-motor"
"#;

/// Reloads the schema, and returns what failed.
fn reload(app: &mut TestApp, build: &LoadedPlugin) -> Result<(), String> {
    let reload = app
        .operator()
        .replace(app.index("low"), build, ReloadOptions::default())
        .unwrap_or_else(|reasons| panic!("{reasons:#?}"));
    app.until_reloaded(&reload).map(drop)
}

/// A memory in Rust, C and C++ has one form, so a build in one language restores what one in another saved. In Python it is
/// pickled.
fn the_next_build_restores_what_one_saved(executor: Executor) {
    let scenario = Scenario::new();
    let mut saved = 0.5;
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Save => {
                saved += 1.0;
                io.save(saved);
            }
            Call::Restore => {
                let restored = io.restore();
                io.record(format!("{restored:?} is {}", restored == Some(saved)));
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, ALONE);
    app.until_line("low iterate");
    let language = Language::of_test();
    let languages = match language {
        Language::Python => vec![Language::Python],
        _ => vec![language, Language::Rust, language],
    };
    for (restored, language) in ["Some(1.5)", "Some(2.5)", "Some(3.5)"].into_iter().zip(languages) {
        reload(&mut app, &language.build()).unwrap_or_else(|reason| panic!("{language:?}: {reason}"));
        assert!(
            scenario.has_line(&format!("low {restored} is true")),
            "{language:?}"
        );
    }
    app.stop();
}

fn a_build_that_cannot_save_or_restore_leaves_the_previous_one_running(executor: Executor) {
    let scenario = Scenario::new();
    let (mut saves, mut refused) = (0, false);
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Save => {
                saves += 1;
                assert!(saves > 1, "it cannot be read");
                io.save(1.0);
            }
            // The previous build restores its own memory when it goes on.
            Call::Restore if !std::mem::replace(&mut refused, true) => {
                return Err("it is of another robot".into());
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, ALONE);
    app.until_line("low iterate");
    let language = Language::of_test();
    let build = language.build();
    for (what, why) in [
        (
            "the present build cannot save what it remembers: ",
            "it cannot be read",
        ),
        ("it refuses what was remembered: ", "it is of another robot"),
    ] {
        let refused = reload(&mut app, &build).expect_err("it cannot");
        let reason = refused.strip_prefix(what).unwrap_or_else(|| panic!("{refused}"));
        assert!(
            language.is_panic(reason, "save", why) || language.is_error(reason, why),
            "{refused}"
        );
        let before = scenario.count("low iterate");
        app.until(|app| app.scenario.count("low iterate") > before + 3);
    }
    assert_eq!(app.schema("low").faults, 0);
    app.stop();
}

/// Collects the messages of schemas on this thread.
#[derive(Clone, Default)]
struct Messages(Arc<Mutex<Vec<String>>>);

impl Subscriber for Messages {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target() == "jde::schema"
    }

    fn event(&self, event: &tracing::Event<'_>) {
        let mut line = event.metadata().level().to_string();
        let mut add = |field: &Field, value: &dyn Debug| line += &format!(" {}={value:?}", field.name());
        event.record(&mut add);
        self.0.lock().push(line);
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

fn a_log_message_has_its_level_its_text_and_the_name_of_its_schema(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => io.log("half past 3: 50 % of it"),
            _ => {}
        }
        Ok(())
    });
    let messages = Messages::default();
    tracing::subscriber::with_default(messages.clone(), || {
        let mut app = TestApp::start(executor, &scenario, ALONE);
        app.until_line("low iterate");
        app.until(|_| !messages.0.lock().is_empty());
        app.stop();
    });
    let expected = "INFO message=half past 3: 50 % of it schema=\"low\"";
    assert_eq!(messages.0.lock()[0], expected);
}
