//! A few worker threads for all schemas, and more only while calls take long.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Weak};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_core::{Nanos, SchemaId, Table};
use parking_lot::{Condvar, Mutex};

use super::calendar::{Calendar, leeway};
use super::capacity::{Capacity, GRACE};
use super::shutdown;
use super::supervisor::{Alarm, ThreadExecutor, run_guarded};
use crate::engine::{Engine, Notifier, Signal};
use crate::inbox::Inbox;
use crate::runner::{CallHandle, Runner};

/// The least number of workers beside the one that is always free, so that long turns do not occupy all of
/// them.
const MIN_WORKERS: usize = 4;
/// About how long a notified worker takes to start, ns. If a busy worker returns within this time, no other
/// is notified.
const WAKE_LATENCY: Nanos = 20_000;

/// Workers that share all runners.
pub(crate) struct Pool {
    this: Weak<Self>,
    schedule: Mutex<Schedule>,
    work: Condvar,
    idle: Condvar,
    runners: Table<SchemaId, Mutex<PooledRunner>>,
    workers: Mutex<Workers>,
    alarm: Arc<Alarm>,
}

/// The runner that takes an instance's turns. A runner that hangs is replaced.
struct PooledRunner {
    runner: Arc<Mutex<Runner>>,
    call_handle: CallHandle,
}

/// The workers that have not hung, by their numbers.
#[derive(Default)]
struct Workers {
    threads: BTreeMap<usize, JoinHandle<()>>,
    started_count: usize,
    /// Whether the system has refused a thread since it last granted one.
    is_refused: bool,
}

struct Schedule {
    inboxes: Table<SchemaId, Inbox>,
    /// The worker that takes the turn of each instance.
    busy: Table<SchemaId, Option<usize>>,
    /// Instances with signals that no worker has taken.
    ready: VecDeque<SchemaId>,
    /// When the instances that are not busy are due.
    calendar: Calendar,
    /// When each instance's turn began, and the longest of its recent turns.
    turns: Table<SchemaId, TurnDurations>,
    /// Until when the timer worker sleeps, which then serves the next deadline; `None` if there is no timer
    /// worker.
    timer_worker_until: Option<Nanos>,
    /// Until when the backup worker sleeps: a little longer than the timer worker, which the system may not
    /// schedule in time; `None` if there is no backup worker.
    backup_worker_until: Option<Nanos>,
    capacity: Capacity,
    /// The number of threads that wait until an instance is idle.
    idle_waiters: usize,
    is_stopping: bool,
}

/// The durations of one instance's turns, including all calls in them.
#[derive(Clone, Copy, Default)]
struct TurnDurations {
    began: Nanos,
    /// Whether the current turn was expected to be short.
    is_short: bool,
    /// The longest recent turn. Falls by a quarter from turn to turn; `None` before the first.
    longest: Option<Nanos>,
}

impl Notifier for Pool {
    fn post(&self, instance: SchemaId, signal: Signal) -> bool {
        let mut schedule = self.schedule.lock();
        // An instance with signals is in the queue already.
        let first = schedule.inboxes[instance].is_empty();
        schedule.inboxes[instance].push(signal);
        let is_ready = first && schedule.busy[instance].is_none();
        if is_ready {
            schedule.ready.push_back(instance);
        }
        is_ready
    }

    fn notify(&self, _: SchemaId) {
        self.work.notify_one();
    }

    fn set_timer(&self, next: Option<Nanos>) -> bool {
        self.alarm.set(next)
    }

    fn notify_timer(&self) {
        self.alarm.notify();
    }
}

impl Pool {
    pub(crate) fn new(
        engine: &Arc<Engine>,
        runners: Table<SchemaId, Runner>,
        alarm: Arc<Alarm>,
    ) -> std::io::Result<Arc<Self>> {
        let count = runners.len();
        let workers = std::thread::available_parallelism()
            .map_or(MIN_WORKERS, usize::from)
            .max(MIN_WORKERS)
            .min(count)
            + 1;
        let schedule = Schedule {
            inboxes: runners.map_ids(|_| Inbox::default()),
            busy: runners.map_ids(|_| None),
            ready: VecDeque::new(),
            calendar: Calendar::new(count),
            turns: runners.map_ids(|_| TurnDurations::default()),
            timer_worker_until: None,
            backup_worker_until: None,
            capacity: Capacity::new(workers, count),
            idle_waiters: 0,
            is_stopping: false,
        };
        let pool = Arc::new_cyclic(|this| Self {
            this: Weak::clone(this),
            schedule: Mutex::new(schedule),
            work: Condvar::new(),
            idle: Condvar::new(),
            runners: runners
                .into_iter()
                .map(PooledRunner::new)
                .map(Mutex::new)
                .collect(),
            workers: Mutex::default(),
            alarm,
        });
        for _ in 0..workers {
            if let Err(error) = pool.start_worker(engine) {
                pool.end_all(engine);
                return Err(error);
            }
        }
        Ok(pool)
    }

