//! Few threads for all schemas: for applications with thousands of light ones, where a thread each would collapse.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, TryLockError, Weak};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_core::Nanos;

use super::supervisor::{Alarm, Crew, guarded};
use crate::engine::{Bells, Engine, Signal};
use crate::inbox::Inbox;
use crate::runner::Runner;

/// Fewest workers: so that slow schemas leave some for the others. One that hangs is made up for.
const FEWEST: usize = 4;

/// Workers that share all runners.
pub(crate) struct Pool {
    own: Weak<Self>,
    desk: Mutex<Desk>,
    work: Condvar,
    idle: Condvar,
    runners: Vec<Mutex<Runner>>,
    workers: Mutex<Vec<JoinHandle<()>>>,
    alarm: Arc<Alarm>,
}

struct Desk {
    inboxes: Vec<Inbox>,
    busy: Vec<bool>,
    /// Instances with mail that nobody has taken up.
    ready: VecDeque<usize>,
    /// When instances are due, the earliest on top; outdated entries are passed over.
    calendar: BinaryHeap<Reverse<(Nanos, usize)>>,
    due: Vec<Option<Nanos>>,
    leave: bool,
}

impl Bells for Pool {
    fn ring(&self, instance: usize, signal: Signal) {
        let mut desk = self.lock();
        // Who has mail already is in the queue already.
        let first = desk.inboxes[instance].is_empty();
        desk.inboxes[instance].put(signal);
        if first && !desk.busy[instance] {
            desk.ready.push_back(instance);
            self.work.notify_one();
        }
    }

    fn alarm(&self, next: Option<Nanos>) {
        self.alarm.set(next);
    }
}

impl Pool {
    pub(crate) fn new(
        engine: &Arc<Engine>,
        runners: Vec<Runner>,
        alarm: Arc<Alarm>,
    ) -> std::io::Result<Arc<Self>> {
        let count = runners.len();
        let desk = Desk {
            inboxes: (0..count).map(|_| Inbox::default()).collect(),
            busy: vec![false; count],
            ready: VecDeque::new(),
            calendar: BinaryHeap::new(),
            due: vec![None; count],
            leave: false,
        };
        let pool = Arc::new_cyclic(|own| Self {
            own: Weak::clone(own),
            desk: Mutex::new(desk),
            work: Condvar::new(),
            idle: Condvar::new(),
            runners: runners.into_iter().map(Mutex::new).collect(),
            workers: Mutex::default(),
            alarm,
        });
        let workers = std::thread::available_parallelism()
            .map_or(FEWEST, usize::from)
            .max(FEWEST);
        for _ in 0..workers {
            if let Err(error) = pool.hire(engine) {
                pool.dismiss();
                return Err(error);
            }
        }
        Ok(pool)
    }

    /// One worker more.
    fn hire(&self, engine: &Arc<Engine>) -> std::io::Result<()> {
        let Some(own) = self.own.upgrade() else {
            return Ok(());
        };
        let mut workers = self.workers.lock().unwrap_or_else(PoisonError::into_inner);
        let engine = Arc::clone(engine);
        let worker = Builder::new().name(format!("worker-{}", workers.len()));
        workers.push(worker.spawn(move || guarded(&engine, || own.run(&engine)))?);
        Ok(())
    }

    fn run(&self, engine: &Engine) {
        super::supervisor::sharpen_timers();
        while let Some((number, inbox)) = self.next(engine) {
            let due = self.runners[number]
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .turn(inbox);
            self.put_back(number, due);
        }
    }

    /// Waits for an instance with mail, or one that is due; `None` to leave.
    fn next(&self, engine: &Engine) -> Option<(usize, Inbox)> {
        let mut desk = self.lock();
        loop {
            if desk.leave {
                return None;
            }
            if let Some(number) = desk.take(engine.clock.now()) {
                desk.busy[number] = true;
                let inbox = std::mem::take(&mut desk.inboxes[number]);
                if !desk.ready.is_empty() || !desk.calendar.is_empty() {
                    // Whoever waited for the next deadline may be this worker, which is now gone for as long as a call takes.
                    self.work.notify_one();
                }
                return Some((number, inbox));
            }
            desk = match desk
                .calendar
                .peek()
                .map(|Reverse((due, _))| engine.clock.until(*due))
            {
                Some(wait) => {
                    self.work
                        .wait_timeout(desk, wait)
                        .unwrap_or_else(PoisonError::into_inner)
                        .0
                }
                None => self.work.wait(desk).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }

    fn put_back(&self, number: usize, due: Option<Nanos>) {
        let mut desk = self.lock();
        desk.busy[number] = false;
        desk.due[number] = due;
        if let Some(due) = due {
            desk.calendar.push(Reverse((due, number)));
            self.work.notify_one();
        }
        if desk.inboxes[number].is_empty() {
            self.idle.notify_all();
        } else {
            desk.ready.push_back(number);
            self.work.notify_one();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Desk {
    /// An instance to run now, mail before time.
    fn take(&mut self, now: Nanos) -> Option<usize> {
        while let Some(number) = self.ready.pop_front() {
            if !self.busy[number] && !self.inboxes[number].is_empty() {
                return Some(number);
            }
        }
        while let Some(Reverse((due, number))) = self.calendar.peek().copied() {
            let current = !self.busy[number] && self.due[number] == Some(due);
            if current && due > now {
                return None;
            }
            self.calendar.pop();
            if current {
                return Some(number);
            }
        }
        None
    }
}

impl Crew for Pool {
    fn settled(&self, instance: usize, within: Duration) -> bool {
        let waiting = |desk: &mut Desk| desk.busy[instance] || !desk.inboxes[instance].is_empty();
        let desk = self.lock();
        let (mut desk, _) = self
            .idle
            .wait_timeout_while(desk, within, waiting)
            .unwrap_or_else(PoisonError::into_inner);
        !waiting(&mut desk)
    }

    fn relieve(&self, engine: &Arc<Engine>) {
        if let Err(error) = self.hire(engine) {
            tracing::error!("the system refuses a thread to make up for one that hangs: {error}");
        }
    }

    fn dismiss(&self) -> Vec<usize> {
        self.lock().leave = true;
        self.work.notify_all();
        let mut lost = Vec::new();
        for (number, runner) in self.runners.iter().enumerate().rev() {
            match runner.try_lock() {
                Ok(mut runner) => runner.destroy(),
                Err(TryLockError::WouldBlock) => lost.push(number),
                Err(TryLockError::Poisoned(_)) => {}
            }
        }
        if lost.is_empty() {
            for worker in std::mem::take(&mut *self.workers.lock().unwrap_or_else(PoisonError::into_inner)) {
                // Its panics were reported by `guarded`.
                let _ = worker.join();
            }
        }
        lost
    }
}
