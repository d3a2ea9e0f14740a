//! The thread of the link that takes the application's locks, except for stops of everything. It has the
//! priority of the application's own threads, so that it is never preempted by less important work while it
//! holds a lock. It does little, and the worker uses it seldom. Work that waits for schemas, such as a
//! reload, runs on a second thread, so that it delays no order to stop a robot.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use jde_board::VariableStatus;
use jde_host::reload::Reloaded;
use jde_host::snapshot::Snapshot;
use zenoh::query::Query;

use super::inbox::Inbox;
use super::subject::Subject;
use crate::Error;
use crate::message::{Action, Refusal, Request};

/// Most pending errands.
const ERRANDS: usize = 32;
/// Most acts among them: there is always room for snapshots and statuses.
const ACTS: usize = ERRANDS - 8;
/// Most gestures among them: dragging on a panel leaves room for orders to stop a robot.
const TOUCHES: usize = ERRANDS / 4;
/// Most pending reloads. Only one runs at a time, and more need not wait.
const RELOADS: usize = 4;

/// Work for the threads.
pub(super) enum Errand {
    Snapshot,
    Statuses,
    Act(Box<Act>),
    /// An act that waits for schemas.
    Reload(Box<Act>),
}

/// A request of an operator.
pub(super) struct Act {
    pub(super) request: Request,
    /// The query to answer; none for an expired lease.
    pub(super) query: Option<Query>,
}

/// The outcome of an errand.
pub(super) enum Done {
    Snapshot(Box<Snapshot>),
    /// In the order of the board.
    Statuses(Vec<VariableStatus>),
    Acted(Box<Act>, Result<(), Refusal>),
    /// Everything was stopped, or not; answers all these queries.
    Stopped(Vec<Query>, Result<(), Refusal>),
    Reloaded(Box<Act>, Result<Reloaded, Refusal>),
}

/// The threads and their queues.
pub(super) struct Hands {
    errands: Option<SyncSender<Errand>>,
    reloads: Option<SyncSender<Errand>>,
    threads: Vec<JoinHandle<()>>,
    /// Acts in progress, without reloads.
    acts: usize,
    /// Gestures among them.
    touches: usize,
}

impl Hands {
    pub(super) fn start(subject: Arc<dyn Subject>, inbox: Arc<Inbox>) -> Result<Self, Error> {
        let mut threads = Vec::new();
        let mut begin = |name: &str, room| {
            let (errands, todo) = sync_channel(room);
            let (subject, inbox) = (Arc::clone(&subject), Arc::clone(&inbox));
            let thread = std::thread::Builder::new()
                .name(name.to_owned())
                .spawn(move || work(&*subject, &inbox, &todo))
                .map_err(Error::Thread)?;
            threads.push(thread);
            Ok(Some(errands))
        };
        let errands = begin("link-hands", ERRANDS)?;
        let reloads = begin("link-reload", RELOADS)?;
        Ok(Self {
            errands,
            reloads,
            threads,
            acts: 0,
            touches: 0,
        })
    }

    /// Queues an errand; returns it as the error if too many are pending.
    pub(super) fn send(&mut self, errand: Errand) -> Result<(), Errand> {
        let errands = match errand {
            Errand::Snapshot | Errand::Statuses | Errand::Act(_) => &self.errands,
            Errand::Reload(_) => &self.reloads,
        };
        let Some(errands) = errands else {
            return Err(errand);
        };
        let act = matches!(errand, Errand::Act(_));
        let touches = matches!(&errand, Errand::Act(act) if act.touches());
        if act && self.acts >= ACTS || touches && self.touches >= TOUCHES {
            return Err(errand);
        }
        errands.try_send(errand).map_err(|error| match error {
            TrySendError::Full(errand) | TrySendError::Disconnected(errand) => errand,
        })?;
        self.acts += usize::from(act);
        self.touches += usize::from(touches);
        Ok(())
    }

    /// Counts an act as finished.
    pub(super) fn acted(&mut self, act: &Act) {
        self.acts -= 1;
        self.touches -= usize::from(act.touches());
    }
}

impl Act {
    fn touches(&self) -> bool {
        matches!(self.request.action, Action::Touch { .. })
    }
}

/// Waits until all queued errands are done.
impl Drop for Hands {
    fn drop(&mut self) {
        drop((self.errands.take(), self.reloads.take()));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

fn work(subject: &dyn Subject, inbox: &Inbox, todo: &Receiver<Errand>) {
    for errand in todo {
        let done = match errand {
            Errand::Snapshot => Done::Snapshot(Box::new(subject.snapshot())),
            Errand::Statuses => {
                let now = subject.now();
                let variables = subject.board().list();
                Done::Statuses(variables.map(|variable| variable.status(now)).collect())
            }
            Errand::Act(act) => {
                let outcome = subject.act(&act.request.by, &act.request.action);
                Done::Acted(act, outcome)
            }
            Errand::Reload(act) => {
                let outcome = subject.reload(&act.request.by, &act.request.action);
                Done::Reloaded(act, outcome)
            }
        };
        // The queue has room for more than all pending errands.
        let _ = inbox.done.push(done);
        inbox.wake();
    }
}
