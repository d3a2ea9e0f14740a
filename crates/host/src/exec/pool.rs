//! A few worker threads for all schemas, and more only while calls take long.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_core::Nanos;

use super::calendar::{Calendar, leeway};
use super::capacity::{Capacity, GRACE};
use super::ending;
use super::supervisor::{Alarm, Crew, guarded};
use crate::engine::{Bells, Engine, Signal};
use crate::inbox::Inbox;
use crate::runner::{Line, Runner};

/// Fewest workers beside the one that is always free, so that long turns leave some for the other schemas.
const FEWEST: usize = 4;
/// About how long a notified worker takes to start, ns. If a busy worker returns within this time, no other
/// is notified.
const CALL: Nanos = 20_000;

/// Workers that share all runners.
pub(crate) struct Pool {
    own: Weak<Self>,
    desk: Mutex<Desk>,
    work: Condvar,
    idle: Condvar,
    holders: Vec<Mutex<Holder>>,
    workers: Mutex<Workers>,
    alarm: Arc<Alarm>,
}

/// The runner that takes an instance's turns. A runner that hangs is replaced.
struct Holder {
    runner: Arc<Mutex<Runner>>,
    line: Line,
}

/// The workers that have not hung, by their numbers.
#[derive(Default)]
struct Workers {
    threads: BTreeMap<usize, JoinHandle<()>>,
    hired: usize,
    /// Whether the system has refused a thread since it last granted one.
    refused: bool,
}

struct Desk {
    inboxes: Vec<Inbox>,
    /// The worker that takes each instance's turn.
    busy: Vec<Option<usize>>,
    /// Instances with signals that no worker has taken.
    ready: VecDeque<usize>,
    /// When the instances that are not busy are due.
    calendar: Calendar,
    /// When each instance's turn began, and the longest of its recent turns.
    turns: Vec<Turns>,
    /// Until when the keeper sleeps, the worker that then looks at the calendar; `None` if no worker keeps
    /// it.
    keeper: Option<Nanos>,
    /// Until when the deputy sleeps: a little longer than the keeper, which the system may not let run in
    /// time; `None` without a deputy.
    deputy: Option<Nanos>,
    capacity: Capacity,
    /// The number of threads that wait until an instance has nothing to do.
    settling: usize,
    leave: bool,
}

/// The durations of one instance's turns, with all that is in them.
#[derive(Clone, Copy, Default)]
struct Turns {
    began: Nanos,
    /// Whether the present turn was expected to be short.
    brief: bool,
    /// The longest recent turn. Falls by a quarter from turn to turn; `None` before the first.
    longest: Option<Nanos>,
}

impl Bells for Pool {
    fn leave(&self, instance: usize, signal: Signal) -> bool {
        let mut desk = self.lock();
        // An instance with signals is in the queue already.
        let first = desk.inboxes[instance].is_empty();
        desk.inboxes[instance].put(signal);
        let waits = first && desk.busy[instance].is_none();
        if waits {
            desk.ready.push_back(instance);
        }
        waits
    }

    fn call(&self, _: usize) {
        self.work.notify_one();
    }

    fn set_alarm(&self, next: Option<Nanos>) -> bool {
        self.alarm.set(next)
    }

    fn call_alarm(&self) {
        self.alarm.call();
    }
}

