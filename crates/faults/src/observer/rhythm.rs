//! That every schema but those that were told to misbehave keeps its period (R11): exactly in lockstep, and in real time as well
//! as a bare thread beside it.

use std::sync::{Arc, Mutex};

use jde_abi::describe::{Kind, Role};
use jde_board::Watch;
use jde_core::{Nanos, State};
use jde_host::Handle;
use jde_host::app::Application;

use super::{Known, Tamper, lock};
use crate::case::Clock;

/// Turns of a bystander that are too few to judge it by.
const FEW: u64 = 20;
/// What the median of all bystanders may lose beyond what a bare thread loses: a selection and a lock or two a turn.
const MEDIAN: f64 = 0.02;
/// What one may: it may have been the one that the machine's load met.
const ONE: f64 = 0.15;

/// When each schema is to have its turns.
pub(crate) struct Rhythm {
    clock: Clock,
    schemas: Vec<Beat>,
}

#[derive(Clone, Debug)]
struct Beat {
    period: Nanos,
    /// It was told to misbehave, or acted upon.
    victim: bool,
    /// While it is awake, when it is due next, on the grid of its period from its awakening on.
    awake: Option<Nanos>,
    /// When it had its last.
    last: Option<Nanos>,
    had: u64,
    owed: u64,
}

impl Rhythm {
    pub(super) fn new(clock: Clock) -> Self {
        Self {
            clock,
            schemas: Vec::new(),
        }
    }

    pub(super) fn begin(&mut self, application: &Application) {
        let instances = application.instances.iter();
        self.schemas = instances
            .map(|instance| Beat {
                period: instance.period_ns,
                victim: false,
                awake: None,
                last: None,
                had: 0,
                owed: 0,
            })
            .collect();
    }

    pub(crate) fn least_kept(&self) -> Option<f64> {
        self.kept().first().map(|(kept, _)| *kept)
    }

    /// From now on it may miss turns.
    pub(super) fn excuse(&mut self, schema: usize) {
        if let Some(beat) = self.schemas.get_mut(schema) {
            beat.victim = true;
        }
    }

    /// Of each bystander with enough turns, the share that it had, the least first.
    fn kept(&self) -> Vec<(f64, usize)> {
        let schemas = self.schemas.iter().enumerate();
        let bystanders = schemas.filter(|(_, beat)| !beat.victim && beat.owed >= FEW);
        let mut kept: Vec<_> = bystanders
            .map(|(place, beat)| (beat.had as f64 / beat.owed as f64, place))
            .collect();
        kept.sort_by(|one, other| one.0.total_cmp(&other.0));
        kept
    }
}

impl Known {
    pub(super) fn changed(&mut self, time: Nanos, schema: usize, from: State, to: State) {
        if to == State::Slept {
            self.owes(schema, time);
        }
        let Some(beat) = self.rhythm.schemas.get_mut(schema) else {
            return;
        };
        match (from, to) {
            (_, State::Slept) => beat.awake = None,
            // Who slept and woke within an instant iterates once in it (R16).
            (State::Slept, _) if beat.last == Some(time) => beat.awake = Some(time + beat.period),
            (State::Slept, _) => beat.awake = Some(time),
            _ => {}
        }
    }

    /// It had a turn, by its period or because something came.
    pub(super) fn had_turn(&mut self, schema: usize, time: Nanos) {
        let clock = self.rhythm.clock;
        let Some(Beat {
            period,
            awake: Some(due),
            last,
            had,
            owed,
            victim,
        }) = self.rhythm.schemas.get_mut(schema)
        else {
            return;
        };
        *last = Some(time);
        // In real time a turn counts for its place on the grid if it comes before the next.
        let on_time = match clock {
            Clock::Lockstep => time == *due,
            Clock::RealTime | Clock::Outside => time >= *due && time < *due + *period,
        };
        if !on_time && time < *due {
            // Something else called it.
            return;
        }
        if on_time {
            let skip =
                !*victim && *owed > FEW && self.tamper.take_if(|tamper| *tamper == Tamper::Turn).is_some();
            if !skip {
                *due += *period;
                *had += 1;
                *owed += 1;
            }
            return;
        }
        self.owes(schema, time);
        if clock != Clock::Lockstep {
            // The one that it has now.
            self.had_turn(schema, time);
        }
    }

    pub(super) fn judge_rhythm(&mut self, now: Nanos) {
        if self.rhythm.clock == Clock::Lockstep {
            (0..self.rhythm.schemas.len()).for_each(|schema| self.owes(schema, now));
        }
    }

    /// Notes the turns that it should have had before now and did not have; in lockstep that is a broken rule.
    fn owes(&mut self, schema: usize, now: Nanos) {
        let clock = self.rhythm.clock;
        let Some(beat) = self.rhythm.schemas.get_mut(schema) else {
            return;
        };
        let Some(due) = &mut beat.awake else {
            return;
        };
        let missed_at = *due;
        // In real time it has until the end of the period.
        let until = match clock {
            Clock::Lockstep => now,
            Clock::RealTime | Clock::Outside => now.saturating_sub(beat.period - 1),
        };
        if missed_at >= until {
            return;
        }
        let missed = (until - missed_at).div_ceil(beat.period);
        *due += missed * beat.period;
        beat.owed += missed;
        if clock == Clock::Lockstep && !beat.victim {
            let name = self.name(schema).to_owned();
            self.tell(format!(
                "R11: `{name}` missed {missed} of its turns from {:.6} s on",
                missed_at as f64 / 1e9
            ));
        }
    }

    pub(super) fn conclude_rhythm(&mut self, bare: f64) {
        if self.rhythm.clock == Clock::Lockstep {
            return;
        }
        let kept = self.rhythm.kept();
        let (Some((median, _)), Some((least, last))) = (kept.get(kept.len() / 2), kept.first()) else {
            return;
        };
        let (median, least) = (1.0 - median, 1.0 - least);
        if median > bare + MEDIAN || least > bare + ONE {
            self.tell(format!(
                "R11: bystanders lost {:.1} % of their turns (median), `{}` {:.1} %, a bare thread beside them {:.1} %",
                median * 100.0,
                self.name(*last),
                least * 100.0,
                bare * 100.0
            ));
        }
    }
}

/// Sees the turns of drivers by what they export, for nobody tells of them.
pub(super) fn watch_drivers(known: &Arc<Mutex<Known>>, handle: &Handle) -> Vec<Watch> {
    let application = handle.application();
    let mut watches = Vec::new();
    for (place, instance) in application.instances.iter().enumerate() {
        if instance.schema.kind != Kind::Driver {
            continue;
        }
        // One that it writes in each of its turns: its count, or where it is.
        let exports = instance
            .schema
            .ports
            .iter()
            .filter(|port| matches!(port.role, Role::Export));
        let told = exports
            .map(|port| port.name.as_str())
            .find(|name| ["beats", "odometry"].contains(name));
        let variable = told.and_then(|told| handle.board().find(&format!("{}.{told}", instance.name)));
        if let Some(variable) = variable {
            let (known, handle) = (Arc::downgrade(known), handle.clone());
            watches.push(variable.watch(move || {
                if let Some(known) = known.upgrade() {
                    let now = handle.now();
                    lock(&known).had_turn(place, now);
                }
            }));
        }
    }
    watches
}
