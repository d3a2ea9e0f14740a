//! A run: how time passes, and how it ends.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_conditions::{Expression, Names};
use jde_core::{Nanos, SchemaId};
use jde_host::{Handle, OperatorHandle, Running};
use jde_records::event::Outcome;
use jde_sim::EditQueue;
use parking_lot::{Condvar, Mutex, MutexGuard};

use crate::Error;
use crate::application::StartOptions;
use crate::lease::Lease;
use crate::names::LivePort;
use crate::observation::Observation;
use crate::state::{Executor, SLICE, State, next_instant};
use jde_experiment::drive::EventQueue;

/// The greatest time that a run reaches, ns: no end.
pub const FOREVER: Nanos = Nanos::MAX - 1;
/// How often a run in real time looks for records, conditions and the end of a lease.
const LOOK_INTERVAL: Duration = Duration::from_millis(10);

/// A started application, in real time or in lockstep. Dropping it brings the application to rest.
pub struct Run {
    pub(crate) shared: Arc<Shared>,
    /// The ports of mocks, by their full names.
    pub(crate) live: BTreeMap<String, LivePort>,
    /// The thread that looks, in real time. Who ends the run holds this lock until it is at rest.
    poller: Mutex<Option<JoinHandle<()>>>,
}

/// What the threads of a run share.
pub(crate) struct Shared {
    pub(crate) handle: Handle,
    pub(crate) operator: OperatorHandle,
    /// The name of the operator.
    pub(crate) by: String,
    state: Mutex<State>,
    /// This lock is taken after that of the state, or alone.
    lease: Mutex<Lease>,
    /// The changes of each world so far, by the driver that makes them.
    pub(crate) edits: Mutex<BTreeMap<SchemaId, EditQueue>>,
    /// Notified after each look and at the end.
    looked: Condvar,
    /// Seconds of application time per second of machine time; `None` in lockstep.
    speed: Option<f64>,
}

/// Why a run stopped letting time pass or waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The time was reached, or nothing is due and there is no such time.
    Time,
    /// The condition became true.
    Condition,
    /// The application has ended.
    End,
}

impl Run {
    pub(crate) fn new(
        executor: Executor,
        handle: &Handle,
        live: BTreeMap<String, LivePort>,
        events: Option<EventQueue>,
        options: &StartOptions,
    ) -> Self {
        let shared = Shared {
            handle: handle.clone(),
            operator: handle.operator(&options.operator),
            by: options.operator.clone(),
            state: Mutex::new(State {
                executor,
                observation: events.map(|events| Observation::new(events, handle)),
                panels: BTreeMap::new(),
            }),
            lease: Mutex::default(),
            edits: Mutex::default(),
            looked: Condvar::new(),
            speed: (!options.lockstep).then_some(options.speed),
        };
        Self {
            shared: Arc::new(shared),
            live,
            poller: Mutex::default(),
        }
    }

    /// Starts the threads of a run in real time: one brings the application to rest when it ends by itself, the other
    /// looks for records, conditions and the end of the lease.
    pub(crate) fn attend(&self, running: Running) -> Result<(), Error> {
        let (waiting, looking) = (Arc::clone(&self.shared), Arc::clone(&self.shared));
        let waiter = Builder::new().name(String::from("jde-rest")).spawn(move || {
            running.wait();
            waiting.looked.notify_all();
        });
        self.state().executor = Executor::RealTime(waiter.map_err(Error::failed)?);
        let poller = Builder::new()
            .name(String::from("jde-look"))
            .spawn(move || looking.look());
        *self.poller() = Some(poller.map_err(Error::failed)?);
        Ok(())
    }

    /// Returns the application, its variables and its time.
    #[must_use]
    pub fn handle(&self) -> &Handle {
        &self.shared.handle
    }

    /// Returns how the application ended: `done`, `failed`, `time up`, `stopped` or `broken: ` with the reason;
    /// `None` while it runs.
    #[must_use]
    pub fn outcome(&self) -> Option<String> {
        self.shared.handle.outcome().map(|outcome| match outcome {
            Outcome::Done => String::from("done"),
            Outcome::Failed => String::from("failed"),
            Outcome::TimeUp => String::from("time up"),
            Outcome::Stopped => String::from("stopped"),
            Outcome::Broken(reason) => format!("broken: {reason}"),
        })
    }

