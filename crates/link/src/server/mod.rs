//! The application's end of the link: announces it, answers, publishes what somebody listens to, and carries out what operators
//! want. Nothing that clients do reaches the application's threads: whatever waits, waits on the link's own.

mod bucket;
mod described;
mod door;
mod events;
mod hands;
mod imports;
mod inbox;
mod lanes;
mod leases;
mod panel_lane;
mod peer;
mod subject;
mod value_lane;
mod worker;

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

pub use described::schemas;
pub use events::Events;
pub(crate) use subject::no_panel;
pub use subject::{Looking, News, Running, Subject, Title};

use jde_host::app::Remote;

use crate::folder::{Announced, Folder};
use crate::keys::{Keys, PROTOCOL};
use crate::message::{About, Network};
use crate::session::{self, Login, Opening, Tls};
use crate::{Error, whoami};
use door::Door;
use hands::Hands;
use imports::Imports;
use inbox::{Inbox, Origin};
use peer::Search;
use worker::Worker;

/// How long the link may take to leave.
const LEAVING: Duration = Duration::from_secs(3);

/// How an application is linked.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How others call it.
    pub name: String,
    /// The name was asked for: another application of that name is an error. Else it gets a number.
    pub named: bool,
    /// Endpoints on the network to listen on: `tcp/0.0.0.0:7447`.
    pub listen: Vec<String>,
    /// Endpoints on the network to look for, for ever.
    pub connect: Vec<String>,
    /// Find others by multicast.
    pub discover: bool,
    /// What clients from the network may do.
    pub access: Access,
    /// Who we are to others, and who others must be.
    pub login: Option<Login>,
    /// Certificates.
    pub tls: Option<Tls>,
    /// Let the network in without knowing whom.
    pub insecure: bool,
    /// Where applications of this user announce themselves.
    pub folder: Folder,
}

/// What clients from the network may do. Those of the same user on the same machine may operate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Access {
    /// Look.
    Read,
    /// Look and operate.
    #[default]
    Operate,
}

/// The link of a running application. Dropped, it leaves at once, and everybody knows.
pub struct Link {
    about: About,
    inbox: Arc<Inbox>,
    worker: Option<JoinHandle<()>>,
    /// Gone before the sessions are, so that nobody finds a door that is closing.
    announced: Option<Announced>,
    imports: Option<Imports>,
    left: mpsc::Receiver<()>,
}

impl Settings {
    /// An application that this user reaches on this machine, and nobody else.
    #[must_use]
    pub fn local(name: &str) -> Self {
        Self {
            name: crate::keys::as_name(name),
            named: false,
            listen: Vec::new(),
            connect: Vec::new(),
            discover: false,
            access: Access::default(),
            login: None,
            tls: None,
            insecure: false,
            folder: Folder::of_user(),
        }
    }

    /// What clients from the network may do: only look, where it is not known who they are.
    #[must_use]
    pub fn network_access(&self) -> Access {
        let proven = self.tls.as_ref().is_some_and(|tls| tls.authority.is_some());
        let strange = |endpoint: &String| {
            let proven = proven && endpoint.starts_with("tls/");
            !(proven || is_loopback(endpoint))
        };
        let known = self.insecure || self.login.is_some() || self.tls.as_ref().is_some_and(|tls| tls.clients);
        if known || !(self.discover || self.connect.iter().any(strange)) {
            self.access
        } else {
            Access::Read
        }
    }

    /// Whether the network is opened at all.
    #[must_use]
    pub fn is_networked(&self) -> bool {
        !self.listen.is_empty() || !self.connect.is_empty() || self.discover
    }
}

