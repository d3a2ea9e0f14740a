//! Output that is never read and terminals that vanish do not delay schemas, and every verb still ends when a
//! signal requests it.

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

use crate::attached::Sandbox;
use crate::support::{jde, jde_with_plugins, pair, signal};

/// A full pipe that is not read.
struct Unread {
    _reader: std::io::PipeReader,
    writer: std::io::PipeWriter,
}

impl Unread {
    fn new() -> Self {
        let (reader, writer) = std::io::pipe().expect("a pipe is created");
        let flags = fcntl_getfl(&writer).unwrap();
        fcntl_setfl(&writer, flags | OFlags::NONBLOCK).unwrap();
        let mut unread = &writer;
        while unread.write(&[b'.'; 4096]).is_ok() {}
        while unread.write(b".").is_ok() {}
        fcntl_setfl(&writer, flags).unwrap();
        Self {
            _reader: reader,
            writer,
        }
    }

    /// Returns the writing end.
    fn end(&self) -> Stdio {
        self.writer
            .try_clone()
            .expect("the descriptor is duplicated")
            .into()
    }
}

/// A process that is killed at the end of the test, even if it fails.
struct Process(Child);

impl Process {
    fn start(command: &mut Command) -> Self {
        Self(command.spawn().expect("the executable starts"))
    }

    fn signal(&self, name: &str) {
        signal(name, &self.0);
    }

    /// Waits until the process ends. Returns its exit status.
    fn exit_status(&mut self) -> Option<i32> {
        self.0.wait().expect("the process ends").code()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A pseudoterminal.
struct Terminal {
    /// The controlling side. Closing it makes the terminal vanish.
    controller: File,
    path: PathBuf,
}

impl Terminal {
    fn new() -> Self {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let path = ptsname(&controller, Vec::new())
            .unwrap()
            .into_string()
            .unwrap()
            .into();
        let size = Winsize {
            ws_row: 24,
            ws_col: 80,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&controller, size).unwrap();
        Self {
            controller: controller.into(),
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
        let mut file: File = terminal.open(OFlags::NONBLOCK).into();
        while file.write(&[b'.'; 256]).is_ok() {}
        while file.write(b".").is_ok() {}
        terminal
    }

    /// Starts a process on this terminal. Only a process with a session of its own gets SIGHUP when the
    /// terminal vanishes.
    fn start(&self, mut command: Command, session: bool) -> Process {
        let ends = [0; 3].map(|_| Stdio::from(self.open(OFlags::empty())));
        let [input, out, err] = ends;
        if session {
            let mut setsid = Command::new("setsid");
            setsid
                .arg("--ctty")
                .arg(command.get_program())
                .args(command.get_args());
            for (key, value) in command.get_envs() {
                match value {
                    Some(value) => setsid.env(key, value),
                    None => setsid.env_remove(key),
                };
            }
            setsid.current_dir(command.get_current_dir().expect("the command has a directory"));
            command = setsid;
        }
        command
            .env("TERM", "xterm-256color")
            .stdin(input)
            .stdout(out)
            .stderr(err);
        Process::start(&mut command)
    }

    /// Reads the output until it contains `text`.
    fn wait_for(&mut self, text: &str) {
        let mut shown = String::new();
        let mut buffer = [0; 4096];
        while !shown.contains(text) {
            let length = self
                .controller
                .read(&mut buffer)
                .expect("the process keeps the terminal open");
            shown += &String::from_utf8_lossy(&buffer[..length]);
        }
    }
}

/// Repeats a check until it is true.
fn until(condition: impl Fn() -> bool) {
    while !condition() {}
}

/// Returns the iterations of all schemas so far.
fn iterations(sandbox: &Sandbox) -> u64 {
    let now = sandbox.json(&["ps"]);
    let schemas = now["schemas"].as_array().expect("a list").iter();
    schemas
        .map(|schema| schema["iterations"].as_u64().expect("a number"))
        .sum()
}

/// Checks that an application starts, keeps iterating, and ends at a signal, while all of its output goes to
/// full pipes.
fn runs_and_ends(sandbox: &Sandbox, signal: &str, options: &[&str]) {
    let (out, err) = (Unread::new(), Unread::new());
    let mut command = sandbox.command(jde_with_plugins(&["run", &pair()]));
    command
        .args(options)
        .stdin(Stdio::null())
        .stdout(out.end())
        .stderr(err.end());
    let mut process = Process::start(&mut command);
    until(|| !sandbox.apps().is_empty());
    let before = iterations(sandbox);
    until(|| iterations(sandbox) > before + 10);
    process.signal(signal);
    assert_eq!(process.exit_status(), Some(0));
}

#[test]
fn a_run_with_unread_output_continues_and_closes_its_recording() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let drive = sandbox.folder().join("drive.mcap");
    let record = ["--plain", "--log", "trace", "--record", drive.to_str().unwrap()];
    runs_and_ends(&sandbox, "TERM", &record);
    let recording = Recording::open(&drive).expect("there is a recording");
    assert!(recording.damage().is_none(), "{:?}", recording.damage());
}

#[test]
fn a_run_with_unread_json_and_decisions_continues_and_ends() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let decisions = Unread::new();
    let path = format!("/proc/{}/fd/{}", std::process::id(), decisions.writer.as_raw_fd());
    runs_and_ends(
        &sandbox,
        "INT",
        &["--json", "--log", "state=info", "--decisions", &path],
    );
}

#[test]
fn a_run_in_lockstep_with_unread_output_ends_at_a_signal() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let (out, err) = (Unread::new(), Unread::new());
    let mut command = sandbox.command(jde_with_plugins(&["run", &pair(), "--lockstep", "--link"]));
    command
        .args(["--log", "trace"])
        .stdin(Stdio::null())
        .stdout(out.end())
        .stderr(err.end());
    let mut process = Process::start(&mut command);
    until(|| !sandbox.apps().is_empty());
    process.signal("TERM");
    assert_eq!(process.exit_status(), Some(0));
}

