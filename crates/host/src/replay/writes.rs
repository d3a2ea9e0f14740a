//! The writes of schemas in their turns, in the recording and in the replay: every value that they exported,
//! commanded or wrote to a child. Pairs them, turn by turn and port by port; whether the two agree is not
//! judged here.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::{Role, Type};
use jde_board::Variable;
use jde_core::Nanos;
use jde_records::turn::{RecordedTurn, Turn};

use super::recorded_run::RecordedRun;
use super::slot::ReplaySlot;
use crate::engine::Engine;
use crate::instance::PortWrite;

/// A write to a port in a turn, in the recording and in the replay.
#[derive(Clone, Debug)]
pub struct PairedWrite {
    /// When that turn ended, ns.
    pub time: Nanos,
    /// The schema.
    pub schema: usize,
    /// Its port.
    pub port: String,
    /// The full name of the variable.
    pub variable: String,
    /// The type of its values.
    pub value_type: Arc<Type>,
    /// The recorded write.
    pub recorded: WriteOutcome,
    /// The write in the replay.
    pub replayed: WriteOutcome,
}

/// What was written to a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WriteOutcome {
    /// Nothing.
    Nothing,
    /// The value before was retracted.
    Retracted,
    /// This value was written.
    Wrote(Vec<u8>),
    /// A value was written that is not in the recording.
    Unknown,
}

/// Pairs that have not been fetched yet.
#[derive(Default)]
pub(super) struct WriteMatcher {
    pairs: Vec<PairedWrite>,
    /// By schema and port.
    counts: BTreeMap<(usize, usize), PairingState>,
}

/// How far the values of a port have been paired.
#[derive(Clone, Copy)]
struct PairingState {
    /// The number of the last recorded value.
    last_recorded: u32,
    /// The recorded number minus the number in the replay; `None` if it is unknown.
    offset: Option<u32>,
}

/// A port whose writes are paired.
struct WrittenPort<'a> {
    time: Nanos,
    schema: usize,
    number: usize,
    name: &'a str,
    is_export: bool,
    variable: Arc<Variable>,
}

impl WriteMatcher {
    pub(super) fn take(&mut self) -> Vec<PairedWrite> {
        std::mem::take(&mut self.pairs)
    }

    /// Pairs the writes of a recorded turn that is over with those of the replay.
    pub(super) fn pair_turn(
        &mut self,
        engine: &Engine,
        schema: usize,
        seat: &mut ReplaySlot,
        turn: &RecordedTurn,
        past: &mut dyn RecordedRun,
    ) {
        let mut now: BTreeMap<usize, Vec<PortWrite>> = BTreeMap::new();
        for wrote in seat.runner.take_writes() {
            now.entry(wrote.port).or_default().push(wrote);
        }
        for (number, about) in engine.application.instances[schema]
            .schema
            .ports
            .iter()
            .enumerate()
        {
            let (then, now) = (turn.port(number), now.remove(&number).unwrap_or_default());
            if then == Turn::UNUSED && now.is_empty() {
                continue;
            }
            // For ports that it reads, a turn contains the values read.
            let Some(variable) = seat.runner.written_variable(number) else {
                continue;
            };
            let port = WrittenPort {
                time: turn.time(),
                schema,
                number,
                name: &about.name,
                is_export: matches!(about.role, Role::Export),
                variable,
            };
            self.pair_port(&port, then, now, past);
        }
    }

    /// Records writes in turns that the recording does not contain.
    pub(super) fn pair_unrecorded(&mut self, engine: &Engine, seats: &mut [Option<ReplaySlot>]) {
        let time = engine.clock.now();
        for (schema, seat) in seats.iter_mut().enumerate() {
            let Some(seat) = seat.as_mut().filter(|seat| !seat.in_turn) else {
                continue;
            };
            for PortWrite { port, bytes, .. } in seat.runner.take_writes() {
                let Some(variable) = seat.runner.written_variable(port) else {
                    continue;
                };
                let about = &engine.application.instances[schema].schema.ports[port];
                let port = WrittenPort {
                    time,
                    schema,
                    number: port,
                    name: &about.name,
                    is_export: matches!(about.role, Role::Export),
                    variable,
                };
                self.pairing_state(&port).offset = None;
                self.add(&port, WriteOutcome::Nothing, WriteOutcome::of(bytes));
            }
        }
    }

