//! Checks that every schema without an injected fault keeps its period (R11): exactly in lockstep; in real
//! time as well as a thread without an application.

use std::sync::Arc;

use jde_abi::describe::{Kind, Role};
use jde_app::Application;
use jde_board::Watch;
use jde_core::{Nanos, SchemaId, State, Table};
use jde_host::Handle;
use parking_lot::Mutex;

use super::{ObserverState, Tamper};
use crate::case::RunMode;

/// With fewer turns than this a bystander is not judged.
const MIN_TURNS: u64 = 40;
/// Periods within which an awake schema must have had a turn.
const MAX_GAP_PERIODS: u64 = 3;
/// Additional time under load, ns.
const LOAD_SLACK: Nanos = 500_000_000;
/// Most misses listed in a report.
const MAX_LISTED: usize = 6;
/// Allowed loss of the median bystander beyond that of a bare thread: a selection and a few locks per turn.
const MAX_MEDIAN_LOSS: f64 = 0.02;
/// Allowed loss of a single bystander, which the load of the machine may have delayed.
const MAX_SINGLE_LOSS: f64 = 0.15;
/// Turns that a single bystander may lose in addition, because a share of few turns is not significant.
const MAX_SINGLE_TURNS: f64 = 3.0;

/// The expected turns of all schemas.
pub(crate) struct PeriodMonitor {
    clock: RunMode,
    schemas: Table<SchemaId, TurnRecord>,
}

#[derive(Clone, Debug, Default)]
struct TurnRecord {
    period: Nanos,
    /// The schema runs in a process of its own.
    isolated: bool,
    /// The schema had an injected fault.
    victim: bool,
    /// The number of its faults that have not ended.
    faults: u32,
    /// The time from which on it must have turns again after a fault.
    resumes_at: Option<Nanos>,
    /// The time of its last turn or awakening, while it is awake.
    last_seen: Option<Nanos>,
    /// While it is awake: in lockstep the next due time, on the grid of its period since its awakening;
    /// otherwise the time of its last turn or awakening.
    awake: Option<Nanos>,
    /// The time of its last turn.
    last: Option<Nanos>,
    taken: u64,
    expected: u64,
    /// The last gap in real time was so long that a turn seems to be missed.
    late: bool,
    /// The first misses: their times and numbers of turns.
    missed: Vec<(Nanos, u64)>,
}

impl PeriodMonitor {
    pub(super) fn new(clock: RunMode) -> Self {
        Self {
            clock,
            schemas: Table::default(),
        }
    }

    pub(super) fn begin(&mut self, application: &Application) {
        let instances = application.instances.iter();
        self.schemas = instances
            .map(|instance| TurnRecord {
                period: instance.period_ns,
                isolated: instance.isolate.is_some(),
                ..TurnRecord::default()
            })
            .collect();
    }

    pub(crate) fn min_turn_share(&self) -> Option<f64> {
        let shares = self.turn_shares();
        let mut in_process = shares.iter().filter(|(_, index)| !self.schemas[*index].isolated);
        in_process.next().map(|(share, _)| *share)
    }

    /// The schema may miss turns from now on.
    pub(super) fn excuse(&mut self, schema: SchemaId) {
        if let Some(record) = self.schemas.get_mut(schema) {
            record.victim = true;
            record.faults += 1;
            record.resumes_at = None;
        }
    }

    /// A fault has ended. After the last one, the schema must have turns from `resumes_at` on, while it is awake.
    pub(super) fn recovers(&mut self, schema: SchemaId, resumes_at: Nanos) {
        if let Some(record) = self.schemas.get_mut(schema) {
            record.faults = record.faults.saturating_sub(1);
            record.resumes_at = (record.faults == 0).then_some(resumes_at);
        }
    }

    /// Whether all its faults ended long enough ago.
    pub(super) fn must_have_turns(&self, schema: SchemaId, now: Nanos) -> bool {
        let record = self.schemas.get(schema);
        record
            .and_then(|record| record.resumes_at)
            .is_some_and(|resumes_at| resumes_at <= now)
    }

