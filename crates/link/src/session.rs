//! Zenoh sessions that open nothing by themselves: no multicast, no gossip, no port, no shared memory, no admin space; only the
//! endpoints they are given, and no other protocol than theirs. Knows nothing of applications.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use serde_json::{Value, json};
use zenoh::{Config, Session, Wait};

use crate::Error;

/// How much less urgent than the application all threads of the link are: a tenth of the share of a thread of its own.
const NICE: i32 = 10;
/// How long a connection may be silent before it counts as cut. Each end sends a sign of life four times in it.
const LEASE_MS: u64 = 3000;
/// How long an endpoint may take to let us in, and when we no longer wait to be told that it did not.
const OPEN_MS: u64 = 3000;
const OPENING: Duration = Duration::from_secs(4);
/// Whoever does not take what he asked for is cut off after this, us: his answers hold up those of others.
const BLOCKED_US: u64 = 200_000;
/// Longest file of a password that is read, bytes.
const LONGEST: u64 = 4096;
/// Largest message: the largest picture with room to spare.
const LARGEST: u64 = 64 << 20;
/// How long a session may take to say good-bye.
const CLOSING: Duration = Duration::from_secs(1);

/// What to open.
#[derive(Default)]
pub(crate) struct Opening<'a> {
    pub(crate) listen: &'a [String],
    pub(crate) connect: &'a [String],
    /// Go on looking for those to connect to, for ever; else not reaching one is an error.
    pub(crate) patient: bool,
    /// Find others by multicast, and connect to them by these protocols.
    pub(crate) discover: Option<&'a [&'a str]>,
    pub(crate) login: Option<&'a Login>,
    /// The file of users who may connect, `user:password` a line.
    pub(crate) users: Option<&'a str>,
    pub(crate) tls: Option<&'a Tls>,
    pub(crate) guard: Option<Value>,
}

/// Who we are to those we connect to.
#[derive(Clone, PartialEq, Eq)]
pub struct Login {
    /// The user.
    pub user: String,
    /// The password.
    pub password: String,
}

/// Certificates, as files in PEM.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tls {
    /// Our certificate and its key, to be recognised by.
    pub identity: Option<(String, String)>,
    /// Who signs those we believe; without one nobody is believed.
    pub authority: Option<String>,
    /// Whoever connects must show a certificate of the authority.
    pub clients: bool,
}

impl Login {
    /// A user whose password is the first line of a file, without the end of that line.
    ///
    /// # Errors
    /// [`Error::Password`]: the file cannot be read, or what is in it is no password.
    pub fn read(user: &str, file: &Path) -> Result<Self, Error> {
        let wrong = |reason: String| Error::Password {
            file: file.to_owned(),
            reason,
        };
        let mut text = String::new();
        File::open(file)
            .and_then(|opened| opened.take(LONGEST + 1).read_to_string(&mut text))
            .map_err(|error| wrong(error.to_string()))?;
        if text.len() as u64 > LONGEST {
            return Err(wrong(format!("it has more than {LONGEST} bytes")));
        }
        let login = Self {
            user: user.to_owned(),
            password: text.lines().next().unwrap_or_default().to_owned(),
        };
        login.check().map_err(|error| wrong(error.to_string()))?;
        Ok(login)
    }

    /// Whether both ends will take it for the same: what reads users from files cuts blanks off at either end, and what is behind a
    /// colon or a line break.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let plain = |text: &str| !text.is_empty() && text.trim() == text && !text.contains(char::is_control);
        let setting = |key, reason: &str| Error::Setting {
            key,
            reason: reason.to_owned(),
        };
        if !plain(&self.user) || self.user.contains(':') {
            return Err(setting(
                "user",
                "a user has one letter at least, no colon, no control character, and no blank at either end",
            ));
        }
        if !plain(&self.password) {
            return Err(setting(
                "password-file",
                "a password is the first line of its file, of one letter at least, without control characters and without blanks at either end",
            ));
        }
        Ok(())
    }
}

/// A password is not for logs.
impl std::fmt::Debug for Login {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Login {{ user: {:?} }}", self.user)
    }
}

