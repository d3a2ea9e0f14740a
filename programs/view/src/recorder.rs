//! The button that records an application, in a process of its own: the verb `jde record`. The recording is complete
//! whenever that process ends: by the button, with the application, or with these windows, however they end.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use eframe::egui::{self, RichText, Ui};
use jde_link::message::About;

use crate::player::last_lines;

/// How often the time that is shown changes, and the process is looked at.
const SHOWN_TIME_INTERVAL: Duration = Duration::from_millis(500);
/// How long the messages of a process that has ended are waited for. One that it started may keep their pipe open.
const MESSAGES_TIMEOUT: Duration = Duration::from_secs(2);
/// The greatest exit status with which `jde` reports a failure. Any other end is a crash.
const MAX_FAILURE_STATUS: i32 = 3;
/// What `jde record` says of a file that it could not write to its end.
const ENDS_TOO_SOON: &str = " ends too soon: ";
/// What is recorded, in words.
const WHAT: &str = "Records every variable, selection and event from now on, and of the time before the newest 1000 \
    selections, states and events. The values of the minute before are not kept: for those, start the application with \
    jde run APP --record drive.mcap --when conflict.";

/// Starts and ends recordings.
pub(crate) struct Recorder {
    /// The program and its arguments before `--app NAME FILE`. Without one, there is no button.
    program: Vec<OsString>,
    /// Where the recordings are written.
    folder: PathBuf,
    running: Option<Running>,
    /// How the last recording ended: its file, or why there is none.
    last: Option<Result<PathBuf, String>>,
}

/// A recording under way.
struct Running {
    child: Child,
    /// Its end ends the recording.
    input: Option<ChildStdin>,
    messages: Option<JoinHandle<String>>,
    file: PathBuf,
    since: Instant,
    /// When the process was found to have ended.
    ended: Option<Instant>,
}

impl Recorder {
    pub(crate) fn new(program: Vec<OsString>, folder: PathBuf) -> Self {
        Self {
            program,
            folder,
            running: None,
            last: None,
        }
    }

    /// Draws the button, and how the recording stands.
    pub(crate) fn show(&mut self, ui: &mut Ui, about: &About, is_over: bool) {
        self.poll();
        let Some(running) = &mut self.running else {
            if !self.program.is_empty() && !is_over && ui.button("Record").on_hover_text(WHAT).clicked() {
                self.last = self.start(about).err().map(Err);
            }
            match &self.last {
                Some(Ok(file)) => {
                    let text = format!("recorded in {}", name(file));
                    ui.label(text).on_hover_text(file.display().to_string());
                }
                Some(Err(reason)) => {
                    let text = RichText::new(headline(reason)).color(ui.visuals().error_fg_color);
                    ui.add(egui::Label::new(text).truncate()).on_hover_text(reason);
                }
                None => {}
            }
            return;
        };
        ui.ctx().request_repaint_after(SHOWN_TIME_INTERVAL);
        if running.input.is_none() {
            ui.label(format!("writing {}", name(&running.file)));
            return;
        }
        if ui
            .button("Stop recording")
            .on_hover_text("Completes the file.")
            .clicked()
        {
            running.input = None;
        }
        let text = format!(
            "{} s in {}",
            running.since.elapsed().as_secs(),
            name(&running.file)
        );
        ui.label(text).on_hover_text(running.file.display().to_string());
    }

    /// Starts a recording of an application.
    fn start(&mut self, about: &About) -> Result<(), String> {
        let [program, arguments @ ..] = self.program.as_slice() else {
            return Err("no program that records is configured".to_owned());
        };
        let file = unused(&self.folder, &about.name);
        let mut child = Command::new(program)
            .args(arguments)
            .arg("--app")
            .arg(format!("{}@{}", about.name, about.id))
            .arg(&file)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{} cannot be started: {error}", program.display()))?;
        let messages = child.stderr.take();
        self.running = Some(Running {
            input: child.stdin.take(),
            messages: messages.map(|messages| thread::spawn(move || last_lines(messages))),
            child,
            file,
            since: Instant::now(),
            ended: None,
        });
        Ok(())
    }

