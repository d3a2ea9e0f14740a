//! The ports of one instance: what they are bound to on the board, and what they show during a call.

use std::ffi::c_void;
use std::sync::Arc;

use jde_abi::raw;
use jde_board::{Parted, Reader, Refused, Stamp, Variable, Writer};
use jde_core::Nanos;

use crate::history::{Aligned, History, Old};
use crate::turn::{Journal, Told, Turn};

/// All ports of an instance, by number.
#[derive(Default)]
pub(crate) struct Ports {
    pub(super) ports: Vec<Port>,
    /// What was read, kept only if turns are recorded.
    looks: Option<Looks>,
    /// What was written since the last query, kept only in a replay.
    wrote: Option<Vec<Wrote>>,
    /// Counts the releases. A value read before a release is not shown after it.
    releases: u64,
    /// Whether a value was read since the last release.
    holds: bool,
    /// The number of unpublished loans. Separated loans count until loans are discarded.
    lent: usize,
    /// Loans separated from their writers, which a call that is about to be given up may still write to.
    pub(super) loaned: Vec<Parted>,
}

/// What was read since the last release.
pub(crate) struct Looks {
    journal: Arc<Journal>,
    /// Encoded as [`Turn::inputs`].
    pub(crate) inputs: Vec<u32>,
    /// The last transaction before the last read, and the time of the read.
    pub(crate) last: Option<(u64, Nanos)>,
}

/// What a port is bound to.
pub(crate) enum Port {
    /// Nothing.
    Unbound,
    /// An import or a modulation.
    Input(Reader),
    /// A modulation that shows its value at the schema's awakening (R8).
    Fixed(Reader),
    /// An import or a modulation that shows recorded values, in a replay.
    Again(Again),
    /// A driver's command, with the neutral value that it shows while no command is in force.
    Command {
        reader: Reader,
        neutral: Aligned,
        /// Whether the latched command was in force when it was first read: this holds until the release
        /// (R8).
        in_force: Option<bool>,
    },
    /// An export.
    Output(Writer),
    /// A driver's command or a child's modulation.
    Wish {
        writer: Writer,
        /// Whether the last write was refused. Only the first of consecutive refusals is reported.
        refused: bool,
    },
}

/// An input that shows recorded values.
pub(crate) struct Again {
    pub(super) history: Arc<History>,
    /// The number of the value, as turns encode it.
    pub(super) wanted: u32,
    /// Its result since the last release.
    pub(super) held: Option<Option<Arc<Old>>>,
}

/// What a port has written.
pub(crate) struct Wrote {
    pub(crate) port: usize,
    /// The number of the value.
    pub(crate) number: u64,
    /// `None` if the previous value was retracted.
    pub(crate) bytes: Option<Vec<u8>>,
}

/// What an input has shown since the last release.
#[derive(Clone)]
pub(crate) enum Shown {
    /// It was not read.
    Unseen,
    /// There was no value.
    Nothing,
    /// This value.
    Value(Arc<Old>),
}

/// What a port shows.
pub(crate) struct View<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) time: Nanos,
    pub(crate) sequence: u64,
    pub(crate) writer: u32,
    pub(crate) neutral: bool,
}

impl<'a> View<'a> {
    /// A published value.
    fn of(bytes: &'a [u8], stamp: &Stamp) -> Self {
        Self {
            bytes,
            time: stamp.time,
            sequence: stamp.sequence,
            writer: stamp.writer,
            neutral: false,
        }
    }

    /// The value in the form that plugins receive.
    pub(crate) fn sample(&self) -> raw::Sample {
        let fresh = if self.sequence == 0 {
            raw::SAMPLE_DEFAULT
        } else {
            0
        };
        raw::Sample {
            data: self.bytes.as_ptr().cast::<c_void>(),
            bytes: self.bytes.len() as u64,
            time_ns: self.time,
            sequence: self.sequence,
            writer: self.writer,
            flags: if self.neutral { raw::SAMPLE_NEUTRAL } else { fresh },
        }
    }
}

/// Why a port cannot be read or written.
pub(crate) enum PortError {
    Unbound,
    NoValue,
    WrongPort,
    NothingLoaned,
    Refused { why: Refused, first: bool },
}

impl Ports {
    pub(crate) fn new(ports: Vec<Port>) -> Self {
        Self {
            ports,
            looks: None,
            wrote: None,
            releases: 0,
            holds: false,
            lent: 0,
            loaned: Vec::new(),
        }
    }

    /// Records every read from now on.
    pub(crate) fn follow(&mut self, journal: &Arc<Journal>) {
        self.looks = Some(Looks {
            journal: Arc::clone(journal),
            inputs: vec![Turn::UNSEEN; self.ports.len()],
            last: None,
        });
    }

    /// Starts a call, in which nothing was read yet. Returns the last transaction, if turns are recorded.
    pub(crate) fn enter(&mut self) -> Option<u64> {
        let looks = self.looks.as_mut()?;
        looks.last = None;
        Some(looks.journal.last())
    }

    /// What was read since the last release, if turns are recorded.
    pub(crate) fn looks(&self) -> Option<&Looks> {
        self.looks.as_ref()
    }

