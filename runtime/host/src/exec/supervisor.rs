//! The supervisor of real time: runs the rules' timers, ends values that nobody renews, detects calls that do not return, and brings
//! all schemas to rest at the end.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use jde_core::{Nanos, SchemaId, Table};
use jde_records::event::{Outcome, What};
use parking_lot::{Condvar, Mutex};

use crate::engine::Engine;
use crate::instance::AbandonedInstance;
use crate::metrics::RunningJudgement;
use crate::stalls::MIN_STALL;

/// By default, a call hangs if it takes more than this many times its budget and more than [`MIN_HANG_TIME`].
const HUNG_BUDGETS: u64 = 10;
/// No call hangs sooner by its budget: a loaded machine may delay a thread for some tenths of a second.
const MIN_HANG_TIME: Duration = Duration::from_secs(1);
/// The longest time between two checks of running calls, ns: a hung call is detected within a quarter of a
/// second.
const MAX_CHECK_INTERVAL: Nanos = 250_000_000;
/// How long an instance may take to fall asleep at the end before it is abandoned.
pub(super) const REST_TIMEOUT: Duration = Duration::from_secs(1);

/// The time of the rules' next timer, and whether the supervisor must stop.
#[derive(Default)]
pub(crate) struct Alarm {
    state: Mutex<(Option<Nanos>, bool)>,
    changed: Condvar,
}

/// The operations of an executor that the supervisor uses.
pub(crate) trait ThreadExecutor: Send + Sync {
    /// Waits until an instance is idle. Returns false if it is still busy after `within`.
    fn wait_until_idle(&self, instance: SchemaId, within: Duration) -> bool;
    /// Gives up the call of an instance that runs since the time in `call`, and puts another runner in its place.
    /// `report` runs before the replacement and receives the bytes of shared values that the call keeps.
    /// The guard in `call`, if there is one, answers for it.
    /// Returns false, without running `report`, if the call cannot be given up now.
    fn replace_runner(
        &self,
        engine: &Arc<Engine>,
        instance: SchemaId,
        call: (Nanos, Option<SchemaId>),
        report: &mut dyn FnMut(u64),
    ) -> bool;
    /// Ends all instances in reverse order, and the threads. Returns the instances that are still
    /// inside a call, which are abandoned.
    fn end_all(&self, engine: &Arc<Engine>) -> Vec<SchemaId>;
}

impl Alarm {
    /// Returns whether the supervisor must be notified, because it sleeps longer than until `next`.
    pub(crate) fn set(&self, next: Option<Nanos>) -> bool {
        let mut state = self.state.lock();
        let sooner = match (next, state.0) {
            (Some(next), Some(previous)) => next < previous,
            (Some(_), None) => true,
            (None, _) => false,
        };
        state.0 = next;
        sooner
    }

    pub(crate) fn notify(&self) {
        self.changed.notify_all();
    }

    pub(crate) fn stop(&self) {
        self.state.lock().1 = true;
        self.notify();
    }
}

/// Supervises until the alarm is stopped.
pub(crate) fn supervise(
    engine: &Arc<Engine>,
    executor: &dyn ThreadExecutor,
    alarm: &Alarm,
    limit: Option<Nanos>,
) {
    jde_isolation::run_when_due();
    let mut reported = engine.metrics.map_ids(|_| None);
    let check_interval = self::check_interval(engine);
    let mut next_expiry = 0;
    loop {
        let now = engine.clock.now();
        engine.stalls.wake(now);
        if limit.is_some_and(|limit| now >= limit) {
            engine.outcome.conclude(Outcome::TimeUp);
        }
        if let Some(timer) = engine.rules.next_timer().filter(|timer| *timer <= now) {
            engine.rules.delays.record(None, now, now - timer);
            engine.clock.mark_busy();
            engine.tick();
        }
        if now > next_expiry {
            next_expiry = engine.expire_values(now);
        }
        detect_hung_calls(engine, executor, now, &mut reported);
        let mut state = alarm.state.lock();
        if state.1 {
            return;
        }
        let end = limit.filter(|limit| *limit > now);
        let next = state
            .0
            .into_iter()
            .chain(end)
            .chain([next_expiry.saturating_add(1)])
            .fold(now + check_interval, Nanos::min);
        let latest = next
            .max(now)
            .saturating_add(engine.clock.scale_machine_time(MIN_STALL));
        engine.stalls.pause(now, latest);
        engine.clock.wait(&alarm.changed, &mut state, Some(next));
    }
}

/// Stops actuators first, then puts schemas to sleep, children before fathers, and then ends them in reverse
/// order.
pub(crate) fn bring_to_rest(engine: &Arc<Engine>, executor: &dyn ThreadExecutor) {
    for driver in engine.rules.brake_all() {
        if !executor.wait_until_idle(driver, REST_TIMEOUT) {
            tracing::error!(
                schema = engine.name(driver),
                "did not carry out the last brake within {REST_TIMEOUT:?}"
            );
        }
    }
    let order = engine.rules.put_to_sleep();
    // Schemas put to sleep earlier may still be in that call.
    for instance in engine.metrics.ids().rev() {
        if !order.contains(&instance) {
            executor.wait_until_idle(instance, REST_TIMEOUT);
        }
    }
    for instance in order {
        engine.rules.send_to_sleep(instance);
        if !executor.wait_until_idle(instance, REST_TIMEOUT) && engine.processes.has_process(instance) {
            let why = "its process was ended while it was inside its last call";
            engine.processes.kill(instance, why, true);
        }
        if !executor.wait_until_idle(instance, REST_TIMEOUT) {
            tracing::error!(
                schema = engine.name(instance),
                "is still inside a call after {REST_TIMEOUT:?} and is left behind"
            );
        }
    }
    for instance in executor.end_all(engine) {
        tracing::error!(
            schema = engine.name(instance),
            "never returned from its last call"
        );
        let time = engine.clock.now();
        engine.rules.report(
            time,
            What::Hung {
                schema: instance,
                since: engine.metrics[instance].running_since().unwrap_or(time),
            },
        );
    }
    engine.builds.close();
}

