//! The errors of all verbs, their messages, and their exit status: those of a run, and those of recordings and of the link.

use std::error::Error;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use jde_app::Faults;
use jde_host::StartError;
use jde_loader::PluginError;
use jde_log::ReadError;
use jde_session::failure::print_error;
use jde_sim::WorldError;
use jde_terminal::escape::escape;

pub(crate) use jde_session::failure::{Failure as RunFailure, describe_skipped_folders, display_path};

/// The exit status of a verdict that nobody waited for: that of a program which a closed pipe ends by SIGPIPE.
const UNREAD: u8 = 141;

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// As a run does.
    #[error(transparent)]
    Run(RunFailure),
    /// A replay made other decisions than the recording. The report has listed them.
    #[error("some selections differ from the recorded ones")]
    Mismatch,
    /// A plugin breaks a promise. The list of checks has shown it.
    #[error("the plugin breaks a promise of the ABI")]
    Promise,
    /// A reload failed: the schemas keep running their previous builds.
    #[error("{0}")]
    NotReloaded(String),
    /// The reader of the report closed the pipe before the verdict.
    #[error("the reader stopped before the verdict")]
    Unread,
    /// The requested event did not occur.
    #[error("{0}")]
    NoMatch(String),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// A running application could not be reached, or refused the request.
    #[error(transparent)]
    Link(#[from] jde_link::Error),
}

impl From<RunFailure> for Failure {
    /// What accompanied a run has failures of its own.
    fn from(failure: RunFailure) -> Self {
        let own = |error: Box<dyn Error + Send + Sync>| error.downcast::<Self>();
        match failure {
            RunFailure::Start(StartError::HookFailed(error)) => match own(error) {
                Ok(failure) => *failure,
                Err(error) => Self::Run(StartError::HookFailed(error).into()),
            },
            other => Self::Run(other),
        }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Run(error.into())
    }
}

impl From<PluginError> for Failure {
    fn from(error: PluginError) -> Self {
        Self::Run(error.into())
    }
}

impl From<StartError> for Failure {
    fn from(error: StartError) -> Self {
        RunFailure::from(error).into()
    }
}

impl Failure {
    /// Returns wrong use with an error and an advice.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Run(RunFailure::usage(message, help))
    }

    /// Returns wrong use because of an unknown name. The advice is the nearest known name, or all of them.
    pub(crate) fn unknown<'n>(what: &str, name: &str, known: impl Iterator<Item = &'n str> + Clone) -> Self {
        Self::Run(RunFailure::unknown(what, name, known))
    }

    /// Returns faults of a file that do not concern plugins.
    pub(crate) fn faults(faults: Faults) -> Self {
        Self::Run(RunFailure::faults(faults))
    }

    /// Returns why a world cannot be used.
    pub(crate) fn world(error: WorldError) -> Self {
        match error {
            WorldError::Faults(faults) => Self::faults(faults),
            other => Self::broken(other.to_string()),
        }
    }

    /// Returns the failure of a run whose report has said that it did not fulfil its mission.
    pub(crate) fn mission() -> Self {
        Self::Run(RunFailure::Mission)
    }

    /// Returns the reason why a verb could not continue.
    pub(crate) fn broken(reason: impl Into<String>) -> Self {
        Self::Run(RunFailure::Broken(reason.into()))
    }

    /// Converts I/O errors of a file.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let failure = RunFailure::file(path);
        move |error| Self::Run(failure(error))
    }

    /// Whether the reader closed the pipe of the output. This is no failure.
    pub(crate) fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Run(failure) if failure.is_closed_pipe())
    }

    /// Prints the failure on standard error. Returns the exit status: 1 for a run that failed, 2 for wrong
    /// use or a wrong application file, 3 for a plugin, 0 if the reader closed the pipe, and 141 if a verdict was to follow.
    pub(crate) fn report(&self) -> ExitCode {
        let status = match self {
            Self::Run(failure) => return failure.report(),
            Self::Mismatch | Self::Promise => return ExitCode::from(1),
            Self::Unread => return ExitCode::from(UNREAD),
            Self::NotReloaded(reason) => {
                print_error(reason);
                return ExitCode::from(1);
            }
            Self::NoMatch(_) => 1,
            Self::Link(error @ jde_link::Error::Ambiguous(names)) if !is_shell() => {
                return RunFailure::usage(error.to_string(), command_for(names)).report();
            }
            Self::Link(error) => link_status(error),
            Self::Recording(ReadError::File { path, error }) if error.kind() == io::ErrorKind::NotFound => {
                let message = format!("{}: there is no such file", display_path(path));
                let help = "give the path of a recording; `jde record` and `jde run --record` write one";
                return RunFailure::usage(message, help).report();
            }
            Self::Recording(_) => 2,
        };
        print_error(&escape(&self.to_string()));
        ExitCode::from(status)
    }
}

/// Whether the verb was typed in the interactive shell.
fn is_shell() -> bool {
    std::env::args().nth(1).is_some_and(|verb| verb == "shell")
}

/// Returns the command of this process for the first of several applications.
fn command_for(applications: &[String]) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "-_./:=,%+@".contains(letter);
    let words = std::env::args()
        .skip(1)
        .map(|word| match word.chars().all(is_plain) {
            true => word,
            false => format!("'{}'", word.replace('\'', "'\\''")),
        });
    let command = words.collect::<Vec<_>>().join(" ");
    let first = applications.first().map_or("NAME", String::as_str);
    format!("such as `jde {command} --app {first}`")
}

/// Returns 2 for errors that another command line or setting can fix, and 1 for all others.
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
