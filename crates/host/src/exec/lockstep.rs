//! Lockstep: virtual time, one thread, as fast as the machine goes; the same seed gives the same run to the bit (R16).
//!
//! Calls take no virtual time, so nothing overruns here and a call that never returns stops the whole run.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use jde_core::Nanos;

use crate::engine::{Bells, Engine, Signal};
use crate::event::Outcome;
use crate::inbox::Inbox;
use crate::order::order;
use crate::runner::Runner;

/// Signals in the order in which they came, and when the rules want to be called.
pub(crate) struct Queue {
    signals: Mutex<VecDeque<(usize, Signal)>>,
    /// Whether there may be any: looked at after every turn, which seldom leads to one.
    waits: AtomicBool,
    /// [`NEVER`] if no timer runs.
    alarm: AtomicU64,
}

/// No time that comes.
const NEVER: Nanos = Nanos::MAX;

/// All runners on one thread.
pub(crate) struct Lockstep {
    engine: Arc<Engine>,
    queue: Arc<Queue>,
    runners: Vec<Runner>,
    due: Vec<Option<Nanos>>,
    /// The last instant at which each was triggered, and how often then.
    triggered: Vec<(Nanos, usize)>,
    /// Who runs first when several are due.
    order: Vec<usize>,
}

impl Bells for Queue {
    /// Several values that come before their reader has looked trigger it once, as in real time.
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

    /// Nobody waits: whoever left it looks.
    fn call(&self, _: usize) {}

    /// Kept here, so that an instant need not ask the rules for it.
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
            // Under the lock: whoever brings one afterwards says so afterwards.
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

    /// Goes on until virtual time is `end`, or the application concludes.
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

    /// Carries out all that the last call led to, at this same instant.
    fn settle(&mut self) {
        while let Some((number, signal)) = self.queue.pop() {
            // A turn for somebody who looks would be one that is not there while nobody does.
            let for_eyes = matches!(signal, Signal::Looked);
            if for_eyes || matches!(signal, Signal::Triggered) && self.goes_round(number) {
                continue;
            }
            let mut inbox = Inbox::default();
            inbox.put(signal);
            self.turn(number, inbox);
        }
    }

    /// Draws the panels of those who sleep, where somebody looks; it takes no virtual time and leads to nothing.
    fn draw_asleep(&mut self) {
        if self.engine.panels.is_any_looked_at() {
            for runner in &mut self.runners {
                runner.draw_asleep();
            }
        }
    }

    /// Whether an instance was triggered more often at this instant than any chain of schemas is long: then they trigger
    /// each other in a circle, which in virtual time would never end.
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
