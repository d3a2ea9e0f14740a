//! Every selection writes a line (R15), and two runs of the same application are alike (R16).

use std::io::Write;
use std::sync::Arc;

use jde_app::parse;
use jde_host::{Lockstep, Options};
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::Observer;
use parking_lot::Mutex;

use crate::common::{Call, Executor, MS, Scenario, TestApp, on_every_executor, plugins, text};

on_every_executor!(
    r15_every_selection_writes_a_line_with_its_reason,
    r15_a_line_describes_a_takeover_completely,
);

/// A buffer that the test reads afterwards.
#[derive(Clone, Default)]
struct Buffer(Arc<Mutex<Vec<u8>>>);

impl Write for Buffer {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

const APP: &str = r#"
    roots = ["high", "low"]
    root = { policy = "urgency" }
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    period = "7ms"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// The deciders that occur in the application.
const DECIDERS: [&str; 3] = ["absence-policy", "nobody", "urgency"];

/// Returns the lines of two virtual seconds in which the seed determines both schemas. In real time, returns
/// at least a hundred lines, until every decider has occurred.
fn decide(executor: Executor, seed: u64) -> String {
    let scenario = Scenario::new();
    for name in ["high", "low"] {
        let mut state = None;
        scenario.on_call(name, move |call, io| {
            // xorshift64 (Marsaglia 2003), whose state must not be 0.
            let state = state.get_or_insert_with(|| io.seed() | 1);
            *state ^= *state << 13;
            *state ^= *state >> 7;
            *state ^= *state << 17;
            match call {
                Call::Check => {
                    let ready = jde_schema::Precondition::from(*state % 3 > 0);
                    io.ready(ready.urgency((*state % 100) as f64));
                }
                Call::Iterate => {
                    io.command((*state % 7) as f64);
                }
                _ => {}
            }
            Ok(())
        });
    }
    let plugins = plugins();
    let body = format!("seed = {seed}\n{}", text(executor, &scenario, APP));
    let application =
        parse(&body, "apps/test.toml".as_ref(), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let buffer = Buffer::default();
    let decisions = DecisionWriter::new(&application, buffer.clone());
    let options = Options {
        observers: vec![Box::new(decisions) as Box<dyn Observer>],
        ..Options::default()
    };
    let text = |buffer: &Buffer| String::from_utf8(buffer.0.lock().clone()).expect("UTF-8");
    if executor == Executor::Lockstep {
        let mut lockstep = Lockstep::start(application, &plugins, options).expect("it starts");
        lockstep.run_until(2_000 * MS);
    } else {
        let mut app = TestApp::run(executor, &scenario, application, &plugins, options).expect("it starts");
        app.until(|_| {
            let text = text(&buffer);
            let occurs = |decider: &str| text.contains(&format!("\"decider\":\"{decider}\""));
            text.lines().count() >= 100 && DECIDERS.into_iter().all(occurs)
        });
        app.stop();
    }
    text(&buffer)
}

#[test]
fn r16_the_same_seed_gives_the_same_choices_byte_for_byte() {
    let first = decide(Executor::Lockstep, 7);
    assert!(first.lines().count() > 200);
    assert_eq!(first, decide(Executor::Lockstep, 7));
    assert_ne!(first, decide(Executor::Lockstep, 8));
}

fn r15_every_selection_writes_a_line_with_its_reason(executor: Executor) {
    let text = decide(executor, 7);
    let (mut number, mut last) = (0, 0.0);
    let mut deciders = std::collections::BTreeSet::new();
    for line in text.lines() {
        let line: serde_json::Value = serde_json::from_str(line).expect("a line of JSON");
        number += 1;
        assert_eq!(line["number"], number, "the lines are complete and in order");
        assert_eq!(line["group"], "roots");
        let time = line["time_s"].as_f64().expect("a number");
        assert!(time >= last, "{time} after {last}");
        last = time;
        for key in ["case", "reason", "cause", "decider"] {
            assert!(
                line[key].as_str().is_some_and(|text| !text.is_empty()),
                "{key} of {line}"
            );
        }
        for candidate in line["candidates"].as_array().expect("a list") {
            assert!(candidate["name"].is_string() && candidate["state"].is_string());
            assert!(candidate["ready"].is_boolean() && candidate["urgency"].is_number());
        }
        let has_winner = line["changed"] == true && line["choice"].is_string();
        if let Some(takeover) = line.get("takeover_us") {
            assert!(
                has_winner && takeover.as_f64().is_some_and(|us| us >= 0.0),
                "{line}"
            );
        }
        deciders.insert(line["decider"].as_str().expect("a text").to_owned());
    }
    let deciders: Vec<_> = deciders.iter().map(String::as_str).collect();
    assert_eq!(deciders, DECIDERS);
}

fn r15_a_line_describes_a_takeover_completely(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    let mut app = TestApp::start(executor, &scenario, APP);
    app.until_line("robot velocity 0.1");
    let buffer = Buffer::default();
    let mut decisions = DecisionWriter::new(app.handle.application(), buffer.clone());
    for event in scenario.events() {
        decisions.on_event(&event);
    }
    decisions.finish().expect("all lines were written");
    let text = String::from_utf8(buffer.0.lock().clone()).expect("UTF-8");
    let line = text
        .lines()
        .find(|line| line.contains("\"changed\":true"))
        .expect("a switch");
    let line: serde_json::Value = serde_json::from_str(line).expect("a line of JSON");
    assert_eq!(line["choice"], "low");
    assert_eq!(line["before"], serde_json::Value::Null);
    assert_eq!(line["case"], "alone");
    assert_eq!(line["reason"], "the only one ready");
    assert_eq!(line["cause"], "the readiness of low changed");
    let took = line["takeover_us"].as_f64().expect("the takeover has a latency");
    assert!(
        took >= 0.0 && (executor != Executor::Lockstep || took == 0.0),
        "{took}"
    );
    app.stop();
}