impl Pool {
    pub(crate) fn new(
        engine: &Arc<Engine>,
        runners: Vec<Runner>,
        alarm: Arc<Alarm>,
    ) -> std::io::Result<Arc<Self>> {
        let count = runners.len();
        let workers = std::thread::available_parallelism()
            .map_or(FEWEST, usize::from)
            .max(FEWEST)
            .min(count)
            + 1;
        let desk = Desk {
            inboxes: (0..count).map(|_| Inbox::default()).collect(),
            busy: vec![None; count],
            ready: VecDeque::new(),
            calendar: Calendar::new(count),
            turns: vec![Turns::default(); count],
            keeper: None,
            deputy: None,
            capacity: Capacity::new(workers, count),
            settling: 0,
            leave: false,
        };
        let pool = Arc::new_cyclic(|own| Self {
            own: Weak::clone(own),
            desk: Mutex::new(desk),
            work: Condvar::new(),
            idle: Condvar::new(),
            holders: runners.into_iter().map(Holder::new).map(Mutex::new).collect(),
            workers: Mutex::default(),
            alarm,
        });
        for _ in 0..workers {
            if let Err(error) = pool.hire(engine) {
                pool.dismiss(engine);
                return Err(error);
            }
        }
        Ok(pool)
    }

    /// Starts one more worker.
    fn hire(&self, engine: &Arc<Engine>) -> std::io::Result<()> {
        let Some(own) = self.own.upgrade() else {
            return Ok(());
        };
        let mut workers = lock(&self.workers);
        let worker = workers.hired;
        let engine = Arc::clone(engine);
        let thread = Builder::new().name(format!("worker-{worker}"));
        engine.clock.hire();
        let thread = thread.spawn(move || {
            guarded(&engine, || own.run(&engine, worker));
            engine.clock.dismiss();
        })?;
        workers.threads.insert(worker, thread);
        workers.hired += 1;
        workers.refused = false;
        Ok(())
    }

    fn run(&self, engine: &Arc<Engine>, worker: usize) {
        super::supervisor::sharpen_timers();
        while let Some((number, inbox)) = self.next(engine, worker) {
            let runner = Arc::clone(&lock(&self.holders[number]).runner);
            let mut runner = lock(&runner);
            let due = runner.turn(inbox);
            let period = runner.period();
            drop(runner);
            self.put_back(number, due, period, engine.clock.now());
        }
        // The shutdown does not join a worker that leaves before it.
        if !self.lock().leave {
            drop(lock(&self.workers).threads.remove(&worker));
        }
    }

    /// Starts more workers, which `capacity` counts already.
    fn hire_some(&self, engine: &Arc<Engine>, number: usize) {
        for hired in 0..number {
            let Err(error) = self.hire(engine) else {
                continue;
            };
            self.lock().capacity.lacks(number - hired);
            if !std::mem::replace(&mut lock(&self.workers).refused, true) {
                tracing::error!("the system refuses a thread in place of those inside calls: {error}");
            }
            return;
        }
    }

    /// Waits for an instance that has signals or is due. Returns `None` when the worker must leave.
    fn next(&self, engine: &Arc<Engine>, worker: usize) -> Option<(usize, Inbox)> {
        let mut desk = self.lock();
        loop {
            if desk.leave {
                return None;
            }
            let now = engine.clock.now();
            let others = desk.capacity.leaves_it(now);
            if others.is_none()
                && let Some(number) = desk.take(now)
            {
                engine.clock.works();
                desk.busy[number] = Some(worker);
                let inbox = std::mem::take(&mut desk.inboxes[number]);
                let turns = &mut desk.turns[number];
                (turns.began, turns.brief) = (now, turns.longest.is_none_or(|longest| longest <= CALL));
                let (longest, brief) = (turns.longest.filter(|_| inbox.is_light()), turns.brief);
                let hired = desk.capacity.begin(now, brief);
                if desk.wants_another(now, longest) {
                    // This worker may have been the keeper of the calendar, and is now busy for as long as
                    // the call takes.
                    self.work.notify_one();
                }
                drop(desk);
                self.hire_some(engine, hired);
                return Some((number, inbox));
            }
            // One worker keeps the calendar. One deputy, possibly the last free worker, stands in for it. The
            // others wait for a notification.
            desk = match (others, desk.calendar.next()) {
                (None, Some(due)) if desk.keeper.is_none_or(|kept| due < kept) => {
                    desk.keeper = Some(due);
                    let mut desk = engine.clock.wait(&self.work, desk, Some(due));
                    if desk.keeper == Some(due) {
                        desk.keeper = None;
                    }
                    desk
                }
                (_, due) if others.is_some() || due.is_some() && desk.deputy.is_none() => {
                    let late = due.map(|due| due.saturating_add(GRACE).max(others.unwrap_or_default()));
                    // Signals are due from the time they arrive.
                    let mail = others.filter(|_| !desk.ready.is_empty());
                    desk.deputy = mail.or(late);
                    let until = desk.deputy;
                    let mut desk = engine.clock.wait(&self.work, desk, until);
                    desk.deputy = None;
                    desk
                }
                _ if desk.capacity.goes(now) => return None,
                _ => {
                    let until = desk.capacity.stays(now);
                    engine.clock.wait(&self.work, desk, until)
                }
            };
        }
    }