#[test]
fn tools_with_unread_output_end_at_a_signal() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let _application = sandbox.start(&pair(), &[]);
    let (drive, file) = (record(&sandbox), sandbox.folder().join("other.mcap"));
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
        let mut command = sandbox.command(jde(arguments));
        command.stdin(Stdio::null()).stdout(out.end()).stderr(err.end());
        let mut process = Process::start(&mut command);
        until(|| handles_sigterm(&process));
        process.signal("TERM");
        assert_eq!(process.exit_status(), Some(0), "{arguments:?}");
    }
    assert!(
        Recording::open(&file)
            .expect("there is a recording")
            .damage()
            .is_none()
    );
}

/// Records one second of an application.
fn record(sandbox: &Sandbox) -> String {
    let drive = sandbox.folder().join("drive.mcap").to_str().unwrap().to_owned();
    let mut run = sandbox.command(jde_with_plugins(&["run", &pair(), "--lockstep", "--for", "1s"]));
    let output = run.args(["--record", &drive]).output();
    assert!(output.expect("the executable starts").status.success());
    drive
}

/// Returns whether a process handles SIGTERM yet.
fn handles_sigterm(process: &Process) -> bool {
    let status =
        std::fs::read_to_string(format!("/proc/{}/status", process.0.id())).expect("the process runs");
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let caught = u64::from_str_radix(caught.expect("Linux reports the handled signals").trim(), 16)
        .expect("the mask is hexadecimal");
    caught & (1 << (signal_hook::consts::SIGTERM - 1)) != 0
}

/// The first output of a view, and of the line editor.
const ALTERNATE_SCREEN: &str = "\u{1b}[?1049h";
const CURSOR_QUERY: &str = "\u{1b}[6n";

#[test]
fn processes_end_without_a_panic_when_their_terminal_vanishes() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let drive = record(&sandbox);
    let _application = sandbox.start(&pair(), &[]);
    let other = sandbox.folder().join("other.mcap");
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
            ALTERNATE_SCREEN,
        ),
        (&["top", "pair"], ALTERNATE_SCREEN),
        (&["watch", "--plot", "pair:talker.count"], ALTERNATE_SCREEN),
        (
            &["replay", &drive, "--name", "played", "--stay"],
            ALTERNATE_SCREEN,
        ),
        (&["shell"], CURSOR_QUERY),
    ];
    for (arguments, first_output) in views {
        for session in [true, false] {
            let mut terminal = Terminal::new();
            let mut process = terminal.start(sandbox.command(jde_with_plugins(arguments)), session);
            terminal.wait_for(first_output);
            drop(terminal);
            let panicked = 101;
            assert_ne!(process.exit_status(), Some(panicked), "{arguments:?}");
            let _ = std::fs::rename(&other, sandbox.folder().join(format!("{session}.mcap")));
        }
    }
    for session in ["true", "false"] {
        let recording =
            Recording::open(&sandbox.folder().join(format!("{session}.mcap"))).expect("a recording");
        assert!(recording.damage().is_none(), "{:?}", recording.damage());
    }
}

#[test]
fn sigterm_ends_a_shell_and_the_verb_that_it_runs() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let _application = sandbox.start(&pair(), &[]);
    let mut terminal = Terminal::new();
    let mut shell = terminal.start(sandbox.command(jde(&["shell"])), false);
    terminal.wait_for(CURSOR_QUERY);
    terminal
        .controller
        .write_all(b"\x1b[1;1Rwatch talker.count\r")
        .unwrap();
    // The line editor has released the terminal.
    terminal.wait_for(" s\u{1b}[0m  ");
    shell.signal("TERM");
    assert_eq!(shell.exit_status(), Some(143));

    let mut command = sandbox.command(jde(&["shell"]));
    let mut shell = Process::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()));
    let mut lines = shell.0.stdin.take().unwrap();
    lines.write_all(b"watch talker.count\n").unwrap();
    shell.0.stdout.as_mut().unwrap().read_exact(&mut [0]).unwrap();
    shell.signal("TERM");
    assert_eq!(shell.exit_status(), Some(143));
}

#[test]
fn views_on_a_terminal_that_accepts_no_output_end_at_a_signal() {
    let _watchdog = Watchdog::for_test();
    let sandbox = Sandbox::new();
    let _application = sandbox.start(&pair(), &[]);
    let pair = pair();
    for arguments in [
        &["run", &pair, "--name", "other"][..],
        &["top", "pair"],
        &["watch", "--plot", "pair:talker.count"],
    ] {
        let terminal = Terminal::full();
        let mut process = terminal.start(sandbox.command(jde_with_plugins(arguments)), false);
        until(|| handles_sigterm(&process));
        process.signal("TERM");
        process.exit_status();
    }
}