impl Link {
    /// Announces an application and serves its clients until it is dropped.
    ///
    /// # Errors
    /// [`Error`]: a name that is taken, a folder that is not safe, a port in use, a network that would be open to anybody.
    pub fn open(settings: &Settings, subject: Arc<dyn Subject>, events: &Events) -> Result<Self, Error> {
        check(settings)?;
        let claim = settings.folder.claim(&settings.name, settings.named)?;
        let title = subject.title();
        let about = About {
            name: claim.name.clone(),
            id: claim.id.clone(),
            protocol: PROTOCOL,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            host: whoami::host(),
            user: whoami::user(),
            pid: std::process::id(),
            application: title.application,
            file: title.file,
            started_ns: SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)),
            executor: title.executor,
            speed: title.speed,
            network: match (settings.is_networked(), settings.network_access()) {
                (false, _) => Network::Closed,
                (true, Access::Read) => Network::Read,
                (true, Access::Operate) => Network::Operate,
            },
        };
        let keys = Keys::new(&about.name, &about.id);
        let inbox = Arc::new(Inbox::new());
        let mut doors = vec![local_door(&claim.socket(), &keys, &inbox)?];
        if settings.is_networked() {
            doors.push(network_door(settings, &keys, subject.imports(), &inbox)?);
        }
        let search = Arc::new(Search {
            folder: settings.folder.clone(),
            network: doors.get(1).map(|door| door.session.clone()),
        });
        let hands = Hands::start(Arc::clone(&subject), Arc::clone(&inbox))?;
        let imports = match subject.imports() {
            [] => None,
            _ => Some(Imports::start(&subject, &search)?),
        };
        let announced = claim.announce(&about)?;
        let sessions: Vec<_> = doors
            .iter()
            .map(|door| (door.origin, door.session.clone()))
            .collect();
        let (lanes, shown, root) = (Arc::clone(&inbox), Arc::clone(&subject), keys.clone());
        let values = std::thread::Builder::new()
            .name("link-values".to_owned())
            .spawn(move || {
                session::give_way();
                lanes::run(&lanes::Yard {
                    subject: &*shown,
                    inbox: &lanes,
                    sessions: &sessions,
                    keys: &root,
                });
            })
            .map_err(Error::Thread)?;
        let sender = values.thread().clone();
        let worker = Worker::new(
            subject,
            Arc::clone(&inbox),
            keys,
            &about,
            doors,
            hands,
            events.chronicle(),
        )
        .outlast(values);
        let (gone, left) = mpsc::channel();
        let worker = std::thread::Builder::new()
            .name("link".to_owned())
            .spawn(move || {
                session::give_way();
                worker.run();
                let _ = gone.send(());
            })
            .map_err(|error| {
                inbox.stop();
                sender.unpark();
                Error::Thread(error)
            })?;
        inbox.attach(worker.thread(), &sender);
        Ok(Self {
            about,
            inbox,
            worker: Some(worker),
            announced: Some(announced),
            imports,
            left,
        })
    }

    /// What others see of the application.
    #[must_use]
    pub fn about(&self) -> &About {
        &self.about
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        drop((self.announced.take(), self.imports.take()));
        self.inbox.stop();
        // A client that takes nothing must not keep the application from ending.
        if self.left.recv_timeout(LEAVING).is_ok()
            && let Some(worker) = self.worker.take()
        {
            let _ = worker.join();
        }
    }
}

fn local_door(socket: &Path, keys: &Keys, inbox: &Arc<Inbox>) -> Result<Door, Error> {
    let endpoint = format!("unixsock-stream/{}", socket.display());
    let session = session::open(&Opening {
        listen: std::slice::from_ref(&endpoint),
        guard: Some(door::guard(keys, &[])),
        ..Opening::default()
    })
    .map_err(|error| cannot_listen(&endpoint, error))?;
    Door::open(Origin::Local, session, keys, inbox)
}

fn network_door(
    settings: &Settings,
    keys: &Keys,
    imports: &[Remote],
    inbox: &Arc<Inbox>,
) -> Result<Door, Error> {
    let mut peers: Vec<_> = imports.iter().map(|import| import.peer.clone()).collect();
    peers.sort();
    peers.dedup();
    // Zenoh reads those who may come in from a file.
    let users = settings
        .login
        .as_ref()
        .map(|login| {
            settings
                .folder
                .secret(&format!("{}:{}\n", login.user, login.password))
        })
        .transpose()?;
    let users_path = users.as_ref().map(crate::folder::Secret::path);
    let session = session::open(&Opening {
        listen: &settings.listen,
        connect: &settings.connect,
        patient: true,
        discover: settings.discover,
        login: settings.login.as_ref(),
        users: users_path.as_deref(),
        tls: settings.tls.as_ref(),
        guard: Some(door::guard(keys, &peers)),
    })
    .map_err(|error| cannot_listen(&settings.listen.join(", "), error))?;
    Door::open(Origin::Network, session, keys, inbox)
}

fn cannot_listen(endpoint: &str, error: Error) -> Error {
    match error {
        Error::Open(reason) if !endpoint.is_empty() => Error::Listen {
            endpoint: endpoint.to_owned(),
            reason,
        },
        other => other,
    }
}

/// Refuses what would open the network by accident.
fn check(settings: &Settings) -> Result<(), Error> {
    let known = settings.login.is_some() || settings.tls.as_ref().is_some_and(|tls| tls.clients);
    if !settings.insecure
        && !known
        && let Some(endpoint) = settings.listen.iter().find(|endpoint| !is_loopback(endpoint))
    {
        return Err(Error::Insecure {
            endpoint: endpoint.clone(),
        });
    }
    if let Some(login) = &settings.login
        && (login.user.is_empty()
            || login.password.is_empty()
            || login.user.contains([':', '\n'])
            || login.password.contains('\n'))
    {
        return Err(Error::Setting {
            key: "user",
            reason: "a user has no `:` in it, and a password is one line".to_owned(),
        });
    }
    Ok(())
}

/// Whether only this machine reaches an endpoint.
fn is_loopback(endpoint: &str) -> bool {
    let Some((protocol, rest)) = endpoint.split_once('/') else {
        return false;
    };
    if protocol == "unixsock-stream" {
        return true;
    }
    let address = rest.split(['?', '#']).next().unwrap_or(rest);
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost"
        || host
            .parse::<std::net::IpAddr>()
            .is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests;
