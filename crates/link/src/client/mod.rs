//! The tools' end of the link: finds applications and talks to them. Blocking calls and callbacks; every wait has its end.

mod choice;
mod connection;
mod events;
mod everything;
mod hold;
mod life;
mod panel;
mod remote;
mod sample;
mod watching;

use std::sync::Arc;
use std::time::Duration;

use crate::folder::{Entry, Folders};
use crate::keys::{EVERYBODY, PROTOCOL};
use crate::message::About;
use crate::session::{Login, Tls};
use crate::{Error, keys::Keys};
pub(crate) use connection::Connection;

pub use events::Happened;
pub use everything::{Heard, everything};
pub use hold::Hold;
pub use panel::PanelSample;
pub use remote::Remote;
pub use sample::Sample;
pub use watching::Watching;

/// Where those are that are not looked for on the network.
const HERE: &str = "on this machine for this user";

/// How long an application may take to answer.
const ANSWER: Duration = Duration::from_secs(5);

/// Where to look for applications.
#[derive(Clone, Debug)]
pub enum Reach {
    /// On this machine, those of this user.
    Local(Folders),
    /// On the network.
    Network {
        /// Where: `tcp/robot2.local:7447`, `tls/...`.
        endpoints: Vec<String>,
        /// Who we are.
        login: Option<Login>,
        /// Certificates; with an identity we show it.
        tls: Option<Tls>,
    },
}

/// Looks for applications.
pub struct Client {
    place: Place,
}

enum Place {
    Local(Folders),
    Network(Vec<Arc<Connection>>),
}

/// An application that was found, and how to get there.
enum Found {
    Local(Entry),
    Network(About, Arc<Connection>),
}

impl Client {
    /// Gets ready to look; connects to what is on the network.
    ///
    /// # Errors
    /// [`Error::Folder`]; [`Error::Connect`] if no endpoint lets us in. Takes 3 s at most.
    pub fn connect(reach: &Reach) -> Result<Self, Error> {
        let place = match reach {
            Reach::Local(folder) => {
                folder.list()?;
                Place::Local(folder.clone())
            }
            Reach::Network {
                endpoints,
                login,
                tls,
            } => Place::Network(connection::all(endpoints, login.as_ref(), tls.as_ref())?),
        };
        Ok(Self { place })
    }

    /// What runs there, in the order of start.
    ///
    /// # Errors
    /// [`Error::Folder`]. Takes 5 s at most.
    pub fn applications(&self) -> Result<Vec<About>, Error> {
        Ok(self.found()?.iter().map(|found| found.about().clone()).collect())
    }

    /// Connects to an application: the one of that name, `name@` and the beginning of its id where several share the name, or
    /// the only one there is.
    ///
    /// # Errors
    /// [`Error::NothingRuns`], [`Error::Several`], [`Error::UnknownApplication`], [`Error::Version`], [`Error::NoAnswer`].
    /// Takes 8 s at most.
    pub fn application(&self, name: Option<&str>) -> Result<Remote, Error> {
        let mut found = self.found()?;
        let abouts: Vec<&About> = found.iter().map(Found::about).collect();
        let place = choice::choose(&abouts, name, &self.whereabouts())?;
        let found = found.swap_remove(place);
        let about = found.about();
        check_version(about)?;
        match found {
            Found::Local(entry) => {
                let connection = Connection::local(&entry)?;
                Remote::new(Arc::new(connection), entry.about)
            }
            Found::Network(about, connection) => Remote::new(connection, about),
        }
    }

    fn found(&self) -> Result<Vec<Found>, Error> {
        match &self.place {
            Place::Local(folder) => Ok(folder.list()?.into_iter().map(Found::Local).collect()),
            Place::Network(connections) => {
                // All at once: one that is silent keeps nobody waiting for the others.
                let answers = at_once(connections, |connection| {
                    let mut abouts: Vec<About> = Vec::new();
                    connection.ask(EVERYBODY, None, ANSWER, |_, answer| {
                        // What cannot be read is no application of ours.
                        let about = answer
                            .ok()
                            .and_then(|answer| serde_json::from_slice(&answer).ok());
                        abouts.extend(about);
                    })?;
                    Ok(abouts)
                });
                let mut found: Vec<Found> = Vec::new();
                for (connection, abouts) in connections.iter().zip(answers) {
                    for about in abouts? {
                        if !found.iter().any(|known| known.about().id == about.id) {
                            found.push(Found::Network(about, Arc::clone(connection)));
                        }
                    }
                }
                found.sort_by_key(|found| found.about().started_ns);
                Ok(found)
            }
        }
    }

    fn whereabouts(&self) -> String {
        match &self.place {
            Place::Local(_) => HERE.to_owned(),
            Place::Network(connections) => {
                let endpoints: Vec<_> = connections
                    .iter()
                    .map(|connection| connection.endpoint())
                    .collect();
                format!("at {}", endpoints.join(", "))
            }
        }
    }
}

impl Found {
    fn about(&self) -> &About {
        match self {
            Self::Local(entry) => &entry.about,
            Self::Network(about, _) => about,
        }
    }
}

/// Does something with each of several at the same time, and answers in their order.
fn at_once<T: Sync, R: Send>(several: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = several
            .iter()
            .map(|one| {
                let work = &work;
                scope.spawn(move || work(one))
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
