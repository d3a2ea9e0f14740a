//! Lockstep: virtual time, one thread, as fast as the machine allows; the same seed gives the same run to the
//! bit (R16).
//!
//! Calls take no virtual time, so nothing overruns here, and a call that never returns stops the whole run.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use jde_core::Nanos;

use crate::engine::{Bells, Engine, Signal};
use crate::event::Outcome;
use crate::inbox::Inbox;
use crate::order::order;
use crate::runner::Runner;

/// Signals in the order in which they arrived, and the time of the rules' next timer.
pub(crate) struct Queue {
    signals: Mutex<VecDeque<(usize, Signal)>>,
    /// Whether signals may wait. Checked after every turn, which rarely causes one.
    waits: AtomicBool,
    /// [`NEVER`] if no timer runs.
    alarm: AtomicU64,
}

/// A time that never occurs.
const NEVER: Nanos = Nanos::MAX;

/// All runners on one thread.
pub(crate) struct Lockstep {
    engine: Arc<Engine>,
    queue: Arc<Queue>,
    runners: Vec<Runner>,
    due: Vec<Option<Nanos>>,
    /// The last instant at which each instance was triggered, and how often at that instant.
    triggered: Vec<(Nanos, usize)>,
    /// The order in which instances run when several are due.
    order: Vec<usize>,
}

impl Bells for Queue {
    /// Several values that arrive before their reader has run trigger it once, as in real time.
    fn leave(&self, instance: usize, signal: Signal) -> bool {
        let mut signals = self.signals.lock().unwrap_or_else(PoisonError::into_inner);
        let waits =
            |(other, signal): &(usize, Signal)| *other == instance && matches!(signal, Signal::Triggered);
        if !(matches!(signal, Signal::Triggered) && signals.iter().any(waits)) {
            signals.push_back((instance, signal));
            self.waits.store(true, Ordering::Release);
        }
        false
    }

    /// No thread waits: the thread that left the signal runs the turn.
    fn call(&self, _: usize) {}

    /// Kept here, so that an instant need not query the rules for it.
    fn set_alarm(&self, next: Option<Nanos>) -> bool {
        self.alarm.store(next.unwrap_or(NEVER), Ordering::Release);
        false
    }

    fn call_alarm(&self) {}
}

impl Default for Queue {
    fn default() -> Self {
        Self {
            signals: Mutex::default(),
            waits: AtomicBool::default(),
            alarm: AtomicU64::new(NEVER),
        }
    }
}

impl Queue {
    /// When the rules' next timer is due.
    fn timer(&self) -> Option<Nanos> {
        Some(self.alarm.load(Ordering::Acquire)).filter(|timer| *timer != NEVER)
    }

    pub(crate) fn pop(&self) -> Option<(usize, Signal)> {
        if !self.waits.load(Ordering::Acquire) {
            return None;
        }
        let mut signals = self.signals.lock().unwrap_or_else(PoisonError::into_inner);
        let signal = signals.pop_front();
        if signal.is_none() {
            // Under the lock, so that a later signal sets the flag later.
            self.waits.store(false, Ordering::Release);
        }
        signal
    }
}

impl Lockstep {
    pub(crate) fn new(engine: Arc<Engine>, runners: Vec<Runner>) -> Self {
        let queue = Arc::new(Queue::default());
        let bells: Arc<dyn Bells> = Arc::clone(&queue) as _;
        engine.attach(&bells);
        let order = order(&engine.application.instances);
        let due = vec![None; runners.len()];
        let triggered = vec![(0, 0); runners.len()];
        Self {
            engine,
            queue,
            runners,
            due,
            triggered,
            order,
        }
    }

    pub(crate) fn start(&mut self) {
        self.engine.start();
        self.settle();
    }

    /// Runs until virtual time is `end`, or the application concludes.
    pub(crate) fn run_until(&mut self, end: Nanos) -> Option<Outcome> {
        self.settle();
        loop {
            if let Some(outcome) = self.engine.outcome() {
                return Some(outcome);
            }
            let timer = self.queue.timer();
            let Some(now) = self
                .due
                .iter()
                .copied()
                .flatten()
                .chain(timer)
                .min()
                .filter(|now| *now <= end)
            else {
                self.engine.clock.set(end);
                return None;
            };
            self.engine.clock.set(now);
            if timer.is_some_and(|timer| timer <= now) {
                self.engine.tick();
                self.settle();
            }
            for place in 0..self.order.len() {
                let number = self.order[place];
                if self.due[number].is_some_and(|due| due <= now) {
                    self.turn(number, Inbox::default());
                    self.settle();
                }
            }
            self.draw_asleep();
        }
    }

    /// Brakes, puts everything to sleep, children before fathers, and ends the instances in reverse order.
    pub(crate) fn shut_down(&mut self) {
        self.engine.brake_all();
        self.settle();
        for number in self.engine.put_to_sleep() {
            let mut inbox = Inbox::default();
            inbox.put(Signal::Asleep);
            self.turn(number, inbox);
            self.settle();
        }
        self.runners.iter_mut().rev().for_each(Runner::destroy);
        self.engine.builds.close();
    }

    /// Processes all signals that the last call caused, at the same instant.
    fn settle(&mut self) {
        while let Some((number, signal)) = self.queue.pop() {
            // A turn for a viewer would change the run, since without a viewer it does not occur.
            let for_eyes = matches!(signal, Signal::Looked);
            if for_eyes || matches!(signal, Signal::Triggered) && self.goes_round(number) {
                continue;
            }
            let mut inbox = Inbox::default();
            inbox.put(signal);
            self.turn(number, inbox);
        }
    }

    /// Draws the viewed panels of sleeping schemas. It takes no virtual time and has no effects.
    fn draw_asleep(&mut self) {
        if self.engine.panels.is_any_looked_at() {
            for runner in &mut self.runners {
                runner.draw_asleep();
            }
        }
    }

    /// Whether an instance was triggered at this instant more often than the longest chain of schemas allows.
    /// Then schemas trigger each other in a circle, which would never end in virtual time.
    fn goes_round(&mut self, number: usize) -> bool {
        let now = self.engine.clock.now();
        let (instant, times) = &mut self.triggered[number];
        if *instant != now {
            (*instant, *times) = (now, 0);
        }
        *times += 1;
        *times > self.runners.len()
    }

    fn turn(&mut self, number: usize, inbox: Inbox) {
        self.due[number] = self.runners[number].turn(inbox);
    }
}
