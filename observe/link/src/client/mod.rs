//! The tools' end of the link: finds applications and sends them requests. Blocking calls and callbacks;
//! every wait is bounded.

mod broadcast;
mod choice;
mod complaint;
mod connection;
mod datagram;
mod endpoint;
mod events;
mod hold;
mod liveliness;
mod panel;
mod remote;
mod sample;
mod subscription;

use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;

use crate::folder::{Folders, RunningEntry};
use crate::keys::{ALL_ABOUT, PROTOCOL};
use crate::message::About;
use crate::session::{Login, Tls};
use crate::{Error, decode, keys::Keys};
pub(crate) use connection::Connection;

pub use broadcast::{Broadcast, BroadcastOutcome, broadcast};
pub use endpoint::complete_endpoint;
pub use events::ReceivedEvent;
pub use hold::Hold;
pub use panel::PanelSample;
pub use remote::Remote;
pub use sample::{Sample, ValueBytes};
pub use subscription::Subscription;

/// Where local applications are searched, for error texts.
const ON_THIS_MACHINE: &str = "on this machine for this user";

/// Longest wait for a reply.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);

/// Where to look for applications.
#[derive(Clone, Debug)]
pub enum Reach {
    /// This user's applications on this machine.
    Local(Folders),
    /// On the network.
    Network {
        /// The endpoints: `tcp/robot2.local:7447`, `tls/...`.
        endpoints: Vec<String>,
        /// The client's credentials.
        login: Option<Login>,
        /// Certificates; an identity is presented to the other end.
        tls: Option<Tls>,
    },
}

/// Looks for applications.
pub struct Client {
    backend: Backend,
    /// The endpoints that could not be connected to.
    unconnected: Vec<Unanswered>,
    /// What the last search got no answer from, or none that makes sense.
    unanswered: Mutex<Vec<Unanswered>>,
}

/// An endpoint or an application that gave no answer, or none that makes sense.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unanswered {
    /// The endpoint, or the name in the key of the answer.
    pub target: String,
    /// The reason as a sentence that names the target.
    pub reason: String,
}

impl Unanswered {
    fn new(target: &str, error: &Error) -> Self {
        Self {
            target: target.to_owned(),
            reason: error.to_string(),
        }
    }
}

enum Backend {
    Local(Folders),
    Network(Vec<Arc<Connection>>),
}

/// An application that was found, and its access.
enum Discovered {
    Local(RunningEntry),
    Network(About, Arc<Connection>),
}

impl Client {
    /// Prepares the search; connects to endpoints on the network.
    ///
    /// # Errors
    /// [`Error::Folder`]; [`Error::Connect`] if no endpoint accepts, and [`Error::Several`] of these if there are
    /// several. Takes at most 5 s on this machine, 4 s on the network.
    pub fn connect(reach: &Reach) -> Result<Self, Error> {
        let mut unconnected = Vec::new();
        let backend = match reach {
            Reach::Local(folder) => {
                folder.list()?;
                Backend::Local(folder.clone())
            }
            Reach::Network {
                endpoints,
                login,
                tls,
            } => {
                let (connections, failed) = connection::connect_all(endpoints, login.as_ref(), tls.as_ref())?;
                unconnected = failed;
                Backend::Network(connections)
            }
        };
        Ok(Self {
            backend,
            unconnected,
            unanswered: Mutex::default(),
        })
    }

    /// Returns the endpoints, and the applications there, from which the last search got no answer, or none that
    /// makes sense.
    #[must_use]
    pub fn unanswered(&self) -> Vec<Unanswered> {
        let last = self.unanswered.lock();
        self.unconnected.iter().chain(&*last).cloned().collect()
    }

    /// Lists the running applications in order of their start.
    ///
    /// # Errors
    /// [`Error::Folder`]. Takes 5 s at most.
    pub fn applications(&self) -> Result<Vec<About>, Error> {
        Ok(self
            .discover()?
            .iter()
            .map(|found| found.about().clone())
            .collect())
    }

