//! The schemas of the tests in Python, `tests/python/fixture.py`, in processes of their own: each call of one runs the
//! scenario's behaviour in this process, whose requests go back through the ports in Python.

use std::cell::RefCell;
use std::fmt::Debug;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::OnceLock;

use jde_abi::inspect::Problem;
use jde_abi::{describe, raw};
use jde_app::Inspection;
use jde_isolation::{Inspector, Program};
use jde_loader::{Inspect, LoadError, Plugins, SearchPath};

use super::foreign::{MadeCall, outcome};
use super::io::{Answer, Call, Caller, Request};

/// The file of the plugin. Beside it is the socket to which its processes connect.
pub(crate) fn file() -> &'static Path {
    static FILE: OnceLock<PathBuf> = OnceLock::new();
    FILE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder").keep();
        let listener = UnixListener::bind(folder.join("socket")).expect("a socket");
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let stream = stream.expect("a connection");
                std::thread::spawn(move || serve(stream));
            }
        });
        let file = folder.join("fixture.py");
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/fixture.py");
        fs::copy(source, &file).expect("the fixture can be copied");
        file
    })
}

/// The line `type = "test/able-motor"` for the class `AbleMotor` of the file; any other line as it is.
pub(super) fn type_line(line: &str) -> String {
    let Some((before, name)) = line.split_once("\"test/") else {
        return line.to_owned();
    };
    let words = name.trim_end_matches('"').split('-');
    let class: String = words.map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    format!("{before}\"fixture.py/{class}\"")
}

/// The plugins along the path and the file, which one process of Python describes for all tests.
pub(super) fn plugins(mut path: SearchPath) -> Plugins {
    path.push(file().parent().expect("a folder"), "of these tests");
    Plugins::new(path).with_inspector(Shared)
}

#[derive(Debug)]
struct Shared;

fn inspector() -> &'static Inspector {
    static INSPECTOR: OnceLock<Inspector> = OnceLock::new();
    INSPECTOR.get_or_init(|| {
        Inspector::new(Program {
            path: "these tests have no libraries".into(),
            arguments: Vec::new(),
        })
    })
}

impl Inspect for Shared {
    fn describe(&self, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError> {
        inspector().describe(copy, path)
    }

    fn inspect(&self, path: &Path, inspection: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        inspector().inspect(path, inspection)
    }

    fn stop(&self) {}
}

/// The process of a schema, and the group to arbitrate. Each line is a list of texts.
struct InPython {
    stream: UnixStream,
    lines: RefCell<BufReader<UnixStream>>,
    group: String,
}

impl InPython {
    /// Writes a line; `None` if the process has ended.
    fn write(&self, words: &[&str]) -> Option<()> {
        let line = serde_json::to_string(words).expect("texts") + "\n";
        (&self.stream).write_all(line.as_bytes()).ok()
    }

    /// Returns the next line; `None` if the process has ended.
    fn read(&self) -> Option<Vec<String>> {
        let mut line = String::new();
        self.lines.borrow_mut().read_line(&mut line).ok()?;
        serde_json::from_str(&line).ok()
    }
}

impl Caller for InPython {
    fn request(&self, request: Request, text: &str, number: f64) -> Answer {
        self.write(&[&format!("{request:?}"), text, &number.to_string()])
            .expect("the process lives");
        let answer = self.read().expect("the process lives");
        let [code, number, count] = &answer[..] else {
            panic!("{answer:?} is no answer");
        };
        (outcome(parse(code)), parse(number), parse(count))
    }

    fn group(&self) -> String {
        self.group.clone()
    }
}

/// Runs the behaviour of each call of a process, until the process ends.
fn serve(stream: UnixStream) {
    let lines = RefCell::new(BufReader::new(stream.try_clone().expect("a copy")));
    let mut process = InPython {
        stream,
        lines,
        group: String::new(),
    };
    while let Some(words) = process.read() {
        let [scenario, kind, name, group, gesture, memory, commands @ ..] = &words[..] else {
            panic!("{words:?} is no call");
        };
        process.group.clone_from(group);
        let made = MadeCall {
            scenario: parse(scenario),
            kind: call(kind),
            name: name.clone(),
            gesture: gesture.clone(),
            memory: parse(memory),
            commands: [0, 2].map(|at| [parse(&commands[at]), parse(&commands[at + 1])]),
        };
        let written = match made.run(&process) {
            Ok((precondition, role)) => {
                let (ready, urgency) = (precondition.ready.to_string(), precondition.urgency.to_string());
                process.write(&["Done", &ready, &urgency, &role])
            }
            Err((code, text)) => {
                let ending = match code {
                    raw::NO_VALUE => "NoValue",
                    raw::FAILED => "Failure",
                    _ => "Panic",
                };
                process.write(&[ending, &text])
            }
        };
        if written.is_none() {
            return;
        }
    }
}

fn call(name: &str) -> Call {
    let calls = [
        Call::Awake,
        Call::Check,
        Call::Iterate,
        Call::Sleep,
        Call::Arbitrate,
        Call::Draw,
        Call::Touch,
        Call::Save,
        Call::Restore,
    ];
    let mut found = calls.into_iter().filter(|call| format!("{call:?}") == name);
    found.next().expect("a call")
}

fn parse<T: FromStr<Err: Debug>>(word: &str) -> T {
    word.parse().expect("a number")
}
