//! The oscilloscope and the shell on a terminal that `script` of util-linux creates.

use jde_watchdog::Watchdog;
use std::process::{Command, Stdio};

use crate::attached::Sandbox;
use crate::support::{pair, plugins, root};
use crate::terminal::{ENTER, LEAVE, Terminal};

#[test]
fn run_on_a_terminal_shows_the_oscilloscope_and_restores_the_terminal() {
    let sandbox = Sandbox::new();
    let run = format!("{} run {}", env!("CARGO_BIN_EXE_jde"), pair());
    let mut terminal = Terminal::start(&sandbox, [24, 80], &run);
    terminal.wait_for(|shown| shown.contains("listener"));
    terminal.type_keys(b"q");
    let (status, shown) = terminal.finish();
    assert_eq!(status, Some(0), "{shown}");
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
        "sh -c 'echo $$ > {}; exec {} run {}'; read line; stty -a",
        process.display(),
        env!("CARGO_BIN_EXE_jde"),
        pair()
    );
    let mut terminal = Terminal::start(&sandbox, [24, 80], &command);
    terminal.wait_for(|shown| shown.contains("listener"));
    let id = std::fs::read_to_string(&process).unwrap();
    let mut kill = Command::new("kill");
    assert!(kill.args(["-KILL", id.trim()]).status().unwrap().success());
    terminal.wait_for(|shown| shown.contains(LEAVE));
    terminal.type_keys(b"\n");
    let (_, shown) = terminal.finish();
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
    let shell = format!("{} shell", env!("CARGO_BIN_EXE_jde"));
    let mut terminal = Terminal::start(&sandbox, [24, 80], &shell);
    // Types half a line and Ctrl-X, and after the confirmation deletes the line and exits. Each waits for a
    // query of the line editor: keys sent before it would reach the terminal instead of the editor.
    let mut pending_keys = [
        ("", &b"get talk\x18"[..]),
        ("every command is neutral", b"\x15exit\r"),
    ]
    .into_iter()
    .peekable();
    let mut responses = 0;
    while let Some(shown) = terminal.more() {
        let queries = shown.matches(CURSOR_QUERY).count();
        let is_queried_after = |text: &str| match (shown.find(text), shown.rfind(CURSOR_QUERY)) {
            (Some(text), Some(query)) => text < query,
            (None, _) | (_, None) => false,
        };
        let keys = pending_keys.next_if(|(text, _)| is_queried_after(text));
        terminal.type_keys(&CURSOR_RESPONSE.repeat(queries - responses));
        responses = queries;
        if let Some((_, keys)) = keys {
            terminal.type_keys(keys);
        }
    }
    let (status, shown) = terminal.finish();
    assert_eq!(status, Some(0), "{shown}");
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
