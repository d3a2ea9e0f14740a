//! The errors of all verbs, their messages, and their exit status.

use std::fmt::Write as _;
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use jde_app::{Fault, FaultLocation, Faults};
use jde_files::is_control;
use jde_host::StartError;
use jde_loader::PluginError;
use jde_terminal::escape::{escape, escape_lines};
use jde_terminal::{self as terminal, BAD, TITLE, WARN, own_styles};

/// The most faults that are shown at once.
const MAX_SHOWN: usize = 40;

/// The most names that are listed in place of an unknown one.
const MAX_NAMES: usize = 20;

/// The advice when plugins are missing. The faults themselves name the plugins and the searched folders.
const MISSING_PLUGIN_HELP: &str = "Plugins are built by `cargo build` in their folder. All that come with jde are in its packages, and are built by\n\
    `cargo build --workspace` in its checkout; `cargo install` brings none. `jde plugins` shows those that are found, and\n\
    JDE_PLUGIN_PATH names more folders.\n";

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Wrong use of the command line.
    #[error("{message}")]
    Usage {
        /// The error.
        message: String,
        /// The advice.
        help: String,
    },
    /// The application's file has faults, or another file that a person wrote.
    #[error("{faults}")]
    Application {
        /// All faults.
        faults: Faults,
        /// Whether the file of a plugin exists and cannot be used.
        unusable: bool,
        /// Whether a plugin does not exist.
        missing: bool,
        /// Folders that were not searched because only a recording names them.
        skipped_folders: Vec<PathBuf>,
    },
    /// A plugin cannot be used.
    #[error(transparent)]
    Plugin(#[from] PluginError),
    /// The application did not start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The application ran and did not fulfil its mission. The summary has reported this.
    #[error("the mission was not fulfilled")]
    Mission,
    /// A takeover took longer than its contract allows. The summary has shown it.
    #[error("a takeover took longer than its contract allows")]
    Contract,
    /// A schema faulted. The summary has shown it.
    #[error("a schema faulted")]
    Fault,
    /// The verb could not continue.
    #[error("{0}")]
    Broken(String),
    /// A file could not be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// The output could not be written.
    #[error("cannot write the output: {0}")]
    Output(#[from] io::Error),
}

impl Failure {
    /// Returns wrong use with an error and an advice.
    pub fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Usage {
            message: message.into(),
            help: help.into(),
        }
    }

    /// Returns wrong use because of an unknown name. The advice is the nearest known name, or the first of them.
    pub fn unknown<'n>(what: &str, name: &str, known: impl Iterator<Item = &'n str> + Clone) -> Self {
        let help = match jde_nearest::nearest(name, known.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are: {}", list(known)),
        };
        Self::usage(format!("there is no {what} `{name}`"), help)
    }

    /// Returns faults of a file that do not concern plugins.
    pub fn faults(faults: Faults) -> Self {
        Self::Application {
            faults,
            unusable: false,
            missing: false,
            skipped_folders: Vec::new(),
        }
    }

    /// Converts I/O errors of a file.
    pub fn file(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |error| Self::File { path, error }
    }

    /// Whether the reader closed the pipe of the output. This is no failure.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == ErrorKind::BrokenPipe)
    }

    /// Prints the failure on standard error. Returns the exit status: 1 for a run that failed, 2 for wrong
    /// use or a wrong application file, 3 for a plugin, 0 if the reader closed the pipe.
    pub fn report(&self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::SUCCESS;
        }
        print(&self.render());
        ExitCode::from(self.status())
    }

    fn status(&self) -> u8 {
        match self {
            Self::Mission
            | Self::Contract
            | Self::Fault
            | Self::Broken(_)
            | Self::File { .. }
            | Self::Output(_) => 1,
            Self::Start(StartError::Thread(_) | StartError::HookFailed(_)) => 1,
            Self::Usage { .. } | Self::Application { unusable: false, .. } => 2,
            Self::Start(StartError::Wiring(_) | StartError::NoProgram(_) | StartError::Mock { .. }) => 2,
            Self::Plugin(_) | Self::Application { unusable: true, .. } => 3,
            Self::Start(StartError::Create { .. } | StartError::MissingPlugin(_)) => 3,
        }
    }

    fn render(&self) -> String {
        match self {
            Self::Mission | Self::Contract | Self::Fault => String::new(),
            Self::Application {
                faults,
                missing,
                skipped_folders: skipped,
                ..
            } => {
                let advice = match *missing {
                    true => format!("\n{MISSING_PLUGIN_HELP}"),
                    false => String::new(),
                };
                let more = match skipped.as_slice() {
                    [_, ..] if *missing => describe_skipped_folders(skipped) + "\n",
                    _ => String::new(),
                };
                render_faults(faults, Severity::Error) + &advice + &more
            }
            Self::Usage { message, help } => render_error(message, Some(help)),
            Self::Plugin(PluginError::Missing { name, folders }) => render_error(
                &format!("there is no plugin `{name}`"),
                Some(&format!(
                    "build it, or add its folder to JDE_PLUGIN_PATH; searched: {}",
                    folders.join(", ")
                )),
            ),
            Self::Plugin(_) | Self::Start(_) | Self::Broken(_) => render_error(&self.to_string(), None),
            Self::File { .. } | Self::Output(_) => render_error(&escape(&self.to_string()), None),
        }
    }
}

