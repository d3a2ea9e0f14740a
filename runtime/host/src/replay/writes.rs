//! The writes of schemas in their turns, in the recording and in the replay: every value that they exported,
//! commanded or wrote to a child. It pairs them, turn by turn and port by port, and does not compare them.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::{Role, Type};
use jde_app::InstancePort;
use jde_board::Variable;
use jde_core::{Nanos, SchemaId, Table};
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
    pub schema: SchemaId,
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
    counts: BTreeMap<InstancePort, PairingState>,
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
    schema: SchemaId,
    number: usize,
    name: &'a str,
    is_export: bool,
    variable: Arc<Variable>,
}

impl WriteMatcher {
    pub(super) fn take(&mut self) -> Vec<PairedWrite> {
        std::mem::take(&mut self.pairs)
    }

    /// Pairs the writes of a completed recorded turn with those of the replay.
    pub(super) fn pair_turn(
        &mut self,
        engine: &Engine,
        schema: SchemaId,
        slot: &mut ReplaySlot,
        turn: &RecordedTurn,
        recorded_run: &mut dyn RecordedRun,
    ) {
        let mut writes: BTreeMap<usize, Vec<PortWrite>> = BTreeMap::new();
        for write in slot.runner.take_writes() {
            writes.entry(write.port).or_default().push(write);
        }
        for (number, description) in engine.application.instances[schema]
            .schema
            .ports
            .iter()
            .enumerate()
        {
            let (recorded, replayed) = (turn.port(number), writes.remove(&number).unwrap_or_default());
            if recorded == Turn::UNUSED && replayed.is_empty() {
                continue;
            }
            // For ports that it reads, a turn contains the values read.
            let Some(variable) = slot.runner.written_variable(number) else {
                continue;
            };
            let port = WrittenPort {
                time: turn.time(),
                schema,
                number,
                name: &description.name,
                is_export: matches!(description.role, Role::Export { .. }),
                variable,
            };
            self.pair_port(&port, recorded, replayed, recorded_run);
        }
    }

    /// Records writes in turns that the recording does not contain.
    pub(super) fn pair_unrecorded(
        &mut self,
        engine: &Engine,
        slots: &mut Table<SchemaId, Option<ReplaySlot>>,
    ) {
        let time = engine.clock.now();
        for schema in slots.ids() {
            let Some(slot) = slots[schema].as_mut().filter(|slot| !slot.in_turn) else {
                continue;
            };
            for PortWrite { port, bytes, .. } in slot.runner.take_writes() {
                let Some(variable) = slot.runner.written_variable(port) else {
                    continue;
                };
                let description = &engine.application.instances[schema].schema.ports[port];
                let port = WrittenPort {
                    time,
                    schema,
                    number: port,
                    name: &description.name,
                    is_export: matches!(description.role, Role::Export { .. }),
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
        recorded: u32,
        replayed: Vec<PortWrite>,
        recorded_run: &mut dyn RecordedRun,
    ) {
        let PairingState {
            last_recorded,
            offset: previous_offset,
        } = *self.pairing_state(port);
        let last_replayed = replayed
            .last()
            .map(|write| (write.number as u32, write.bytes.is_some()));
        match recorded {
            // A command or a modulation was refused for lack of authority. Whether it is refused again shows
            // in the comparison of selections.
            Turn::NO_VALUE if !port.is_export => {}
            Turn::UNUSED | Turn::NO_VALUE => {
                let outcome = if recorded == Turn::UNUSED {
                    WriteOutcome::Nothing
                } else {
                    WriteOutcome::Retracted
                };
                let is_retracted = last_replayed.is_some_and(|(_, has_value)| !has_value);
                self.pairing_state(port).offset = None;
                if outcome == WriteOutcome::Retracted && is_retracted {
                    return self.add(port, WriteOutcome::Retracted, WriteOutcome::Retracted);
                }
                let last = replayed.into_iter().next_back();
                self.add(
                    port,
                    outcome,
                    last.map_or(WriteOutcome::Nothing, |write| WriteOutcome::of(write.bytes)),
                );
            }
            number => {
                let name = port.variable.describe().full_name();
                let mut value = |number| {
                    recorded_run
                        .written_value(&name, number)
                        .map_or(WriteOutcome::Unknown, WriteOutcome::Wrote)
                };
                let is_new = |number: u32| number.wrapping_sub(last_recorded).wrapping_sub(1) < u32::MAX / 2;
                self.pairing_state(port).last_recorded = number;
                let Some((last, true)) = last_replayed else {
                    self.pairing_state(port).offset = None;
                    let outcome = if last_replayed.is_some() {
                        WriteOutcome::Retracted
                    } else {
                        WriteOutcome::Nothing
                    };
                    return self.add(port, value(number), outcome);
                };
                let offset = number.wrapping_sub(last);
                self.pairing_state(port).offset = Some(offset);
                // A retracted value was overwritten in the same turn.
                let values = replayed.into_iter().filter_map(|write| write.bytes).rev();
                let mut written = 0;
                for (place, bytes) in (0..).zip(values) {
                    let number = number.wrapping_sub(place);
                    let recorded = if is_new(number) {
                        value(number)
                    } else {
                        WriteOutcome::Nothing
                    };
                    self.add(port, recorded, WriteOutcome::Wrote(bytes));
                    written += 1;
                }
                let has_more = previous_offset
                    .is_some_and(|previous| offset.wrapping_sub(previous).wrapping_sub(1) < u32::MAX / 2);
                if port.is_export && has_more {
                    self.add(port, value(number.wrapping_sub(written)), WriteOutcome::Nothing);
                }
            }
        }
    }

    fn pairing_state(&mut self, port: &WrittenPort<'_>) -> &mut PairingState {
        let initial = PairingState {
            last_recorded: 0,
            offset: Some(0),
        };
        self.counts
            .entry(InstancePort::new(port.schema, port.number))
            .or_insert(initial)
    }

    fn add(&mut self, port: &WrittenPort<'_>, recorded: WriteOutcome, replayed: WriteOutcome) {
        let variable = port.variable.describe();
        self.pairs.push(PairedWrite {
            time: port.time,
            schema: port.schema,
            port: port.name.to_owned(),
            variable: variable.full_name(),
            value_type: Arc::clone(&variable.value_type),
            recorded,
            replayed,
        });
    }
}

impl WriteOutcome {
    fn of(bytes: Option<Vec<u8>>) -> Self {
        bytes.map_or(Self::Retracted, Self::Wrote)
    }
}
