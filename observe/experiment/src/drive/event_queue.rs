//! The events that wait to be judged or kept. The observer is called under the application's lock, so it only appends.

use std::sync::Arc;

use jde_records::event::{Event, Observer};
use parking_lot::Mutex;

/// The most events that wait; newer ones are dropped and counted.
const MAX_WAITING: usize = 100_000;

/// The events since the last call of [`EventQueue::take`].
#[derive(Clone, Default)]
pub struct EventQueue(Arc<Mutex<Waiting>>);

#[derive(Default)]
struct Waiting {
    events: Vec<Event>,
    dropped: u64,
}

impl Observer for EventQueue {
    fn on_event(&mut self, event: &Event) {
        let mut waiting = self.0.lock();
        if waiting.events.len() < MAX_WAITING {
            waiting.events.push(event.clone());
        } else {
            waiting.dropped += 1;
        }
    }
}

impl EventQueue {
    /// Returns the events since the last call, in their order, and how many were dropped.
    #[must_use]
    pub fn take(&self) -> (Vec<Event>, u64) {
        let mut waiting = self.0.lock();
        (
            std::mem::take(&mut waiting.events),
            std::mem::take(&mut waiting.dropped),
        )
    }
}

#[cfg(test)]
mod tests {
    use jde_records::event::{Outcome, What};

    use super::*;

    #[test]
    fn events_that_nobody_takes_are_dropped_and_counted() {
        let mut events = EventQueue::default();
        let outcome = Outcome::Done;
        let end = |time| {
            Event::Other(
                What::Ended {
                    outcome: outcome.clone(),
                }
                .at(time),
            )
        };
        for time in 0..MAX_WAITING as u64 + 3 {
            events.on_event(&end(time));
        }
        let (taken, dropped) = events.take();
        assert_eq!((taken.len(), dropped), (MAX_WAITING, 3));
        assert_eq!(taken[0].time(), 0, "the newest are dropped");
        events.on_event(&end(7));
        let (taken, dropped) = events.take();
        assert_eq!((taken.len(), dropped), (1, 0));
    }
}
