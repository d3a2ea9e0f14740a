//! `[link]`: which other processes and machines may connect to the application, and to which it connects.
//! Contains settings only and opens no socket.
//!
//! Without this section only the same user on the same machine can connect.
//!
//! ```toml
//! [link]
//! name          = "robot2"                # its name for others; the application's name if left out
//! listen        = ["tls/0.0.0.0:7447"]    # further addresses; if left out, this machine and this user alone
//! connect       = ["tls/base.local:7447"] # others to connect to, with unlimited retries
//! discover      = false                   # find others by multicast, where it listens
//! access        = "operate"               # or "read": what clients from the network may do
//! user          = "lab"                   # with password-file: required of clients, within TLS
//! password-file = "link.password"         # a file with the password on its first line
//! tls           = { certificate = "robot.pem", key = "robot.key", authority = "ca.pem", clients = true }
//! stale         = "1s"                    # when values imported from other applications expire
//! insecure      = false                   # true: accept peers that are not authenticated
//! off           = false                   # true: no link at all
//! ```

mod address;
mod authentication;
mod read;

use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;

use jde_core::Nanos;

use super::drafts::{MAX_NAME_LENGTH, is_legal, is_legal_name};

pub(crate) use authentication::{existing_file, refuse_without};
pub(crate) use read::{access, read};

/// The default age at which an imported value expires, ns.
const DEFAULT_STALE: Nanos = 1_000_000_000;

/// Which peers an application admits, and which it connects to. Paths are absolute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// The name for other applications: see [`Link::is_name`].
    pub name: String,
    /// Addresses on which it listens beyond its own user's folder: `tcp/0.0.0.0:7447`, `tls/[::]:7447`,
    /// `unixsock-stream//run/robot`.
    pub listen: Vec<String>,
    /// Addresses to which it connects, with unlimited retries; in the same notation.
    pub connect: Vec<String>,
    /// Whether it discovers others by multicast.
    pub discover: bool,
    /// What clients from the network may do.
    pub access: Access,
    /// The login required of clients, and presented to those it connects to; only within TLS with an
    /// authority.
    pub login: Option<Login>,
    /// Certificates.
    pub tls: Option<Tls>,
    /// The age at which a value from another application is retracted, ns.
    pub stale_ns: Nanos,
    /// Whether it may listen where anybody can connect, and connect to unauthenticated peers.
    pub insecure: bool,
    /// Whether there is no link at all.
    pub off: bool,
}

/// What clients from the network may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Access {
    /// Read, and act as operators (R14).
    #[default]
    Operate,
    /// Read only.
    Read,
}

/// A user name, and the file of the password.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Login {
    /// The user.
    pub user: String,
    /// A file whose first line is the password.
    pub password_file: PathBuf,
}

/// Certificates, as PEM files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tls {
    /// Its own certificate: needed to listen.
    pub identity: Option<Identity>,
    /// The authority whose certificates it trusts.
    pub authority: Option<PathBuf>,
    /// Whether clients must present a certificate of the authority; true by default if there is an authority.
    pub clients: bool,
}

/// A certificate and its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The certificate.
    pub certificate: PathBuf,
    /// Its key.
    pub key: PathBuf,
}

impl Link {
    /// Returns the link of an application without the section: for this machine and this user alone.
    /// Characters that a link's name may not contain are replaced by `-`.
    #[must_use]
    pub fn local(application: &str) -> Self {
        let legal = |c: char| if is_legal(c) { c } else { '-' };
        let name: String = application.chars().take(MAX_NAME_LENGTH).map(legal).collect();
        Self {
            name: if name.is_empty() {
                "application".to_owned()
            } else {
                name
            },
            listen: Vec::new(),
            connect: Vec::new(),
            discover: false,
            access: Access::default(),
            login: None,
            tls: None,
            stale_ns: DEFAULT_STALE,
            insecure: false,
            off: false,
        }
    }

    /// Whether the text can be the name of a link: 1 to 64 letters, digits, `-` and `_`.
    #[must_use]
    pub fn is_name(name: &str) -> bool {
        is_legal_name(name)
    }

    /// Returns a warning for each secret file that users other than its owner can read.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let identity = self.tls.as_ref().and_then(|tls| tls.identity.as_ref());
        let password = self
            .login
            .as_ref()
            .map(|login| ("password", &login.password_file));
        let key = identity.map(|identity| ("key", &identity.key));
        let readable = |file: &PathBuf| {
            let found = std::fs::metadata(file);
            found.is_ok_and(|found| found.permissions().mode() & 0o044 != 0)
        };
        let secrets = password.into_iter().chain(key);
        secrets
            .filter(|(_, file)| readable(file))
            .map(|(what, file)| {
                let file = file.display();
                format!("other users of this machine can read the {what} in {file}; run `chmod 600 {file}`")
            })
            .collect()
    }

    /// Whether other machines can connect.
    #[must_use]
    pub fn is_open(&self) -> bool {
        !self.off && self.listen.iter().any(|address| address::is_network(address))
    }
}
