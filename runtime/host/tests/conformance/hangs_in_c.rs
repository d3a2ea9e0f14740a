//! A plugin in C that hangs: all requests of its call are refused, and its loan stays its own.

use std::io::{PipeReader, Read, Write, pipe};
use std::os::fd::AsRawFd;
use std::path::Path;

use jde_abi::raw;
use jde_app::parse;
use jde_core::{Health, State};
use jde_host::Options;
use jde_loader::SearchPath;
use jde_records::event::{Event, Occurrence, What};

use crate::common::{Call, Executor, Scenario, TestApp, c, in_real_time, plugins_with, text};

in_real_time!(all_requests_of_an_abandoned_call_are_refused);

/// Reads the report of the plugin: whether its input changed, and ten statuses.
fn read_report(pipe: &mut PipeReader) -> [i32; 11] {
    let mut bytes = [0; 11 * 4];
    pipe.read_exact(&mut bytes).expect("the plugin reports");
    std::array::from_fn(|index| {
        i32::from_ne_bytes(bytes[index * 4..index * 4 + 4].try_into().expect("four bytes"))
    })
}

fn all_requests_of_an_abandoned_call_are_refused(executor: Executor) {
    // A separate library for each executor, because each hangs only once.
    let folder = tempfile::tempdir().expect("a folder");
    c::build("hanging.c", &[], &folder.path().join("libhanging.so"));
    let mut path = SearchPath::default();
    path.push(folder.path(), "of this test");
    let plugins = plugins_with(path);
    let (wait, mut release) = pipe().expect("a pipe");
    let (mut reports, report) = pipe().expect("a pipe");
    let body = format!(
        r#"
        roots = ["hanging", "low"]
        [schemas.robot]
        type = "test/robot"
        [schemas.eye]
        type = "test/eye"
        [schemas.helper]
        type = "test/motor"
        [schemas.hanging]
        type = "hanging/hanging"
        imports = {{ input = "eye.out" }}
        actuators = {{ base = "robot.velocity" }}
        children = {{ helper = "helper" }}
        wait = {}
        report = {}
        hang = "250ms"
        restart = {{ back-off = "200ms", limit = 5 }}
        [schemas.low]
        type = "test/motor"
        imports = {{ input = "hanging.output" }}
        actuators = {{ base = "robot.velocity" }}
        "#,
        wait.as_raw_fd(),
        report.as_raw_fd()
    );
    let scenario = Scenario::new();
    let mut count = 0.0;
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1.0;
            io.publish(count);
        }
        Ok(())
    });
    scenario.on_call("helper", |_, _| Ok(()));
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                if let Some((value, _)) = io.input() {
                    io.record(format!("read {value}"));
                }
                io.command(0.1);
            }
            _ => {}
        }
        Ok(())
    });
    let application = parse(
        &text(executor, &scenario, &body),
        Path::new("apps/test.toml"),
        &[],
        &plugins,
    )
    .unwrap_or_else(|faults| panic!("{faults}"));
    let mut app = TestApp::run(executor, &scenario, application, &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let hanging = app.index("hanging");
    app.until_line("robot velocity 0.3");
    // The fault itself causes the new selection: the sibling does not wait for another schema's turn.
    let start = scenario.first("robot velocity 0.3");
    app.until(|app| {
        let lines = app.scenario.lines().split_off(start);
        lines.iter().any(|line| line == "robot velocity 0.1")
    });
    let events = scenario.events();
    let faulted = events.iter().find_map(|event| match event {
        Event::Other(Occurrence {
            time,
            what: What::HealthChanged { schema, health },
        }) if *schema == hanging => matches!(health, Health::Faulted(_)).then_some(*time),
        _ => None,
    });
    let low = Some(app.index("low"));
    assert!(faulted.is_some());
    assert!(events.iter().any(|event| match event {
        Event::Decision(record) => {
            Some(record.time) == faulted && record.changed && record.choice == low
        }
        _ => false,
    }));
    app.until(|app| app.schema("hanging").left == 1 && app.schema("hanging").state != State::Slept);
    let policy = app.group("hanging/group").policy;
    let refused = app.schema("hanging").refused;
    release.write_all(b"!").expect("the plugin waits");
    let [changed, statuses @ ..] = read_report(&mut reports);
    assert_eq!(changed, 0, "the input of the call has not changed");
    assert_eq!(statuses, [raw::REFUSED; 10]);
    app.until(|app| app.schema("hanging").left == 0);
    assert_eq!(app.group("hanging/group").policy, policy);
    assert_eq!(app.schema("helper").state, State::Slept);
    assert_eq!(
        app.schema("hanging").refused,
        refused,
        "refusals of an abandoned call are not counted"
    );
    assert!(!scenario.lines().iter().any(|line| line.starts_with("low read")));
    app.stop();
}
