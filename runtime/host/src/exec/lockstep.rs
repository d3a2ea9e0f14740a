//! Lockstep: virtual time, one thread, as fast as the machine allows; the same seed gives the same run to the
//! bit (R16).
//!
//! Calls take no virtual time, so nothing overruns, and a call that never returns stops the whole run.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use jde_core::{Nanos, SchemaId, Table};
use jde_records::event::Outcome;
use parking_lot::Mutex;

use crate::engine::{Engine, Notifier, Signal};
use crate::inbox::Inbox;
use crate::runner::Runner;
use crate::turn_order::turn_order;

/// The signals in the order of their arrival, and the time of the rules' next timer.
pub(crate) struct SignalQueue {
    signals: Mutex<VecDeque<(SchemaId, Signal)>>,
    /// Whether the queue may contain signals. Checked after every turn, which rarely causes one.
    has_signals: AtomicBool,
    /// [`NEVER_DUE`] if no timer runs.
    alarm: AtomicU64,
}

/// A time that never occurs.
const NEVER_DUE: Nanos = Nanos::MAX;

/// All runners on one thread.
pub(crate) struct LockstepExecutor {
    engine: Arc<Engine>,
    queue: Arc<SignalQueue>,
    runners: Table<SchemaId, Runner>,
    due: Table<SchemaId, Option<Nanos>>,
    /// The last instant at which each instance was triggered, and how often at that instant.
    triggered: Table<SchemaId, (Nanos, usize)>,
    /// The order in which instances run when several are due.
    order: Vec<SchemaId>,
    /// No value of before expires sooner.
    next_expiry: Nanos,
}

impl Notifier for SignalQueue {
    /// Several values that arrive before their reader has run trigger it once, as in real time.
    fn post(&self, instance: SchemaId, signal: Signal) -> bool {
        let mut signals = self.signals.lock();
        let is_same =
            |(other, signal): &(SchemaId, Signal)| *other == instance && matches!(signal, Signal::Triggered);
        if !(matches!(signal, Signal::Triggered) && signals.iter().any(is_same)) {
            signals.push_back((instance, signal));
            self.has_signals.store(true, Ordering::Release);
        }
        false
    }

    /// No thread waits: the thread that posted the signal runs the turn.
    fn notify(&self, _: SchemaId) {}

    /// Stores the time, so that an instant need not query the rules for it.
    fn set_timer(&self, next: Option<Nanos>) -> bool {
        self.alarm.store(next.unwrap_or(NEVER_DUE), Ordering::Release);
        false
    }

    fn notify_timer(&self) {}
}

impl Default for SignalQueue {
    fn default() -> Self {
        Self {
            signals: Mutex::default(),
            has_signals: AtomicBool::default(),
            alarm: AtomicU64::new(NEVER_DUE),
        }
    }
}

impl SignalQueue {
    /// Returns when the rules' next timer is due.
    fn next_timer(&self) -> Option<Nanos> {
        Some(self.alarm.load(Ordering::Acquire)).filter(|timer| *timer != NEVER_DUE)
    }

    pub(crate) fn pop(&self) -> Option<(SchemaId, Signal)> {
        if !self.has_signals.load(Ordering::Acquire) {
            return None;
        }
        let mut signals = self.signals.lock();
        let signal = signals.pop_front();
        if signal.is_none() {
            // Under the lock, so that a later signal sets the flag later.
            self.has_signals.store(false, Ordering::Release);
        }
        signal
    }
}

impl LockstepExecutor {
    pub(crate) fn new(engine: Arc<Engine>, runners: Table<SchemaId, Runner>) -> Self {
        let queue = Arc::new(SignalQueue::default());
        let notifier: Arc<dyn Notifier> = Arc::clone(&queue) as _;
        engine.attach(&notifier);
        let order = turn_order(&engine.application.instances);
        let due = runners.map_ids(|_| None);
        let triggered = runners.map_ids(|_| (0, 0));
        Self {
            engine,
            queue,
            runners,
            due,
            triggered,
            order,
            next_expiry: 0,
        }
    }

