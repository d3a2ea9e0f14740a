//! The oscilloscope and the shell on a terminal of their own, which `script` of util-linux creates.

use jde_watchdog::Watchdog;
use std::io::{Read, Write};
use std::process::{Command, Stdio};

use crate::attached::Place;
use crate::support::{pair, plugins, root};

/// The sequences that show the alternate screen of a terminal, and leave it.
const ENTER: &str = "\u{1b}[?1049h";
const LEAVE: &str = "\u{1b}[?1049l";

#[test]
fn on_a_terminal_it_shows_the_oscilloscope_and_gives_the_terminal_back() {
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
        .expect("script of util-linux is there");
    let mut keys = child.stdin.take().unwrap();
    let mut screen = child.stdout.take().unwrap();
    let mut shown = Vec::new();
    let mut piece = [0; 4096];
    let mut left = false;
    loop {
        let length = screen.read(&mut piece).unwrap();
        if length == 0 {
            break;
        }
        shown.extend_from_slice(&piece[..length]);
        if !left && String::from_utf8_lossy(&shown).contains("listener") {
            keys.write_all(b"q").unwrap();
            left = true;
        }
    }
    let shown = String::from_utf8_lossy(&shown);
    assert_eq!(child.wait().unwrap().code(), Some(0), "{shown}");
    let (enter, leave) = (
        shown.find(ENTER).expect("it enters"),
        shown.find(LEAVE).expect("it leaves"),
    );
    let summary = shown.find("stopped").expect("there is a summary");
    assert!(enter < leave && leave < summary, "{shown}");
}

/// The request for the cursor's position, and a response.
const WHERE: &str = "\u{1b}[6n";
const HERE: &[u8] = b"\x1b[1;1R";

#[test]
fn r14_a_key_of_the_shell_stops_everything_whatever_is_typed() {
    let place = Place::new();
    let _application = place.start(&pair(), &[]);
    let mut command = Command::new("script");
    let shell = format!("stty rows 24 cols 80; {} shell", env!("CARGO_BIN_EXE_jde"));
    command
        .args(["-qec", &shell, "/dev/null"])
        .env("TERM", "xterm-256color");
    let mut child = place
        .command(command)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("script of util-linux is there");
    let mut keys = child.stdin.take().unwrap();
    let mut screen = child.stdout.take().unwrap();
    // Types half a line and Ctrl-X. Once that is handled and the line editor asks again, it deletes the line
    // and leaves the shell. Keys sent before the editor asks would reach the terminal instead of the editor.
    let mut to_press = [
        ("", &b"get talk\x18"[..]),
        ("every command is neutral", b"\x15exit\r"),
    ]
    .into_iter()
    .peekable();
    let (mut shown, mut answered) = (String::new(), 0);
    let mut piece = [0; 4096];
    loop {
        let length = screen.read(&mut piece).unwrap();
        if length == 0 {
            break;
        }
        shown += &String::from_utf8_lossy(&piece[..length]);
        let asked = shown.matches(WHERE).count();
        keys.write_all(&HERE.repeat(asked - answered)).unwrap();
        answered = asked;
        let is_asked_after = |words: &str| match (shown.find(words), shown.rfind(WHERE)) {
            (Some(said), Some(asked)) => said < asked,
            (None, _) | (_, None) => false,
        };
        if let Some((_, keystrokes)) = to_press.next_if(|(words, _)| is_asked_after(words)) {
            keys.write_all(keystrokes).unwrap();
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(0), "{shown}");
    let now = place.json(&["ps"]);
    let asleep = |schema: &serde_json::Value| schema["state"] == "slept";
    assert!(
        now["schemas"].as_array().expect("a list").iter().all(asleep),
        "{now}\n{shown}"
    );
}

#[test]
fn takeovers_and_the_log_never_share_a_line_of_a_terminal() {
    let _watchdog = Watchdog::for_test();
    let run = format!(
        "{} run safe-navigation --plain --for 1s --color never --log state=trace",
        env!("CARGO_BIN_EXE_jde")
    );
    let ran = Command::new("script")
        .args(["-qec", &run, "/dev/null"])
        .env("JDE_PLUGIN_PATH", plugins())
        .env("TERM", "xterm-256color")
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .expect("script of util-linux is there");
    let shown = String::from_utf8(ran.stdout).expect("it is text");
    let count = |line: &str| line.matches("from=").count() + line.matches(" -> ").count();
    assert!(
        shown.contains("roots: nobody -> example") && shown.contains("trace goon: from="),
        "{shown}"
    );
    assert!(shown.lines().all(|line| count(line) <= 1), "{shown}");
}
