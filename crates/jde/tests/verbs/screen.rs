//! The oscilloscope and the shell on a terminal that `script` of util-linux creates.

use jde_watchdog::Watchdog;
use std::io::{Read, Write};
use std::process::{Command, Stdio};

use crate::attached::Sandbox;
use crate::support::{pair, plugins, root};

/// The sequences that enter and leave the alternate screen of a terminal.
const ENTER: &str = "\u{1b}[?1049h";
const LEAVE: &str = "\u{1b}[?1049l";

#[test]
fn run_on_a_terminal_shows_the_oscilloscope_and_restores_the_terminal() {
    let _watchdog = Watchdog::for_test();
    let command = format!(
        "stty rows 24 cols 80; {} run {}",
        env!("CARGO_BIN_EXE_jde"),
        pair()
    );
    let mut child = Command::new("script")
        .args(["-qec", &command, "/dev/null"])
        .env("JDE_PLUGIN_PATH", plugins())
        .env("TERM", "xterm-256color")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("script of util-linux is installed");
    let mut keys = child.stdin.take().unwrap();
    let mut screen = child.stdout.take().unwrap();
    let mut shown = Vec::new();
    let mut buffer = [0; 4096];
    let mut quit = false;
    loop {
        let length = screen.read(&mut buffer).unwrap();
        if length == 0 {
            break;
        }
        shown.extend_from_slice(&buffer[..length]);
        if !quit && String::from_utf8_lossy(&shown).contains("listener") {
            keys.write_all(b"q").unwrap();
            quit = true;
        }
    }
    let shown = String::from_utf8_lossy(&shown);
    assert_eq!(child.wait().unwrap().code(), Some(0), "{shown}");
    let (enter, leave) = (
        shown.find(ENTER).expect("the alternate screen is entered"),
        shown.find(LEAVE).expect("the alternate screen is left"),
    );
    let summary = shown.find("stopped").expect("there is a summary");
    assert!(enter < leave && leave < summary, "{shown}");
}

#[test]
fn the_terminal_is_restored_after_the_oscilloscope_is_killed() {
    let sandbox = Sandbox::new();
    let process = sandbox.folder().join("process");
    // The terminal lives until a line is typed, and then shows its settings.
    let command = format!(
        "stty rows 24 cols 80; sh -c 'echo $$ > {}; exec {} run {}'; read line; stty -a",
        process.display(),
        env!("CARGO_BIN_EXE_jde"),
        pair()
    );
    let mut script = Command::new("script");
    script
        .args(["-qec", &command, "/dev/null"])
        .env("JDE_PLUGIN_PATH", plugins())
        .env("TERM", "xterm-256color")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
    let mut child = sandbox
        .command(script)
        .spawn()
        .expect("script of util-linux is installed");
    let (mut keys, mut screen) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
    let (mut shown, mut buffer) = (Vec::new(), [0; 4096]);
    let (mut is_killed, mut is_typed) = (false, false);
    loop {
        let length = screen.read(&mut buffer).unwrap();
        if length == 0 {
            break;
        }
        shown.extend_from_slice(&buffer[..length]);
        let text = String::from_utf8_lossy(&shown);
        if !is_killed && text.contains("listener") {
            let id = std::fs::read_to_string(&process).unwrap();
            let mut kill = Command::new("kill");
            assert!(kill.args(["-KILL", id.trim()]).status().unwrap().success());
            is_killed = true;
        }
        if !is_typed && text.contains(LEAVE) {
            keys.write_all(b"\n").unwrap();
            is_typed = true;
        }
    }
    child.wait().unwrap();
    let shown = String::from_utf8_lossy(&shown);
    let settings = &shown[shown.find(LEAVE).expect("the alternate screen is left")..];
    assert!(
        settings.contains(" icanon") && settings.contains(" echo "),
        "{settings}"
    );
}

/// The query of the cursor's position, and a response.
const CURSOR_QUERY: &str = "\u{1b}[6n";
const CURSOR_RESPONSE: &[u8] = b"\x1b[1;1R";

#[test]
fn r14_ctrl_x_in_the_shell_stops_everything_while_a_line_is_typed() {
    let sandbox = Sandbox::new();
    let _application = sandbox.start(&pair(), &[]);
    let mut command = Command::new("script");
    let shell = format!("stty rows 24 cols 80; {} shell", env!("CARGO_BIN_EXE_jde"));
    command
        .args(["-qec", &shell, "/dev/null"])
        .env("TERM", "xterm-256color");
    let mut child = sandbox
        .command(command)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("script of util-linux is installed");
    let mut keys = child.stdin.take().unwrap();
    let mut screen = child.stdout.take().unwrap();
    // Types half a line and Ctrl-X, and after the confirmation deletes the line and exits. Each waits for a
    // query of the line editor: keys sent before it would reach the terminal instead of the editor.
    let mut pending_keys = [
        ("", &b"get talk\x18"[..]),
        ("every command is neutral", b"\x15exit\r"),
    ]
    .into_iter()
    .peekable();
    let (mut shown, mut responses) = (String::new(), 0);
    let mut buffer = [0; 4096];
    loop {
        let length = screen.read(&mut buffer).unwrap();
        if length == 0 {
            break;
        }
        shown += &String::from_utf8_lossy(&buffer[..length]);
        let queries = shown.matches(CURSOR_QUERY).count();
        keys.write_all(&CURSOR_RESPONSE.repeat(queries - responses))
            .unwrap();
        responses = queries;
        let is_queried_after = |text: &str| match (shown.find(text), shown.rfind(CURSOR_QUERY)) {
            (Some(text), Some(query)) => text < query,
            (None, _) | (_, None) => false,
        };
        if let Some((_, keystrokes)) = pending_keys.next_if(|(text, _)| is_queried_after(text)) {
            keys.write_all(keystrokes).unwrap();
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(0), "{shown}");
    assert_eq!(sandbox.motors_awake(), [""; 0], "{shown}");
}

#[test]
fn takeovers_and_log_messages_are_on_separate_lines_of_a_terminal() {
    let _watchdog = Watchdog::for_test();
    let run = format!(
        "{} run safe-navigation --plain --for 1s --color never --log state=trace",
        env!("CARGO_BIN_EXE_jde")
    );
    let output = Command::new("script")
        .args(["-qec", &run, "/dev/null"])
        .env("JDE_PLUGIN_PATH", plugins())
        .env("TERM", "xterm-256color")
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .expect("script of util-linux is installed");
    let shown = String::from_utf8(output.stdout).expect("the output is UTF-8");
    let count = |line: &str| line.matches("from=").count() + line.matches(" -> ").count();
    assert!(
        shown.contains("roots: nobody -> example") && shown.contains("trace goon: from="),
        "{shown}"
    );
    assert!(shown.lines().all(|line| count(line) <= 1), "{shown}");
}
