//! The end of instances when the application ends: one after the other, none of which may keep those after it waiting. It
//! ends no thread: whoever does not return keeps the one it is on.

use std::collections::VecDeque;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::thread::Builder;

use super::supervisor::{REST, guarded};
use crate::engine::Engine;
use crate::runner::Runner;

/// A runner, and which instance it runs.
type Seat = (usize, Arc<Mutex<Runner>>);

/// Ends instances in this order; answers with those that are inside a call, or do not return from their end, and stay behind.
pub(super) fn end(engine: &Arc<Engine>, seats: impl IntoIterator<Item = Seat>) -> Vec<usize> {
    let seats: Arc<Mutex<VecDeque<Seat>>> = Arc::new(Mutex::new(seats.into_iter().collect()));
    let mut lost = Vec::new();
    loop {
        let (done, ended) = channel();
        let (own, mine) = (Arc::clone(engine), Arc::clone(&seats));
        let thread = Builder::new().name("jde-end".to_owned());
        let thread = thread.spawn(move || guarded(&own, || end_each(&mine, &done)));
        let Ok(thread) = thread else {
            // Without a thread they end here, and whoever hangs holds up the end.
            let (done, ended) = channel();
            end_each(&seats, &done);
            drop(done);
            lost.extend(ended.into_iter().filter_map(Ended::lost));
            return lost;
        };
        let mut present = None;
        loop {
            match ended.recv_timeout(REST) {
                Ok(Ended::Begins(number)) => present = Some(number),
                Ok(Ended::Done) => present = None,
                Ok(Ended::Lost(number)) => lost.push(number),
                Err(RecvTimeoutError::Disconnected) => {
                    // Its panics were reported by `guarded`.
                    let _ = thread.join();
                    return lost;
                }
                Err(RecvTimeoutError::Timeout) => break,
            }
        }
        // Whoever hangs keeps that thread; the others get another.
        lost.extend(present);
    }
}

/// What becomes of one.
enum Ended {
    Begins(usize),
    Done,
    Lost(usize),
}

impl Ended {
    fn lost(self) -> Option<usize> {
        match self {
            Self::Lost(number) => Some(number),
            Self::Begins(_) | Self::Done => None,
        }
    }
}

/// Nobody may be listening any more.
fn end_each(seats: &Mutex<VecDeque<Seat>>, told: &Sender<Ended>) {
    loop {
        let next = seats.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        let Some((number, runner)) = next else { return };
        match runner.try_lock() {
            Ok(mut runner) => {
                let _ = told.send(Ended::Begins(number));
                runner.destroy();
                let _ = told.send(Ended::Done);
            }
            Err(TryLockError::WouldBlock) => {
                let _ = told.send(Ended::Lost(number));
            }
            Err(TryLockError::Poisoned(_)) => {}
        }
    }
}
