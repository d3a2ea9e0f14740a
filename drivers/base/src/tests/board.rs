//! The sketch's board, built for this machine, with a model of motors and wheels, in a time that the test tells; and faults
//! of its line. It has no protocol of its own: all that it says is the sketch's.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::OnceLock;
use std::time::Instant;

use jde_device::emulate::Emulator;

/// The sources of the program, also for tests of other crates in a folder of folders.
const SOURCES: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../drivers/base/tests/host/board.cpp"
);

/// A board and its model.
pub(crate) struct Board {
    program: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// How the model moves now.
    pub(crate) truth: Truth,
}

/// What the model does.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Truth {
    /// Its speeds: ahead, to the left, m/s; counter-clockwise, rad/s.
    pub(crate) speeds: [f64; 3],
    /// Its pose: m, m, rad without wraps.
    pub(crate) pose: [f64; 3],
}

/// Builds the program once, and returns its path. It stays there for the next run of the tests, which builds it anew.
fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let path = std::env::temp_dir().join("jde-base-board");
        // Another run may be using it.
        let built = path.with_extension(std::process::id().to_string());
        let flags = ["-std=c++11", "-O1", "-Wall", "-Wextra", "-Werror"];
        let result = Command::new("c++")
            .args(flags)
            .arg(SOURCES)
            .arg("-o")
            .arg(&built)
            .status();
        assert!(
            result.expect("a compiler of C++").success(),
            "the sketch compiles"
        );
        std::fs::rename(&built, &path).expect("the same folder");
        path
    })
}

impl Board {
    /// A differential or a mecanum board, whose clock and counts wrap soon.
    pub(crate) fn new(kind: &str, serial_number: &str) -> Self {
        let mut child = Command::new(program())
            .args([kind, serial_number, "4294960000", "4294967000"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it was built");
        let requests = child.stdin.take().expect("it is piped");
        let answers = BufReader::new(child.stdout.take().expect("it is piped"));
        Self {
            program: child,
            requests,
            answers,
            truth: Truth::default(),
        }
    }

    /// Gives bytes to the board, and lets so many milliseconds pass. Returns what it sends.
    pub(crate) fn advance(&mut self, milliseconds: u64, bytes: &[u8]) -> Vec<u8> {
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.request(&format!("{milliseconds} {digits}"))
    }

    /// Changes the model: "block", "reverse", "dead", "full" or "race", each until it is said again; "push", "bump", "reset".
    pub(crate) fn change(&mut self, what: &str) -> Vec<u8> {
        self.request(what)
    }

    fn request(&mut self, text: &str) -> Vec<u8> {
        writeln!(self.requests, "{text}").expect("the program reads");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("the program answers");
        let mut words = line.trim_end().split(' ');
        let digits = words.next().expect("the bytes that it sent").as_bytes();
        let numbers: Vec<f64> = words.map(|word| word.parse().expect("a number")).collect();
        self.truth = Truth {
            speeds: core::array::from_fn(|index| numbers[index]),
            pose: core::array::from_fn(|index| numbers[3 + index]),
        };
        let byte = |pair: &[u8]| u8::from_str_radix(core::str::from_utf8(pair).expect("digits"), 16);
        digits
            .chunks(2)
            .map(|pair| byte(pair).expect("hexadecimal digits"))
            .collect()
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.program.kill());
        drop(self.program.wait());
    }
}

/// What is wrong with the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    None,
    /// Nothing comes from the board.
    Silent,
    /// Nothing comes to the board.
    Deaf,
    /// Every line of so many is missing.
    Missing(usize),
    /// A byte of every line of so many is wrong.
    Corrupt(usize),
    /// Bytes that are no line precede each.
    Noisy,
    /// The bytes are those of another speed.
    OtherBaud,
    /// What comes from the board comes so many milliseconds later.
    Late(u64),
}

/// A board at a line, in real time.
pub(crate) struct Wired {
    pub(crate) board: Board,
    pub(crate) fault: Fault,
    /// Lines so far.
    lines: usize,
    start: Instant,
    passed: u64,
    /// The time of all that was let pass, ms, and what is on its way, with the time at which it arrives.
    time: u64,
    late: VecDeque<(u64, Vec<u8>)>,
}

impl Wired {
    pub(crate) fn new(board: Board) -> Self {
        Self {
            board,
            fault: Fault::None,
            lines: 0,
            start: Instant::now(),
            passed: 0,
            time: 0,
            late: VecDeque::new(),
        }
    }

    /// Gives bytes to the board over its line, and lets time pass.
    pub(crate) fn advance(&mut self, milliseconds: u64, bytes: &[u8]) -> Vec<u8> {
        let heard = if self.fault == Fault::Deaf { &[] } else { bytes };
        let sent = self.board.advance(milliseconds, heard);
        let mut arrived = Vec::new();
        for line in sent.split_inclusive(|byte| *byte == b'\n') {
            self.lines += 1;
            let mut line = line.to_vec();
            match self.fault {
                Fault::None | Fault::Deaf | Fault::Late(_) => {}
                Fault::Silent => line.clear(),
                Fault::Missing(divisor) if self.lines.is_multiple_of(divisor) => line.clear(),
                Fault::Corrupt(divisor) if self.lines.is_multiple_of(divisor) => line[4] ^= 1,
                Fault::Missing(_) | Fault::Corrupt(_) => {}
                Fault::Noisy => arrived.extend(b"\x00s 1 t=\xff*\n*0000\n"),
                Fault::OtherBaud => line
                    .iter_mut()
                    .for_each(|byte| *byte = byte.rotate_left(3) | 0x80),
            }
            arrived.extend(line);
        }
        self.time += milliseconds;
        if let Fault::Late(delay) = self.fault {
            self.late.push_back((self.time + delay, arrived));
            arrived = Vec::new();
            while self.late.front().is_some_and(|(due, _)| *due <= self.time) {
                arrived.extend(self.late.pop_front().unwrap_or_default().1);
            }
        }
        arrived
    }

    fn catch_up(&mut self, bytes: &[u8]) -> Vec<u8> {
        let now = self.start.elapsed().as_millis() as u64;
        let step = now - core::mem::replace(&mut self.passed, now);
        self.advance(step, bytes)
    }
}

impl Emulator for Wired {
    fn receive(&mut self, bytes: &[u8], _: u32) -> Vec<u8> {
        self.catch_up(bytes)
    }

    fn poll_output(&mut self) -> Vec<u8> {
        self.catch_up(&[])
    }
}
