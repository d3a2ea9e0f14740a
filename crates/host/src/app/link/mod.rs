//! `[link]`: whom the application lets in from other processes and machines, and whom it looks for. Settings only; nothing here
//! opens a socket.
//!
//! Without it the application is found by its own user on its own machine, and by nobody else.
//!
//! ```toml
//! [link]
//! name          = "robot2"                # how others call it; the application's name if left out
//! listen        = ["tls/0.0.0.0:7447"]    # the network; none: this machine and this user alone
//! connect       = ["tls/base.local:7447"] # others to look for, for ever
//! discover      = false                   # find others by multicast, where it listens
//! access        = "operate"               # or "read": what clients from the network may do
//! user          = "lab"                   # with password-file: asked of whoever connects, within TLS
//! password-file = "link.password"         # holds the password, on its first line
//! tls           = { certificate = "robot.pem", key = "robot.key", authority = "ca.pem", clients = true }
//! stale         = "1s"                    # when what was imported from elsewhere no longer counts
//! insecure      = false                   # true: speak with whoever is there, although nothing proves who that is
//! off           = false                   # true: no link at all
//! ```

mod address;
mod guard;
mod read;

use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;

use jde_core::Nanos;

pub(super) use read::read;

/// Longest name, as of everything that an application names.
const LONGEST_NAME: usize = 64;
/// How old an imported value may get where nobody says.
const STALE: Nanos = 1_000_000_000;

/// Whom an application lets in, and whom it looks for. Paths are absolute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// How others call it: see [`Link::is_name`].
    pub name: String,
    /// Where it listens beyond its own user's folder: `tcp/0.0.0.0:7447`, `tls/[::]:7447`, `unixsock-stream//run/robot`.
    pub listen: Vec<String>,
    /// Whom it looks for, for ever; written likewise.
    pub connect: Vec<String>,
    /// Finds others by multicast.
    pub discover: bool,
    /// What clients from the network may do.
    pub access: Access,
    /// What is asked of whoever connects, and given to those it connects to; only within TLS with an authority.
    pub login: Option<Login>,
    /// Certificates.
    pub tls: Option<Tls>,
    /// How old a value from elsewhere may get before it is taken back, ns.
    pub stale_ns: Nanos,
    /// Listens where anybody may connect, and connects to whoever is there.
    pub insecure: bool,
    /// No link at all.
    pub off: bool,
}

/// What clients from the network may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Access {
    /// Look, and act as operators (R14).
    #[default]
    Operate,
    /// Look.
    Read,
}

/// A user, and where the password is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Login {
    /// The user.
    pub user: String,
    /// A file whose first line is the password.
    pub password_file: PathBuf,
}

/// Certificates, as files in PEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tls {
    /// What it shows of itself: needed to listen.
    pub identity: Option<Identity>,
    /// Who signs those it believes.
    pub authority: Option<PathBuf>,
    /// Whoever connects must show a certificate of the authority; unless the file says, where there is an authority.
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
    /// The link of an application that says nothing of it: this machine and this user alone. A name that is none of a link has
    /// its other characters replaced by `-`.
    #[must_use]
    pub fn local(application: &str) -> Self {
        let legal = |c: char| if is_legal(c) { c } else { '-' };
        let name: String = application.chars().take(LONGEST_NAME).map(legal).collect();
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
            stale_ns: STALE,
            insecure: false,
            off: false,
        }
    }

    /// Whether others can call an application so: 1 to 64 letters, digits, `-` and `_`.
    #[must_use]
    pub fn is_name(name: &str) -> bool {
        (1..=LONGEST_NAME).contains(&name.len()) && name.chars().all(is_legal)
    }

    /// Files of secrets that others than their owner can read.
    pub(in crate::app) fn warnings(&self) -> Vec<String> {
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
                format!("other users of this machine can read the {what} in {file}; say `chmod 600 {file}`")
            })
            .collect()
    }

    /// Whether it can be reached from other machines.
    #[must_use]
    pub fn is_open(&self) -> bool {
        !self.off && self.listen.iter().any(|address| address::is_network(address))
    }
}

fn is_legal(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '-'
}
