//! A terminal that `script` of util-linux creates, and what a program shows on it.

use std::io::{Read as _, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::attached::Sandbox;
use crate::support::plugins;

/// The sequences that enter and leave the alternate screen of a terminal.
pub(crate) const ENTER: &str = "\u{1b}[?1049h";
pub(crate) const LEAVE: &str = "\u{1b}[?1049l";

/// A terminal on which a command of the shell runs. The watchdog of its [`Sandbox`] ends each wait.
pub(crate) struct Terminal {
    script: Child,
    keys: ChildStdin,
    screen: ChildStdout,
    shown: String,
}

impl Terminal {
    /// Starts a command on a terminal of some rows and columns.
    pub(crate) fn start(sandbox: &Sandbox, [rows, columns]: [u16; 2], command: &str) -> Self {
        let command = format!("stty rows {rows} cols {columns}; {command}");
        let mut script = Command::new("script");
        script
            .args(["-qec", &command, "/dev/null"])
            .env("JDE_PLUGIN_PATH", plugins())
            .env("TERM", "xterm-256color")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut script = sandbox
            .command(script)
            .spawn()
            .expect("script of util-linux is installed");
        let (keys, screen) = (script.stdin.take(), script.stdout.take());
        Self {
            script,
            keys: keys.expect("it is piped"),
            screen: screen.expect("it is piped"),
            shown: String::new(),
        }
    }

    /// Waits for more. Returns all that was shown, or `None` at the end.
    pub(crate) fn more(&mut self) -> Option<&str> {
        let mut buffer = [0; 4096];
        let length = self.screen.read(&mut buffer).expect("the terminal is read");
        // A letter may be cut; the tests look for others.
        self.shown += &String::from_utf8_lossy(&buffer[..length]);
        (length > 0).then_some(&*self.shown)
    }

    /// Waits until what was shown is as expected.
    pub(crate) fn wait_for(&mut self, mut is_expected: impl FnMut(&str) -> bool) {
        while !is_expected(&self.shown) {
            assert!(self.more().is_some(), "it ended: {}", self.shown);
        }
    }

    /// Types keys.
    pub(crate) fn type_keys(&mut self, keys: &[u8]) {
        self.keys.write_all(keys).expect("the terminal takes keys");
    }

    /// Waits for the end. Returns the exit status and all that was shown.
    pub(crate) fn finish(mut self) -> (Option<i32>, String) {
        while self.more().is_some() {}
        let status = self.script.wait().expect("it ended");
        (status.code(), self.shown)
    }
}