    /// The variable that a port is bound to, and whether the port writes it.
    pub(crate) fn variable(&self, port: usize) -> Option<(&Arc<Variable>, bool)> {
        match self.ports.get(port)? {
            Port::Unbound | Port::Again(_) => None,
            Port::Input(reader) | Port::Fixed(reader) | Port::Command { reader, .. } => {
                Some((reader.variable(), false))
            }
            Port::Output(writer) | Port::Wish { writer, .. } => Some((writer.variable(), true)),
        }
    }

    /// The number of releases.
    pub(crate) fn releases(&self) -> u64 {
        self.releases
    }

    /// What was written since the last call of this function, in a replay.
    pub(crate) fn take_wrote(&mut self) -> Vec<Wrote> {
        self.wrote.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Makes the inputs show values of the past instead of the newest, and keeps what the ports write.
    pub(crate) fn look_back(&mut self, mut history: impl FnMut(&Reader) -> Arc<History>) {
        self.wrote = Some(Vec::new());
        for port in &mut self.ports {
            if let Port::Input(reader) | Port::Fixed(reader) = port {
                *port = Port::Again(Again {
                    history: history(reader),
                    wanted: Turn::UNSEEN,
                    held: None,
                });
            }
        }
    }

    /// Makes the inputs show what they showed in that turn; the newest values without a turn.
    pub(crate) fn recall(&mut self, turn: Option<&Told>) {
        for (number, port) in self.ports.iter_mut().enumerate() {
            if let Port::Again(again) = port {
                again.wanted = turn.map_or(Turn::UNSEEN, |turn| turn.port(number));
            }
        }
    }

    /// What the inputs show now, by their numbers.
    pub(crate) fn shown(&self) -> Vec<Shown> {
        let shown = self.ports.iter().map(|port| match port {
            Port::Again(again) => again.held.clone().map_or(Shown::Unseen, Shown::from),
            Port::Unbound
            | Port::Input(_)
            | Port::Fixed(_)
            | Port::Command { .. }
            | Port::Output(_)
            | Port::Wish { .. } => Shown::Unseen,
        });
        shown.collect()
    }

    /// The value of an input, the same until [`Self::release`]. Calls `now` only if the time matters.
    pub(crate) fn read(&mut self, port: usize, now: impl Fn() -> Nanos) -> Result<View<'_>, PortError> {
        self.holds = true;
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            Port::Unbound => Err(PortError::Unbound),
            Port::Output(_) | Port::Wish { .. } => Err(PortError::WrongPort),
            Port::Input(reader) | Port::Fixed(reader) => {
                let latched = reader.latch();
                if let Some(looks) = &mut self.looks {
                    looks.look(port, latched.map(|latched| latched.stamp.sequence), now());
                }
                let latched = latched.ok_or(PortError::NoValue)?;
                Ok(View::of(latched.bytes, &latched.stamp))
            }
            Port::Again(again) => {
                let Again {
                    history,
                    wanted,
                    held,
                } = again;
                let old = held.get_or_insert_with(|| history.find(*wanted));
                let old = old.as_ref().ok_or(PortError::NoValue)?;
                Ok(View::of(old.bytes(), &old.stamp))
            }
            Port::Command {
                reader,
                neutral,
                in_force,
            } => {
                let now = now();
                match reader.latch() {
                    Some(latched)
                        if latched.stamp.sequence > 0
                            && *in_force.get_or_insert(latched.stamp.valid_until >= now) =>
                    {
                        Ok(View::of(latched.bytes, &latched.stamp))
                    }
                    _ => Ok(View {
                        bytes: neutral.bytes(),
                        time: now,
                        sequence: 0,
                        writer: u32::MAX,
                        neutral: true,
                    }),
                }
            }
        }
    }

    /// The memory for the next value of an output.
    pub(crate) fn loan(&mut self, port: usize) -> Result<&mut [u8], PortError> {
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            Port::Unbound => Err(PortError::Unbound),
            Port::Input(_) | Port::Fixed(_) | Port::Again(_) | Port::Command { .. } => {
                Err(PortError::WrongPort)
            }
            Port::Output(writer) | Port::Wish { writer, .. } => {
                self.lent += usize::from(!writer.is_lent());
                Ok(writer.loan())
            }
        }
    }

    /// Publishes the loan. A command is in force for at least two of the schema's periods, so that a schema
    /// that is slow by design does not count as silent.
    pub(crate) fn publish(
        &mut self,
        port: usize,
        time: Nanos,
        now: Nanos,
        period: Nanos,
    ) -> Result<(), PortError> {
        let failed = |why| match why {
            Refused::NothingLoaned => PortError::NothingLoaned,
            why => PortError::Refused { why, first: true },
        };
        let number = port;
        let port = self.ports.get_mut(port).ok_or(PortError::WrongPort)?;
        let mut bytes = None;
        if let Port::Output(writer) | Port::Wish { writer, .. } = port
            && writer.is_lent()
        {
            // Nothing is loaned afterwards, whether the publication succeeds or not.
            self.lent -= 1;
            bytes = self.wrote.as_ref().map(|_| writer.loan().to_vec());
        }
        let published = match port {
            Port::Unbound => return Err(PortError::Unbound),
            Port::Input(_) | Port::Fixed(_) | Port::Again(_) | Port::Command { .. } => {
                return Err(PortError::WrongPort);
            }
            Port::Output(writer) => writer.publish(time, now).map_err(failed),
            Port::Wish { writer, refused } => match writer.publish_for(time, now, period.saturating_mul(2)) {
                Ok(sequence) => {
                    *refused = false;
                    Ok(sequence)
                }
                Err(Refused::NothingLoaned) => Err(PortError::NothingLoaned),
                Err(why) => Err(PortError::Refused {
                    why,
                    first: !std::mem::replace(refused, true),
                }),
            },
        };
        match &published {
            Ok(sequence) => self.note(number, Some(*sequence), bytes),
            Err(PortError::Refused {
                why: Refused::NoAuthority,
                ..
            }) => self.note(number, None, None),
            Err(_) => {}
        }
        published.map(drop)
    }

    /// Records that a port has written a value of that number; without a number, that the write was refused
    /// or the value retracted.
    fn note(&mut self, port: usize, number: Option<u64>, bytes: Option<Vec<u8>>) {
        if let Some(looks) = &mut self.looks
            && let Some(told) = looks.inputs.get_mut(port)
        {
            *told = number.map_or(Turn::NOTHING, |number| number as u32);
            // It is part of one turn, and forgotten at the next release.
            self.holds = true;
        }
        if let (Some(wrote), Some(number)) = (&mut self.wrote, number) {
            wrote.push(Wrote { port, number, bytes });
        }
    }

    /// Whether the port writes another schema's variable: a command or a child's modulation.
    pub(crate) fn is_wish(&self, port: usize) -> bool {
        matches!(self.ports.get(port), Some(Port::Wish { .. }))
    }

    /// Retracts the newest value of an export.
    pub(crate) fn retract(&mut self, port: usize) -> Result<(), PortError> {
        match self.ports.get_mut(port) {
            Some(Port::Output(writer)) => {
                writer.retract();
                let newest = writer.variable().newest();
                if let Some(wrote) = &mut self.wrote {
                    let (number, bytes) = (newest, None);
                    wrote.push(Wrote { port, number, bytes });
                }
                self.note(port, None, None);
                Ok(())
            }
            _ => Err(PortError::WrongPort),
        }
    }

    /// Releases every value read. The next read shows the newest.
    pub(crate) fn release(&mut self) {
        self.releases += 1;
        self.holds = false;
        for port in &mut self.ports {
            match port {
                Port::Input(reader) => reader.release(),
                Port::Again(again) => again.held = None,
                Port::Command { reader, in_force, .. } => {
                    reader.release();
                    *in_force = None;
                }
                Port::Unbound | Port::Fixed(_) | Port::Output(_) | Port::Wish { .. } => {}
            }
        }
        if let Some(looks) = &mut self.looks {
            looks.inputs.fill(Turn::UNSEEN);
            looks.last = None;
        }
    }

    /// Releases all values when the schema awakes, and latches those that stay while it is awake.
    pub(crate) fn renew(&mut self) {
        for port in &mut self.ports {
            if let Port::Fixed(reader) = port {
                reader.release();
                reader.latch();
            }
        }
        self.release();
    }

    /// Whether a value was read since the last release.
    pub(crate) fn holds(&self) -> bool {
        self.holds
    }

    /// Whether there are unpublished loans.
    pub(crate) fn lends(&self) -> bool {
        self.lent > 0
    }

    /// Discards unpublished loans.
    pub(crate) fn discard_loans(&mut self) {
        if std::mem::take(&mut self.lent) == 0 {
            return;
        }
        self.loaned.clear();
        for port in &mut self.ports {
            match port {
                Port::Output(writer) | Port::Wish { writer, .. } => writer.discard(),
                Port::Unbound | Port::Input(_) | Port::Fixed(_) | Port::Again(_) | Port::Command { .. } => {}
            }
        }
    }

    /// Time of the newest value read since the last release; 0 without one.
    pub(crate) fn newest(&self) -> Nanos {
        let times = self.ports.iter().filter_map(|port| match port {
            Port::Input(reader) | Port::Command { reader, .. } => {
                reader.latched().map(|latched| latched.stamp.time)
            }
            Port::Again(again) => again.held.as_ref()?.as_ref().map(|old| old.stamp.time),
            Port::Unbound | Port::Fixed(_) | Port::Output(_) | Port::Wish { .. } => None,
        });
        times.max().unwrap_or(0)
    }
}

impl From<Option<Arc<Old>>> for Shown {
    fn from(held: Option<Arc<Old>>) -> Self {
        held.map_or(Self::Nothing, Self::Value)
    }
}

impl Looks {
    fn look(&mut self, port: usize, sequence: Option<u64>, now: Nanos) {
        if let Some(input @ &mut Turn::UNSEEN) = self.inputs.get_mut(port) {
            *input = sequence.map_or(Turn::NOTHING, |sequence| sequence as u32);
            self.last = Some((self.journal.last(), now));
        }
    }
}
