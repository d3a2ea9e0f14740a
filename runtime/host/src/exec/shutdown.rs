//! Ends all instances when the application ends, one after the other; an instance that hangs does not delay
//! the next. It ends no thread: a hung instance keeps the thread it is on.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::Builder;

use jde_core::SchemaId;
use parking_lot::Mutex;

use super::supervisor::{REST_TIMEOUT, run_guarded};
use crate::engine::Engine;
use crate::runner::Runner;

/// An instance and its runner.
type NumberedRunner = (SchemaId, Arc<Mutex<Runner>>);

/// Ends instances in this order. Returns the instances that are abandoned: inside a call, or hung in their
/// end.
pub(super) fn end_all(
    engine: &Arc<Engine>,
    runners: impl IntoIterator<Item = NumberedRunner>,
) -> Vec<SchemaId> {
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
    Started(SchemaId),
    Done,
    Lost(SchemaId),
}

impl EndProgress {
    fn lost(self) -> Option<SchemaId> {
        match self {
            Self::Lost(number) => Some(number),
            Self::Started(_) | Self::Done => None,
        }
    }
}

/// Ends the instances of `runners`. The receiver of `progress` may have been dropped.
fn end_each(runners: &Mutex<VecDeque<NumberedRunner>>, progress: &Sender<EndProgress>) {
    loop {
        let next = runners.lock().pop_front();
        let Some((number, runner)) = next else { return };
        let ended = if let Some(mut runner) = runner.try_lock() {
            let _ = progress.send(EndProgress::Started(number));
            // A panic of the host may have left this one half changed. It must not keep the others from their end.
            if catch_unwind(AssertUnwindSafe(|| runner.destroy())).is_err() {
                tracing::error!("an instance panicked while it was ended");
            }
            EndProgress::Done
        } else {
            EndProgress::Lost(number)
        };
        let _ = progress.send(ended);
    }
}
