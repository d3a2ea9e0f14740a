//! The errors between an application and its tools, with texts that name a remedy.

use std::path::PathBuf;
use std::time::Duration;

use crate::decode::Refused;
use crate::keys::PROTOCOL;
use crate::message::Refusal;

/// Why an operation over the link failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The folder in which applications announce themselves cannot be used.
    #[error("the folder {path} cannot be used: {reason}; {advice}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The reason.
        reason: String,
        /// The remedy.
        advice: String,
    },
    /// An application of that name already runs on this machine.
    #[error(
        "an application called `{name}` already runs here (process {pid}); stop it, or choose another name"
    )]
    NameTaken {
        /// The name.
        name: String,
        /// The process that has it.
        pid: u32,
    },
    /// Not a valid name of an application.
    #[error("`{0}` is not a valid name for an application; use 1 to 64 letters, digits, `_` and `-`")]
    Name(String),
    /// Listening failed.
    #[error("cannot listen on {endpoint}: {reason}; is the port in use, or the address not of this machine?")]
    Listen {
        /// The endpoint.
        endpoint: String,
        /// The reason.
        reason: String,
    },
    /// Listening here would admit everybody.
    #[error(
        "{endpoint} would admit any client; listen by `tls/...` with an `authority` in `tls` and require certificates or `user` and `password-file`, or set `insecure = true`"
    )]
    Insecure {
        /// The endpoint.
        endpoint: String,
    },
    /// Connecting here would not authenticate the other end.
    #[error(
        "nothing authenticates {endpoint}; connect by `tls/...` with an `authority` in `tls`, or set `insecure = true`"
    )]
    Unproven {
        /// The endpoint.
        endpoint: String,
    },
    /// A password would be sent to an unauthenticated end.
    #[error(
        "a password requires TLS with an authority, which {endpoint} does not have; use `tls/...` with an `authority` in `tls`, or omit `user` and `password-file`"
    )]
    PlainPassword {
        /// The endpoint.
        endpoint: String,
    },
    /// A password that cannot be read from its file.
    #[error("the password file {file}: {reason}")]
    Password {
        /// The file.
        file: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A setting that is not valid.
    #[error("[link] {key}: {reason}")]
    Setting {
        /// The key of the setting.
        key: &'static str,
        /// The reason.
        reason: String,
    },
    /// The session could not be opened.
    #[error("the link cannot be opened: {0}")]
    Open(String),
    /// The endpoint does not respond, or refuses the connection.
    #[error("cannot connect to {endpoint}: {reason}")]
    Connect {
        /// The endpoint.
        endpoint: String,
        /// The reason.
        reason: String,
    },
    /// No application runs where the client searched.
    #[error("no application runs {0}; start one with `jde run`")]
    NoApplication(String),
    /// Several applications run, and the request names none.
    #[error("several applications run: {}; name one", .0.join(", "))]
    Ambiguous(Vec<String>),
    /// No application of that name.
    #[error("no application is called `{name}`{}", suggestion(.nearest, .running))]
    UnknownApplication {
        /// The requested name.
        name: String,
        /// The most similar name of a running application.
        nearest: Option<String>,
        /// The names of all that run.
        running: Vec<String>,
    },
    /// No application of that name answered.
    #[error("no application called `{name}` answered {whereabouts}")]
    NotFound {
        /// The requested name.
        name: String,
        /// Where the client searched.
        whereabouts: String,
    },
    /// Only replays of recordings run, which control no robot.
    #[error("only replays of recordings run; they control no robot")]
    OnlyRecordings,
    /// The other end implements another version of the protocol.
    #[error(
        "`{application}` (jde {theirs_version}) speaks link protocol {theirs}, and this is protocol {PROTOCOL} (jde {}); use the same version of jde on both",
        env!("CARGO_PKG_VERSION")
    )]
    Version {
        /// The application.
        application: String,
        /// Its protocol.
        theirs: u32,
        /// Its version.
        theirs_version: String,
    },
    /// The application ended, was killed, or can no longer be reached.
    #[error("`{0}` is gone: it ended, was killed, or the network to it is cut")]
    Disconnected(String),
    /// The application runs and does not reply.
    #[error("`{application}` did not reply within {:.1} s; it is stopped, or too busy", .waited.as_secs_f64())]
    Timeout {
        /// The application.
        application: String,
        /// How long the caller waited.
        waited: Duration,
    },
    /// The application refused the request.
    #[error("{text}{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Refused {
        /// The reason.
        text: String,
        /// The most similar name that exists.
        nearest: Option<String>,
    },
    /// A reply that cannot be read.
    #[error("the reply of `{application}` cannot be read ({reason}); is it another version of jde?")]
    Garbled {
        /// The application.
        application: String,
        /// The reason.
        reason: String,
    },
    /// A reply that can be read and makes no sense.
    #[error("`{application}`: its answer makes no sense: {reason}")]
    Nonsense {
        /// The application.
        application: String,
        /// The reason.
        reason: String,
    },
    /// An endpoint or an application gave no answer, or none that makes sense.
    #[error("{0}")]
    Unanswered(String),
    /// Several things went wrong at different places.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Several(Vec<Self>),
    /// The system refused to create a thread.
    #[error("the system refused to create a thread: {0}")]
    Thread(#[source] std::io::Error),
}

impl From<Refusal> for Error {
    fn from(Refusal { error, nearest }: Refusal) -> Self {
        Self::Refused { text: error, nearest }
    }
}

impl Error {
    /// A message of an application that its reader refused.
    pub(crate) fn refused(application: &str, refused: Refused) -> Self {
        let application = application.to_owned();
        match refused {
            Refused::Unreadable(reason) => Self::Garbled { application, reason },
            Refused::Nonsense(reason) => Self::Nonsense { application, reason },
        }
    }
}

fn suggestion(nearest: &Option<String>, running: &[String]) -> String {
    match (nearest, running) {
        (Some(near), _) => format!("; did you mean `{near}`?"),
        (None, []) => "; none runs there".to_owned(),
        (None, running) => format!("; there are {}", running.join(", ")),
    }
}