/// Runs a thread's body, and ends the instance of a call that was given up in it. A panic in the body is a
/// fault of the host: it brakes all actuators and ends the application.
pub(crate) fn run_guarded(engine: &Engine, body: impl FnOnce()) {
    reserve_waiting();
    let Err(payload) = catch_unwind(AssertUnwindSafe(body)) else {
        return;
    };
    match AbandonedInstance::from_payload(payload) {
        Ok(instance) => engine.end_abandoned(instance),
        Err(_) => engine.report_panic(),
    }
}

/// Lets this thread get the memory that its first wait for a lock takes, while there is some.
fn reserve_waiting() {
    let lock = Mutex::new(());
    Condvar::new().wait_for(&mut lock.lock(), Duration::ZERO);
}

fn detect_hung_calls(
    engine: &Arc<Engine>,
    executor: &dyn ThreadExecutor,
    now: Nanos,
    reported: &mut Table<SchemaId, Option<Nanos>>,
) {
    for (number, meter) in engine.metrics.entries() {
        let Some(since) = meter.running_since() else {
            continue;
        };
        if let Some(judgement) = meter.running_judgement() {
            detect_hung_judgement(engine, executor, now, (number, since), judgement, reported);
            continue;
        }
        let took = now.saturating_sub(since).saturating_sub(meter.judged());
        let took = took.saturating_sub(engine.stalls.within(since, now));
        if took <= hang_timeout(engine, number) {
            continue;
        }
        report_once(engine, now, number, since, reported);
        let reason = format!("has not returned from a call for {:.1} s", took as f64 / 1e9);
        if engine.process_config(number).is_some() {
            // The call returns once its process is dead, and its runner handles the death.
            engine.processes.kill(number, &reason, false);
            // Even the kernel cannot kill a process that waits in it for a device that is gone.
            if took
                > hang_timeout(engine, number).saturating_add(engine.clock.scale_machine_time(MIN_HANG_TIME))
            {
                engine.report_hung_call(number, reason);
            }
            continue;
        }
        let mut report = |kept| engine.report_abandoned_call(number, since, reason.clone(), kept);
        // The level selects again even if the replacement must wait.
        if !executor.replace_runner(engine, number, (since, None), &mut report) {
            engine.report_hung_call(number, reason);
        }
    }
}

/// A judgement that does not return is a hang of the guard, in the call of the schema `number` that began at `since`
/// (R18). The call is given up, and the schema gets another instance without a fault.
fn detect_hung_judgement(
    engine: &Arc<Engine>,
    executor: &dyn ThreadExecutor,
    now: Nanos,
    (number, since): (SchemaId, Nanos),
    judgement: RunningJudgement,
    reported: &mut Table<SchemaId, Option<Nanos>>,
) {
    let guard = judgement.guard;
    let took = now.saturating_sub(judgement.since);
    let took = took.saturating_sub(engine.stalls.within(judgement.since, now));
    if took <= hang_timeout(engine, guard) {
        return;
    }
    report_once(engine, now, guard, judgement.since, reported);
    let reason = format!(
        "has not returned from the judgement of a command of `{}` for {:.1} s",
        engine.name(number),
        took as f64 / 1e9
    );
    if engine.process_config(number).is_some() {
        engine.processes.kill(number, &reason, true);
    }
    let mut report = |kept| engine.report_abandoned_judgement(number, judgement, reason.clone(), kept);
    if !executor.replace_runner(engine, number, (since, Some(guard)), &mut report) {
        engine.report_hung_call(guard, reason);
    }
}

/// Reports a hung call of a schema, once.
fn report_once(
    engine: &Engine,
    now: Nanos,
    schema: SchemaId,
    since: Nanos,
    reported: &mut Table<SchemaId, Option<Nanos>>,
) {
    if reported[schema].replace(since) != Some(since) {
        engine.rules.report(now, What::Hung { schema, since });
    }
}

/// Returns how long a call may take before it counts as hung, in the application's time, ns.
fn hang_timeout(engine: &Engine, number: SchemaId) -> Nanos {
    let instance = &engine.application.instances[number];
    let least = || engine.clock.scale_machine_time(MIN_HANG_TIME);
    let by_budget = || instance.budget_ns.saturating_mul(HUNG_BUDGETS).max(least());
    instance.hang_ns.unwrap_or_else(by_budget)
}

/// Returns the time between two checks of running calls: a quarter of the shortest hang timeout, ns.
fn check_interval(engine: &Engine) -> Nanos {
    let timeouts = engine.metrics.ids().map(|number| hang_timeout(engine, number));
    timeouts
        .min()
        .map_or(MAX_CHECK_INTERVAL, |least| (least / 4).min(MAX_CHECK_INTERVAL))
}
