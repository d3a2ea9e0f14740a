//! The thread of the link that takes the application's locks, except for stops of everything. It has the
//! priority of the application's own threads, so that it is never preempted by less important work while it
//! holds a lock. It does little, and the worker uses it seldom. Work that waits for schemas, such as a
//! reload, runs on a second thread, so that it delays no request to stop a robot.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use jde_board::VariableStatus;
use jde_records::reload::ReloadReport;
use jde_records::snapshot::{SchemaView, Snapshot};
use zenoh::query::Query;

use super::inbox::Inbox;
use super::subject::Subject;
use crate::Error;
use crate::message::{Action, Refusal, Request};

/// Most pending jobs.
const MAX_JOBS: usize = 32;
/// Most requests among them: there is always room for snapshots and statuses.
const MAX_REQUESTS: usize = MAX_JOBS - 8;
/// Most gestures among them: dragging on a panel leaves room for requests to stop a robot.
const MAX_GESTURES: usize = MAX_JOBS / 4;
/// Most pending reloads. Only one runs at a time, and more need not wait.
const MAX_RELOADS: usize = 4;

/// Work for the threads.
pub(super) enum Job {
    Snapshot,
    Statuses,
    Operate(Box<OperatorRequest>),
    /// A request that waits for schemas.
    Reload(Box<OperatorRequest>),
}

/// A request of an operator.
pub(super) struct OperatorRequest {
    pub(super) request: Request,
    /// The query that receives the reply; none for an expired lease.
    pub(super) query: Option<Query>,
}

/// The outcome of a job.
pub(super) enum JobOutcome {
    Snapshot(Box<Snapshot>),
    /// In the order of the board.
    Statuses(Vec<VariableStatus>),
    /// With what awake schemas lose by it, in words.
    Operated(Box<OperatorRequest>, Result<String, Refusal>),
    /// Everything was released; with the schemas that had been stopped with everything.
    Released(Box<OperatorRequest>, Result<Vec<String>, Refusal>),
    /// Everything was stopped, or the stop was refused; the reply to all these queries.
    Stopped(Vec<Query>, Result<(), Refusal>),
    Reloaded(Box<OperatorRequest>, Result<ReloadReport, Refusal>),
}

/// The threads and their queues.
pub(super) struct OperatorWorkers {
    jobs: Option<SyncSender<Job>>,
    reloads: Option<SyncSender<Job>>,
    threads: Vec<JoinHandle<()>>,
    /// Requests in progress, without reloads.
    requests: usize,
    /// Gestures among them.
    gestures: usize,
}

impl OperatorWorkers {
    pub(super) fn start(subject: Arc<dyn Subject>, inbox: Arc<Inbox>) -> Result<Self, Error> {
        let mut threads = Vec::new();
        let mut begin = |name: &str, capacity| {
            let (sender, receiver) = sync_channel(capacity);
            let (subject, inbox) = (Arc::clone(&subject), Arc::clone(&inbox));
            let thread = std::thread::Builder::new()
                .name(name.to_owned())
                .spawn(move || run_worker(&*subject, &inbox, &receiver))
                .map_err(Error::Thread)?;
            threads.push(thread);
            Ok::<_, Error>(Some(sender))
        };
        let jobs = begin("link-operator", MAX_JOBS)?;
        let reloads = begin("link-reload", MAX_RELOADS)?;
        Ok(Self {
            jobs,
            reloads,
            threads,
            requests: 0,
            gestures: 0,
        })
    }

    /// Queues a job; returns it as the error if too many are pending.
    pub(super) fn send(&mut self, job: Job) -> Result<(), Job> {
        let queue = match job {
            Job::Snapshot | Job::Statuses | Job::Operate(_) => &self.jobs,
            Job::Reload(_) => &self.reloads,
        };
        let Some(queue) = queue else {
            return Err(job);
        };
        let is_request = matches!(job, Job::Operate(_));
        let is_gesture = matches!(&job, Job::Operate(request) if request.is_gesture());
        if is_request && self.requests >= MAX_REQUESTS || is_gesture && self.gestures >= MAX_GESTURES {
            return Err(job);
        }
        queue.try_send(job).map_err(|error| match error {
            TrySendError::Full(job) | TrySendError::Disconnected(job) => job,
        })?;
        self.requests += usize::from(is_request);
        self.gestures += usize::from(is_gesture);
        Ok(())
    }

    /// Counts a request as finished.
    pub(super) fn finish(&mut self, request: &OperatorRequest) {
        self.requests -= 1;
        self.gestures -= usize::from(request.is_gesture());
    }
}

impl OperatorRequest {
    fn is_gesture(&self) -> bool {
        matches!(self.request.action, Action::Touch { .. })
    }
}

/// Waits until all queued jobs are done.
impl Drop for OperatorWorkers {
    fn drop(&mut self) {
        drop((self.jobs.take(), self.reloads.take()));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

fn run_worker(subject: &dyn Subject, inbox: &Inbox, jobs: &Receiver<Job>) {
    for job in jobs {
        let outcome = match job {
            Job::Snapshot => JobOutcome::Snapshot(Box::new(subject.snapshot())),
            Job::Statuses => {
                let now = subject.now();
                let variables = subject.board().list();
                JobOutcome::Statuses(variables.map(|variable| variable.status(now)).collect())
            }
            Job::Operate(operation) if operation.request.action == Action::ReleaseAll => {
                let mut schemas = subject.snapshot().schemas;
                schemas.retain(SchemaView::is_stopped_with_everything);
                let stopped = schemas.into_iter().map(|schema| schema.name).collect();
                let outcome = subject.operate(&operation.request).map(|_| stopped);
                JobOutcome::Released(operation, outcome)
            }
            Job::Operate(operation) => {
                let outcome = subject.operate(&operation.request);
                JobOutcome::Operated(operation, outcome)
            }
            Job::Reload(operation) => {
                let outcome = subject.reload(&operation.request.by, &operation.request.action);
                JobOutcome::Reloaded(operation, outcome)
            }
        };
        // The queue has room for more than all pending jobs.
        let _ = inbox.outcomes.push(outcome);
        inbox.wake();
    }
}
