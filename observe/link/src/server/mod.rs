//! The application's end of the link: announces the application, answers queries, publishes what clients
//! subscribe to, and carries out operators' requests. No action of a client blocks the application's threads;
//! all waiting is done on the link's own threads.

mod bucket;
mod cached_reply;
mod description;
mod events;
mod fair_queue;
mod imports;
mod inbox;
mod leases;
mod operator_workers;
mod panel_publisher;
mod peer;
mod publications;
mod repeats;
mod server_session;
mod stop_socket;
mod stopper;
mod subject;
mod value_publisher;
mod value_reader;
mod worker;

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

pub use bucket::TokenBucket;
pub use description::schemas;
pub use events::Events;
pub(crate) use subject::no_panel;
pub use subject::{OnDrawn, PanelViewer, Subject, SubjectInfo};

use jde_app::RemoteVariable;
pub use jde_app::link::Access;

use crate::folder::{Announcement, Claim, Folders};
use crate::keys::{Keys, OPERATE, PROTOCOL};
use crate::message::{About, Network};
use crate::session::{self, Login, SessionOptions, Tls};
use crate::{Error, whoami};
use imports::Imports;
use inbox::{Inbox, Origin};
use operator_workers::OperatorWorkers;
use peer::PeerSearch;
use server_session::ServerSession;
use stop_socket::StopSocket;
use stopper::Stopper;
use worker::Worker;

/// How long closing the link may take.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(3);

/// The configuration of a link.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The name by which others address the application.
    pub name: String,
    /// The name is mandatory: another application of that name is an error. Otherwise a taken name gets a
    /// number.
    pub require_name: bool,
    /// Endpoints on the network to listen on: `tcp/0.0.0.0:7447`.
    pub listen: Vec<String>,
    /// Endpoints on the network to connect to, retried forever.
    pub connect: Vec<String>,
    /// Discover peers by multicast.
    pub discover: bool,
    /// What clients on the network may do. Clients of the same user on the same machine may always operate.
    pub access: Access,
    /// The credentials presented to others and required of them.
    pub login: Option<Login>,
    /// Certificates.
    pub tls: Option<Tls>,
    /// Communicate with unauthenticated peers.
    pub insecure: bool,
    /// The folders in which applications of this user announce themselves.
    pub folder: Folders,
}

/// The link of a running application. Dropping it withdraws the announcement, notifies all peers and closes
/// the sessions, for which it waits at most 3 s.
pub struct Link {
    about: About,
    inbox: Arc<Inbox>,
    worker: Option<JoinHandle<()>>,
    /// Dropped before the sessions close, so that no client connects to a closing session.
    announced: Option<Announcement>,
    imports: Option<Imports>,
    stop_socket: Option<StopSocket>,
    stopped: mpsc::Receiver<()>,
}

impl Settings {
    /// Settings of an application that only this user can reach, on this machine.
    #[must_use]
    pub fn local(name: &str) -> Self {
        Self {
            name: crate::keys::as_name(name),
            require_name: false,
            listen: Vec::new(),
            connect: Vec::new(),
            discover: false,
            access: Access::default(),
            login: None,
            tls: None,
            insecure: false,
            folder: Folders::of_user(),
        }
    }

    /// Whether the settings use the network.
    #[must_use]
    pub fn is_networked(&self) -> bool {
        !self.listen.is_empty() || !self.connect.is_empty() || self.discover
    }
}

impl Link {
    /// Announces an application and serves its clients until the link is dropped.
    ///
    /// # Errors
    /// [`Error`]: a taken name, an unsafe folder, a port in use, or a network that would admit anybody.
    pub fn open(settings: &Settings, subject: Arc<dyn Subject>, events: &Events) -> Result<Self, Error> {
        check(settings)?;
        let claim = settings.folder.claim(&settings.name, settings.require_name)?;
        let info = subject.info();
        let about = About {
            name: claim.name.clone(),
            id: claim.id.clone(),
            protocol: PROTOCOL,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            host: whoami::host(),
            user: whoami::user(),
            pid: std::process::id(),
            application: info.application,
            file: info.file,
            started_ns: SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)),
            executor: info.executor,
            speed: info.speed,
            network: match (settings.is_networked(), settings.access) {
                (false, _) => Network::Closed,
                (true, Access::Read) => Network::Read,
                (true, Access::Operate) => Network::Operate,
            },
        };
        let keys = Keys::new(&about.name, &about.id);
        let inbox = Arc::new(Inbox::new());
        let mut sessions = vec![open_local_session(&claim.socket(), &keys, &inbox)?];
        if settings.is_networked() {
            sessions.push(open_network_session(
                settings,
                &claim,
                &keys,
                subject.imports(),
                &inbox,
            )?);
        }
        let search = Arc::new(PeerSearch {
            folder: settings.folder.clone(),
            network: sessions.get(1).map(|session| session.session.clone()),
        });
        let operator_workers = OperatorWorkers::start(Arc::clone(&subject), Arc::clone(&inbox))?;
        let imports = match subject.imports() {
            [] => None,
            _ => Some(Imports::start(&subject, &search)?),
        };
        let stop_socket = StopSocket::open(&claim.stop_socket(), Arc::clone(&subject), Arc::clone(&inbox))?;
        let announced = claim.announce(&about)?;
        let publish_sessions: Vec<_> = sessions
            .iter()
            .map(|session| (session.origin, session.session.clone()))
            .collect();
        let (publish_inbox, publish_subject, publish_keys) =
            (Arc::clone(&inbox), Arc::clone(&subject), keys.clone());
        let values = std::thread::Builder::new()
            .name("link-values".to_owned())
            .spawn(move || {
                session::lower_priority();
                publications::run(&publications::PublishContext {
                    subject: &*publish_subject,
                    inbox: &publish_inbox,
                    sessions: &publish_sessions,
                    keys: &publish_keys,
                });
            })
            .map_err(Error::Thread)?;
        let values_thread = values.thread().clone();
        let stopper = Stopper {
            subject: Arc::clone(&subject),
            inbox: Arc::clone(&inbox),
            key: keys.of(OPERATE),
            network: about.network,
        };
        let stops = std::thread::Builder::new()
            .name("link-stop".to_owned())
            .spawn(move || stopper.run())
            .map_err(|error| {
                inbox.stop();
                values_thread.unpark();
                Error::Thread(error)
            })?;
        let stop_thread = stops.thread().clone();
        let worker = Worker::new(
            subject,
            Arc::clone(&inbox),
            keys,
            &about,
            sessions,
            operator_workers,
            events.history(),
        )
        .with_threads(vec![values, stops]);
        let (done, stopped) = mpsc::channel();
        let worker = std::thread::Builder::new()
            .name("link".to_owned())
            .spawn(move || {
                session::lower_priority();
                worker.run();
                let _ = done.send(());
            })
            .map_err(|error| {
                inbox.stop();
                values_thread.unpark();
                stop_thread.unpark();
                Error::Thread(error)
            })?;
        inbox.attach(worker.thread(), &values_thread, &stop_thread);
        Ok(Self {
            about,
            inbox,
            worker: Some(worker),
            announced: Some(announced),
            imports,
            stop_socket: Some(stop_socket),
            stopped,
        })
    }

    /// The application's description as clients see it.
    #[must_use]
    pub fn about(&self) -> &About {
        &self.about
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        drop((
            self.announced.take(),
            self.imports.take(),
            self.stop_socket.take(),
        ));
        self.inbox.stop();
        // A client that takes no data must not prevent the application from ending.
        if self.stopped.recv_timeout(CLOSE_TIMEOUT).is_ok()
            && let Some(worker) = self.worker.take()
        {
            let _ = worker.join();
        }
    }
}

