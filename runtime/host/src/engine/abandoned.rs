//! Calls that do not return. A call that was given up may run for ever, but nothing it does has an effect,
//! and the number of such calls is bounded and counted.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::{Nanos, SchemaId};
use jde_records::ResourceUsage;
use jde_records::event::What;

use super::{Engine, Signal};
use crate::instance::AbandonedInstance;
use crate::metrics::RunningJudgement;

/// The limit of calls of one schema that were given up and have not returned. Each keeps a thread, its stack,
/// and the memory and files of the schema. A few are tolerated; a schema that always hangs must not exhaust
/// the machine.
const MAX_ABANDONED: u64 = 4;

impl Engine {
    /// Whether an instance may be created.
    ///
    /// # Errors
    /// Too many calls of earlier instances were given up and never returned.
    pub(crate) fn check_can_create(&self, instance: SchemaId) -> Result<(), String> {
        let left = self.metrics[instance].abandoned_calls.load(Relaxed);
        if left < MAX_ABANDONED {
            return Ok(());
        }
        Err(format!(
            "{left} calls of it were given up and never returned; it gets no other instance until one does"
        ))
    }

    /// Reports that a call does not return: the level selects again as after a failure. If the call could not
    /// be given up and still runs at a restart, the restart fails too.
    pub(crate) fn report_hung_call(&self, instance: SchemaId, reason: String) {
        if !self.rules.is_faulted(instance) {
            // Marks a death of the process as reported: a later discovery of it must not report it again.
            self.processes.claim_death_report(instance);
            self.report_death(instance, reason);
        }
    }

    /// Reports that the call which runs since `since` was given up for `reason`; it keeps `kept` bytes of
    /// shared values.
    pub(crate) fn report_abandoned_call(&self, instance: SchemaId, since: Nanos, reason: String, kept: u64) {
        let meter = &self.metrics[instance];
        meter.end_call();
        let left = meter.abandoned_calls.fetch_add(1, Relaxed) + 1;
        // First, so that the next instance is created from the right build.
        self.interrupt_reload(instance, &reason);
        // Before the next instance can run and publish. The instance may have faulted long before and published since.
        self.variables.retract_exports(instance);
        self.report_hung_call(instance, reason);
        self.end_abandoned_iteration(instance);
        self.report_left_behind(instance, since, left, kept);
    }

    /// Reports that the call of a schema was given up because a guard does not return from the judgement of its
    /// command. The guard hangs (R18). The schema stays what it is for the rules, and gets another instance at once.
    pub(crate) fn report_abandoned_judgement(
        &self,
        instance: SchemaId,
        hung: RunningJudgement,
        reason: String,
        kept: u64,
    ) {
        let RunningJudgement { guard, since } = hung;
        self.metrics[instance].end_call();
        self.metrics[instance].give_up_judgement();
        let left = self.metrics[guard].abandoned_calls.fetch_add(1, Relaxed) + 1;
        self.interrupt_reload(instance, &reason);
        self.report_hung_call(guard, reason);
        self.variables.retract_exports(instance);
        self.end_abandoned_iteration(instance);
        self.rules.awake_again(instance);
        self.report_left_behind(guard, since, left, kept);
    }

    fn end_abandoned_iteration(&self, instance: SchemaId) {
        self.rules.transact_end(None, instance);
        if self.builds.is_pending(instance) {
            // The call may have taken the signal from the inbox and hung before the exchange.
            self.rules.signals.send(instance, Signal::BuildPending);
        }
    }

    /// Reports that a call for which a schema answers is left behind, as the last of `left`.
    fn report_left_behind(&self, schema: SchemaId, since: Nanos, left: u64, kept: u64) {
        let process = ResourceUsage::now();
        tracing::warn!(
            schema = self.name(schema),
            "a call that hangs is left behind; {left} of its calls are, and the process has {process}"
        );
        self.rules.report_now(What::CallAbandoned {
            schema,
            since,
            abandoned: left,
            retained_bytes: kept,
            process,
        });
    }

    /// Ends the instance of a call that was given up and has now returned, on the calling thread.
    pub(crate) fn end_abandoned(&self, left: AbandonedInstance) {
        let (schema, since) = (left.number, left.since);
        left.end();
        let left = self.metrics[schema].abandoned_calls.fetch_sub(1, Relaxed) - 1;
        self.rules.report_now(What::AbandonedCallReturned {
            schema,
            since,
            abandoned: left,
            process: ResourceUsage::now(),
        });
    }
}
