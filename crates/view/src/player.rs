//! A recording that plays for these windows: a process of its own, which serves it over the link as if its application ran. It
//! ends with the windows, however they end.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use jde_link::{Client, Folders, Reach, Remote};

/// How long a recording may take until it can be looked into; long ones are read whole first.
const BEGIN: Duration = Duration::from_secs(600);
/// Between two looks whether it can be.
const LOOK: Duration = Duration::from_millis(100);
/// Lines of what it said that are kept.
const LAST: usize = 20;

/// A recording that plays.
pub(crate) struct Player {
    /// It ends at the end of its standard input, which is open for as long as this process lives.
    child: Child,
    /// Hears what it says, so that it never waits for that; answers with the last of it.
    words: Option<JoinHandle<String>>,
    file: PathBuf,
}

impl Player {
    /// Starts it, and waits until it can be looked into or nobody wants that any more: not for the window's thread.
    ///
    /// # Errors
    /// Why it cannot be played, in words of the program that plays it.
    pub(crate) fn start(
        program: &[OsString],
        file: &Path,
        cancelled: &AtomicBool,
    ) -> Result<(Self, Remote), String> {
        // Of this process each has a name of its own.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let [program, arguments @ ..] = program else {
            return Err("nothing here plays recordings".to_owned());
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
        let said = child.stderr.take();
        let mut player = Self {
            words: said.map(|said| thread::spawn(move || last_words(said))),
            child,
            file: file.to_owned(),
        };
        let reach = Reach::Local(Folders::of_user());
        let begun = Instant::now();
        while begun.elapsed() < BEGIN {
            if let Some(words) = player.ended() {
                return Err(words);
            }
            if cancelled.load(Ordering::Relaxed) {
                return Err(format!("{} was not opened", file.display()));
            }
            let client = Client::connect(&reach).map_err(|error| error.to_string())?;
            if let Ok(remote) = client.application(Some(&name)) {
                return Ok((player, remote));
            }
            thread::sleep(LOOK);
        }
        Err(format!(
            "{} cannot be looked into after {} s",
            file.display(),
            BEGIN.as_secs()
        ))
    }

    /// The recording.
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    /// Its last words, if it has ended.
    fn ended(&mut self) -> Option<String> {
        let status = self.child.try_wait().ok()??;
        let words = self.words.take().and_then(|words| words.join().ok());
        Some(match words {
            Some(words) if !words.is_empty() => words,
            _ => format!("{} was not played: {status}", self.file.display()),
        })
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        // It drives nothing, so nothing has to be ended in order.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Reads to the end; answers with the last lines.
fn last_words(said: ChildStderr) -> String {
    let mut last = VecDeque::new();
    for line in BufReader::new(said).split(b'\n').map_while(Result::ok) {
        if last.len() == LAST {
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
    fn the_last_words_of_one_that_says_much_and_fails_are_told() {
        // More than a pipe holds: if nobody read it, this would not end.
        let program = shell("seq 100000 >&2; echo 'it is no recording' >&2; exit 2");
        let came = Player::start(&program, Path::new("x.mcap"), &AtomicBool::new(false));
        let words = came.err().expect("it does not play");
        assert_eq!(words.lines().count(), LAST);
        assert!(words.ends_with("100000\nit is no recording"), "{words}");
        let silent = Player::start(&shell("exit 3"), Path::new("x.mcap"), &AtomicBool::new(false));
        assert!(silent.is_err_and(|words| words.starts_with("x.mcap was not played: exit status: 3")));
    }

    #[test]
    fn one_that_nobody_waits_for_any_more_is_ended() {
        let folder = tempfile::tempdir().expect("a folder");
        let ended = folder.path().join("ended");
        // `cat` ends with its input, and by nothing else.
        let program = shell(&format!("cat; touch {}", ended.display()));
        let came = Player::start(&program, Path::new("x.mcap"), &AtomicBool::new(true));
        assert!(came.is_err_and(|words| words == "x.mcap was not opened"));
        assert!(!ended.exists(), "it was killed");
    }
}
