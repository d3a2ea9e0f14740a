//! What the agent holds (R14): leases that end with this process, or when the agent releases them. It ends no hold of
//! anybody else.

use std::collections::BTreeMap;

use jde_link::message::{Action, Request};
use jde_link::{Hold, Remote};
use parking_lot::Mutex;

use crate::cli::tools::client::operate::begin_hold;
use crate::failure::Failure;

/// The most holds at once: an application has 256 leases for all its clients.
const MAX_HOLDS: usize = 64;

/// What is held of a schema. An action takes the place of the one before in the same slot.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Slot {
    /// Played or stopped.
    Awake,
    Forced,
    Period,
    Modulation(String),
}

/// An application's id, a schema, and what is held of it.
type Key = (String, String, Slot);

/// The holds of the agent.
#[derive(Default)]
pub(super) struct Holds {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    holds: BTreeMap<Key, Hold>,
    has_ended: bool,
}

impl Holds {
    /// Begins a hold. Returns what awake schemas lose by it; empty if nothing.
    ///
    /// # Errors
    /// The application refuses it, the agent holds too much, or the server ends.
    pub(super) fn begin(&self, remote: &Remote, request: &Request) -> Result<String, Failure> {
        let schema = request.action.schema().to_owned();
        let key = (remote.about().id.clone(), schema, slot(&request.action)?);
        let before = {
            let mut state = self.state.lock();
            state.check(&key)?;
            // The agent's own stop would refuse its play.
            match request.action {
                Action::Play { .. } => state.holds.remove(&key),
                _ => None,
            }
        };
        drop(before);
        let hold = begin_hold(remote, request)?;
        let losses = hold.losses().to_owned();
        let mut state = self.state.lock();
        if state.has_ended {
            drop(state);
            drop(hold);
            return Err(ended());
        }
        let before = state.holds.insert(key, hold);
        // To end it may take seconds.
        drop(state);
        drop(before);
        Ok(losses)
    }

    /// Ends everything that the agent holds of a schema. Returns how many holds that were.
    pub(super) fn release(&self, remote: &Remote, schema: &str) -> usize {
        let id = &remote.about().id;
        let of_schema = |key: &Key| key.0 == *id && key.1 == schema;
        let mut state = self.state.lock();
        let released: Vec<Hold> = state
            .holds
            .extract_if(.., |key, _| of_schema(key))
            .map(|(_, hold)| hold)
            .collect();
        drop(state);
        // Those that somebody else has ended are not counted.
        released.iter().filter(|hold| hold.lost().is_none()).count()
    }

    /// Ends all holds, at the same time, and refuses further ones.
    pub(super) fn end(&self) {
        let mut state = self.state.lock();
        state.has_ended = true;
        let holds = std::mem::take(&mut state.holds);
        drop(state);
        std::thread::scope(|scope| {
            for hold in holds.into_values() {
                scope.spawn(move || drop(hold));
            }
        });
    }
}

impl State {
    fn check(&mut self, key: &Key) -> Result<(), Failure> {
        if self.has_ended {
            return Err(ended());
        }
        self.holds.retain(|_, hold| hold.lost().is_none());
        if self.holds.len() >= MAX_HOLDS && !self.holds.contains_key(key) {
            return Err(Failure::broken(format!(
                "the agent holds {MAX_HOLDS} things already"
            )));
        }
        Ok(())
    }
}

fn ended() -> Failure {
    Failure::broken("the server ends")
}

fn slot(action: &Action) -> Result<Slot, Failure> {
    match action {
        Action::Play { .. } | Action::Stop { .. } => Ok(Slot::Awake),
        Action::Force { .. } => Ok(Slot::Forced),
        Action::Period { .. } => Ok(Slot::Period),
        Action::Modulate { variable, .. } => Ok(Slot::Modulation(variable.clone())),
        _ => Err(Failure::broken("this action is no hold")),
    }
}