    /// Starts one more worker.
    fn start_worker(&self, engine: &Arc<Engine>) -> std::io::Result<()> {
        let Some(pool) = self.this.upgrade() else {
            return Ok(());
        };
        let mut workers = self.workers.lock();
        let worker = workers.started_count;
        let engine = Arc::clone(engine);
        let thread = Builder::new().name(format!("worker-{worker}"));
        engine.clock.register_thread();
        let thread = thread.spawn(move || {
            run_guarded(&engine, || pool.run(&engine, worker));
            engine.clock.unregister_thread();
        })?;
        workers.threads.insert(worker, thread);
        workers.started_count += 1;
        workers.is_refused = false;
        Ok(())
    }

    fn run(&self, engine: &Arc<Engine>, worker: usize) {
        jde_isolation::run_when_due();
        while let Some((number, inbox)) = self.next_turn(engine, worker) {
            let runner = Arc::clone(&self.runners[number].lock().runner);
            let mut runner = runner.lock();
            let due = runner.take_turn(Some(inbox));
            let period = runner.period();
            drop(runner);
            self.finish_turn(number, due, period, engine.clock.now());
        }
        // The shutdown does not join a worker that exits before it.
        if !self.schedule.lock().is_stopping {
            drop(self.workers.lock().threads.remove(&worker));
        }
    }

    /// Starts more workers, which `capacity` counts already.
    fn start_workers(&self, engine: &Arc<Engine>, count: usize) {
        for started in 0..count {
            let Err(error) = self.start_worker(engine) else {
                continue;
            };
            self.schedule.lock().capacity.remove_workers(count - started);
            if !std::mem::replace(&mut self.workers.lock().is_refused, true) {
                tracing::error!("the system refuses a thread in place of those inside calls: {error}");
            }
            return;
        }
    }

    /// Waits for an instance that has signals or is due. Returns `None` when the worker must exit.
    fn next_turn(&self, engine: &Arc<Engine>, worker: usize) -> Option<(SchemaId, Inbox)> {
        let mut schedule = self.schedule.lock();
        loop {
            if schedule.is_stopping {
                return None;
            }
            let now = engine.clock.now();
            let deferred_until = schedule.capacity.deferred_until(now);
            if deferred_until.is_none()
                && let Some(number) = schedule.pop_ready(now)
            {
                engine.clock.mark_busy();
                schedule.busy[number] = Some(worker);
                let inbox = std::mem::take(&mut schedule.inboxes[number]);
                let turns = &mut schedule.turns[number];
                (turns.began, turns.is_short) =
                    (now, turns.longest.is_none_or(|longest| longest <= WAKE_LATENCY));
                let (longest, is_short) = (turns.longest.filter(|_| inbox.is_light()), turns.is_short);
                let added = schedule.capacity.begin_turn(now, is_short);
                if schedule.needs_another_worker(now, longest) {
                    // This worker may have been the timer worker, and is now busy for as long as the call
                    // takes.
                    self.work.notify_one();
                }
                drop(schedule);
                self.start_workers(engine, added);
                return Some((number, inbox));
            }
            // One worker waits for the next deadline. One backup worker, possibly the last free one, waits
            // slightly longer. The others wait for a notification.
            match (deferred_until, schedule.calendar.next_wakeup()) {
                (None, Some(due)) if schedule.timer_worker_until.is_none_or(|until| due < until) => {
                    schedule.timer_worker_until = Some(due);
                    engine.clock.wait(&self.work, &mut schedule, Some(due));
                    if schedule.timer_worker_until == Some(due) {
                        schedule.timer_worker_until = None;
                    }
                }
                (_, due)
                    if deferred_until.is_some()
                        || due.is_some() && schedule.backup_worker_until.is_none() =>
                {
                    let for_deadline =
                        due.map(|due| due.saturating_add(GRACE).max(deferred_until.unwrap_or_default()));
                    // Signals are due from the time they arrive.
                    let for_signals = deferred_until.filter(|_| !schedule.ready.is_empty());
                    schedule.backup_worker_until = for_signals.or(for_deadline);
                    let until = schedule.backup_worker_until;
                    engine.clock.wait(&self.work, &mut schedule, until);
                    schedule.backup_worker_until = None;
                }
                _ if schedule.capacity.try_retire(now) => return None,
                _ => {
                    let until = schedule.capacity.idle_until(now);
                    engine.clock.wait(&self.work, &mut schedule, until);
                }
            };
        }
    }

