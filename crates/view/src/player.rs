//! A recording that plays for these windows: a process of its own, which serves it over the link as if its application ran. It
//! ends with the windows.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use jde_link::{Client, Folder, Reach, Remote};

/// How long a recording may take until it can be looked into; long ones are read whole first.
const BEGIN: Duration = Duration::from_secs(600);
/// Between two looks whether it can be.
const LOOK: Duration = Duration::from_millis(100);

/// A recording that plays.
pub(crate) struct Player {
    child: Child,
    file: PathBuf,
}

impl Player {
    /// Starts it, and waits until it can be looked into: not for the window's thread.
    ///
    /// # Errors
    /// Why it cannot be played, in words of the program that plays it.
    pub(crate) fn start(program: &[String], file: &Path) -> Result<(Self, Remote), String> {
        let [program, arguments @ ..] = program else {
            return Err("nothing here plays recordings".to_owned());
        };
        let name = format!("view-{}", std::process::id());
        let child = Command::new(program)
            .args(arguments)
            .arg("--name")
            .arg(&name)
            .arg(file)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{program} cannot be started: {error}"))?;
        let mut player = Self {
            child,
            file: file.to_owned(),
        };
        let reach = Reach::Local(Folder::of_user());
        let begun = Instant::now();
        while begun.elapsed() < BEGIN {
            if let Some(words) = player.ended() {
                return Err(words);
            }
            let client = Client::connect(&reach).map_err(|error| error.to_string())?;
            if let Ok(remote) = client.application(Some(&name)) {
                return Ok((player, remote));
            }
            std::thread::sleep(LOOK);
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
        let mut words = String::new();
        if let Some(mut said) = self.child.stderr.take() {
            let _ = said.read_to_string(&mut words);
        }
        let words = words.trim();
        Some(if words.is_empty() {
            format!("{} was not played: {status}", self.file.display())
        } else {
            words.to_owned()
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