fn open_local_session(socket: &Path, keys: &Keys, inbox: &Arc<Inbox>) -> Result<ServerSession, Error> {
    let endpoint = format!("unixsock-stream/{}", socket.display());
    let session = session::open(&SessionOptions {
        listen: std::slice::from_ref(&endpoint),
        access_control: Some(server_session::access_rules(keys, &[])),
        ..SessionOptions::default()
    })
    .map_err(|error| cannot_listen(&endpoint, error))?;
    ServerSession::open(Origin::Local, session, keys, inbox)
}

fn open_network_session(
    settings: &Settings,
    claim: &Claim,
    keys: &Keys,
    imports: &[RemoteVariable],
    inbox: &Arc<Inbox>,
) -> Result<ServerSession, Error> {
    let mut peers: Vec<_> = imports.iter().map(|import| import.peer.clone()).collect();
    peers.sort();
    peers.dedup();
    // Zenoh reads the admitted users from a file.
    let users = settings
        .login
        .as_ref()
        .map(|login| claim.secret(&format!("{}:{}\n", login.user, login.password)))
        .transpose()?;
    let users_path = users.as_ref().map(crate::folder::Secret::path);
    let session = session::open(&SessionOptions {
        listen: &settings.listen,
        connect: &settings.connect,
        retry: true,
        discover: settings
            .discover
            .then_some(if settings.insecure && settings.login.is_none() {
                &["tcp", "tls"]
            } else {
                &["tls"]
            }),
        login: settings.login.as_ref(),
        users: users_path.as_deref(),
        tls: settings.tls.as_ref(),
        access_control: Some(server_session::access_rules(keys, &peers)),
    })
    .map_err(|error| cannot_listen(&settings.listen.join(", "), error))?;
    ServerSession::open(Origin::Network, session, keys, inbox)
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

/// Refuses settings under which a peer could connect without authentication. Zenoh does not report over which
/// connection a message arrived, so every connection must be authenticated: an incoming one by a certificate
/// of the authority or by the password within TLS, an outgoing one by a certificate of the authority.
fn check(settings: &Settings) -> Result<(), Error> {
    let tls = settings.tls.as_ref();
    let authority = tls.is_some_and(|tls| tls.authority.is_some());
    let authenticates_clients = settings.login.is_some() || tls.is_some_and(|tls| tls.clients);
    let is_authenticated = |endpoint: &String| authority && endpoint.starts_with("tls/");
    let endpoints = || settings.listen.iter().chain(&settings.connect);
    if settings.login.is_some()
        && let Some(endpoint) = endpoints().find(|endpoint| !is_authenticated(endpoint))
    {
        return Err(Error::PlainPassword {
            endpoint: endpoint.clone(),
        });
    }
    if !settings.insecure {
        let mut listen = settings.listen.iter();
        if let Some(endpoint) = listen.find(|endpoint| !(is_authenticated(endpoint) && authenticates_clients))
        {
            return Err(Error::Insecure {
                endpoint: endpoint.clone(),
            });
        }
        let unauthenticated = settings
            .connect
            .iter()
            .find(|endpoint| !is_authenticated(endpoint))
            .cloned();
        let discovered = (settings.discover && !authority).then(|| "peers found by multicast".to_owned());
        if let Some(endpoint) = unauthenticated.or(discovered) {
            return Err(Error::Unproven { endpoint });
        }
    }
    settings.login.as_ref().map_or(Ok(()), Login::check)
}

#[cfg(test)]
mod tests;
