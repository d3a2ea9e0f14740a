//! Every selection writes a line (R15), and two runs of the same application are alike (R16).

use std::io::Write;
use std::sync::{Arc, Mutex};

use jde_app::parse;
use jde_host::{Lockstep, Options};
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::Observer;

use crate::common::{Call, Executor, MS, Rig, Stage, on_every_executor, plugins, text};

on_every_executor!(
    r15_every_selection_leaves_a_line_that_says_why,
    r15_a_line_tells_the_whole_of_a_takeover,
);

/// A buffer that the test reads afterwards.
#[derive(Clone, Default)]
struct Paper(Arc<Mutex<Vec<u8>>>);

impl Write for Paper {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
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

/// The deciders that occur in it.
const DECIDERS: [&str; 3] = ["absence-policy", "nobody", "urgency"];

/// The lines of two virtual seconds in which both schemas behave by their seed. In real time, the lines until
/// every decider has occurred, and at least a hundred.
fn decide(executor: Executor, seed: u64) -> String {
    let stage = Stage::new();
    for name in ["high", "low"] {
        let mut state = None;
        stage.play(name, move |call, io| {
            // xorshift64 (Marsaglia 2003), whose state must not be 0.
            let state = state.get_or_insert_with(|| io.cx().seed() | 1);
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
                Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
            }
            Ok(())
        });
    }
    let plugins = plugins();
    let body = format!("seed = {seed}\n{}", text(executor, &stage, APP));
    let application =
        parse(&body, "apps/test.toml".as_ref(), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let paper = Paper::default();
    let decisions = DecisionWriter::new(&application, paper.clone());
    let options = Options {
        observers: vec![Box::new(decisions) as Box<dyn Observer>],
        ..Options::default()
    };
    let text = |paper: &Paper| String::from_utf8(paper.0.lock().unwrap().clone()).expect("text");
    if executor == Executor::Lockstep {
        let mut lockstep = Lockstep::start(application, &plugins, options).expect("it starts");
        lockstep.run_until(2_000 * MS);
    } else {
        let mut rig = Rig::run(executor, &stage, application, &plugins, options).expect("it starts");
        rig.until(|_| {
            let text = text(&paper);
            let decides = |decider: &str| text.contains(&format!("\"decider\":\"{decider}\""));
            text.lines().count() >= 100 && DECIDERS.into_iter().all(decides)
        });
        rig.stop();
    }
    text(&paper)
}

#[test]
fn r16_the_same_seed_makes_the_same_choices_to_the_byte() {
    let first = decide(Executor::Lockstep, 7);
    assert!(first.lines().count() > 200);
    assert_eq!(first, decide(Executor::Lockstep, 7));
    assert_ne!(first, decide(Executor::Lockstep, 8));
}

fn r15_every_selection_leaves_a_line_that_says_why(executor: Executor) {
    let text = decide(executor, 7);
    let (mut number, mut last) = (0, 0.0);
    let mut deciders = std::collections::BTreeSet::new();
    for line in text.lines() {
        let line: serde_json::Value = serde_json::from_str(line).expect("a line of JSON");
        number += 1;
        assert_eq!(line["number"], number, "none is missing, and they are in order");
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
        let taken = line["changed"] == true && line["choice"].is_string();
        if let Some(takeover) = line.get("takeover_us") {
            assert!(taken && takeover.as_f64().is_some_and(|us| us >= 0.0), "{line}");
        }
        deciders.insert(line["decider"].as_str().expect("a text").to_owned());
    }
    let deciders: Vec<_> = deciders.iter().map(String::as_str).collect();
    assert_eq!(deciders, DECIDERS);
}

fn r15_a_line_tells_the_whole_of_a_takeover(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    let mut rig = Rig::start(executor, &stage, APP);
    rig.until_did("robot velocity 0.1");
    let paper = Paper::default();
    let mut decisions = DecisionWriter::new(rig.handle.application(), paper.clone());
    for event in stage.events() {
        decisions.on_event(&event);
    }
    decisions.finish().expect("it was written");
    let text = String::from_utf8(paper.0.lock().unwrap().clone()).expect("text");
    let line = text
        .lines()
        .find(|line| line.contains("\"changed\":true"))
        .expect("low won");
    let line: serde_json::Value = serde_json::from_str(line).expect("a line of JSON");
    assert_eq!(line["choice"], "low");
    assert_eq!(line["before"], serde_json::Value::Null);
    assert_eq!(line["case"], "alone");
    assert_eq!(line["reason"], "the only one ready");
    assert_eq!(line["cause"], "the readiness of low changed");
    let took = line["takeover_us"].as_f64().expect("it began");
    assert!(
        took >= 0.0 && (executor != Executor::Lockstep || took == 0.0),
        "{took}"
    );
    rig.stop();
}
