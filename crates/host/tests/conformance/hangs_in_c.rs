//! A plugin in C that hangs: all requests of its call are refused, and its loan stays its own.

use std::io::{PipeReader, Read, Write, pipe};
use std::os::fd::AsRawFd;
use std::path::Path;

use jde_abi::raw;
use jde_app::parse;
use jde_core::{Health, SchemaId, State};
use jde_host::Options;
use jde_loader::SearchPath;
use jde_records::event::Event;

use crate::common::{Call, Executor, Rig, Stage, c, in_real_time, plugins_along, text};

in_real_time!(whatever_a_call_asks_that_was_given_up_is_refused);

/// The report of the plugin: one value that it read, and ten statuses.
fn told(pipe: &mut PipeReader) -> [i32; 11] {
    let mut bytes = [0; 11 * 4];
    pipe.read_exact(&mut bytes).expect("it tells");
    std::array::from_fn(|nth| i32::from_ne_bytes(bytes[nth * 4..nth * 4 + 4].try_into().expect("four bytes")))
}

fn whatever_a_call_asks_that_was_given_up_is_refused(executor: Executor) {
    // A separate library for each executor, because each hangs only once.
    let folder = tempfile::tempdir().expect("a folder");
    c::make("captive.c", &[], &folder.path().join("libcaptive.so"));
    let mut path = SearchPath::default();
    path.push(folder.path(), "of this test");
    let plugins = plugins_along(path);
    let (held, mut release) = pipe().expect("a pipe");
    let (mut tells, tell) = pipe().expect("a pipe");
    let body = format!(
        r#"
        roots = ["captive", "low"]
        [schemas.robot]
        type = "test/robot"
        [schemas.eye]
        type = "test/eye"
        [schemas.helper]
        type = "test/motor"
        [schemas.captive]
        type = "captive/captive"
        imports = {{ input = "eye.out" }}
        actuators = {{ base = "robot.velocity" }}
        children = {{ helper = "helper" }}
        held = {}
        told = {}
        hang = "250ms"
        restart = {{ back-off = "200ms", limit = 5 }}
        [schemas.low]
        type = "test/motor"
        imports = {{ input = "captive.output" }}
        actuators = {{ base = "robot.velocity" }}
        "#,
        held.as_raw_fd(),
        tell.as_raw_fd()
    );
    let stage = Stage::new();
    let mut seen = 0.0;
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            seen += 1.0;
            io.publish(seen);
        }
        Ok(())
    });
    stage.play("helper", |_, _| Ok(()));
    stage.play("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                if let Some((value, _)) = io.input() {
                    io.say(format!("saw {value}"));
                }
                io.command(0.1);
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let application = parse(
        &text(executor, &stage, &body),
        Path::new("apps/test.toml"),
        &[],
        &plugins,
    )
    .unwrap_or_else(|faults| panic!("{faults}"));
    let mut rig = Rig::run(executor, &stage, application, &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let captive = rig.place("captive");
    rig.until_did("robot velocity 0.3");
    // The level selects again because of the fault itself: the sibling need not wait for another schema's
    // turn.
    let after = stage.first("robot velocity 0.3");
    rig.until(|rig| {
        let lines = rig.stage.lines().split_off(after);
        lines.iter().any(|line| line == "robot velocity 0.1")
    });
    let events = stage.events();
    let faulted = events.iter().find_map(|event| match event {
        Event::HealthChanged { time, schema, health } if *schema == captive => {
            matches!(health, Health::Faulted(_)).then_some(*time)
        }
        _ => None,
    });
    let low = Some(rig.place("low"));
    assert!(faulted.is_some());
    assert!(events.iter().any(|event| match event {
        Event::Decided(record) => {
            Some(record.time) == faulted && record.changed && record.choice.map(SchemaId::index) == low
        }
        _ => false,
    }));
    rig.until(|rig| rig.see("captive").left == 1 && rig.see("captive").state != State::Slept);
    let policy = rig.group("captive/group").policy;
    let refused = rig.see("captive").refused;
    release.write_all(b"!").expect("it waits");
    let [changed, answers @ ..] = told(&mut tells);
    assert_eq!(changed, 0, "what it looked at is as it was");
    assert_eq!(answers, [raw::REFUSED; 10]);
    rig.until(|rig| rig.see("captive").left == 0);
    assert_eq!(rig.group("captive/group").policy, policy);
    assert_eq!(rig.see("helper").state, State::Slept);
    assert_eq!(rig.see("captive").refused, refused, "nobody is blamed for it");
    assert!(!stage.lines().iter().any(|line| line.starts_with("low saw")));
    rig.stop();
}
