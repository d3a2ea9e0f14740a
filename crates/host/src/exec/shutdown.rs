//! Ends all instances when the application ends, one after the other; an instance that hangs does not delay
//! the next. It ends no thread: a hung instance keeps the thread it is on.

use std::collections::VecDeque;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::thread::Builder;

use super::supervisor::{REST_TIMEOUT, run_guarded};
use crate::engine::Engine;
use crate::runner::Runner;

/// An instance's number and its runner.
type NumberedRunner = (usize, Arc<Mutex<Runner>>);

/// Ends instances in this order. Returns the instances that are left behind: inside a call, or hung in their
/// end.
pub(super) fn end_all(engine: &Arc<Engine>, seats: impl IntoIterator<Item = NumberedRunner>) -> Vec<usize> {
    let seats: Arc<Mutex<VecDeque<NumberedRunner>>> = Arc::new(Mutex::new(seats.into_iter().collect()));
    let mut lost = Vec::new();
    loop {
        let (done, ended) = channel();
        let (own, mine) = (Arc::clone(engine), Arc::clone(&seats));
        let thread = Builder::new().name("jde-end".to_owned());
        let thread = thread.spawn(move || run_guarded(&own, || end_each(&mine, &done)));
        let Ok(thread) = thread else {
            // Without a thread they end here, and an instance that hangs blocks the shutdown.
            let (done, ended) = channel();
            end_each(&seats, &done);
            drop(done);
            lost.extend(ended.into_iter().filter_map(EndProgress::lost));
            return lost;
        };
        let mut present = None;
        loop {
            match ended.recv_timeout(REST_TIMEOUT) {
                Ok(EndProgress::Started(number)) => present = Some(number),
                Ok(EndProgress::Done) => present = None,
                Ok(EndProgress::Lost(number)) => lost.push(number),
                Err(RecvTimeoutError::Disconnected) => {
                    // `guarded` has reported its panics.
                    let _ = thread.join();
                    return lost;
                }
                Err(RecvTimeoutError::Timeout) => break,
            }
        }
        // The hung instance keeps that thread; the others get a new one.
        lost.extend(present);
    }
}

/// The progress of one instance's end.
enum EndProgress {
    Started(usize),
    Done,
    Lost(usize),
}

impl EndProgress {
    fn lost(self) -> Option<usize> {
        match self {
            Self::Lost(number) => Some(number),
            Self::Started(_) | Self::Done => None,
        }
    }
}

/// Ends the instances of `seats`. The receiver of `told` may be gone already.
fn end_each(seats: &Mutex<VecDeque<NumberedRunner>>, told: &Sender<EndProgress>) {
    loop {
        let next = seats.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        let Some((number, runner)) = next else { return };
        match runner.try_lock() {
            Ok(mut runner) => {
                let _ = told.send(EndProgress::Started(number));
                runner.destroy();
                let _ = told.send(EndProgress::Done);
            }
            Err(TryLockError::WouldBlock) => {
                let _ = told.send(EndProgress::Lost(number));
            }
            Err(TryLockError::Poisoned(_)) => {}
        }
    }
}