    /// Pairs the writes of a port in a turn from the last value backwards, because turns contain the number
    /// of the last one.
    fn pair_port(
        &mut self,
        port: &WrittenPort<'_>,
        then: u32,
        now: Vec<PortWrite>,
        past: &mut dyn RecordedRun,
    ) {
        let PairingState {
            last_recorded: upto,
            offset: ahead,
        } = *self.pairing_state(port);
        let last_now = now
            .last()
            .map(|wrote| (wrote.number as u32, wrote.bytes.is_some()));
        match then {
            // A command or a modulation was refused for lack of authority. Whether it is refused again shows
            // in the comparison of selections.
            Turn::NO_VALUE if !port.is_export => {}
            Turn::UNUSED | Turn::NO_VALUE => {
                let then = if then == Turn::UNUSED {
                    WriteOutcome::Nothing
                } else {
                    WriteOutcome::Retracted
                };
                let took_back = last_now.is_some_and(|(_, value)| !value);
                self.pairing_state(port).offset = None;
                if then == WriteOutcome::Retracted && took_back {
                    return self.add(port, WriteOutcome::Retracted, WriteOutcome::Retracted);
                }
                let last = now.into_iter().next_back();
                self.add(
                    port,
                    then,
                    last.map_or(WriteOutcome::Nothing, |wrote| WriteOutcome::of(wrote.bytes)),
                );
            }
            number => {
                let name = port.variable.describe().full_name();
                let mut value = |number| {
                    past.written_value(&name, number)
                        .map_or(WriteOutcome::Unknown, WriteOutcome::Wrote)
                };
                let is_new = |number: u32| number.wrapping_sub(upto).wrapping_sub(1) < u32::MAX / 2;
                self.pairing_state(port).last_recorded = number;
                let Some((last, true)) = last_now else {
                    self.pairing_state(port).offset = None;
                    let now = if last_now.is_some() {
                        WriteOutcome::Retracted
                    } else {
                        WriteOutcome::Nothing
                    };
                    return self.add(port, value(number), now);
                };
                let gap = number.wrapping_sub(last);
                self.pairing_state(port).offset = Some(gap);
                // A retracted value was overwritten in the same turn.
                let values = now.into_iter().filter_map(|wrote| wrote.bytes).rev();
                let mut written = 0;
                for (place, bytes) in (0..).zip(values) {
                    let number = number.wrapping_sub(place);
                    let then = if is_new(number) {
                        value(number)
                    } else {
                        WriteOutcome::Nothing
                    };
                    self.add(port, then, WriteOutcome::Wrote(bytes));
                    written += 1;
                }
                let is_more =
                    ahead.is_some_and(|before| gap.wrapping_sub(before).wrapping_sub(1) < u32::MAX / 2);
                if port.is_export && is_more {
                    self.add(port, value(number.wrapping_sub(written)), WriteOutcome::Nothing);
                }
            }
        }
    }

    fn pairing_state(&mut self, port: &WrittenPort<'_>) -> &mut PairingState {
        let both_begin = PairingState {
            last_recorded: 0,
            offset: Some(0),
        };
        self.counts
            .entry((port.schema, port.number))
            .or_insert(both_begin)
    }

    fn add(&mut self, port: &WrittenPort<'_>, then: WriteOutcome, now: WriteOutcome) {
        let variable = port.variable.describe();
        self.pairs.push(PairedWrite {
            time: port.time,
            schema: port.schema,
            port: port.name.to_owned(),
            variable: variable.full_name(),
            value_type: Arc::clone(&variable.value_type),
            recorded: then,
            replayed: now,
        });
    }
}

impl WriteOutcome {
    fn of(bytes: Option<Vec<u8>>) -> Self {
        bytes.map_or(Self::Retracted, Self::Wrote)
    }
}
