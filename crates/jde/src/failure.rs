//! Everything that can go wrong, what is said about it, and the exit status it has.

use std::fmt::Write as _;
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use jde_host::StartError;
use jde_host::app::{Fault, Faults, Place};
use jde_host::plugin::PluginError;
use jde_log::ReadError;

use crate::terminal::{self, BAD, TITLE, WARN};

/// Most faults that are shown; whoever has more mends these first.
const MOST_SHOWN: usize = 40;

/// What to do when plugins are missing; the faults themselves say which, and where they were looked for.
const HOW_TO_FIND: &str = "Plugins are built by `cargo build` in their folder, and all that come with jde by `cargo build` in its\n\
    checkout; `jde plugins` shows those that are found, and JDE_PLUGIN_PATH names more folders.\n";

/// Why a verb did not do what was asked.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// It was used wrongly.
    #[error("{message}")]
    Use {
        /// What is wrong.
        message: String,
        /// What to do.
        help: String,
    },
    /// The application file is wrong.
    #[error("{faults}")]
    Application {
        /// All that is wrong.
        faults: Faults,
        /// A plugin's file is there and cannot be used.
        unusable: bool,
        /// A plugin is not there.
        missing: bool,
        /// Folders in which none was looked for, because a recording names them.
        withheld: Vec<PathBuf>,
    },
    /// A plugin cannot be used.
    #[error(transparent)]
    Plugin(#[from] PluginError),
    /// The application did not start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// It ran, and its mission was not fulfilled; the summary has said so.
    #[error("the mission was not fulfilled")]
    Mission,
    /// A drive was decided otherwise this time; the report has said how.
    #[error("not every selection is as it was")]
    Different,
    /// It could not go on.
    #[error("{0}")]
    Broken(String),
    /// Schemas run on with the builds they had.
    #[error("{0}")]
    NotReloaded(String),
    /// What was asked for never happened.
    #[error("{0}")]
    Unanswered(String),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// A running application could not be reached, or refused.
    #[error(transparent)]
    Link(#[from] jde_link::Error),
    /// A file could not be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// What is said could not be said.
    #[error("cannot write the output: {0}")]
    Output(#[from] io::Error),
}

impl Failure {
    /// It was used wrongly, and what to do instead.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Use {
            message: message.into(),
            help: help.into(),
        }
    }

    /// A name that is none of those there are: the nearest is named, or all of them.
    pub(crate) fn unknown<'n>(what: &str, name: &str, known: impl Iterator<Item = &'n str> + Clone) -> Self {
        let help = match jde_board::nearest(name, known.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are: {}", known.collect::<Vec<_>>().join(", ")),
        };
        Self::usage(format!("there is no {what} `{name}`"), help)
    }

    /// What an application names is not there at present.
    pub(crate) fn missing(faults: Faults) -> Self {
        Self::Application {
            faults,
            unusable: false,
            missing: false,
            withheld: Vec::new(),
        }
    }

    /// For errors of a file.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |error| Self::File { path, error }
    }

    /// Whether the reader of a pipe went away, which is no failure.
    pub(crate) fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == ErrorKind::BrokenPipe)
    }

    /// Says it on standard error, and gives the exit status: 1 it ran and failed, 2 wrong use or application file, 3 a plugin.
    pub(crate) fn report(&self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::SUCCESS;
        }
        let words = self.words();
        // Whoever closed standard error does not want to hear of it.
        let _ = terminal::err().write_all(words.as_bytes());
        ExitCode::from(self.status())
    }

    fn status(&self) -> u8 {
        match self {
            Self::Mission
            | Self::Different
            | Self::Broken(_)
            | Self::NotReloaded(_)
            | Self::Unanswered(_)
            | Self::File { .. }
            | Self::Output(_) => 1,
            Self::Start(StartError::Thread(_) | StartError::Hindered(_)) => 1,
            Self::Link(error) => link_status(error),
            Self::Use { .. } | Self::Recording(_) | Self::Application { unusable: false, .. } => 2,
            Self::Start(StartError::Wiring(_) | StartError::NoProgram(_)) => 2,
            Self::Plugin(_) | Self::Application { unusable: true, .. } => 3,
            Self::Start(StartError::Create { .. } | StartError::OtherPlugins(_)) => 3,
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Mission | Self::Different => String::new(),
            Self::Application {
                faults,
                missing,
                withheld,
                ..
            } => {
                let how = if *missing { HOW_TO_FIND } else { "" };
                let more = match withheld.as_slice() {
                    [_, ..] if *missing => not_searched(withheld) + "\n",
                    _ => String::new(),
                };
                faults_in_words(faults, Tone::Error) + how + &more
            }
            Self::Use { message, help } => plain(message, Some(help)),
            Self::Plugin(PluginError::Missing { name, folders }) => plain(
                &format!("there is no plugin `{name}`"),
                Some(&format!(
                    "build it, or add its folder to JDE_PLUGIN_PATH; searched:\n          {}",
                    folders.join("\n          ")
                )),
            ),
            Self::Plugin(_)
            | Self::Start(_)
            | Self::Broken(_)
            | Self::NotReloaded(_)
            | Self::Unanswered(_)
            | Self::Recording(_)
            | Self::Link(_)
            | Self::File { .. }
            | Self::Output(_) => plain(&self.to_string(), None),
        }
    }
}

