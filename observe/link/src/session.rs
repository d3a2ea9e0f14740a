//! Zenoh sessions without multicast, gossip, ports, shared memory or admin space unless requested. A session
//! uses only the endpoints given to it, and only their protocols. Knows nothing of applications.

use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use serde_json::{Value, json};
use zenoh::{Config, Session, Wait};

use crate::Error;

/// Niceness added to all threads of the link: they get about a tenth of the CPU share of a thread of the
/// application.
const ADDED_NICENESS: i32 = 10;
/// A connection counts as cut after this silence, ms. Each end sends a keep-alive four times in it.
const LEASE_MS: u64 = 3000;
/// Longest time in which an endpoint may accept a connection, ms; and how long the caller waits for the
/// outcome.
const OPEN_MS: u64 = 3000;
const OPENING_TIMEOUT: Duration = Duration::from_secs(4);
/// A receiver that takes no data for this long is disconnected, µs, since it delays the answers to others.
const BLOCKED_US: u64 = 200_000;
/// Longest password file that is read, bytes.
const MAX_PASSWORD_FILE: u64 = 4096;
/// The largest file of certificates or of a key, in bytes: some hundred authorities.
const MAX_PEM_FILE: u64 = 1 << 20;
/// Largest message, bytes: the largest picture with room to spare.
const MAX_MESSAGE_BYTES: u64 = 64 << 20;
/// Longest time for closing a session.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(1);

/// Parameters of a session.
#[derive(Default)]
pub(crate) struct SessionOptions<'a> {
    pub(crate) listen: &'a [String],
    pub(crate) connect: &'a [String],
    /// Retry unreachable endpoints forever. Otherwise an unreachable endpoint is an error.
    pub(crate) retry: bool,
    /// Discover peers by multicast, and connect to them by these protocols.
    pub(crate) discover: Option<&'a [&'a str]>,
    pub(crate) login: Option<&'a Login>,
    /// The file of users that may connect, one `user:password` per line.
    pub(crate) users: Option<&'a str>,
    pub(crate) tls: Option<&'a Tls>,
    pub(crate) access_control: Option<Value>,
}

/// The credentials with which a session connects.
#[derive(Clone, PartialEq, Eq)]
pub struct Login {
    /// The user.
    pub user: String,
    /// The password.
    pub password: String,
}

/// Certificates, as PEM files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tls {
    /// The own certificate and its key.
    pub identity: Option<(String, String)>,
    /// The authority whose certificates are trusted; without one no peer is trusted.
    pub authority: Option<String>,
    /// Connecting peers must show a certificate of the authority.
    pub clients: bool,
}

impl Login {
    /// Reads the password of a user from the first line of a file, without its line break.
    ///
    /// # Errors
    /// [`Error::Password`]: the file cannot be read, or its first line is not a valid password.
    pub fn read(user: &str, file: &Path) -> Result<Self, Error> {
        let unusable = |reason: String| Error::Password {
            file: file.to_owned(),
            reason,
        };
        let text =
            jde_files::read_text(file, MAX_PASSWORD_FILE).map_err(|error| unusable(error.to_string()))?;
        let login = Self {
            user: user.to_owned(),
            password: text.lines().next().unwrap_or_default().to_owned(),
        };
        login.check().map_err(|error| unusable(error.to_string()))?;
        Ok(login)
    }

    /// Refuses credentials that the two ends would read differently: the reader of user files trims blanks at
    /// both ends and cuts at a colon or a line break.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let is_plain =
            |text: &str| !text.is_empty() && text.trim() == text && !text.contains(char::is_control);
        let setting = |key, reason: &str| Error::Setting {
            key,
            reason: reason.to_owned(),
        };
        if !is_plain(&self.user) || self.user.contains(':') {
            return Err(setting(
                "user",
                "a user name needs at least one character, without colons, control characters, and blanks at either end",
            ));
        }
        if !is_plain(&self.password) {
            return Err(setting(
                "password-file",
                "a password is the first line of its file and needs at least one character, without control characters and blanks at either end",
            ));
        }
        Ok(())
    }
}

/// Omits the password, so that it never reaches a log.
impl std::fmt::Debug for Login {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Login {{ user: {:?} }}", self.user)
    }
}

/// Opens a session. All its threads run at the link's niceness.
pub(crate) fn open(options: &SessionOptions<'_>) -> Result<Session, Error> {
    let config = config(options)?;
    let (sender, opened) = mpsc::channel();
    // Opening a session that cannot connect takes long. This thread finishes on its own, and closes a
    // session that opens too late.
    std::thread::Builder::new()
        .name("link-open".to_owned())
        .spawn(move || {
            lower_priority();
            if let Err(mpsc::SendError(Ok(late))) = sender.send(zenoh::open(config).wait()) {
                close(late);
            }
        })
        .map_err(Error::Thread)?;
    match opened.recv_timeout(OPENING_TIMEOUT) {
        Ok(session) => session.map_err(|error| Error::Open(strip_locations(&error.to_string()))),
        Err(_) => Err(Error::Open(format!(
            "no reply within {} s",
            OPENING_TIMEOUT.as_secs()
        ))),
    }
}