    /// Connects to an application: the one of that name, or the only one. `name@` and the beginning of the id
    /// selects among several of the same name.
    ///
    /// # Errors
    /// [`Error::NoApplication`], [`Error::Ambiguous`], [`Error::UnknownApplication`], [`Error::Version`],
    /// [`Error::Timeout`]. Takes at most 13 s on this machine, 8 s on the network.
    pub fn application(&self, name: Option<&str>) -> Result<Remote, Error> {
        let mut found = self.discover()?;
        let abouts: Vec<&About> = found.iter().map(Discovered::about).collect();
        let index = choice::choose(&abouts, name, &self.describe_backend())
            .map_err(|error| self.with_unanswered(error))?;
        let found = found.swap_remove(index);
        let about = found.about();
        check_version(about)?;
        match found {
            Discovered::Local(entry) => {
                let connection = Connection::local(&entry)?;
                Remote::new(Arc::new(connection), entry.about)
            }
            Discovered::Network(about, connection) => Remote::new(connection, about),
        }
    }

    fn discover(&self) -> Result<Vec<Discovered>, Error> {
        match &self.backend {
            Backend::Local(folder) => Ok(folder.list()?.into_iter().map(Discovered::Local).collect()),
            Backend::Network(connections) => {
                // All concurrently: a silent endpoint delays no other.
                let replies = map_concurrently(connections, |connection| {
                    let (mut abouts, mut unanswered) = (Vec::new(), Vec::new());
                    let endpoint = connection.endpoint();
                    let outcome = connection.query(ALL_ABOUT, None, REPLY_TIMEOUT, |key, reply| {
                        let name = key.split('/').nth(2).unwrap_or(endpoint);
                        let about = reply.map_err(Error::from).and_then(|message| {
                            decode::about_at(key, &message).map_err(|refused| Error::refused(name, refused))
                        });
                        match about {
                            Ok(about) => abouts.push(about),
                            Err(error) => unanswered.push(Unanswered::new(name, &error)),
                        }
                    });
                    let silent = match outcome {
                        Ok(true) if abouts.is_empty() && unanswered.is_empty() => {
                            Some(Error::NoApplication(format!("at {endpoint}")))
                        }
                        Ok(true) => None,
                        Ok(false) => Some(Error::Timeout {
                            application: endpoint.to_owned(),
                            waited: REPLY_TIMEOUT,
                        }),
                        Err(error) => Some(error),
                    };
                    unanswered.extend(silent.map(|error| Unanswered::new(endpoint, &error)));
                    (abouts, unanswered)
                });
                let mut found: Vec<Discovered> = Vec::new();
                let mut last = Vec::new();
                for (connection, (abouts, unanswered)) in connections.iter().zip(replies) {
                    last.extend(unanswered);
                    for about in abouts {
                        if !found.iter().any(|known| known.about().id == about.id) {
                            found.push(Discovered::Network(about, Arc::clone(connection)));
                        }
                    }
                }
                found.sort_by_key(|found| found.about().started_ns);
                *self.unanswered.lock() = last;
                Ok(found)
            }
        }
    }

    /// Adds what gave no answer to an error: the application that was requested may be there.
    fn with_unanswered(&self, error: Error) -> Error {
        let text = error.to_string();
        let others = self.unanswered().into_iter().filter(|one| one.reason != text);
        let mut all = vec![error];
        all.extend(others.map(|one| Error::Unanswered(one.reason)));
        match all.len() {
            1 => all.remove(0),
            _ => Error::Several(all),
        }
    }

    fn describe_backend(&self) -> String {
        match &self.backend {
            Backend::Local(_) => ON_THIS_MACHINE.to_owned(),
            Backend::Network(connections) => {
                let endpoints: Vec<_> = connections
                    .iter()
                    .map(|connection| connection.endpoint())
                    .collect();
                format!("at {}", endpoints.join(", "))
            }
        }
    }
}

impl Discovered {
    fn about(&self) -> &About {
        match self {
            Self::Local(entry) => &entry.about,
            Self::Network(about, _) => about,
        }
    }
}

/// Applies `work` to all elements concurrently, and returns the results in their order.
fn map_concurrently<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = items
            .iter()
            .map(|item| {
                let work = &work;
                scope.spawn(move || work(item))
            })
            .collect();
        let joined = threads.into_iter().map(|thread| {
            thread
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        joined.collect()
    })
}

pub(crate) fn check_version(about: &About) -> Result<(), Error> {
    if about.protocol == PROTOCOL {
        return Ok(());
    }
    Err(Error::Version {
        application: about.name.clone(),
        theirs: about.protocol,
        theirs_version: about.version.clone(),
    })
}

fn keys(about: &About) -> Keys {
    Keys::new(&about.name, &about.id)
}