/// Lists names, at most so many that a person reads them.
pub(crate) fn list<'n>(names: impl Iterator<Item = &'n str>) -> String {
    let mut names: Vec<_> = names.collect();
    let more = names.len().saturating_sub(MAX_NAMES);
    names.truncate(MAX_NAMES);
    let list = names.join(", ");
    if more == 0 {
        list
    } else {
        format!("{list} and {more} more")
    }
}

/// Whether the fault ends the verb.
#[derive(Clone, Copy)]
enum Severity {
    Error,
    Warning,
}

/// Prints what is absent at present as warnings on standard error.
pub fn warn(concerns: &Faults) {
    print(&render_faults(concerns, Severity::Warning));
}

/// Prints an error on standard error.
pub fn print_error(message: &str) {
    print(&render_error(message, None));
}

fn print(text: &str) {
    // If standard error is closed, there is no place left to report to.
    let _ = terminal::err().write_all(text.as_bytes());
}

fn render_error(message: &str, help: Option<&str>) -> String {
    render_message(Severity::Error, message, help)
}

fn render_message(label: Severity, message: &str, help: Option<&str>) -> String {
    let (style, label) = match label {
        Severity::Error => (BAD, "error"),
        Severity::Warning => (WARN, "warning"),
    };
    let message = escape_lines(message);
    let mut text = format!("{style}{label}{style:#}{TITLE}: {message}{TITLE:#}\n");
    if let Some(help) = help {
        text += &format!("  {TITLE}help{TITLE:#}: {}\n", escape_lines(help));
    }
    text
}

/// Describes the folders that were not searched for plugins, and the option that searches them.
pub fn describe_skipped_folders(skipped: &[PathBuf]) -> String {
    let folders: Vec<_> = skipped
        .iter()
        .map(|folder| escape(&display_path(folder)))
        .collect();
    format!(
        "plugins were not searched for in {}, which the recording names: plugins run with your rights; --trust searches there too",
        folders.join(", ")
    )
}

fn render_faults(faults: &Faults, label: Severity) -> String {
    let mut text = String::new();
    let list = faults.list();
    for fault in list.iter().take(MAX_SHOWN) {
        if !text.is_empty() {
            text.push('\n');
        }
        text += &render_fault(fault, label);
    }
    if let more @ 1.. = faults.count().saturating_sub(MAX_SHOWN) {
        let _ = writeln!(text, "\nand {more} more");
    }
    text
}

/// A fault with its source line, in the form that compilers use.
fn render_fault(fault: &Fault, label: Severity) -> String {
    let help = fault.help.as_deref();
    match &fault.location {
        // A column of a part of a long line would be another one.
        FaultLocation::Text { column, excerpt, .. }
            if *column != excerpt.text[..excerpt.marked.start].chars().count() + 1 =>
        {
            let place = escape(&fault.location.to_string());
            render_message(label, &format!("{place}: {}", fault.message), help)
        }
        FaultLocation::Text {
            file, line, excerpt, ..
        } => {
            let snippet = Snippet::source(hide_controls(&excerpt.text))
                .path(escape(&display_path(file)))
                .line_start(*line)
                .annotation(AnnotationKind::Primary.span(excerpt.marked.clone()));
            let level = match label {
                Severity::Error => Level::ERROR,
                Severity::Warning => Level::WARNING,
            };
            let mut group = level.primary_title(escape_lines(&fault.message)).element(snippet);
            if let Some(help) = help {
                group = group.element(Level::HELP.message(escape_lines(help)));
            }
            own_styles(&Renderer::styled().render(&[group])) + "\n"
        }
        FaultLocation::File(file) | FaultLocation::Line { file, .. } => {
            let line = fault.line().map_or(String::new(), |line| format!(":{line}"));
            let place = escape(&display_path(file)) + &line;
            render_message(label, &format!("{place}: {}", fault.message), help)
        }
        FaultLocation::Option(option) => render_message(label, &format!("{option}: {}", fault.message), help),
    }
}

/// Replaces characters that control a terminal by others of as many bytes, so that all places in the text remain.
fn hide_controls(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        match (is_control(letter) && letter != '\t', letter.len_utf8()) {
            (false, _) => shown.push(letter),
            (true, 1) => shown.push('?'),
            (true, 2) => shown.push('·'),
            (true, 3) => shown.push('\u{fffd}'),
            (true, _) => shown += "?\u{fffd}",
        }
    }
    shown
}

/// A path as the user would write it: relative if it is below the working directory, and without `..` inside.
pub fn display_path(path: &Path) -> String {
    let winding = path.components().skip(1).any(|part| part == Component::ParentDir);
    let straight = winding.then(|| path.canonicalize().ok()).flatten();
    let path = straight.as_deref().unwrap_or(path);
    let relative = std::env::current_dir()
        .ok()
        .and_then(|folder| Some(path.strip_prefix(folder).ok()?.display().to_string()));
    match relative {
        Some(itself) if itself.is_empty() => ".".to_owned(),
        Some(below) => below,
        None => path.display().to_string(),
    }
}