/// Wrong use is what can be mended by writing something else; the rest is how things are.
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
        | Error::Several(_)
        | Error::UnknownApplication { .. }
        | Error::Refused { .. } => 2,
        Error::Folder { .. }
        | Error::Listen { .. }
        | Error::Open(_)
        | Error::Connect { .. }
        | Error::NothingRuns(_)
        | Error::NotThere { .. }
        | Error::OnlyRecordings
        | Error::Version { .. }
        | Error::Gone(_)
        | Error::NoAnswer { .. }
        | Error::Garbled { .. }
        | Error::Thread(_) => 1,
    }
}

/// Whether it goes on.
#[derive(Clone, Copy)]
enum Tone {
    Error,
    Warning,
}

/// Says what is missing at present, on standard error.
pub(crate) fn warn(concerns: &Faults) {
    // Whoever closed standard error does not want to hear of it.
    let _ = terminal::err().write_all(faults_in_words(concerns, Tone::Warning).as_bytes());
}

fn plain(message: &str, help: Option<&str>) -> String {
    in_tone(Tone::Error, message, help)
}

fn in_tone(tone: Tone, message: &str, help: Option<&str>) -> String {
    let (style, tone) = match tone {
        Tone::Error => (BAD, "error"),
        Tone::Warning => (WARN, "warning"),
    };
    let mut words = format!("{style}{tone}{style:#}{TITLE}: {message}{TITLE:#}\n");
    if let Some(help) = help {
        words += &format!("  {TITLE}help{TITLE:#}: {help}\n");
    }
    words
}

/// Where no plugin was looked for, and how to have it done.
pub(crate) fn not_searched(withheld: &[PathBuf]) -> String {
    let folders: Vec<_> = withheld.iter().map(|folder| shown(folder)).collect();
    format!(
        "no plugin was looked for in {}, which the recording names: what is there runs with your rights; --trust has them searched",
        folders.join(", ")
    )
}

fn faults_in_words(faults: &Faults, tone: Tone) -> String {
    let mut words = String::new();
    let list = faults.list();
    for fault in list.iter().take(MOST_SHOWN) {
        words += &fault_in_words(fault, tone);
        words.push('\n');
    }
    if let more @ 1.. = faults.count().saturating_sub(MOST_SHOWN) {
        let _ = writeln!(words, "and {more} more");
    }
    words
}

/// A fault with the line it is in, as compilers show them.
fn fault_in_words(fault: &Fault, tone: Tone) -> String {
    let help = fault.help.as_deref();
    match &fault.place {
        Place::Text {
            file,
            line,
            column,
            span,
        } => {
            let shown = shown(file);
            let source = std::fs::read_to_string(file).ok();
            let text = source
                .as_deref()
                .and_then(|source| line_around(source, span.start));
            let Some((start, text)) = text else {
                return in_tone(tone, &format!("{shown}:{line}:{column}: {}", fault.message), help);
            };
            let end = span.end.clamp(span.start, start + text.len());
            let snippet = Snippet::source(text)
                .path(shown)
                .line_start(*line)
                .annotation(AnnotationKind::Primary.span(span.start - start..end - start));
            let level = match tone {
                Tone::Error => Level::ERROR,
                Tone::Warning => Level::WARNING,
            };
            let mut group = level.primary_title(&fault.message).element(snippet);
            if let Some(help) = help {
                group = group.element(Level::HELP.message(help));
            }
            Renderer::styled().render(&[group]) + "\n"
        }
        Place::File(file) => in_tone(tone, &format!("{}: {}", shown(file), fault.message), help),
        Place::Option(option) => in_tone(tone, &format!("{option}: {}", fault.message), help),
    }
}

/// The line of `source` that holds byte `at`, and where it begins; none if the file has changed since.
fn line_around(source: &str, at: usize) -> Option<(usize, &str)> {
    let before = source.get(..at)?;
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let rest = &source[start..];
    Some((start, rest.lines().next().unwrap_or_default()))
}

/// A path as the user would write it: relative if it is below the working directory, and without ways up and down again.
pub(crate) fn shown(path: &Path) -> String {
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
    fn a_fault_is_shown_with_the_line_it_is_in() {
        assert_eq!(line_around("one\ntwo\nthree", 5), Some((4, "two")));
        assert_eq!(line_around("one\n", 0), Some((0, "one")));
        assert_eq!(line_around("one\n", 4), Some((4, "")));
        assert_eq!(line_around("one\r\ntwo", 1), Some((0, "one")));
    }

    #[test]
    fn a_file_that_has_become_shorter_shows_no_line() {
        assert_eq!(line_around("one", 7), None);
    }
}