/// Removes the source locations from a message of Zenoh: ` at /.../tcp.rs:105.`
fn strip_locations(error: &str) -> String {
    let is_location = |word: &str| word.trim_end_matches('.').rsplit_once(".rs:").is_some();
    let mut kept: Vec<&str> = Vec::new();
    for word in error.split(' ') {
        if is_location(word) && kept.last() == Some(&"at") {
            kept.pop();
        } else {
            kept.push(word);
        }
    }
    kept.join(" ")
}

/// Closes a session and notifies its peers, waiting a bounded time.
pub(crate) fn close(session: Session) {
    let (done, closed) = mpsc::channel();
    let close = move || {
        // The session is dropped even if the peers cannot be notified.
        let _ = session.close().wait();
        drop(session);
        let _ = done.send(());
    };
    if std::thread::Builder::new()
        .name("link-close".to_owned())
        .spawn(close)
        .is_ok()
    {
        let _ = closed.recv_timeout(CLOSING_TIMEOUT);
    }
}

/// Raises the niceness of the calling thread and of threads that it starts.
pub(crate) fn lower_priority() {
    // If the system refuses, the thread keeps its priority.
    let _ = rustix::process::nice(ADDED_NICENESS);
}

fn config(options: &SessionOptions<'_>) -> Result<Config, Error> {
    let endpoints = options.listen.iter().chain(options.connect);
    let mut protocols: Vec<_> = endpoints
        .filter_map(|endpoint| endpoint.split('/').next())
        .collect();
    protocols.extend(options.discover.unwrap_or_default());
    protocols.sort_unstable();
    protocols.dedup();
    let mut settings = vec![
        ("mode", json!("peer")),
        // A peer found by multicast may announce an address of any protocol.
        ("transport/link/protocols", json!(protocols)),
        ("listen/endpoints", json!(options.listen)),
        ("listen/timeout_ms", json!(0)),
        ("listen/exit_on_failure", json!(true)),
        ("connect/endpoints", json!(options.connect)),
        ("connect/timeout_ms", json!(if options.retry { -1 } else { 0 })),
        ("connect/exit_on_failure", json!(!options.retry)),
        ("scouting/multicast/enabled", json!(options.discover.is_some())),
        ("scouting/gossip/enabled", json!(false)),
        ("timestamping/enabled", json!(false)),
        ("adminspace/enabled", json!(false)),
        ("transport/shared_memory/enabled", json!(false)),
        ("transport/unicast/open_timeout", json!(OPEN_MS)),
        ("transport/unicast/accept_timeout", json!(OPEN_MS)),
        ("transport/link/tx/lease", json!(LEASE_MS)),
        ("transport/link/tx/keep_alive", json!(4)),
        (
            "transport/link/tx/queue/congestion_control/block/wait_before_close",
            json!(BLOCKED_US),
        ),
        ("transport/link/rx/max_message_size", json!(MAX_MESSAGE_BYTES)),
    ];
    if options.retry {
        // Opening does not wait for discovered peers.
        settings.push(("open/return_conditions/connect_scouted", json!(false)));
    }
    if options.discover.is_some() {
        settings.push(("scouting/multicast/autoconnect", json!({ "peer": ["peer"] })));
    }
    if let Some(login) = options.login {
        settings.push(("transport/auth/usrpwd/user", json!(login.user)));
        settings.push(("transport/auth/usrpwd/password", json!(login.password)));
    }
    if let Some(users) = options.users {
        settings.push(("transport/auth/usrpwd/dictionary_file", json!(users)));
    }
    if let Some(tls) = options.tls {
        tls.check()?;
        settings.push(("transport/link/tls", tls.json()));
    }
    if let Some(rules) = &options.access_control {
        settings.push(("access_control", rules.clone()));
    }
    let mut config = Config::default();
    for (key, value) in settings {
        config
            .insert_json5(key, &value.to_string())
            .map_err(|error| Error::Open(format!("{key}: {error}")))?;
    }
    Ok(config)
}

impl Tls {
    /// Refuses files that Zenoh, which reads them to their end, would not return from.
    ///
    /// # Errors
    /// [`Error::Open`]: a file cannot be read, is no regular file or is larger than any of its kind.
    fn check(&self) -> Result<(), Error> {
        let own = self
            .identity
            .iter()
            .flat_map(|(certificate, key)| [certificate, key]);
        own.chain(&self.authority).try_for_each(|file| {
            let read = jde_files::read(Path::new(file), MAX_PEM_FILE);
            read.map(drop)
                .map_err(|error| Error::Open(format!("{file}: {error}")))
        })
    }

    fn json(&self) -> Value {
        let (certificate, key) = self.identity.clone().unzip();
        let mutual = self.identity.is_some() && self.authority.is_some() && self.clients;
        json!({
            "root_ca_certificate": self.authority,
            "listen_certificate": certificate,
            "listen_private_key": key,
            "connect_certificate": certificate,
            "connect_private_key": key,
            "enable_mtls": mutual,
            "verify_name_on_connect": true,
            "close_link_on_expiration": true,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::strip_locations;

    #[test]
    fn source_locations_are_removed_from_errors_of_zenoh() {
        let error = "Unable to connect to tcp/127.0.0.1:1 at /x/y-1.10/src/tcp.rs:105. - Caused by refused at /x/z.rs:9.";
        assert_eq!(
            strip_locations(error),
            "Unable to connect to tcp/127.0.0.1:1 - Caused by refused"
        );
        assert_eq!(strip_locations("look at it"), "look at it");
    }
}
