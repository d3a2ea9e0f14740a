//! Output that is never read, and terminals that vanish: running schemas are not delayed, and a request to
//! end is obeyed.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::{AsRawFd, OwnedFd};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use jde_log::Recording;
use jde_watchdog::Watchdog;
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

use crate::attached::Place;
use crate::support::{jde, jde_with_plugins, pair};

/// A full pipe that is not read.
struct Unread {
    _reader: std::io::PipeReader,
    writer: std::io::PipeWriter,
}

impl Unread {
    fn new() -> Self {
        let (reader, writer) = std::io::pipe().expect("there are pipes");
        let flags = fcntl_getfl(&writer).unwrap();
        fcntl_setfl(&writer, flags | OFlags::NONBLOCK).unwrap();
        let mut filling = &writer;
        while filling.write(&[b'.'; 4096]).is_ok() {}
        // Less room remains than the first writes needed.
        while filling.write(b".").is_ok() {}
        fcntl_setfl(&writer, flags).unwrap();
        Self {
            _reader: reader,
            writer,
        }
    }

    fn end(&self) -> Stdio {
        self.writer.try_clone().expect("it can be had twice").into()
    }
}

/// A process that is killed at the end of the test, even if it fails.
struct Process(Child);

impl Process {
    fn start(command: &mut Command) -> Self {
        Self(command.spawn().expect("the executable starts"))
    }

    fn signal(&self, name: &str) {
        let id = self.0.id().to_string();
        let sent = Command::new("kill").args([&format!("-{name}"), &id]).status();
        assert!(sent.expect("there is a kill").success());
    }

    /// Waits until the process ends. Returns its exit status.
    fn ended(&mut self) -> Option<i32> {
        self.0.wait().expect("it can be asked").code()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A terminal whose other end the test holds.
struct Terminal {
    /// The other end. Closing it makes the terminal vanish.
    shows: File,
    path: PathBuf,
}

impl Terminal {
    fn new() -> Self {
        let shows = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&shows).unwrap();
        unlockpt(&shows).unwrap();
        let path = ptsname(&shows, Vec::new()).unwrap().into_string().unwrap().into();
        let size = Winsize {
            ws_row: 24,
            ws_col: 80,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&shows, size).unwrap();
        Self {
            shows: shows.into(),
            path,
        }
    }

    fn open(&self, flags: OFlags) -> OwnedFd {
        rustix::fs::open(
            &self.path,
            OFlags::RDWR | OFlags::NOCTTY | flags,
            rustix::fs::Mode::empty(),
        )
        .unwrap()
    }

    /// Creates a terminal that accepts no more output.
    fn full() -> Self {
        let terminal = Self::new();
        let mut filling: File = terminal.open(OFlags::NONBLOCK).into();
        while filling.write(&[b'.'; 256]).is_ok() {}
        while filling.write(b".").is_ok() {}
        terminal
    }

    /// Starts a process on this terminal. With a session of its own, a signal informs the process when the
    /// terminal vanishes; without, nothing does.
    fn start(&self, mut command: Command, session: bool) -> Process {
        let ends = [0; 3].map(|_| Stdio::from(self.open(OFlags::empty())));
        let [input, out, err] = ends;
        if session {
            let mut within = Command::new("setsid");
            within
                .arg("--ctty")
                .arg(command.get_program())
                .args(command.get_args());
            for (key, value) in command.get_envs() {
                match value {
                    Some(value) => within.env(key, value),
                    None => within.env_remove(key),
                };
            }
            within.current_dir(command.get_current_dir().expect("it has one"));
            command = within;
        }
        command
            .env("TERM", "xterm-256color")
            .stdin(input)
            .stdout(out)
            .stderr(err);
        Process::start(&mut command)
    }

    /// Reads the output until it contains `what`.
    fn shows(&mut self, what: &str) {
        let mut shown = String::new();
        let mut piece = [0; 4096];
        while !shown.contains(what) {
            let length = self.shows.read(&mut piece).expect("somebody is there");
            shown += &String::from_utf8_lossy(&piece[..length]);
        }
    }
}

/// Repeats a check until it is true.
fn until(so: impl Fn() -> bool) {
    while !so() {}
}

/// Returns the iterations of all schemas so far.
fn iterations(place: &Place) -> u64 {
    let now = place.json(&["ps"]);
    let schemas = now["schemas"].as_array().expect("a list").iter();
    schemas
        .map(|schema| schema["iterations"].as_u64().expect("a number"))
        .sum()
}

/// Checks that an application starts, keeps iterating, and ends at a signal, while all of its output goes to
/// full pipes.
fn runs_and_ends(place: &Place, signal: &str, more: &[&str]) {
    let (out, err) = (Unread::new(), Unread::new());
    let mut command = place.command(jde_with_plugins(&["run", &pair()]));
    command
        .args(more)
        .stdin(Stdio::null())
        .stdout(out.end())
        .stderr(err.end());
    let mut process = Process::start(&mut command);
    until(|| !place.apps().is_empty());
    let before = iterations(place);
    until(|| iterations(place) > before + 10);
    process.signal(signal);
    assert_eq!(process.ended(), Some(0));
}

#[test]
fn a_run_whose_log_and_lines_nobody_reads_goes_on_and_ends_with_its_recording_closed() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let drive = place.folder().join("drive.mcap");
    let record = ["--plain", "--log", "trace", "--record", drive.to_str().unwrap()];
    runs_and_ends(&place, "TERM", &record);
    let recording = Recording::open(&drive).expect("there is a recording");
    assert!(recording.damage().is_none(), "{:?}", recording.damage());
}

