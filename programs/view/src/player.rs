//! Plays a recording for these windows, in a separate process that serves it over the link as if its
//! application ran. The process ends with the windows, however they end.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use jde_link::{Client, Folders, Reach, Remote};

/// Longest time until a client can connect to a recording. The player reads a long recording completely
/// first.
const START_TIMEOUT: Duration = Duration::from_secs(600);
/// Pause between two attempts to connect.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// How many of the last lines of the player's standard error are kept.
const KEPT_LINES: usize = 20;

/// A recording that plays.
pub(crate) struct Player {
    /// Ends at the end of its standard input, which stays open for as long as this process lives.
    child: Child,
    /// Reads its standard error, so that the player never blocks on a full pipe. Returns the last lines.
    messages: Option<JoinHandle<String>>,
    file: PathBuf,
}

impl Player {
    /// Starts the player and waits until a client can connect to it or `cancelled` is set. Blocks: not for
    /// the window's thread.
    ///
    /// # Errors
    /// Why the recording cannot be played: the player's own error message if it ended.
    pub(crate) fn start(
        program: &[OsString],
        file: &Path,
        cancelled: &AtomicBool,
    ) -> Result<(Self, Remote), String> {
        // Gives each player of this process a unique name.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let [program, arguments @ ..] = program else {
            return Err("no player for recordings is configured".to_owned());
        };
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("view-{}-{count}", std::process::id());
        let mut child = Command::new(program)
            .args(arguments)
            .arg("--name")
            .arg(&name)
            .arg(file)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{} cannot be started: {error}", program.display()))?;
        let stderr = child.stderr.take();
        let mut player = Self {
            messages: stderr.map(|stderr| thread::spawn(move || last_lines(stderr))),
            child,
            file: file.to_owned(),
        };
        let reach = Reach::Local(Folders::of_user());
        let begun = Instant::now();
        while begun.elapsed() < START_TIMEOUT {
            if let Some(messages) = player.ended() {
                return Err(messages);
            }
            if cancelled.load(Ordering::Relaxed) {
                return Err(format!("{} was not opened", file.display()));
            }
            let client = Client::connect(&reach).map_err(|error| error.to_string())?;
            if let Ok(remote) = client.application(Some(&name)) {
                return Ok((player, remote));
            }
            thread::sleep(POLL_INTERVAL);
        }
        Err(format!(
            "{} cannot be opened after {} s",
            file.display(),
            START_TIMEOUT.as_secs()
        ))
    }

    /// The path of the recording.
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    /// Its last lines of standard error, or its exit status if it wrote none. `None` while it runs.
    fn ended(&mut self) -> Option<String> {
        let status = self.child.try_wait().ok()??;
        let messages = self.messages.take().and_then(|messages| messages.join().ok());
        Some(match messages {
            Some(messages) if !messages.is_empty() => messages,
            _ => format!("{} was not played: {status}", self.file.display()),
        })
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        // The player drives no hardware, so it needs no orderly shutdown.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Reads to the end of the stream. Returns the last [`KEPT_LINES`] lines.
pub(crate) fn last_lines(stderr: ChildStderr) -> String {
    let mut last = VecDeque::new();
    for line in BufReader::new(stderr).split(b'\n').map_while(Result::ok) {
        if last.len() == KEPT_LINES {
            last.pop_front();
        }
        last.push_back(String::from_utf8_lossy(&line).into_owned());
    }
    Vec::from(last).join("\n").trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Vec<OsString> {
        ["sh", "-c", script].map(OsString::from).to_vec()
    }

    #[test]
    fn the_last_lines_of_a_failed_player_are_reported() {
        // More than a pipe holds: the player would block if its standard error were not read.
        let program = shell("seq 100000 >&2; echo 'it is not a recording' >&2; exit 2");
        let result = Player::start(&program, Path::new("x.mcap"), &AtomicBool::new(false));
        let messages = result.err().expect("the player fails");
        assert_eq!(messages.lines().count(), KEPT_LINES);
        assert!(messages.ends_with("100000\nit is not a recording"), "{messages}");
        let silent = Player::start(&shell("exit 3"), Path::new("x.mcap"), &AtomicBool::new(false));
        assert!(silent.is_err_and(|messages| messages.starts_with("x.mcap was not played: exit status: 3")));
    }

    #[test]
    fn a_cancelled_player_is_killed() {
        let folder = tempfile::tempdir().expect("the folder is created");
        let ended = folder.path().join("ended");
        // `cat` ends only with its input.
        let program = shell(&format!("cat; touch {}", ended.display()));
        let result = Player::start(&program, Path::new("x.mcap"), &AtomicBool::new(true));
        assert!(result.is_err_and(|messages| messages == "x.mcap was not opened"));
        assert!(!ended.exists(), "the player was killed");
    }
}
