//! The thread of the link that takes the application's locks, except for stops of everything. It has the
//! priority of the application's own threads, so that it is never preempted by less important work while it
//! holds a lock. It does little, and the worker uses it seldom. Work that waits for schemas, such as a
//! reload, runs on a second thread, so that it delays no order to stop a robot.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use jde_board::VariableStatus;
use jde_records::reload::ReloadReport;
use jde_records::snapshot::Snapshot;
use zenoh::query::Query;

use super::inbox::Inbox;
use super::subject::Subject;
use crate::Error;
use crate::message::{Action, Refusal, Request};

/// Most pending errands.
const ERRANDS: usize = 32;
/// Most acts among them: there is always room for snapshots and statuses.
const MAX_REQUESTS: usize = ERRANDS - 8;
/// Most gestures among them: dragging on a panel leaves room for orders to stop a robot.
const MAX_GESTURES: usize = ERRANDS / 4;
/// Most pending reloads. Only one runs at a time, and more need not wait.
const RELOADS: usize = 4;

/// Work for the threads.
pub(super) enum Job {
    Snapshot,
    Statuses,
    Operate(Box<OperatorRequest>),
    /// An act that waits for schemas.
    Reload(Box<OperatorRequest>),
}

/// A request of an operator.
pub(super) struct OperatorRequest {
    pub(super) request: Request,
    /// The query to answer; none for an expired lease.
    pub(super) query: Option<Query>,
}

/// The outcome of an errand.
pub(super) enum JobOutcome {
    Snapshot(Box<Snapshot>),
    /// In the order of the board.
    Statuses(Vec<VariableStatus>),
    Operated(Box<OperatorRequest>, Result<(), Refusal>),
    /// Everything was stopped, or not; answers all these queries.
    Stopped(Vec<Query>, Result<(), Refusal>),
    Reloaded(Box<OperatorRequest>, Result<ReloadReport, Refusal>),
}

/// The threads and their queues.
pub(super) struct OperatorWorkers {
    jobs: Option<SyncSender<Job>>,
    reloads: Option<SyncSender<Job>>,
    threads: Vec<JoinHandle<()>>,
    /// Acts in progress, without reloads.
    requests: usize,
    /// Gestures among them.
    gestures: usize,
}

impl OperatorWorkers {
    pub(super) fn start(subject: Arc<dyn Subject>, inbox: Arc<Inbox>) -> Result<Self, Error> {
        let mut threads = Vec::new();
        let mut begin = |name: &str, room| {
            let (errands, todo) = sync_channel(room);
            let (subject, inbox) = (Arc::clone(&subject), Arc::clone(&inbox));
            let thread = std::thread::Builder::new()
                .name(name.to_owned())
                .spawn(move || run_worker(&*subject, &inbox, &todo))
                .map_err(Error::Thread)?;
            threads.push(thread);
            Ok(Some(errands))
        };
        let errands = begin("link-operator", ERRANDS)?;
        let reloads = begin("link-reload", RELOADS)?;
        Ok(Self {
            jobs: errands,
            reloads,
            threads,
            requests: 0,
            gestures: 0,
        })
    }

    /// Queues an errand; returns it as the error if too many are pending.
    pub(super) fn send(&mut self, errand: Job) -> Result<(), Job> {
        let errands = match errand {
            Job::Snapshot | Job::Statuses | Job::Operate(_) => &self.jobs,
            Job::Reload(_) => &self.reloads,
        };
        let Some(errands) = errands else {
            return Err(errand);
        };
        let act = matches!(errand, Job::Operate(_));
        let touches = matches!(&errand, Job::Operate(act) if act.is_gesture());
        if act && self.requests >= MAX_REQUESTS || touches && self.gestures >= MAX_GESTURES {
            return Err(errand);
        }
        errands.try_send(errand).map_err(|error| match error {
            TrySendError::Full(errand) | TrySendError::Disconnected(errand) => errand,
        })?;
        self.requests += usize::from(act);
        self.gestures += usize::from(touches);
        Ok(())
    }

    /// Counts an act as finished.
    pub(super) fn finish(&mut self, act: &OperatorRequest) {
        self.requests -= 1;
        self.gestures -= usize::from(act.is_gesture());
    }
}

impl OperatorRequest {
    fn is_gesture(&self) -> bool {
        matches!(self.request.action, Action::Touch { .. })
    }
}

/// Waits until all queued errands are done.
impl Drop for OperatorWorkers {
    fn drop(&mut self) {
        drop((self.jobs.take(), self.reloads.take()));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

fn run_worker(subject: &dyn Subject, inbox: &Inbox, todo: &Receiver<Job>) {
    for errand in todo {
        let done = match errand {
            Job::Snapshot => JobOutcome::Snapshot(Box::new(subject.snapshot())),
            Job::Statuses => {
                let now = subject.now();
                let variables = subject.board().list();
                JobOutcome::Statuses(variables.map(|variable| variable.status(now)).collect())
            }
            Job::Operate(act) => {
                let outcome = subject.act(&act.request.by, &act.request.action);
                JobOutcome::Operated(act, outcome)
            }
            Job::Reload(act) => {
                let outcome = subject.reload(&act.request.by, &act.request.action);
                JobOutcome::Reloaded(act, outcome)
            }
        };
        // The queue has room for more than all pending errands.
        let _ = inbox.outcomes.push(done);
        inbox.wake();
    }
}
