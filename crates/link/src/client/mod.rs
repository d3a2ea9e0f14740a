//! The tools' end of the link: finds applications and talks to them. Blocking calls and callbacks; every wait has its end.

mod choice;
mod connection;
mod events;
mod hold;
mod life;
mod panel;
mod remote;
mod sample;
mod watching;

use std::sync::Arc;
use std::time::Duration;

use crate::folder::{Entry, Folder};
use crate::keys::{EVERYBODY, PROTOCOL};
use crate::message::About;
use crate::session::{Login, Tls};
use crate::{Error, keys::Keys};
pub(crate) use connection::Connection;

pub use events::Happened;
pub use hold::Hold;
pub use panel::PanelSample;
pub use remote::Remote;
pub use sample::Sample;
pub use watching::Watching;

/// How long an application may take to answer.
const ANSWER: Duration = Duration::from_secs(5);

/// Where to look for applications.
#[derive(Clone, Debug)]
pub enum Reach {
    /// On this machine, those of this user.
    Local(Folder),
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
    Local(Folder),
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
        if about.protocol != PROTOCOL {
            return Err(Error::Version {
                application: about.name.clone(),
                theirs: about.protocol,
                theirs_version: about.version.clone(),
            });
        }
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
                let mut found: Vec<Found> = Vec::new();
                for connection in connections {
                    for answer in connection.ask(EVERYBODY, ANSWER)? {
                        // What cannot be read is no application of ours.
                        let Ok(about) = serde_json::from_slice::<About>(&answer) else {
                            continue;
                        };
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
            Place::Local(_) => "on this machine for this user".to_owned(),
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

fn keys(about: &About) -> Keys {
    Keys::new(&about.name, &about.id)
}