    fn put_back(&self, number: usize, due: Option<Nanos>, period: Nanos, now: Nanos) {
        let mut desk = self.lock();
        desk.busy[number] = None;
        let brief = desk.turns[number].brief;
        desk.capacity.end(brief);
        desk.turns[number].end(now);
        // A schema with long turns gets no leeway: a schema due after it, to read what it writes, would need
        // another worker meanwhile.
        let leeway = if desk.turns[number].are_short() {
            leeway(period)
        } else {
            0
        };
        desk.calendar.put(number, due, leeway);
        if !desk.inboxes[number].is_empty() {
            desk.ready.push_back(number);
        } else if desk.settling > 0 {
            self.idle.notify_all();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Desk> {
        lock(&self.desk)
    }
}

impl Holder {
    fn new(runner: Runner) -> Self {
        Self {
            line: runner.line(),
            runner: Arc::new(Mutex::new(runner)),
        }
    }
}

impl Turns {
    fn end(&mut self, now: Nanos) {
        let took = now.saturating_sub(self.began);
        let before = self.longest.unwrap_or_default();
        self.longest = Some(took.max(before - before / 4));
    }

    /// Whether the turns end before a worker notified for another turn would start.
    fn are_short(self) -> bool {
        self.longest.is_some_and(|longest| longest <= CALL)
    }
}

impl Desk {
    /// Whether to notify another worker after one has taken a turn that is expected to end after `longest`.
    /// False if no more signals wait and the next deadline is served: by the keeper, or by this worker if it
    /// returns in time and a deputy stands in for it. In time means before a worker notified at the deadline
    /// could start. If this worker takes longer, or cannot serve all that is due, the deputy takes over.
    fn wants_another(&self, now: Nanos, longest: Option<Nanos>) -> bool {
        if !self.ready.is_empty() {
            return true;
        }
        let Some(due) = self.calendar.next() else {
            return false;
        };
        let kept = self.keeper.is_some_and(|kept| kept <= due);
        let stood_in = self
            .deputy
            .is_some_and(|until| until <= due.saturating_add(GRACE));
        let back = longest.is_some_and(|longest| now + longest <= due.max(now).saturating_add(CALL));
        !(kept || stood_in && back)
    }

    /// Takes an instance to run now; signals precede deadlines.
    fn take(&mut self, now: Nanos) -> Option<usize> {
        while let Some(number) = self.ready.pop_front() {
            if self.busy[number].is_none() && !self.inboxes[number].is_empty() {
                self.calendar.take_out(number);
                return Some(number);
            }
        }
        self.calendar.take(now)
    }
}

impl Crew for Pool {
    fn settled(&self, instance: usize, within: Duration) -> bool {
        let waiting = |desk: &mut Desk| desk.busy[instance].is_some() || !desk.inboxes[instance].is_empty();
        let mut desk = self.lock();
        desk.settling += 1;
        let (mut desk, _) = self
            .idle
            .wait_timeout_while(desk, within, waiting)
            .unwrap_or_else(PoisonError::into_inner);
        desk.settling -= 1;
        !waiting(&mut desk)
    }

    /// The hung worker is abandoned with its call, and a new one is started.
    fn relieve(
        &self,
        engine: &Arc<Engine>,
        instance: usize,
        since: Nanos,
        tell: &mut dyn FnMut(u64),
    ) -> bool {
        let line = lock(&self.holders[instance]).line.clone();
        let Some(runner) = line.give_up(since, tell) else {
            return false;
        };
        *lock(&self.holders[instance]) = Holder::new(runner);
        let Some(worker) = self.lock().busy[instance] else {
            // The instance hangs in its end, which runs on no worker.
            return true;
        };
        // The shutdown does not join this thread. If the call ever returns, the thread ends the remains of
        // the instance and exits.
        drop(lock(&self.workers).threads.remove(&worker));
        self.put_back(instance, None, 0, engine.clock.now());
        // The abandoned worker may have been the keeper, and does not look at the work it left.
        self.work.notify_one();
        self.hire_some(engine, 1);
        true
    }

    fn dismiss(&self, engine: &Arc<Engine>) -> Vec<usize> {
        self.lock().leave = true;
        self.work.notify_all();
        let holders = self.holders.iter().enumerate().rev();
        let lost = ending::end(
            engine,
            holders.map(|(number, holder)| (number, Arc::clone(&lock(holder).runner))),
        );
        if lost.is_empty() {
            let workers = std::mem::take(&mut *lock(&self.workers));
            for worker in workers.threads.into_values() {
                // `guarded` has reported its panics.
                let _ = worker.join();
            }
        }
        lost
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A desk with one instance, due at that time.
    fn due(due: Nanos) -> Desk {
        let mut calendar = Calendar::new(1);
        calendar.put(0, Some(due), 0);
        Desk {
            inboxes: Vec::new(),
            busy: vec![None],
            ready: VecDeque::new(),
            calendar,
            turns: vec![Turns::default()],
            keeper: None,
            deputy: None,
            capacity: Capacity::new(2, 1),
            settling: 0,
            leave: false,
        }
    }

    #[test]
    fn another_is_called_unless_the_next_is_served_in_time() {
        let mut desk = due(1_000_000);
        let called = |desk: &Desk, now, longest| desk.wants_another(now, Some(longest));
        assert!(called(&desk, 0, 0), "nobody would come if this one stays away");
        desk.deputy = Some(1_000_000 + GRACE);
        assert!(!called(&desk, 0, 900_000), "it is back, or the deputy comes");
        assert!(
            !called(&desk, 0, 1_000_000 + CALL),
            "who is called comes no sooner"
        );
        assert!(called(&desk, 0, 1_000_001 + CALL), "it would be late");
        assert!(desk.wants_another(0, None), "nobody knows how long this takes");
        assert!(
            !called(&desk, 1_100_000, CALL),
            "it is due, but who is called comes no sooner"
        );
        assert!(called(&desk, 1_100_000, CALL + 1), "it is due");
        desk.deputy = Some(1_000_001 + GRACE);
        assert!(called(&desk, 0, 0), "the deputy comes too late");
        desk.keeper = Some(1_000_000);
        assert!(!desk.wants_another(0, None), "the calendar is kept");
        desk.ready.push_back(0);
        assert!(desk.wants_another(0, None), "there is more to do now");
    }

    #[test]
    fn a_long_turn_is_remembered_for_some_turns() {
        let mut turns = Turns::default();
        assert_eq!(turns.longest, None);
        turns.began = 100;
        turns.end(1124);
        assert_eq!(turns.longest, Some(1024));
        turns.end(101);
        assert_eq!(turns.longest, Some(768));
        turns.end(1000);
        assert_eq!(turns.longest, Some(900));
        assert!(turns.are_short());
        turns.end(101 + CALL);
        assert!(!turns.are_short());
    }
}
