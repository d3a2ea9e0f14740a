//! One application from which variables are imported. A thread of its own searches for the peer on this
//! machine and on the network, subscribes to it while it is alive, and searches again when it is gone.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use jde_ros::definition;
use parking_lot::{Condvar, Mutex};
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
pub(super) struct PeerSearch {
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
    slots: Vec<usize>,
    state: &Arc<ImportState>,
    search: &Arc<PeerSearch>,
) -> Result<(), Error> {
    let peer = Peer {
        name: name.to_owned(),
        slots,
        state: Arc::clone(state),
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
    state: Arc<ImportState>,
    search: Arc<PeerSearch>,
    waker: Arc<Waker>,
}

impl Peer {
    fn run(self) {
        let _watch = self.search.network.as_ref().map(|session| self.listen(session));
        let mut last_error = None;
        while !self.state.is_stopping() {
            match self.find() {
                Ok(Some(remote)) => {
                    last_error = None;
                    let waker = Arc::clone(&self.waker);
                    remote.on_gone(move || waker.wake());
                    let mut missing = self.slots.clone();
                    let mut subscriptions = self.import(&remote, &mut missing);
                    tracing::info!(peer = self.name, "found on {}", remote.about().host);
                    while remote.is_alive() && !self.state.is_stopping() {
                        self.waker.wait();
                        subscriptions.extend(self.import(&remote, &mut missing));
                    }
                    drop(subscriptions);
                    self.slots.iter().for_each(|slot| self.state.retract(*slot));
                    if !self.state.is_stopping() {
                        tracing::warn!(peer = self.name, "gone; its values are retracted");
                    }
                }
                Ok(None) => self.waker.wait(),
                Err(error) => {
                    let text = error.to_string();
                    if last_error.as_ref() != Some(&text) {
                        tracing::warn!(peer = self.name, "{text}");
                    }
                    last_error = Some(text);
                    self.waker.wait();
                }
            }
        }
    }

    /// Subscribes to the peer's liveliness on the network.
    fn listen(&self, session: &Session) -> Option<zenoh::pubsub::Subscriber<()>> {
        let waker = Arc::clone(&self.waker);
        let subscriber = session
            .liveliness()
            .declare_subscriber(format!("{}/{}", keys::of_name(&self.name), keys::ALIVE))
            .history(true)
            .callback(move |token| {
                if let Some(id) = token.key_expr().as_str().split('/').nth(3) {
                    waker.set_alive(id, token.kind() == SampleKind::Put);
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
    /// stays without a value. One for which the peer sent no reply in time stays missing and is requested
    /// again.
    fn import(&self, remote: &Remote, missing: &mut Vec<usize>) -> Vec<Subscription> {
        let own = self.state.subject.info().speed;
        let ratio = own / remote.about().speed.max(f64::MIN_POSITIVE);
        let watch = |slot: usize| {
            let import = &self.state.slots[slot].import;
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
                        "`{}` of `{}` is a {} with the peer's layout, but a {} is imported",
                        import.variable,
                        self.name,
                        variable.type_name,
                        definition::name(&import.value_type)
                    ),
                    nearest: None,
                });
            }
            let (state, value_type) = (Arc::clone(&self.state), Arc::clone(&import.value_type));
            remote.watch_as(&variable, value_type, Rate::Full, move |sample| {
                state.receive(slot, sample, ratio);
            })
        };
        let mut subscriptions = Vec::new();
        missing.retain(|slot| match watch(*slot) {
            Ok(subscription) => {
                subscriptions.push(subscription);
                false
            }
            Err(Error::Timeout { .. } | Error::Disconnected(_)) => true,
            Err(error) => {
                tracing::error!(peer = self.name, "a variable cannot be imported: {error}");
                false
            }
        });
        subscriptions
    }
}

impl Waker {
    fn wake(&self) {
        self.state.lock().is_woken = true;
        self.condvar.notify_all();
    }

    fn set_alive(&self, id: &str, is_alive: bool) {
        let mut state = self.state.lock();
        if is_alive {
            state.alive.insert(id.to_owned());
        } else {
            state.alive.remove(id);
        }
        drop(state);
        self.wake();
    }

    fn first_alive(&self) -> Option<String> {
        let state = self.state.lock();
        state.alive.first().cloned()
    }

    /// Waits until woken or until the next search is due.
    fn wait(&self) {
        let mut state = self.state.lock();
        self.condvar
            .wait_while_for(&mut state, |state| !state.is_woken, SEARCH_PAUSE);
        state.is_woken = false;
    }
}