/// Opens a session; all its threads give way to the application's.
pub(crate) fn open(opening: &Opening<'_>) -> Result<Session, Error> {
    let config = config(opening)?;
    let (tell, opened) = mpsc::channel();
    // A session that could not connect takes its time to say so: it is left to itself.
    std::thread::Builder::new()
        .name("link-open".to_owned())
        .spawn(move || {
            give_way();
            if let Err(mpsc::SendError(Ok(late))) = tell.send(zenoh::open(config).wait()) {
                close(late);
            }
        })
        .map_err(Error::Thread)?;
    match opened.recv_timeout(OPENING) {
        Ok(session) => session.map_err(|error| Error::Open(words(&error.to_string()))),
        Err(_) => Err(Error::Open(format!(
            "nobody answered within {} s",
            OPENING.as_secs()
        ))),
    }
}

/// What Zenoh says, without the places in its source that say it: ` at /.../tcp.rs:105.`
fn words(error: &str) -> String {
    let place = |word: &str| word.trim_end_matches('.').rsplit_once(".rs:").is_some();
    let mut kept: Vec<&str> = Vec::new();
    for word in error.split(' ') {
        if place(word) && kept.last() == Some(&"at") {
            kept.pop();
        } else {
            kept.push(word);
        }
    }
    kept.join(" ")
}

/// Says good-bye to all peers, in bounded time.
pub(crate) fn close(session: Session) {
    let (done, closed) = mpsc::channel();
    let close = move || {
        // Whether it can still say so or not, it goes.
        let _ = session.close().wait();
        drop(session);
        let _ = done.send(());
    };
    if std::thread::Builder::new()
        .name("link-close".to_owned())
        .spawn(close)
        .is_ok()
    {
        let _ = closed.recv_timeout(CLOSING);
    }
}

/// Makes the calling thread, and those that it starts, give way to others.
pub(crate) fn give_way() {
    // A system that refuses even this leaves it as urgent as the others.
    let _ = rustix::process::nice(NICE);
}

fn config(opening: &Opening<'_>) -> Result<Config, Error> {
    let endpoints = opening.listen.iter().chain(opening.connect);
    let mut protocols: Vec<_> = endpoints
        .filter_map(|endpoint| endpoint.split('/').next())
        .collect();
    protocols.extend(opening.discover.unwrap_or_default());
    protocols.sort_unstable();
    protocols.dedup();
    let mut settings = vec![
        ("mode", json!("peer")),
        // Whom multicast finds may name an address of any protocol.
        ("transport/link/protocols", json!(protocols)),
        ("listen/endpoints", json!(opening.listen)),
        ("listen/timeout_ms", json!(0)),
        ("listen/exit_on_failure", json!(true)),
        ("connect/endpoints", json!(opening.connect)),
        ("connect/timeout_ms", json!(if opening.patient { -1 } else { 0 })),
        ("connect/exit_on_failure", json!(!opening.patient)),
        ("scouting/multicast/enabled", json!(opening.discover.is_some())),
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
        ("transport/link/rx/max_message_size", json!(LARGEST)),
    ];
    if opening.patient {
        // Whether peers are there at the start makes no difference.
        settings.push(("open/return_conditions/connect_scouted", json!(false)));
    }
    if opening.discover.is_some() {
        settings.push(("scouting/multicast/autoconnect", json!({ "peer": ["peer"] })));
    }
    if let Some(login) = opening.login {
        settings.push(("transport/auth/usrpwd/user", json!(login.user)));
        settings.push(("transport/auth/usrpwd/password", json!(login.password)));
    }
    if let Some(users) = opening.users {
        settings.push(("transport/auth/usrpwd/dictionary_file", json!(users)));
    }
    if let Some(tls) = opening.tls {
        settings.push(("transport/link/tls", tls.json()));
    }
    if let Some(guard) = &opening.guard {
        settings.push(("access_control", guard.clone()));
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
    use super::words;

    #[test]
    fn errors_of_zenoh_do_not_name_its_source() {
        let said = "Unable to connect to tcp/127.0.0.1:1 at /x/y-1.10/src/tcp.rs:105. - Caused by refused at /x/z.rs:9.";
        assert_eq!(
            words(said),
            "Unable to connect to tcp/127.0.0.1:1 - Caused by refused"
        );
        assert_eq!(words("look at it"), "look at it");
    }
}
