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

/// Ends instances in this order. Returns the instances that are abandoned: inside a call, or hung in their
/// end.
pub(super) fn end_all(engine: &Arc<Engine>, runners: impl IntoIterator<Item = NumberedRunner>) -> Vec<usize> {
    let runners: Arc<Mutex<VecDeque<NumberedRunner>>> = Arc::new(Mutex::new(runners.into_iter().collect()));
    let mut lost = Vec::new();
    loop {
        let (done, ended) = channel();
        let (thread_engine, queue) = (Arc::clone(engine), Arc::clone(&runners));
        let thread = Builder::new().name("jde-end".to_owned());
        let thread = thread.spawn(move || run_guarded(&thread_engine, || end_each(&queue, &done)));
        let Ok(thread) = thread else {
            // Without a new thread they end on this one, and an instance that hangs blocks the shutdown.
            let (done, ended) = channel();
            end_each(&runners, &done);
            drop(done);
            lost.extend(ended.into_iter().filter_map(EndProgress::lost));
            return lost;
        };
        let mut current = None;
        loop {
            match ended.recv_timeout(REST_TIMEOUT) {
                Ok(EndProgress::Started(number)) => current = Some(number),
                Ok(EndProgress::Done) => current = None,
                Ok(EndProgress::Lost(number)) => lost.push(number),
                Err(RecvTimeoutError::Disconnected) => {
                    // `run_guarded` has reported its panics.
                    let _ = thread.join();
                    return lost;
                }
                Err(RecvTimeoutError::Timeout) => break,
            }
        }
        // The hung instance keeps that thread; the others get a new one.
        lost.extend(current);
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

/// Ends the instances of `runners`. The receiver of `progress` may have been dropped.
fn end_each(runners: &Mutex<VecDeque<NumberedRunner>>, progress: &Sender<EndProgress>) {
    loop {
        let next = runners.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        let Some((number, runner)) = next else { return };
        match runner.try_lock() {
            Ok(mut runner) => {
                let _ = progress.send(EndProgress::Started(number));
                runner.destroy();
                let _ = progress.send(EndProgress::Done);
            }
            Err(TryLockError::WouldBlock) => {
                let _ = progress.send(EndProgress::Lost(number));
            }
            Err(TryLockError::Poisoned(_)) => {}
        }
    }
}