    /// Notes the end of the process, once its messages are read.
    fn poll(&mut self) {
        let Some(running) = &mut self.running else {
            return;
        };
        let Ok(Some(status)) = running.child.try_wait() else {
            return;
        };
        let ended = *running.ended.get_or_insert_with(Instant::now);
        let is_read = running.messages.as_ref().is_none_or(JoinHandle::is_finished);
        if !is_read && ended.elapsed() < MESSAGES_TIMEOUT {
            return;
        }
        let Some(running) = self.running.take() else {
            return;
        };
        let messages = running.messages.filter(|_| is_read);
        let messages = messages.and_then(|messages| messages.join().ok());
        self.last = Some(outcome(status, &messages.unwrap_or_default(), running.file));
    }
}

/// Returns the file of a recording whose process has ended, or why it is not complete. The file may be another's that
/// appeared meanwhile, so its existence says nothing.
fn outcome(status: ExitStatus, messages: &str, file: PathBuf) -> Result<PathBuf, String> {
    if status.success() {
        return Ok(file);
    }
    let is_failure = status
        .code()
        .is_some_and(|code| (1..=MAX_FAILURE_STATUS).contains(&code));
    if is_failure && messages.contains(ENDS_TOO_SOON) {
        return Err(format!("{messages}\nrecorded in {}, incomplete", name(&file)));
    }
    if is_failure && !messages.is_empty() {
        return Err(messages.to_owned());
    }
    let reason = format!("{} was not recorded completely: {status}", file.display());
    Err(format!("{messages}\n{reason}").trim().to_owned())
}

/// Returns the line of a message that says what is wrong. An advice may follow it.
fn headline(message: &str) -> &str {
    let mut lines = message.lines().rev();
    let headline = lines.find(|line| !line.trim_start().starts_with("help: "));
    headline.unwrap_or_default()
}

/// The first file of a name that does not exist. The program refuses to overwrite one that appears meanwhile.
fn unused(folder: &Path, name: &str) -> PathBuf {
    let is_safe = |letter: char| letter.is_alphanumeric() || "-_".contains(letter);
    let name: String = name
        .chars()
        .map(|letter| if is_safe(letter) { letter } else { '-' })
        .collect();
    let mut files = (1_u64..).map(|number| folder.join(format!("{name}-{number}.mcap")));
    files
        .find(|file| !file.exists())
        .unwrap_or_else(|| folder.join(name))
}

fn name(file: &Path) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str());
    name.to_string_lossy().into_owned()
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::process::ExitStatusExt;

    use super::*;

    /// The outcome for an exit status, as its headline.
    fn reason(code: i32, messages: &str) -> String {
        let ended = outcome(
            ExitStatus::from_raw(code << 8),
            messages,
            PathBuf::from("drive-1.mcap"),
        );
        headline(&ended.expect_err("the recording failed")).to_owned()
    }

    #[test]
    fn only_a_file_that_the_recorder_could_not_end_is_recorded_incompletely() {
        let full = "error: drive-1.mcap ends too soon: no space is left";
        assert_eq!(reason(1, full), "recorded in drive-1.mcap, incomplete");
        let taken = "error: drive-1.mcap exists already\n  help: give the recording another name";
        assert_eq!(reason(2, taken), "error: drive-1.mcap exists already");
        let crashed = reason(101, "thread 'main' panicked");
        assert!(
            crashed.starts_with("drive-1.mcap was not recorded completely: "),
            "{crashed}"
        );
        let killed = outcome(ExitStatus::from_raw(9), "", PathBuf::from("drive-1.mcap"));
        assert!(killed.is_err_and(|reason| reason.contains("signal: 9")));
    }
}