    /// The share of turns that each bystander with enough turns had, in ascending order.
    fn turn_shares(&self) -> Vec<(f64, SchemaId)> {
        let schemas = self.schemas.entries();
        let bystanders = schemas.filter(|(_, record)| !record.victim && record.expected >= MIN_TURNS);
        let mut shares: Vec<_> = bystanders
            .map(|(index, record)| (record.taken as f64 / record.expected as f64, index))
            .collect();
        shares.sort_by(|a, b| a.0.total_cmp(&b.0));
        shares
    }
}

/// For real time, where turns are slightly early or late.
impl TurnRecord {
    fn took_turn(&mut self, time: Nanos) {
        let Some(last) = self.awake else {
            return;
        };
        let gap = time.saturating_sub(last);
        if self.last.is_some() && gap < self.period / 2 {
            // Either the previous turn was late and this one is on time, or this is an additional turn
            // between two due ones.
            if std::mem::take(&mut self.late) {
                self.taken += 1;
                self.awake = Some(time);
            }
            return;
        }
        let due = ((gap + self.period / 2) / self.period).max(1);
        self.misses(last, due - 1);
        self.late = due > 1;
        self.taken += 1;
        self.expected += 1;
        self.awake = Some(time);
        self.last = Some(time);
    }

    fn went_to_sleep(&mut self, time: Nanos) {
        if let Some(last) = self.awake {
            self.misses(last, (time.saturating_sub(last) / self.period).saturating_sub(1));
        }
        self.last = None;
    }

    fn misses(&mut self, from: Nanos, count: u64) {
        self.expected += count;
        if count > 0 && self.missed.len() < MAX_LISTED {
            self.missed.push((from, count));
        }
    }
}

impl ObserverState {
    pub(super) fn changed(&mut self, time: Nanos, schema: SchemaId, from: State, to: State) {
        let lockstep = self.rhythm.clock == RunMode::Lockstep;
        if to == State::Slept && lockstep {
            self.expect_turns(schema, time);
        }
        let Some(record) = self.rhythm.schemas.get_mut(schema) else {
            return;
        };
        record.last_seen = match (from, to) {
            (_, State::Slept) => None,
            (State::Slept, _) => Some(time),
            _ => record.last_seen,
        };
        match (from, to) {
            (_, State::Slept) => {
                if !lockstep {
                    record.went_to_sleep(time);
                }
                record.awake = None;
            }
            // A schema that sleeps and wakes within an instant iterates once in it (R16).
            (State::Slept, _) if lockstep && record.last == Some(time) => {
                record.awake = Some(time + record.period)
            }
            (State::Slept, _) => record.awake = Some(time),
            _ => {}
        }
    }

    /// Records a turn, due by period or triggered by a value.
    pub(super) fn had_turn(&mut self, schema: SchemaId, time: Nanos) {
        let clock = self.rhythm.clock;
        let hides_recovery = self.tamper == Some(Tamper::Recovery);
        let Some(record) = self.rhythm.schemas.get_mut(schema) else {
            return;
        };
        if !(hides_recovery && record.resumes_at.is_some()) {
            record.last_seen = record.last_seen.map(|seen| seen.max(time));
        }
        let hides_turn =
            || !record.victim && record.expected > MIN_TURNS && self.tamper == Some(Tamper::Turn);
        match (clock, &mut record.awake) {
            (_, None) => {}
            (RunMode::Lockstep, Some(due)) if time == *due => {
                record.last = Some(time);
                if hides_turn() {
                    self.tamper = None;
                    return;
                }
                *due += record.period;
                record.taken += 1;
                record.expected += 1;
            }
            (RunMode::Lockstep, Some(due)) => {
                record.last = Some(time);
                if time > *due {
                    self.expect_turns(schema, time);
                }
            }
            (RunMode::RealTime | RunMode::Outside, Some(_)) => record.took_turn(time),
        }
    }

