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
#[cfg(feature = "tools")]
use jde_log::ReadError;

use crate::escape::{escape, escape_lines};
use crate::terminal::{self, BAD, TITLE, WARN, own_styles};

/// The most faults that are shown at once.
const MAX_SHOWN: usize = 40;

/// The advice when plugins are missing. The faults themselves name the plugins and the searched folders.
const MISSING_PLUGIN_HELP: &str = "Plugins are built by `cargo build` in their folder. All that come with jde are in its packages, and are built by\n\
    `cargo build --workspace` in its checkout; `cargo install` brings none. `jde plugins` shows those that are found, and\n\
    JDE_PLUGIN_PATH names more folders.\n";

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// Wrong use of the command line.
    #[error("{message}")]
    Usage {
        /// The error.
        message: String,
        /// The advice.
        help: String,
    },
    /// The application's file has faults.
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
    /// A replay made other decisions than the recording. The report has listed them.
    #[error("not every selection is as it was")]
    Mismatch,
    /// A takeover took longer than its contract allows. The summary has shown it.
    #[error("a takeover took longer than its contract allows")]
    Contract,
    /// A plugin breaks a promise. The list of checks has shown it.
    #[error("not every promise is kept")]
    Promise,
    /// The verb could not continue.
    #[error("{0}")]
    Broken(String),
    /// A reload failed: the schemas keep running their previous builds.
    #[error("{0}")]
    NotReloaded(String),
    /// The requested event did not occur.
    #[error("{0}")]
    NoMatch(String),
    /// A recording cannot be read.
    #[cfg(feature = "tools")]
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// A running application could not be reached, or refused the request.
    #[cfg(feature = "tools")]
    #[error(transparent)]
    Link(#[from] jde_link::Error),
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
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Usage {
            message: message.into(),
            help: help.into(),
        }
    }

    /// Returns wrong use because of an unknown name. The advice is the nearest known name, or all of them.
    pub(crate) fn unknown<'n>(what: &str, name: &str, known: impl Iterator<Item = &'n str> + Clone) -> Self {
        let help = match jde_board::nearest(name, known.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are: {}", known.collect::<Vec<_>>().join(", ")),
        };
        Self::usage(format!("there is no {what} `{name}`"), help)
    }

    /// Returns faults of an application that do not concern its plugins.
    pub(crate) fn application(faults: Faults) -> Self {
        Self::Application {
            faults,
            unusable: false,
            missing: false,
            skipped_folders: Vec::new(),
        }
    }

    /// Converts I/O errors of a file.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |error| Self::File { path, error }
    }

    /// Whether the reader closed the pipe of the output. This is no failure.
    pub(crate) fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == ErrorKind::BrokenPipe)
    }

    /// Prints the failure on standard error. Returns the exit status: 1 for a run that failed, 2 for wrong
    /// use or a wrong application file, 3 for a plugin, 0 if the reader closed the pipe.
    pub(crate) fn report(&self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::SUCCESS;
        }
        let text = self.render();
        // If standard error is closed, there is no place left to report to.
        let _ = terminal::err().write_all(text.as_bytes());
        ExitCode::from(self.status())
    }

    fn status(&self) -> u8 {
        match self {
            Self::Mission
            | Self::Mismatch
            | Self::Contract
            | Self::Promise
            | Self::Broken(_)
            | Self::NotReloaded(_)
            | Self::NoMatch(_)
            | Self::File { .. }
            | Self::Output(_) => 1,
            Self::Start(StartError::Thread(_) | StartError::HookFailed(_)) => 1,
            #[cfg(feature = "tools")]
            Self::Link(error) => link_status(error),
            #[cfg(feature = "tools")]
            Self::Recording(_) => 2,
            Self::Usage { .. } | Self::Application { unusable: false, .. } => 2,
            Self::Start(StartError::Wiring(_) | StartError::NoProgram(_) | StartError::Mock { .. }) => 2,
            Self::Plugin(_) | Self::Application { unusable: true, .. } => 3,
            Self::Start(StartError::Create { .. } | StartError::MissingPlugin(_)) => 3,
        }
    }

    fn render(&self) -> String {
        match self {
            Self::Mission | Self::Mismatch | Self::Contract | Self::Promise => String::new(),
            Self::Application {
                faults,
                missing,
                skipped_folders: skipped,
                ..
            } => {
                let advice = if *missing { MISSING_PLUGIN_HELP } else { "" };
                let more = match skipped.as_slice() {
                    [_, ..] if *missing => describe_skipped_folders(skipped) + "\n",
                    _ => String::new(),
                };
                render_faults(faults, Severity::Error) + advice + &more
            }
            Self::Usage { message, help } => render_error(message, Some(help)),
            Self::Plugin(PluginError::Missing { name, folders }) => render_error(
                &format!("there is no plugin `{name}`"),
                Some(&format!(
                    "build it, or add its folder to JDE_PLUGIN_PATH; searched: {}",
                    folders.join(", ")
                )),
            ),
            Self::Plugin(_) | Self::Start(_) | Self::Broken(_) | Self::NotReloaded(_) => {
                render_error(&self.to_string(), None)
            }
            Self::NoMatch(_) | Self::File { .. } | Self::Output(_) => {
                render_error(&escape(&self.to_string()), None)
            }
            #[cfg(feature = "tools")]
            Self::Recording(_) | Self::Link(_) => render_error(&escape(&self.to_string()), None),
        }
    }
}

