//! Imports of exports of other applications behave like any other import.

use jde_app::RemoteVariable;
use jde_board::typed::TypedWriter;
use jde_core::State;

use crate::common::{Call, Executor, MS, Scenario, TestApp, on_every_executor};

on_every_executor!(
    r12_a_remote_value_triggers_and_can_be_retracted_and_written_again,
    an_import_without_a_server_has_no_value_and_delays_nothing,
);

const APP: &str = r#"
    roots = ["low"]
    [schemas.low]
    type = "test/motor"
    period = "1000s"
    imports = { input = "robot2:eye.out", other = { from = "robot2:eye.out", stale = "300ms" } }
    triggers = ["input"]
"#;

fn reads_input(scenario: &Scenario) {
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            match io.input() {
                Some((value, number)) => io.record(format!("reads {value} {number}")),
                None => io.record("reads nothing"),
            }
            io.ready(io.input().is_some());
        }
        Ok(())
    });
}

fn r12_a_remote_value_triggers_and_can_be_retracted_and_written_again(executor: Executor) {
    let scenario = Scenario::new();
    reads_input(&scenario);
    let mut app = TestApp::start(executor, &scenario, APP);
    let [remote] = &app.handle.application().remotes[..] else {
        panic!("both imports read one variable");
    };
    assert_eq!((&*remote.peer, &*remote.variable), ("robot2", "eye.out"));
    assert_eq!(remote.stale_ns, 300 * MS);
    let out = app
        .handle
        .board()
        .get(&remote.local)
        .expect("the variable is declared");
    let mut link =
        TypedWriter::<f64>::open(&out, RemoteVariable::WRITER, "link").expect("it has no other writer");
    assert!(TypedWriter::<f64>::open(&out, 1, "another").is_err());
    app.until_line("low reads nothing");

    let now = app.handle.now();
    link.write(1.0, now.saturating_sub(5 * MS), now).expect("a value");
    app.until_line("low reads 1 1");
    app.until(|app| app.schema("low").state == State::Winner);
    let status = out.status(app.handle.now());
    assert_eq!(status.last_writer, Some(RemoteVariable::WRITER));
    assert!(
        status.age >= Some((5 * MS).min(now)),
        "its age includes the transfer"
    );

    let before = app.scenario.count("low reads nothing");
    out.retract();
    app.until(|app| app.scenario.count("low reads nothing") > before);
    app.until(|app| app.schema("low").state == State::Checking);

    let now = app.handle.now();
    link.write(2.0, now, now).expect("a value");
    app.until_line("low reads 2 2");
    app.until(|app| app.schema("low").state == State::Winner);
    app.stop();
}

fn an_import_without_a_server_has_no_value_and_delays_nothing(executor: Executor) {
    let scenario = Scenario::new();
    reads_input(&scenario);
    let body = APP.replace("1000s", "10ms");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until(|app| app.scenario.count("low reads nothing") > 5);
    assert_eq!(app.schema("low").state, State::Checking);
    assert_eq!(app.handle.value::<f64>("robot2:eye.out"), Ok(None));
    app.stop();
}
