//! What can go wrong between an application and its tools, in words that say what to do.

use std::path::PathBuf;
use std::time::Duration;

use crate::keys::PROTOCOL;

/// Why something could not be done over the link.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The folder in which applications announce themselves cannot be used.
    #[error("the folder {path} cannot be used: {reason}; {advice}")]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        reason: String,
        /// What to do.
        advice: String,
    },
    /// An application of that name runs here.
    #[error(
        "an application called `{name}` already runs here (process {pid}); stop it, or choose another name"
    )]
    NameTaken {
        /// The name.
        name: String,
        /// The process that has it.
        pid: u32,
    },
    /// No name that an application may have.
    #[error("`{0}` is no name for an application; use 1 to 64 letters, digits, `_` and `-`")]
    Name(String),
    /// Listening failed.
    #[error("cannot listen on {endpoint}: {reason}; is the port in use, or the address not of this machine?")]
    Listen {
        /// Where.
        endpoint: String,
        /// Why.
        reason: String,
    },
    /// Nobody may be let in like this.
    #[error(
        "{endpoint} would let in whoever gets there; listen by `tls/...` with an `authority` in `tls`, which asks for certificates or for `user` and `password-file`, or say `insecure = true`"
    )]
    Insecure {
        /// The endpoint.
        endpoint: String,
    },
    /// Nobody may be connected to like this.
    #[error(
        "nothing proves who answers at {endpoint}; connect by `tls/...` with an `authority` in `tls`, or say `insecure = true`"
    )]
    Unproven {
        /// The endpoint.
        endpoint: String,
    },
    /// A password would be given away.
    #[error(
        "a password is given to whoever has a certificate of an authority, and to nobody at {endpoint}; use `tls/...` with an `authority` in `tls`, or leave `user` and `password-file` out"
    )]
    PlainPassword {
        /// The endpoint.
        endpoint: String,
    },
    /// A password that cannot be had.
    #[error("the password file {file}: {reason}")]
    Password {
        /// The file.
        file: PathBuf,
        /// Why.
        reason: String,
    },
    /// A setting that does not work.
    #[error("[link] {key}: {reason}")]
    Setting {
        /// Which.
        key: &'static str,
        /// Why.
        reason: String,
    },
    /// The session could not be opened.
    #[error("the link cannot be opened: {0}")]
    Open(String),
    /// Nobody answers there, or does not let us in.
    #[error("cannot connect to {endpoint}: {reason}")]
    Connect {
        /// Where.
        endpoint: String,
        /// Why.
        reason: String,
    },
    /// No application runs where we looked.
    #[error("no application runs {0}; start one with `jde run`")]
    NothingRuns(String),
    /// Several run, and none was named.
    #[error("several applications run: {}; name one", .0.join(", "))]
    Several(Vec<String>),
    /// None of that name.
    #[error("no application is called `{name}`{}", or(.nearest, .running))]
    UnknownApplication {
        /// The name asked for.
        name: String,
        /// The nearest that runs.
        nearest: Option<String>,
        /// All that run.
        running: Vec<String>,
    },
    /// Nobody there was asked for.
    #[error("no application called `{name}` answered {whereabouts}")]
    NotThere {
        /// The name asked for.
        name: String,
        /// Where.
        whereabouts: String,
    },
    /// Only what cannot move anything is there.
    #[error("only recordings play; they move nothing")]
    OnlyRecordings,
    /// The other end speaks another version.
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
    /// The application ended, was killed, or cannot be reached any more.
    #[error("`{0}` is gone: it ended, was killed, or the network to it is cut")]
    Gone(String),
    /// It is there and does not answer.
    #[error("`{application}` did not answer within {:.1} s; it is stopped, or too busy", .waited.as_secs_f64())]
    NoAnswer {
        /// Who.
        application: String,
        /// How long.
        waited: Duration,
    },
    /// The application refused.
    #[error("{text}{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Refused {
        /// Why.
        text: String,
        /// The nearest name there is.
        nearest: Option<String>,
    },
    /// An answer that makes no sense.
    #[error("`{application}` gave an answer that cannot be read ({reason}); is it another version of jde?")]
    Garbled {
        /// Who.
        application: String,
        /// Why.
        reason: String,
    },
    /// The machine refused a thread.
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