    /// Runs the next instant in lockstep, or until a time, ns, if that comes first. Returns whether the application
    /// goes on: not if it has ended, and not if nothing is due and no time is given.
    ///
    /// # Errors
    /// The run is in real time.
    pub fn step(&self, end: Option<Nanos>) -> Result<bool, Error> {
        if self.shared.speed.is_some() {
            let reason = "time passes by itself in real time; only a run in lockstep has steps";
            return Err(Error::invalid(reason));
        }
        let next = match &mut self.shared.state().executor {
            Executor::Lockstep(lockstep) => next_instant(lockstep, &self.shared.handle),
            _ => None,
        };
        match next.into_iter().chain(end).min() {
            Some(time) => Ok(self.advance(time, None, || true) != Stop::End),
            None => Ok(false),
        }
    }

    /// Lets time pass in lockstep, or waits in real time, until a time, ns, is reached or a condition is true.
    /// `go_on` is called about every 20 ms of machine time; if it returns false, the application is brought to rest.
    ///
    /// # Errors
    /// The condition is none, or the run keeps no records.
    pub fn until(
        &self,
        end: Option<Nanos>,
        condition: Option<&str>,
        go_on: impl FnMut() -> bool,
    ) -> Result<Stop, Error> {
        let end = end.unwrap_or(FOREVER);
        let Some(condition) = condition else {
            return Ok(self.advance(end, None, go_on));
        };
        let handle = &self.shared.handle;
        let names = Names::of(handle.application());
        let expression = Expression::condition(condition, &names).map_err(Error::invalid)?;
        let number = self.observation(|observation| observation.add_condition(expression, handle))?;
        let stop = self.advance(end, Some(number), go_on);
        // Later instants do not evaluate it.
        self.observation(|observation| observation.remove_condition(number, handle))?;
        Ok(stop)
    }

    /// Brings the application to rest, and returns when it is. Afterwards its variables and records can still be
    /// read.
    pub fn end(&self) {
        self.shared.handle.stop();
        let mut poller = self.poller();
        let executor = std::mem::replace(&mut self.state().executor, Executor::AtRest);
        match executor {
            Executor::Lockstep(lockstep) => drop(lockstep),
            // The threads of the application catch their panics.
            Executor::RealTime(waiter) => drop(waiter.join()),
            Executor::AtRest => {}
        }
        self.state().observe(&self.shared);
        self.shared.looked.notify_all();
        drop(poller.take().map(JoinHandle::join));
    }

    fn poller(&self) -> MutexGuard<'_, Option<JoinHandle<()>>> {
        self.poller.lock()
    }

    fn advance(&self, end: Nanos, condition: Option<u64>, mut go_on: impl FnMut() -> bool) -> Stop {
        loop {
            if let Some(stop) = self.shared.advance(end, condition) {
                return stop;
            }
            if !go_on() {
                self.end();
                return Stop::End;
            }
        }
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state()
    }

    pub(crate) fn observation<T>(&self, using: impl FnOnce(&mut Observation) -> T) -> Result<T, Error> {
        match &mut self.state().observation {
            Some(observation) => Ok(using(observation)),
            None => Err(Error::invalid("the run keeps no records; start it with them")),
        }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        self.end();
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock()
    }

    pub(crate) fn lease(&self) -> MutexGuard<'_, Lease> {
        self.lease.lock()
    }

    /// Lets time pass or waits, for [`SLICE`] at most. Returns `None` if the time was not reached.
    fn advance(&self, end: Nanos, condition: Option<u64>) -> Option<Stop> {
        let mut state = self.state();
        let Some(speed) = self.speed else {
            return state.advance(self, end, condition);
        };
        let stop = |state: &mut State| {
            let (outcome, now) = (self.handle.outcome(), self.handle.now());
            state.observe(self);
            match outcome {
                _ if state.was_true(condition) => Some(Stop::Condition),
                Some(_) => Some(Stop::End),
                None => (now >= end).then_some(Stop::Time),
            }
        };
        stop(&mut state).or_else(|| {
            let left = end.saturating_sub(self.handle.now()) as f64 / speed;
            let wait = Duration::from_nanos(left as u64).min(SLICE);
            self.looked.wait_for(&mut state, wait);
            stop(&mut state)
        })
    }

    /// Looks until the application is at rest.
    fn look(&self) {
        let mut state = self.state();
        while !matches!(state.executor, Executor::AtRest) || self.handle.outcome().is_none() {
            state.observe(self);
            self.looked.notify_all();
            self.looked.wait_for(&mut state, LOOK_INTERVAL);
        }
    }
}
