//! The oscilloscope on a terminal of its own, made by `script` of util-linux.

use std::io::{Read, Write};
use std::process::{Command, Stdio};

use crate::support::{pair, plugins};

/// What a terminal is sent to show its alternate screen, and to leave it.
const ENTER: &str = "\u{1b}[?1049h";
const LEAVE: &str = "\u{1b}[?1049l";

#[test]
fn on_a_terminal_it_shows_the_oscilloscope_and_gives_the_terminal_back() {
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
