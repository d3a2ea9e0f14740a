//! The errors between an application and its tools, with texts that name a remedy.

use std::path::PathBuf;
use std::time::Duration;

use crate::keys::PROTOCOL;

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
    /// An application of that name already runs here.
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
    #[error("`{0}` is no name for an application; use 1 to 64 letters, digits, `_` and `-`")]
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
        "{endpoint} would let in whoever gets there; listen by `tls/...` with an `authority` in `tls`, which asks for certificates or for `user` and `password-file`, or say `insecure = true`"
    )]
    Insecure {
        /// The endpoint.
        endpoint: String,
    },
    /// Connecting here would not authenticate the other end.
    #[error(
        "nothing proves who answers at {endpoint}; connect by `tls/...` with an `authority` in `tls`, or say `insecure = true`"
    )]
    Unproven {
        /// The endpoint.
        endpoint: String,
    },
    /// A password would be sent to an unauthenticated end.
    #[error(
        "a password is given to whoever has a certificate of an authority, and to nobody at {endpoint}; use `tls/...` with an `authority` in `tls`, or leave `user` and `password-file` out"
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
    /// The endpoint does not answer, or refuses the connection.
    #[error("cannot connect to {endpoint}: {reason}")]
    Connect {
        /// The endpoint.
        endpoint: String,
        /// The reason.
        reason: String,
    },
    /// No application runs at the searched place.
    #[error("no application runs {0}; start one with `jde run`")]
    NoApplication(String),
    /// Several applications run, and the request names none.
    #[error("several applications run: {}; name one", .0.join(", "))]
    Ambiguous(Vec<String>),
    /// No application of that name.
    #[error("no application is called `{name}`{}", or(.nearest, .running))]
    UnknownApplication {
        /// The name asked for.
        name: String,
        /// The most similar name of a running application.
        nearest: Option<String>,
        /// The names of all that run.
        running: Vec<String>,
    },
    /// No application of that name answered.
    #[error("no application called `{name}` answered {whereabouts}")]
    NotFound {
        /// The name asked for.
        name: String,
        /// The searched place.
        whereabouts: String,
    },
    /// Only replays run there, and they move nothing.
    #[error("only recordings play; they move nothing")]
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
    /// The application runs and does not answer.
    #[error("`{application}` did not answer within {:.1} s; it is stopped, or too busy", .waited.as_secs_f64())]
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
    /// An answer that cannot be read.
    #[error("`{application}` gave an answer that cannot be read ({reason}); is it another version of jde?")]
    Garbled {
        /// The application.
        application: String,
        /// The reason.
        reason: String,
    },
    /// The system refused to create a thread.
    #[error("the system refuses a thread: {0}")]
    Thread(#[source] std::io::Error),
}

fn or(nearest: &Option<String>, running: &[String]) -> String {
    match (nearest, running) {
        (Some(near), _) => format!("; did you mean `{near}`?"),
        (None, []) => "; none runs there".to_owned(),
        (None, running) => format!("; there are {}", running.join(", ")),
    }
}