    fn finish_turn(&self, number: SchemaId, due: Option<Nanos>, period: Nanos, now: Nanos) {
        let mut schedule = self.schedule.lock();
        schedule.busy[number] = None;
        let is_short = schedule.turns[number].is_short;
        schedule.capacity.end_turn(is_short);
        schedule.turns[number].end(now);
        // A schema with long turns gets no leeway: a schema due after it, to read what it writes, would need
        // another worker.
        let leeway = if schedule.turns[number].has_short_turns() {
            leeway(period)
        } else {
            0
        };
        schedule.calendar.set_due(number, due, leeway);
        if !schedule.inboxes[number].is_empty() {
            schedule.ready.push_back(number);
        } else if schedule.idle_waiters > 0 {
            self.idle.notify_all();
        }
    }
}

impl PooledRunner {
    fn new(runner: Runner) -> Self {
        Self {
            call_handle: runner.call_handle(),
            runner: Arc::new(Mutex::new(runner)),
        }
    }
}

impl TurnDurations {
    fn end(&mut self, now: Nanos) {
        let took = now.saturating_sub(self.began);
        let before = self.longest.unwrap_or_default();
        self.longest = Some(took.max(before - before / 4));
    }

    /// Whether the turns end before a worker notified for another turn would start.
    fn has_short_turns(self) -> bool {
        self.longest.is_some_and(|longest| longest <= WAKE_LATENCY)
    }
}

impl Schedule {
    /// Whether to notify another worker after one has taken a turn that is expected to end after `longest`.
    /// False if no more signals wait and the next deadline is served: by the timer worker, or by this worker
    /// if it returns in time and there is a backup worker. In time means before a worker notified at the
    /// deadline could start. If this worker takes longer, or cannot serve all that is due, the backup worker
    /// takes over.
    fn needs_another_worker(&self, now: Nanos, longest: Option<Nanos>) -> bool {
        if !self.ready.is_empty() {
            return true;
        }
        let Some(due) = self.calendar.next_wakeup() else {
            return false;
        };
        let has_timer_worker = self.timer_worker_until.is_some_and(|until| until <= due);
        let has_backup = self
            .backup_worker_until
            .is_some_and(|until| until <= due.saturating_add(GRACE));
        let returns_in_time =
            longest.is_some_and(|longest| now + longest <= due.max(now).saturating_add(WAKE_LATENCY));
        !(has_timer_worker || has_backup && returns_in_time)
    }

    /// Takes an instance to run now; signals precede deadlines.
    fn pop_ready(&mut self, now: Nanos) -> Option<SchemaId> {
        while let Some(number) = self.ready.pop_front() {
            if self.busy[number].is_none() && !self.inboxes[number].is_empty() {
                self.calendar.remove(number);
                return Some(number);
            }
        }
        self.calendar.pop_due(now)
    }
}

impl ThreadExecutor for Pool {
    fn wait_until_idle(&self, instance: SchemaId, within: Duration) -> bool {
        let is_busy = |schedule: &mut Schedule| {
            schedule.busy[instance].is_some() || !schedule.inboxes[instance].is_empty()
        };
        let mut schedule = self.schedule.lock();
        schedule.idle_waiters += 1;
        self.idle.wait_while_for(&mut schedule, is_busy, within);
        schedule.idle_waiters -= 1;
        !is_busy(&mut schedule)
    }

