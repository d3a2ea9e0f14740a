//! The button that records an application, in a process of its own: the verb `jde record`. The recording is complete
//! whenever that process ends: by the button, with the application, or with these windows, however they end.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use eframe::egui::{self, RichText, Ui};
use jde_link::message::About;

use crate::player::last_lines;

/// How often the time that is shown changes, and the process is looked at.
const SHOWN_TIME_INTERVAL: Duration = Duration::from_millis(500);
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
                    let first = reason.lines().last().unwrap_or_default();
                    let text = RichText::new(first).color(ui.visuals().error_fg_color);
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
        });
        Ok(())
    }

    /// Notes the end of the process.
    fn poll(&mut self) {
        let ended = |running: &mut Running| running.child.try_wait().ok().flatten();
        let Some(status) = self.running.as_mut().and_then(ended) else {
            return;
        };
        let Some(running) = self.running.take() else {
            return;
        };
        let messages = running.messages.and_then(|messages| messages.join().ok());
        self.last = Some(match (status.success(), messages) {
            (true, _) => Ok(running.file),
            // Values that were lost on their way make a recording incomplete, but do not end it.
            (false, Some(messages)) if running.file.exists() => Err(format!(
                "{messages}\nrecorded in {}, incomplete",
                name(&running.file)
            )),
            (false, Some(messages)) if !messages.is_empty() => Err(messages),
            (false, _) => Err(format!("{} was not recorded: {status}", running.file.display())),
        });
    }
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