    pub(crate) fn start(&mut self) {
        self.engine.rules.start();
        self.process_signals();
    }

    /// Returns the next time at which a schema or a timer is due, or a value ends.
    pub(crate) fn next_instant(&self) -> Option<Nanos> {
        let schemas = self.due.iter().copied().flatten();
        let due = schemas.chain(self.queue.next_timer()).min();
        if due.is_some_and(|due| due <= self.next_expiry) {
            return due;
        }
        // No schema publishes anything before that. A value that came from elsewhere may be over already.
        let end = self.engine.variables.next_end();
        let end = end.map(|end| end.max(self.engine.clock.now()));
        due.into_iter().chain(end).min()
    }

    /// Runs until virtual time is `end` or stands still, or the application concludes.
    pub(crate) fn run_until(&mut self, end: Nanos) -> Option<Outcome> {
        self.process_signals();
        loop {
            if let Some(outcome) = self.engine.outcome.get() {
                return Some(outcome);
            }
            if self.engine.clock.is_still() {
                return None;
            }
            let Some(now) = self.next_instant().filter(|now| *now <= end) else {
                self.engine.clock.advance_to(end);
                return None;
            };
            self.engine.clock.advance_to(now);
            if self.queue.next_timer().is_some_and(|timer| timer <= now) {
                self.engine.tick();
                self.process_signals();
            }
            if now > self.next_expiry {
                self.next_expiry = self.engine.expire_values(now);
                self.process_signals();
            }
            for place in 0..self.order.len() {
                let number = self.order[place];
                if self.due[number].is_some_and(|due| due <= now) {
                    self.take_turn(number, None);
                    self.process_signals();
                }
            }
            self.draw_asleep();
        }
    }

    /// Brakes, puts all schemas to sleep, children before fathers, and ends the instances in reverse order.
    pub(crate) fn shut_down(&mut self) {
        self.engine.rules.brake_all();
        self.process_signals();
        for number in self.engine.rules.put_to_sleep() {
            let mut inbox = Inbox::default();
            inbox.push(Signal::Asleep);
            self.take_turn(number, Some(inbox));
            self.process_signals();
        }
        self.runners.iter_mut().rev().for_each(Runner::destroy);
        self.engine.builds.close();
    }

    /// Processes all signals that the last call caused, at the same instant.
    fn process_signals(&mut self) {
        while let Some((number, signal)) = self.queue.pop() {
            // A turn for a viewer would change the run, because it does not occur without a viewer.
            let for_viewer = matches!(signal, Signal::PanelOpened);
            if for_viewer || matches!(signal, Signal::Triggered) && self.is_trigger_loop(number) {
                continue;
            }
            let mut inbox = Inbox::default();
            inbox.push(signal);
            self.take_turn(number, Some(inbox));
        }
    }

    /// Draws the viewed panels of sleeping schemas. It takes no virtual time and has no effects.
    fn draw_asleep(&mut self) {
        if self.engine.panels.has_viewers() {
            for runner in self.runners.iter_mut() {
                runner.draw_asleep();
            }
        }
    }

    /// Whether an instance was triggered at this instant more often than the longest chain of schemas allows.
    /// Then schemas trigger each other in a cycle, which would never end in virtual time.
    fn is_trigger_loop(&mut self, number: SchemaId) -> bool {
        let now = self.engine.clock.now();
        let (instant, times) = &mut self.triggered[number];
        if *instant != now {
            (*instant, *times) = (now, 0);
        }
        *times += 1;
        let is_loop = *times > self.runners.len();
        if is_loop {
            self.engine.metrics[number]
                .triggers_dropped
                .fetch_add(1, Ordering::Relaxed);
        }
        is_loop
    }

    fn take_turn(&mut self, number: SchemaId, signals: Option<Inbox>) {
        self.due[number] = self.runners[number].take_turn(signals);
    }
}