    /// The hung worker is abandoned with its call, and a new one is started.
    fn replace_runner(
        &self,
        engine: &Arc<Engine>,
        instance: SchemaId,
        (since, guard): (Nanos, Option<SchemaId>),
        report: &mut dyn FnMut(u64),
    ) -> bool {
        let call_handle = self.runners[instance].lock().call_handle.clone();
        let Some(runner) = call_handle.give_up(since, guard, report) else {
            return false;
        };
        *self.runners[instance].lock() = PooledRunner::new(runner);
        let Some(worker) = self.schedule.lock().busy[instance] else {
            // The instance hangs in its end, which runs on no worker.
            return true;
        };
        // The shutdown does not join this thread. If the call ever returns, the thread ends the remains of
        // the instance and exits.
        drop(self.workers.lock().threads.remove(&worker));
        self.finish_turn(instance, None, 0, engine.clock.now());
        // The abandoned worker may have been the timer worker, and does not take the work that waits.
        self.work.notify_one();
        self.start_workers(engine, 1);
        true
    }

    fn end_all(&self, engine: &Arc<Engine>) -> Vec<SchemaId> {
        self.schedule.lock().is_stopping = true;
        self.work.notify_all();
        let runners = self.runners.entries().rev();
        let lost = shutdown::end_all(
            engine,
            runners.map(|(number, pooled)| (number, Arc::clone(&pooled.lock().runner))),
        );
        if lost.is_empty() {
            let workers = std::mem::take(&mut *self.workers.lock());
            for worker in workers.threads.into_values() {
                // `run_guarded` has reported its panics.
                let _ = worker.join();
            }
        }
        lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A schedule with one instance, due at that time.
    fn schedule_due_at(due: Nanos) -> Schedule {
        let mut calendar = Calendar::new(1);
        calendar.set_due(SchemaId(0), Some(due), 0);
        Schedule {
            inboxes: Table::default(),
            busy: vec![None].into(),
            ready: VecDeque::new(),
            calendar,
            turns: vec![TurnDurations::default()].into(),
            timer_worker_until: None,
            backup_worker_until: None,
            capacity: Capacity::new(2, 1),
            idle_waiters: 0,
            is_stopping: false,
        }
    }

    #[test]
    fn another_worker_is_notified_unless_the_next_deadline_is_served_in_time() {
        let mut schedule = schedule_due_at(1_000_000);
        let needs_another =
            |schedule: &Schedule, now, longest| schedule.needs_another_worker(now, Some(longest));
        assert!(
            needs_another(&schedule, 0, 0),
            "no other worker serves the deadline"
        );
        schedule.backup_worker_until = Some(1_000_000 + GRACE);
        assert!(
            !needs_another(&schedule, 0, 900_000),
            "this worker returns in time, or the backup worker takes over"
        );
        assert!(
            !needs_another(&schedule, 0, 1_000_000 + WAKE_LATENCY),
            "a notified worker would not start sooner"
        );
        assert!(
            needs_another(&schedule, 0, 1_000_001 + WAKE_LATENCY),
            "this worker would return too late"
        );
        assert!(
            schedule.needs_another_worker(0, None),
            "the duration of the turn is unknown"
        );
        assert!(
            !needs_another(&schedule, 1_100_000, WAKE_LATENCY),
            "the instance is due, but a notified worker would not start sooner"
        );
        assert!(
            needs_another(&schedule, 1_100_000, WAKE_LATENCY + 1),
            "the instance is due"
        );
        schedule.backup_worker_until = Some(1_000_001 + GRACE);
        assert!(
            needs_another(&schedule, 0, 0),
            "the backup worker starts too late"
        );
        schedule.timer_worker_until = Some(1_000_000);
        assert!(
            !schedule.needs_another_worker(0, None),
            "the timer worker serves the deadline"
        );
        schedule.ready.push_back(SchemaId(0));
        assert!(schedule.needs_another_worker(0, None), "a signal waits");
    }

    #[test]
    fn a_long_turn_is_remembered_for_some_turns() {
        let mut turns = TurnDurations::default();
        assert_eq!(turns.longest, None);
        turns.began = 100;
        turns.end(1124);
        assert_eq!(turns.longest, Some(1024));
        turns.end(101);
        assert_eq!(turns.longest, Some(768));
        turns.end(1000);
        assert_eq!(turns.longest, Some(900));
        assert!(turns.has_short_turns());
        turns.end(101 + WAKE_LATENCY);
        assert!(!turns.has_short_turns());
    }
}