/// Returns 2 for errors that another command line or setting can fix, and 1 for all others.
#[cfg(feature = "tools")]
fn link_status(error: &jde_link::Error) -> u8 {
    use jde_link::Error;
    match error {
        Error::Name(_)
        | Error::NameTaken { .. }
        | Error::Insecure { .. }
        | Error::Unproven { .. }
        | Error::PlainPassword { .. }
        | Error::Password { .. }
        | Error::Setting { .. }
        | Error::Ambiguous(_)
        | Error::UnknownApplication { .. }
        | Error::Refused { .. } => 2,
        Error::Folder { .. }
        | Error::Listen { .. }
        | Error::Open(_)
        | Error::Connect { .. }
        | Error::NoApplication(_)
        | Error::NotFound { .. }
        | Error::OnlyRecordings
        | Error::Version { .. }
        | Error::Disconnected(_)
        | Error::Timeout { .. }
        | Error::Garbled { .. }
        | Error::Nonsense { .. }
        | Error::Unanswered(_)
        | Error::Several(_)
        | Error::Thread(_) => 1,
    }
}

/// Whether the fault ends the verb.
#[derive(Clone, Copy)]
enum Severity {
    Error,
    Warning,
}

/// Prints what is absent at present as warnings on standard error.
pub(crate) fn warn(concerns: &Faults) {
    // If standard error is closed, there is no place left to report to.
    let _ = terminal::err().write_all(render_faults(concerns, Severity::Warning).as_bytes());
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
pub(crate) fn describe_skipped_folders(skipped: &[PathBuf]) -> String {
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
        text += &render_fault(fault, label);
        text.push('\n');
    }
    if let more @ 1.. = faults.count().saturating_sub(MAX_SHOWN) {
        let _ = writeln!(text, "and {more} more");
    }
    text
}

/// The largest file of which a line is shown, bytes: none that has faults is larger.
const MAX_SOURCE: u64 = 4 << 20;

/// A fault with its source line, in the form that compilers use.
fn render_fault(fault: &Fault, label: Severity) -> String {
    let help = fault.help.as_deref();
    match &fault.location {
        FaultLocation::Text {
            file,
            line,
            column,
            span,
        } => {
            let shown = escape(&display_path(file));
            let source = jde_files::read(file, MAX_SOURCE).ok();
            let source = source.and_then(|source| String::from_utf8(source).ok());
            let text = source
                .as_deref()
                .and_then(|source| line_around(source, span.start));
            let Some((start, text)) = text else {
                return render_message(
                    label,
                    &format!("{shown}:{line}:{column}: {}", fault.message),
                    help,
                );
            };
            let end = span.end.clamp(span.start, start + text.len());
            let snippet = Snippet::source(hide_controls(text))
                .path(shown)
                .line_start(*line)
                .annotation(AnnotationKind::Primary.span(span.start - start..end - start));
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
        FaultLocation::File(file) => render_message(
            label,
            &format!("{}: {}", escape(&display_path(file)), fault.message),
            help,
        ),
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

/// Returns the line of `source` that contains byte `at`, with its start. `None` if the file has changed
/// since.
fn line_around(source: &str, at: usize) -> Option<(usize, &str)> {
    let before = source.get(..at)?;
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let rest = &source[start..];
    Some((start, rest.lines().next().unwrap_or_default()))
}

/// A path as the user would write it: relative if it is below the working directory, and without `..` inside.
pub(crate) fn display_path(path: &Path) -> String {
    let winding = path.components().skip(1).any(|part| part == Component::ParentDir);
    let straight = winding.then(|| path.canonicalize().ok()).flatten();
    let path = straight.as_deref().unwrap_or(path);
    let relative = std::env::current_dir()
        .ok()
        .and_then(|folder| Some(path.strip_prefix(folder).ok()?.display().to_string()));
    relative.unwrap_or_else(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::line_around;

    #[test]
    fn a_fault_is_shown_with_its_line() {
        assert_eq!(line_around("one\ntwo\nthree", 5), Some((4, "two")));
        assert_eq!(line_around("one\n", 0), Some((0, "one")));
        assert_eq!(line_around("one\n", 4), Some((4, "")));
        assert_eq!(line_around("one\r\ntwo", 1), Some((0, "one")));
    }

    #[test]
    fn a_file_that_has_become_shorter_has_no_line_shown() {
        assert_eq!(line_around("one", 7), None);
    }
}