    pub(super) fn judge_rhythm(&mut self, now: Nanos) {
        let lockstep = self.rhythm.clock == RunMode::Lockstep;
        for schema in self.rhythm.schemas.ids() {
            if lockstep {
                self.expect_turns(schema, now);
            }
            let record = &mut self.rhythm.schemas[schema];
            let (Some(seen), Some(resumes_at)) = (record.last_seen, record.resumes_at) else {
                continue;
            };
            let slack = if lockstep { 0 } else { LOAD_SLACK };
            if now.saturating_sub(seen.max(resumes_at)) > MAX_GAP_PERIODS * record.period + slack {
                record.resumes_at = None;
                let (name, now) = (self.name(schema).to_owned(), now as f64 / 1e9);
                self.report(format!(
                    "recovery: `{name}` is awake, its faults have ended, and it has no turns any more, at {now:.6} s"
                ));
            }
        }
    }

    /// Counts the turns that were due before now and did not occur. In lockstep this is a violation.
    fn expect_turns(&mut self, schema: SchemaId, now: Nanos) {
        let Some(record) = self.rhythm.schemas.get_mut(schema) else {
            return;
        };
        let Some(due) = record.awake.filter(|due| *due < now) else {
            return;
        };
        let missed = (now - due).div_ceil(record.period);
        record.awake = Some(due + missed * record.period);
        record.expected += missed;
        if !record.victim {
            let (name, from) = (self.name(schema).to_owned(), due as f64 / 1e9);
            self.report(format!(
                "R11: `{name}` missed {missed} of its turns from {from:.6} s on"
            ));
        }
    }

    pub(super) fn conclude_rhythm(&mut self, bare: f64) {
        if self.rhythm.clock == RunMode::Lockstep {
            return;
        }
        let shares = self.rhythm.turn_shares();
        // A turn of a schema in a process of its own waits for the processor several times. It counts for the
        // median only.
        let mut in_process = shares
            .iter()
            .filter(|(_, index)| !self.rhythm.schemas[*index].isolated);
        let (Some((median, _)), Some((least, last))) = (shares.get(shares.len() / 2), in_process.next())
        else {
            return;
        };
        let (median, least) = (1.0 - median, 1.0 - least);
        let allowed = bare + MAX_SINGLE_LOSS + MAX_SINGLE_TURNS / self.rhythm.schemas[*last].expected as f64;
        if median > bare + MAX_MEDIAN_LOSS || least > allowed {
            let missed = self.rhythm.schemas[*last].missed.iter();
            let missed = missed.map(|(at, count)| format!("{count} from {:.3} s", *at as f64 / 1e9));
            self.report(format!(
                "R11: bystanders lost {:.1} % of their turns (median), `{}` {:.1} % ({}), a bare thread beside them {:.1} %",
                median * 100.0,
                self.name(*last),
                least * 100.0,
                missed.collect::<Vec<_>>().join(", "),
                bare * 100.0
            ));
        }
    }
}

/// Observes the turns of drivers by their exports, since drivers' turns are not reported.
pub(super) fn watch_drivers(state: &Arc<Mutex<ObserverState>>, handle: &Handle) -> Vec<Watch> {
    let application = handle.application();
    let mut watches = Vec::new();
    for (id, instance) in application.instances.entries() {
        if instance.schema.kind != Kind::Driver {
            continue;
        }
        // An export that the driver writes in each turn: its count, or its pose.
        let exports = instance
            .schema
            .ports
            .iter()
            .filter(|port| matches!(port.role, Role::Export { .. }));
        let export = exports
            .map(|port| port.name.as_str())
            .find(|name| ["beats", "odometry"].contains(name));
        let variable = export.and_then(|export| handle.board().find(&format!("{}.{export}", instance.name)));
        if let Some(variable) = variable {
            let (state, handle) = (Arc::downgrade(state), handle.clone());
            watches.push(variable.watch(move || {
                if let Some(state) = state.upgrade() {
                    let now = handle.now();
                    state.lock().had_turn(id, now);
                }
            }));
        }
    }
    watches
}
