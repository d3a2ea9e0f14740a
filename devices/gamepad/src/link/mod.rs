//! A gamepad that can appear and disappear. It is looked for and opened on a thread of its own, which may wait for the device,
//! and read in a step, which does not. All its transitions are here.

use core::time::Duration;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

use crate::layout::Controls;

/// Time between two searches.
const SEARCH_INTERVAL: Duration = Duration::from_millis(500);

/// A gamepad that is open.
pub trait Source: Send {
    /// Returns what is held now. It waits for nothing.
    ///
    /// # Errors
    /// If the gamepad is gone.
    fn read(&mut self) -> io::Result<Controls>;
}

/// The result of a search.
pub struct Found {
    /// The name of the gamepad, and where it is.
    pub name: String,
    /// The gamepad.
    pub source: Box<dyn Source>,
}

type Search = dyn Fn() -> Result<Found, String> + Send + Sync;

/// The connection to a gamepad.
pub struct Link {
    search: Arc<Search>,
    max_silence: Option<Duration>,
    state: State,
    attempts: u32,
}

enum State {
    Open {
        found: Found,
        /// What it held last, and since when.
        held: Option<(Controls, Duration)>,
        /// Why it counts as absent nevertheless: it is silent.
        silence: Option<String>,
    },
    Absent {
        /// Why it is absent; empty before the first search has ended.
        reason: String,
        search: Option<Receiver<Result<Found, String>>>,
        retry_at: Duration,
    },
}

/// The state of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkState<'a> {
    /// The first search has not ended.
    Searching,
    /// It is there: its name.
    Open(&'a str),
    /// It is not there: why.
    Absent(&'a str),
}

impl Link {
    /// Creates a connection that `search` finds; it runs on threads of its own. Nothing happens before the first step. A
    /// gamepad on which nothing changes for `max_silence` counts as absent until something does.
    pub fn new(
        search: impl Fn() -> Result<Found, String> + Send + Sync + 'static,
        max_silence: Option<Duration>,
    ) -> Self {
        Self {
            search: Arc::new(search),
            max_silence,
            state: State::Absent {
                reason: String::new(),
                search: None,
                retry_at: Duration::ZERO,
            },
            attempts: 0,
        }
    }

    /// Returns what is held at this moment, if the gamepad is there. Call it periodically.
    pub fn step(&mut self, now: Duration) -> Option<Controls> {
        match &mut self.state {
            State::Open { found, held, silence } => {
                match found.source.read() {
                    Ok(controls) => {
                        let since = held
                            .as_ref()
                            .filter(|(last, _)| *last == controls)
                            .map_or(now, |(_, since)| *since);
                        *held = Some((controls.clone(), since));
                        let limit = self
                            .max_silence
                            .filter(|limit| now.saturating_sub(since) >= *limit);
                        *silence = limit.map(|limit| {
                        let (name, limit) = (&found.name, limit.as_secs_f64());
                        format!("nothing has changed on {name} for {limit} s: is it out of reach? move a stick")
                    });
                        silence.is_none().then_some(controls)
                    }
                    Err(error) => {
                        let reason = format!("{} is gone: {error}", found.name);
                        self.lose(reason, now);
                        None
                    }
                }
            }
            State::Absent {
                search: None,
                retry_at,
                ..
            } if now < *retry_at => None,
            State::Absent { search, .. } => {
                let result = match search {
                    Some(result) => result.try_recv(),
                    None => {
                        self.attempts = self.attempts.saturating_add(1);
                        *search = Some(start(&self.search));
                        Err(TryRecvError::Empty)
                    }
                };
                match result {
                    Ok(Ok(found)) => {
                        self.attempts = 0;
                        self.state = State::Open {
                            found,
                            held: None,
                            silence: None,
                        };
                    }
                    Ok(Err(reason)) => self.lose(reason, now),
                    Err(TryRecvError::Disconnected) => {
                        self.lose("the search for a gamepad failed".to_owned(), now)
                    }
                    Err(TryRecvError::Empty) => {}
                }
                None
            }
        }
    }

    /// Returns the state of the connection.
    #[must_use]
    pub fn state(&self) -> LinkState<'_> {
        match &self.state {
            State::Open {
                silence: Some(reason),
                ..
            } => LinkState::Absent(reason),
            State::Open { found, .. } => LinkState::Open(&found.name),
            State::Absent { reason, .. } if reason.is_empty() => LinkState::Searching,
            State::Absent { reason, .. } => LinkState::Absent(reason),
        }
    }

    /// Returns the number of searches since the gamepad was there.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    /// Between two states with a pad there is always one without: whoever reads sees that it was gone.
    fn lose(&mut self, reason: String, now: Duration) {
        self.state = State::Absent {
            reason,
            search: None,
            retry_at: now.saturating_add(SEARCH_INTERVAL),
        };
    }
}

impl core::fmt::Debug for Link {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Link").field(&self.state()).finish()
    }
}

impl core::fmt::Debug for Found {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Found").field(&self.name).finish()
    }
}

/// Starts a search. If it cannot have a thread, its result is that it failed.
fn start(search: &Arc<Search>) -> Receiver<Result<Found, String>> {
    let (sender, result) = mpsc::channel();
    let search = search.clone();
    let work = move || {
        // If nobody waits any more, what was opened is closed here.
        let _ = sender.send(search());
    };
    let _ = thread::Builder::new().name("gamepads".to_owned()).spawn(work);
    result
}

#[cfg(test)]
mod tests;
