//! The writes of schemas in their turns, in the recording and in the replay: every value that they exported,
//! commanded or wrote to a child. Pairs them, turn by turn and port by port; whether the two agree is not
//! judged here.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::{Role, Type};
use jde_board::Variable;
use jde_core::Nanos;

use super::past::Past;
use super::seat::Seat;
use crate::engine::Engine;
use crate::instance::Wrote;
use crate::turn::{Told, Turn};

/// A write to a port in a turn, in the recording and in the replay.
#[derive(Clone, Debug)]
pub struct Deed {
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
    pub then: Done,
    /// The write in the replay.
    pub now: Done,
}

/// What was written to a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Done {
    /// Nothing.
    Nothing,
    /// The value before was retracted.
    TookBack,
    /// This value was written.
    Wrote(Vec<u8>),
    /// A value was written that is not in the recording.
    Unknown,
}

/// Pairs that have not been fetched yet.
#[derive(Default)]
pub(super) struct Deeds {
    done: Vec<Deed>,
    /// By schema and port.
    counts: BTreeMap<(usize, usize), Count>,
}

/// How far the values of a port have been paired.
#[derive(Clone, Copy)]
struct Count {
    /// The number of the last recorded value.
    upto: u32,
    /// The recorded number minus the number in the replay; `None` if it is unknown.
    ahead: Option<u32>,
}

/// A port whose writes are paired.
struct Port<'a> {
    time: Nanos,
    schema: usize,
    number: usize,
    name: &'a str,
    is_export: bool,
    variable: Arc<Variable>,
}

impl Deeds {
    pub(super) fn take(&mut self) -> Vec<Deed> {
        std::mem::take(&mut self.done)
    }

    /// Pairs the writes of a recorded turn that is over with those of the replay.
    pub(super) fn told(
        &mut self,
        engine: &Engine,
        schema: usize,
        seat: &mut Seat,
        turn: &Told,
        past: &mut dyn Past,
    ) {
        let mut now: BTreeMap<usize, Vec<Wrote>> = BTreeMap::new();
        for wrote in seat.runner.wrote() {
            now.entry(wrote.port).or_default().push(wrote);
        }
        for (number, about) in engine.application.instances[schema]
            .schema
            .ports
            .iter()
            .enumerate()
        {
            let (then, now) = (turn.port(number), now.remove(&number).unwrap_or_default());
            if then == Turn::UNSEEN && now.is_empty() {
                continue;
            }
            // For ports that it reads, a turn contains the values read.
            let Some(variable) = seat.runner.written_by(number) else {
                continue;
            };
            let port = Port {
                time: turn.time(),
                schema,
                number,
                name: &about.name,
                is_export: matches!(about.role, Role::Export),
                variable,
            };
            self.pair(&port, then, now, past);
        }
    }

    /// Records writes in turns that the recording does not contain.
    pub(super) fn told_of_none(&mut self, engine: &Engine, seats: &mut [Option<Seat>]) {
        let time = engine.clock.now();
        for (schema, seat) in seats.iter_mut().enumerate() {
            let Some(seat) = seat.as_mut().filter(|seat| !seat.in_turn) else {
                continue;
            };
            for Wrote { port, bytes, .. } in seat.runner.wrote() {
                let Some(variable) = seat.runner.written_by(port) else {
                    continue;
                };
                let about = &engine.application.instances[schema].schema.ports[port];
                let port = Port {
                    time,
                    schema,
                    number: port,
                    name: &about.name,
                    is_export: matches!(about.role, Role::Export),
                    variable,
                };
                self.count(&port).ahead = None;
                self.add(&port, Done::Nothing, Done::of(bytes));
            }
        }
    }

    /// Pairs the writes of a port in a turn from the last value backwards, because turns contain the number
    /// of the last one.
    fn pair(&mut self, port: &Port<'_>, then: u32, now: Vec<Wrote>, past: &mut dyn Past) {
        let Count { upto, ahead } = *self.count(port);
        let last_now = now
            .last()
            .map(|wrote| (wrote.number as u32, wrote.bytes.is_some()));
        match then {
            // A command or a modulation was refused for lack of authority. Whether it is refused again shows
            // in the comparison of selections.
            Turn::NOTHING if !port.is_export => {}
            Turn::UNSEEN | Turn::NOTHING => {
                let then = if then == Turn::UNSEEN {
                    Done::Nothing
                } else {
                    Done::TookBack
                };
                let took_back = last_now.is_some_and(|(_, value)| !value);
                self.count(port).ahead = None;
                if then == Done::TookBack && took_back {
                    return self.add(port, Done::TookBack, Done::TookBack);
                }
                let last = now.into_iter().next_back();
                self.add(
                    port,
                    then,
                    last.map_or(Done::Nothing, |wrote| Done::of(wrote.bytes)),
                );
            }
            number => {
                let name = port.variable.describe().full_name();
                let mut value = |number| past.written(&name, number).map_or(Done::Unknown, Done::Wrote);
                let is_new = |number: u32| number.wrapping_sub(upto).wrapping_sub(1) < u32::MAX / 2;
                self.count(port).upto = number;
                let Some((last, true)) = last_now else {
                    self.count(port).ahead = None;
                    let now = if last_now.is_some() {
                        Done::TookBack
                    } else {
                        Done::Nothing
                    };
                    return self.add(port, value(number), now);
                };
                let gap = number.wrapping_sub(last);
                self.count(port).ahead = Some(gap);
                // A retracted value was overwritten in the same turn.
                let values = now.into_iter().filter_map(|wrote| wrote.bytes).rev();
                let mut written = 0;
                for (place, bytes) in (0..).zip(values) {
                    let number = number.wrapping_sub(place);
                    let then = if is_new(number) {
                        value(number)
                    } else {
                        Done::Nothing
                    };
                    self.add(port, then, Done::Wrote(bytes));
                    written += 1;
                }
                let is_more =
                    ahead.is_some_and(|before| gap.wrapping_sub(before).wrapping_sub(1) < u32::MAX / 2);
                if port.is_export && is_more {
                    self.add(port, value(number.wrapping_sub(written)), Done::Nothing);
                }
            }
        }
    }

    fn count(&mut self, port: &Port<'_>) -> &mut Count {
        let both_begin = Count {
            upto: 0,
            ahead: Some(0),
        };
        self.counts
            .entry((port.schema, port.number))
            .or_insert(both_begin)
    }

    fn add(&mut self, port: &Port<'_>, then: Done, now: Done) {
        let variable = port.variable.describe();
        self.done.push(Deed {
            time: port.time,
            schema: port.schema,
            port: port.name.to_owned(),
            variable: variable.full_name(),
            value_type: Arc::clone(&variable.value_type),
            then,
            now,
        });
    }
}

impl Done {
    fn of(bytes: Option<Vec<u8>>) -> Self {
        bytes.map_or(Self::TookBack, Self::Wrote)
    }
}
