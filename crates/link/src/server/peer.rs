//! One application from which variables are imported. A thread of its own searches for the peer on this
//! machine and on the network, subscribes to it while it is there, and searches again when it is gone.

use std::collections::BTreeSet;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use jde_ros::definition;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::imports::Inner;
use crate::client::{Connection, Remote, Watching, check_version};
use crate::folder::Folders;
use crate::keys::{self, Keys, Rate};
use crate::{Error, session};

/// Pause between two searches for an absent peer.
const LOOK: Duration = Duration::from_millis(500);

/// Where peers are searched.
pub(super) struct Search {
    pub(super) folder: Folders,
    /// The network session of `[link]`, if it opened one.
    pub(super) network: Option<Session>,
}

/// Wakes the thread that waits for a peer.
#[derive(Default)]
struct Bell {
    state: Mutex<Heard>,
    rung: Condvar,
}

#[derive(Default)]
struct Heard {
    rung: bool,
    /// Ids of the peer's instances that are alive on the network.
    alive: BTreeSet<String>,
}

/// Starts following a peer until the imports stop.
pub(super) fn follow(
    name: &str,
    places: Vec<usize>,
    inner: &Arc<Inner>,
    search: &Arc<Search>,
) -> Result<(), Error> {
    let peer = Peer {
        name: name.to_owned(),
        places,
        inner: Arc::clone(inner),
        search: Arc::clone(search),
        bell: Arc::default(),
    };
    std::thread::Builder::new()
        .name("link-peer".to_owned())
        .spawn(move || {
            session::give_way();
            peer.run();
        })
        .map(drop)
        .map_err(Error::Thread)
}

struct Peer {
    name: String,
    /// Indices of the imports from this peer.
    places: Vec<usize>,
    inner: Arc<Inner>,
    search: Arc<Search>,
    bell: Arc<Bell>,
}

impl Peer {
    fn run(self) {
        let _watch = self.search.network.as_ref().map(|session| self.listen(session));
        let mut last_trouble = None;
        while !self.inner.stopping() {
            match self.find() {
                Ok(Some(remote)) => {
                    last_trouble = None;
                    let bell = Arc::clone(&self.bell);
                    remote.on_gone(move || bell.ring());
                    let mut missing = self.places.clone();
                    let mut watching = self.import(&remote, &mut missing);
                    tracing::info!(peer = self.name, "found on {}", remote.about().host);
                    while remote.alive() && !self.inner.stopping() {
                        self.bell.wait();
                        watching.extend(self.import(&remote, &mut missing));
                    }
                    drop(watching);
                    self.places.iter().for_each(|place| self.inner.gone(*place));
                    if !self.inner.stopping() {
                        tracing::warn!(peer = self.name, "gone; what it exports is taken back");
                    }
                }
                Ok(None) => self.bell.wait(),
                Err(error) => {
                    let trouble = error.to_string();
                    if last_trouble.as_ref() != Some(&trouble) {
                        tracing::warn!(peer = self.name, "{trouble}");
                    }
                    last_trouble = Some(trouble);
                    self.bell.wait();
                }
            }
        }
    }

    /// Subscribes to the peer's liveliness on the network.
    fn listen(&self, session: &Session) -> Option<zenoh::pubsub::Subscriber<()>> {
        let bell = Arc::clone(&self.bell);
        let subscriber = session
            .liveliness()
            .declare_subscriber(format!("{}/{}", keys::of_name(&self.name), keys::ALIVE))
            .history(true)
            .callback(move |token| {
                if let Some(id) = token.key_expr().as_str().split('/').nth(3) {
                    bell.alive(id, token.kind() == SampleKind::Put);
                }
            })
            .wait();
        subscriber
            .inspect_err(|error| tracing::warn!("peers on the network are not found: {error}"))
            .ok()
    }

    fn find(&self) -> Result<Option<Remote>, Error> {
        let entries = self.search.folder.list()?;
        if let Some(entry) = entries.into_iter().find(|entry| entry.about.name == self.name) {
            check_version(&entry.about)?;
            let connection = Connection::local(&entry)?;
            return Remote::new(Arc::new(connection), entry.about).map(Some);
        }
        let (Some(session), Some(id)) = (&self.search.network, self.bell.first()) else {
            return Ok(None);
        };
        let connection = Connection::shared(session.clone(), &self.name)?;
        let key = Keys::new(&self.name, &id).of(keys::ABOUT);
        let about = connection.about(&key)?;
        check_version(&about)?;
        Remote::new(Arc::new(connection), about).map(Some)
    }

    /// Subscribes to the missing imports. An import that the peer does not have, or has with another type,
    /// stays without a value. One that was not answered in time stays missing and is requested again.
    fn import(&self, remote: &Remote, missing: &mut Vec<usize>) -> Vec<Watching> {
        let own = self.inner.subject.title().speed;
        let ratio = own / remote.about().speed.max(f64::MIN_POSITIVE);
        let watch = |place: usize| {
            let import = &self.inner.slots[place].import;
            let variable = remote.variable(&import.variable)?;
            // Docs may differ between two versions of a plugin; layouts must not.
            let ours = definition::read(&variable.type_name, &definition::definition(&import.value_type));
            let same = match (ours, variable.value_type()) {
                (Ok(ours), Ok(theirs)) => {
                    definition::name(&import.value_type) == variable.type_name && ours.same_as(&theirs)
                }
                _ => false,
            };
            if !same {
                return Err(Error::Refused {
                    text: format!(
                        "`{}` of `{}` is a {} laid out as there, and a {} is imported",
                        import.variable,
                        self.name,
                        variable.type_name,
                        definition::name(&import.value_type)
                    ),
                    nearest: None,
                });
            }
            let (inner, native) = (Arc::clone(&self.inner), Arc::clone(&import.value_type));
            remote.watch_as(&variable, native, Rate::Full, move |sample| {
                inner.came(place, sample, ratio);
            })
        };
        let mut watching = Vec::new();
        missing.retain(|place| match watch(*place) {
            Ok(watch) => {
                watching.push(watch);
                false
            }
            Err(Error::NoAnswer { .. } | Error::Gone(_)) => true,
            Err(error) => {
                tracing::error!(peer = self.name, "not imported: {error}");
                false
            }
        });
        watching
    }
}

impl Bell {
    fn ring(&self) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).rung = true;
        self.rung.notify_all();
    }

    fn alive(&self, id: &str, there: bool) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if there {
            state.alive.insert(id.to_owned());
        } else {
            state.alive.remove(id);
        }
        drop(state);
        self.ring();
    }

    fn first(&self) -> Option<String> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.alive.first().cloned()
    }

    /// Waits until the bell rings or the next search is due.
    fn wait(&self) {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut state, _) = self
            .rung
            .wait_timeout_while(state, LOOK, |state| !state.rung)
            .unwrap_or_else(PoisonError::into_inner);
        state.rung = false;
    }
}
