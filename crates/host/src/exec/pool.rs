//! Few threads for all schemas, and more only while calls take long.

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

/// Fewest workers beside the one that is always free: so that turns that take some time leave some for the others.
const FEWEST: usize = 4;
/// About how long it takes until a worker that is called is there, ns: who is back by then need not call one.
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

/// Who takes an instance's turns. Whoever hangs is replaced.
struct Holder {
    runner: Arc<Mutex<Runner>>,
    line: Line,
}

/// Those who have not hung, by their numbers.
#[derive(Default)]
struct Workers {
    threads: BTreeMap<usize, JoinHandle<()>>,
    hired: usize,
    /// The system has refused a thread since it last gave one.
    refused: bool,
}

struct Desk {
    inboxes: Vec<Inbox>,
    /// The worker that is taking each one's turn.
    busy: Vec<Option<usize>>,
    /// Instances with mail that nobody has taken up.
    ready: VecDeque<usize>,
    /// When those are due who are not busy.
    calendar: Calendar,
    /// When each one's turn began, and how long its turns take at most, lately.
    turns: Vec<Turns>,
    /// Until when a worker sleeps that will then look at the calendar; nothing while none does.
    keeper: Option<Nanos>,
    /// Until when another sleeps, which is a little longer, for the system may not let the first run; nothing while none does.
    deputy: Option<Nanos>,
    capacity: Capacity,
    /// How many wait until an instance has nothing to do.
    settling: usize,
    leave: bool,
}

/// The turns of one instance, all that is in them.
#[derive(Clone, Copy, Default)]
struct Turns {
    began: Nanos,
    /// The present one was thought to be short.
    brief: bool,
    /// Falls by a quarter from turn to turn; nothing before the first.
    longest: Option<Nanos>,
}

impl Bells for Pool {
    fn leave(&self, instance: usize, signal: Signal) -> bool {
        let mut desk = self.lock();
        // Who has mail already is in the queue already.
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

    /// One worker more.
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
        // Who goes before the end is not waited for then.
        if !self.lock().leave {
            drop(lock(&self.workers).threads.remove(&worker));
        }
    }

    /// So many workers more, who are counted already.
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

    /// Waits for an instance with mail, or one that is due; `None` to leave.
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
                    // Whoever kept the calendar may be this worker, which is now gone for as long as a call takes.
                    self.work.notify_one();
                }
                drop(desk);
                self.hire_some(engine, hired);
                return Some((number, inbox));
            }
            // One keeps the calendar and one stands in for it, who may be the last that is free; the others wait until they are called.
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
                    // Mail is due since it came.
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
        // Who takes long is not kept waiting: whoever is due after it, to read what it writes, would have to be called meanwhile.
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

    /// Whether a worker that is called for another turn would not be there before they end.
    fn are_short(self) -> bool {
        self.longest.is_some_and(|longest| longest <= CALL)
    }
}

impl Desk {
    /// Whether another worker is to look for work, when one has taken some and is thought to be back after `longest`: there is more
    /// mail, or nobody keeps the calendar until then. Who is due already waits for it too, if one that is called would not be there
    /// sooner. If it stays away, or what is due is more than it can do, the deputy comes.
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

    /// An instance to run now, mail before time.
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

    /// The worker goes with the call, and another is hired for it.
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
            // It hangs in its end, which is on no worker.
            return true;
        };
        // Not waited for at the end; if the call ever returns, it ends what is left of it and goes.
        drop(lock(&self.workers).threads.remove(&worker));
        self.put_back(instance, None, 0, engine.clock.now());
        // No worker of its own looks at what it left, and the keeper of the calendar may be gone with it.
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
                // Its panics were reported by `guarded`.
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

    /// Nothing but one instance that is due then.
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
