//! One application from which variables are imported. A thread of its own searches for the peer on this
//! machine and on the network, subscribes to it while it is there, and searches again when it is gone.

use std::collections::BTreeSet;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use jde_ros::definition;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::imports::ImportState;
use crate::client::{Connection, Remote, Subscription, check_version};
use crate::folder::Folders;
use crate::keys::{self, Keys, Rate};
use crate::{Error, session};

/// Pause between two searches for an absent peer.
const SEARCH_PAUSE: Duration = Duration::from_millis(500);

/// Where peers are searched.
pub(super) struct Search {
    pub(super) folder: Folders,
    /// The network session of `[link]`, if it opened one.
    pub(super) network: Option<Session>,
}

/// Wakes the thread that waits for a peer.
#[derive(Default)]
struct Waker {
    state: Mutex<PeerState>,
    condvar: Condvar,
}

#[derive(Default)]
struct PeerState {
    is_woken: bool,
    /// Ids of the peer's instances that are alive on the network.
    alive: BTreeSet<String>,
}

/// Starts following a peer until the imports stop.
pub(super) fn follow(
    name: &str,
    places: Vec<usize>,
    inner: &Arc<ImportState>,
    search: &Arc<Search>,
) -> Result<(), Error> {
    let peer = Peer {
        name: name.to_owned(),
        slots: places,
        inner: Arc::clone(inner),
        search: Arc::clone(search),
        waker: Arc::default(),
    };
    std::thread::Builder::new()
        .name("link-peer".to_owned())
        .spawn(move || {
            session::lower_priority();
            peer.run();
        })
        .map(drop)
        .map_err(Error::Thread)
}

struct Peer {
    name: String,
    /// Indices of the imports from this peer.
    slots: Vec<usize>,
    inner: Arc<ImportState>,
    search: Arc<Search>,
    waker: Arc<Waker>,
}

impl Peer {
    fn run(self) {
        let _watch = self.search.network.as_ref().map(|session| self.listen(session));
        let mut last_trouble = None;
        while !self.inner.is_stopping() {
            match self.find() {
                Ok(Some(remote)) => {
                    last_trouble = None;
                    let bell = Arc::clone(&self.waker);
                    remote.on_gone(move || bell.wake());
                    let mut missing = self.slots.clone();
                    let mut watching = self.import(&remote, &mut missing);
                    tracing::info!(peer = self.name, "found on {}", remote.about().host);
                    while remote.is_alive() && !self.inner.is_stopping() {
                        self.waker.wait();
                        watching.extend(self.import(&remote, &mut missing));
                    }
                    drop(watching);
                    self.slots.iter().for_each(|place| self.inner.retract(*place));
                    if !self.inner.is_stopping() {
                        tracing::warn!(peer = self.name, "gone; what it exports is taken back");
                    }
                }
                Ok(None) => self.waker.wait(),
                Err(error) => {
                    let trouble = error.to_string();
                    if last_trouble.as_ref() != Some(&trouble) {
                        tracing::warn!(peer = self.name, "{trouble}");
                    }
                    last_trouble = Some(trouble);
                    self.waker.wait();
                }
            }
        }
    }

    /// Subscribes to the peer's liveliness on the network.
    fn listen(&self, session: &Session) -> Option<zenoh::pubsub::Subscriber<()>> {
        let bell = Arc::clone(&self.waker);
        let subscriber = session
            .liveliness()
            .declare_subscriber(format!("{}/{}", keys::of_name(&self.name), keys::ALIVE))
            .history(true)
            .callback(move |token| {
                if let Some(id) = token.key_expr().as_str().split('/').nth(3) {
                    bell.set_alive(id, token.kind() == SampleKind::Put);
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
        let (Some(session), Some(id)) = (&self.search.network, self.waker.first_alive()) else {
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
    fn import(&self, remote: &Remote, missing: &mut Vec<usize>) -> Vec<Subscription> {
        let own = self.inner.subject.info().speed;
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
                inner.receive(place, sample, ratio);
            })
        };
        let mut watching = Vec::new();
        missing.retain(|place| match watch(*place) {
            Ok(watch) => {
                watching.push(watch);
                false
            }
            Err(Error::Timeout { .. } | Error::Disconnected(_)) => true,
            Err(error) => {
                tracing::error!(peer = self.name, "not imported: {error}");
                false
            }
        });
        watching
    }
}

impl Waker {
    fn wake(&self) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).is_woken = true;
        self.condvar.notify_all();
    }

    fn set_alive(&self, id: &str, there: bool) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if there {
            state.alive.insert(id.to_owned());
        } else {
            state.alive.remove(id);
        }
        drop(state);
        self.wake();
    }

    fn first_alive(&self) -> Option<String> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.alive.first().cloned()
    }

    /// Waits until the bell rings or the next search is due.
    fn wait(&self) {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut state, _) = self
            .condvar
            .wait_timeout_while(state, SEARCH_PAUSE, |state| !state.is_woken)
            .unwrap_or_else(PoisonError::into_inner);
        state.is_woken = false;
    }
}