#[test]
fn a_run_whose_json_and_decisions_nobody_reads_goes_on_and_ends() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let decisions = Unread::new();
    let path = format!("/proc/{}/fd/{}", std::process::id(), decisions.writer.as_raw_fd());
    runs_and_ends(
        &place,
        "INT",
        &["--json", "--log", "state=info", "--decisions", &path],
    );
}

#[test]
fn a_run_in_lockstep_whose_lines_nobody_reads_ends_when_it_is_asked_to() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let (out, err) = (Unread::new(), Unread::new());
    let mut command = place.command(jde_with_plugins(&["run", &pair(), "--lockstep", "--link"]));
    command
        .args(["--log", "trace"])
        .stdin(Stdio::null())
        .stdout(out.end())
        .stderr(err.end());
    let mut process = Process::start(&mut command);
    until(|| !place.apps().is_empty());
    process.signal("TERM");
    assert_eq!(process.ended(), Some(0));
}

#[test]
fn tools_whose_reader_does_not_read_end_when_they_are_asked_to() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let _application = place.start(&pair(), &[]);
    let (drive, file) = (recorded(&place), place.folder().join("other.mcap"));
    for arguments in [
        &["watch", "listener.period", "talker.count"][..],
        &["watch", "--json", "talker.count"],
        &["events", "--all", "--last", "1000"],
        &["stop", "listener", "--for", "1h"],
        &["record", file.to_str().unwrap()],
        &["replay", &drive, "--plain", "--stay"],
        &["sim", "office", "--pty"],
    ] {
        let (out, err) = (Unread::new(), Unread::new());
        let mut command = place.command(jde(arguments));
        command.stdin(Stdio::null()).stdout(out.end()).stderr(err.end());
        let mut process = Process::start(&mut command);
        until(|| is_told(&process));
        process.signal("TERM");
        assert_eq!(process.ended(), Some(0), "{arguments:?}");
    }
    assert!(
        Recording::open(&file)
            .expect("there is a recording")
            .damage()
            .is_none()
    );
}

/// Records one second of an application.
fn recorded(place: &Place) -> String {
    let drive = place.folder().join("drive.mcap").to_str().unwrap().to_owned();
    let mut run = place.command(jde_with_plugins(&["run", &pair(), "--lockstep", "--for", "1s"]));
    let recorded = run.args(["--record", &drive]).output();
    assert!(recorded.expect("it starts").status.success());
    drive
}

/// Whether a process handles SIGTERM yet, according to Linux.
fn is_told(process: &Process) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.0.id())).expect("it is there");
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let caught = u64::from_str_radix(caught.expect("Linux says so").trim(), 16).expect("a mask");
    caught & (1 << (signal_hook::consts::SIGTERM - 1)) != 0
}

/// The first output of a view, and the first query of the line editor.
const VIEW: &str = "\u{1b}[?1049h";
const ASKS: &str = "\u{1b}[6n";

#[test]
fn whoever_had_a_terminal_ends_with_it() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let drive = recorded(&place);
    let _application = place.start(&pair(), &[]);
    let other = place.folder().join("other.mcap");
    let pair = pair();
    let views = [
        (
            &[
                "run",
                &pair,
                "--name",
                "other",
                "--record",
                other.to_str().unwrap(),
            ][..],
            VIEW,
        ),
        (&["top", "pair"], VIEW),
        (&["watch", "--plot", "pair:talker.count"], VIEW),
        (&["replay", &drive, "--name", "played", "--stay"], VIEW),
        (&["shell"], ASKS),
    ];
    for (arguments, begins) in views {
        for session in [true, false] {
            let mut terminal = Terminal::new();
            let mut process = terminal.start(place.command(jde_with_plugins(arguments)), session);
            terminal.shows(begins);
            drop(terminal);
            let panicked = 101;
            assert_ne!(process.ended(), Some(panicked), "{arguments:?}");
            let _ = std::fs::rename(&other, place.folder().join(format!("{session}.mcap")));
        }
    }
    for session in ["true", "false"] {
        let recording =
            Recording::open(&place.folder().join(format!("{session}.mcap"))).expect("a recording");
        assert!(recording.damage().is_none(), "{:?}", recording.damage());
    }
}

#[test]
fn a_shell_that_is_asked_to_end_ends_with_the_verb_that_runs() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let _application = place.start(&pair(), &[]);
    let mut terminal = Terminal::new();
    let mut shell = terminal.start(place.command(jde(&["shell"])), false);
    terminal.shows(ASKS);
    terminal
        .shows
        .write_all(b"\x1b[1;1Rwatch talker.count\r")
        .unwrap();
    // The line editor has released the terminal.
    terminal.shows(" s\u{1b}[0m  ");
    shell.signal("TERM");
    assert_eq!(shell.ended(), Some(143));

    let mut command = place.command(jde(&["shell"]));
    let mut shell = Process::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()));
    let mut lines = shell.0.stdin.take().unwrap();
    lines.write_all(b"watch talker.count\n").unwrap();
    shell.0.stdout.as_mut().unwrap().read_exact(&mut [0]).unwrap();
    shell.signal("TERM");
    assert_eq!(shell.ended(), Some(143));
}

#[test]
fn views_on_a_terminal_that_takes_nothing_end_when_they_are_asked_to() {
    let _watchdog = Watchdog::for_test();
    let place = Place::new();
    let _application = place.start(&pair(), &[]);
    let pair = pair();
    for arguments in [
        &["run", &pair, "--name", "other"][..],
        &["top", "pair"],
        &["watch", "--plot", "pair:talker.count"],
    ] {
        let terminal = Terminal::full();
        let mut process = terminal.start(place.command(jde_with_plugins(arguments)), false);
        until(|| is_told(&process));
        process.signal("TERM");
        process.ended();
    }
}
