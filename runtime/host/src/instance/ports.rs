//! The ports of one instance: their bindings to variables of the board, and the values that they show during
//! a call.

use std::sync::Arc;

use jde_board::{DetachedLoan, Latched, Reader, Refused, Stamp, Variable};
use jde_core::Nanos;
use jde_records::turn::{RecordedTurn, Turn};

use super::bound_port::{BoundPort, PortError, PortWrite, RecordedInput, ShownValue};
use super::chunks::Chunks;
use super::export_faults::{ExportFaults, Publication};
use super::guard::{Guarding, Refusal};
use super::guarded_ports::{is_import, refuse_without_state};
use super::measurement::Measurements;
use super::view::View;
use crate::history::{HistoricValue, History};
use crate::journal::Journal;

/// All ports of an instance, by number.
#[derive(Default)]
pub(crate) struct Ports {
    pub(super) ports: Vec<BoundPort>,
    /// The reads since the last release; only if turns are recorded.
    pub(super) read_log: Option<ReadLog>,
    /// The writes since the last query; only in a replay.
    write_log: Option<Vec<PortWrite>>,
    /// Counts the releases. A value read before a release is not shown after it.
    releases: u64,
    /// Whether a value was read since the last release.
    pub(super) has_reads: bool,
    /// The number of unpublished loans. Separated loans count until loans are discarded.
    pub(super) loan_count: usize,
    /// Loans separated from their writers. A call that is about to be given up may still write to them.
    pub(super) separated_loans: Vec<DetachedLoan>,
    /// The exports that fail.
    pub(super) faults: Arc<ExportFaults>,
    /// The exports that measure something.
    pub(crate) measurements: Measurements,
    /// The imports of chunks.
    pub(crate) chunks: Chunks,
    /// The command that a guard refused when it was last read, until it is reported.
    pub(super) refusal: Option<Refusal>,
    /// The command that was published last exceeded its limits.
    pub(super) is_limited: bool,
    /// What it judges, if it is a guard.
    pub(super) guarding: Option<Guarding>,
}

/// The reads since the last release.
pub(crate) struct ReadLog {
    journal: Arc<Journal>,
    /// Encoded as [`Turn::inputs`].
    pub(crate) inputs: Vec<u32>,
    /// The last transaction before the last read, and the time of the read.
    pub(crate) last: Option<(u64, Nanos)>,
}

impl Ports {
    pub(crate) fn new(ports: Vec<BoundPort>, faults: Arc<ExportFaults>) -> Self {
        Self {
            ports,
            read_log: None,
            write_log: None,
            releases: 0,
            has_reads: false,
            loan_count: 0,
            separated_loans: Vec::new(),
            faults,
            measurements: Measurements::default(),
            chunks: Chunks::default(),
            refusal: None,
            is_limited: false,
            guarding: None,
        }
    }

    /// Records every read from now on.
    pub(crate) fn record_reads(&mut self, journal: &Arc<Journal>) {
        self.read_log = Some(ReadLog {
            journal: Arc::clone(journal),
            inputs: vec![Turn::UNUSED; self.ports.len()],
            last: None,
        });
    }

    /// Starts a call, with an empty log of reads. Returns the last transaction, if turns are recorded.
    pub(crate) fn enter(&mut self) -> Option<u64> {
        let log = self.read_log.as_mut()?;
        log.last = None;
        Some(log.journal.last())
    }

    /// Returns the reads since the last release, if turns are recorded.
    pub(crate) fn read_log(&self) -> Option<&ReadLog> {
        self.read_log.as_ref()
    }

    /// Returns the variable that a port is bound to, and whether the port writes it.
    pub(crate) fn variable(&self, port: usize) -> Option<(&Arc<Variable>, bool)> {
        match self.ports.get(port)? {
            BoundPort::Unbound | BoundPort::Recorded(_) => None,
            BoundPort::Input(reader) | BoundPort::Fixed(reader) | BoundPort::Command { reader, .. } => {
                Some((reader.variable(), false))
            }
            BoundPort::Output(writer) | BoundPort::ForeignOutput { writer, .. } => {
                Some((writer.variable(), true))
            }
        }
    }

    /// Returns the number of releases.
    pub(crate) fn releases(&self) -> u64 {
        self.releases
    }

    /// Returns the writes since the last call of this function, in a replay.
    pub(crate) fn take_writes(&mut self) -> Vec<PortWrite> {
        self.write_log.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Makes the inputs show recorded values instead of the newest, and logs the writes of the ports.
    pub(crate) fn read_from_history(&mut self, mut history: impl FnMut(&Reader) -> Arc<History>) {
        self.write_log = Some(Vec::new());
        for port in &mut self.ports {
            if let BoundPort::Input(reader) | BoundPort::Fixed(reader) = port {
                *port = BoundPort::Recorded(RecordedInput {
                    history: history(reader),
                    is_import: is_import(reader),
                    number: Turn::UNUSED,
                    resolved: None,
                });
            }
        }
    }

    /// Makes the inputs show the values that they showed in that turn; the newest values without a turn.
    pub(crate) fn show_recorded(&mut self, turn: Option<&RecordedTurn>) {
        for (number, port) in self.ports.iter_mut().enumerate() {
            if let BoundPort::Recorded(input) = port {
                input.number = turn.map_or(Turn::UNUSED, |turn| turn.port(number));
            }
        }
    }

    /// Returns the values that the inputs show now, by their numbers.
    pub(crate) fn shown_values(&self) -> Vec<ShownValue> {
        let shown = self.ports.iter().map(|port| match port {
            BoundPort::Recorded(input) => input
                .resolved
                .clone()
                .map_or(ShownValue::NotRead, ShownValue::from),
            BoundPort::Unbound
            | BoundPort::Input(_)
            | BoundPort::Fixed(_)
            | BoundPort::Command { .. }
            | BoundPort::Output(_)
            | BoundPort::ForeignOutput { .. } => ShownValue::NotRead,
        });
        shown.collect()
    }

    /// Returns the value of an input, the same until [`Self::release`]. Calls `now` only if the time matters. A
    /// command whose guard has no state reads as neutral, and [`Self::take_refusal`] returns the refusal.
    pub(crate) fn read(&mut self, port: usize, now: impl Fn() -> Nanos) -> Result<View<'_>, PortError> {
        self.has_reads = true;
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            BoundPort::Unbound => Err(PortError::Unbound),
            BoundPort::Output(_) | BoundPort::ForeignOutput { .. } => Err(PortError::WrongPort),
            BoundPort::Input(reader) | BoundPort::Fixed(reader) => {
                let time = if reader.needs_time() { now() } else { 0 };
                let latched = reader.latch(time);
                let latched = latched.filter(|latched| !self.chunks.is_void(port, latched.stamp.time));
                if let Some(log) = &mut self.read_log {
                    log.record_read(port, latched.map(|latched| latched.stamp.sequence), now());
                }
                let latched = latched.ok_or(PortError::NoValue)?;
                Ok(View::of(latched.bytes, &latched.stamp))
            }
            BoundPort::Recorded(input) => {
                let RecordedInput {
                    history,
                    number,
                    resolved,
                    ..
                } = input;
                let value = resolved.get_or_insert_with(|| history.find(*number));
                let value = value.as_ref().ok_or(PortError::NoValue)?;
                Ok(View::of(value.bytes(), &value.stamp))
            }
            BoundPort::Command {
                reader,
                neutral,
                in_force,
                guards,
                driver,
            } => {
                let now = now();
                let variable = Arc::clone(reader.variable());
                let mut is_in_force = |latched: Latched<'_>| {
                    let Stamp {
                        sequence,
                        valid_until,
                        writer,
                        ..
                    } = latched.stamp;
                    let mut is_guarded = || {
                        let refusal = refuse_without_state(guards, now, writer);
                        self.refusal = refusal.map(|refusal| Refusal {
                            in_force: Some((Arc::clone(&variable), sequence)),
                            ..refusal
                        });
                        self.refusal.is_none()
                    };
                    sequence > 0 && valid_until >= now && is_guarded()
                };
                match reader.latch(now) {
                    Some(latched) if *in_force.get_or_insert_with(|| is_in_force(latched)) => Ok(View {
                        neutral: latched.stamp.writer == *driver,
                        ..View::of(latched.bytes, &latched.stamp)
                    }),
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

    /// Returns the memory for the next value of an output.
    pub(crate) fn loan(&mut self, port: usize) -> Result<&mut [u8], PortError> {
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            BoundPort::Unbound => Err(PortError::Unbound),
            BoundPort::Input(_)
            | BoundPort::Fixed(_)
            | BoundPort::Recorded(_)
            | BoundPort::Command { .. } => Err(PortError::WrongPort),
            BoundPort::Output(writer) | BoundPort::ForeignOutput { writer, .. } => {
                self.loan_count += usize::from(!writer.is_loaned());
                Ok(writer.loan())
            }
        }
    }

    #[inline(always)]
    pub(super) fn publish_loan(
        &mut self,
        port: usize,
        time: Nanos,
        now: Nanos,
        least: Nanos,
    ) -> Result<u64, PortError> {
        let failed = |why| match why {
            Refused::NothingLoaned => PortError::NothingLoaned,
            why => PortError::Refused { why, first: true },
        };
        let mut time = time;
        if self.faults.any()
            && let Some(published) = self.publish_failing(port, &mut time, now)
        {
            return published;
        }
        if !self.measurements.is_empty() {
            self.judge_measurement(port, time, now)?;
        }
        let number = port;
        let port = self.ports.get_mut(port).ok_or(PortError::WrongPort)?;
        let mut bytes = None;
        if let BoundPort::Output(writer) | BoundPort::ForeignOutput { writer, .. } = port
            && writer.is_loaned()
        {
            // Nothing is loaned afterwards, whether the publication succeeds or not.
            self.loan_count -= 1;
            bytes = self.write_log.as_ref().map(|_| writer.copy_loan());
        }
        let published = match port {
            BoundPort::Unbound => return Err(PortError::Unbound),
            BoundPort::Input(_)
            | BoundPort::Fixed(_)
            | BoundPort::Recorded(_)
            | BoundPort::Command { .. } => {
                return Err(PortError::WrongPort);
            }
            BoundPort::Output(writer) => writer.publish(time, now).map_err(failed),
            BoundPort::ForeignOutput { writer, refused, .. } => match writer.publish_for(time, now, least) {
                Ok(sequence) => {
                    *refused = None;
                    Ok(sequence)
                }
                Err(Refused::NothingLoaned) => Err(PortError::NothingLoaned),
                Err(why) => Err(PortError::Refused {
                    why,
                    first: refused.replace(why) != Some(why),
                }),
            },
        };
        match &published {
            Ok(sequence) => self.record_write(number, Some(*sequence), bytes),
            Err(PortError::Refused {
                why: Refused::NoAuthority,
                ..
            }) => self.record_write(number, None, None),
            Err(_) => {}
        }
        published
    }

    /// Changes the loan of an export that fails, and the time of its measurement. Returns the result of the publication
    /// if nothing is to be published.
    #[cold]
    fn publish_failing(
        &mut self,
        port: usize,
        time: &mut Nanos,
        now: Nanos,
    ) -> Option<Result<u64, PortError>> {
        let Some(BoundPort::Output(writer)) = self.ports.get_mut(port) else {
            return None;
        };
        if !writer.is_loaned() {
            return None;
        }
        let publication = self.faults.apply(port, writer, *time, now);
        if let Publication::Loan(measured_at) = publication {
            *time = measured_at;
            return None;
        }
        writer.discard();
        self.loan_count -= 1;
        Some(match publication {
            Publication::Retraction => self.retract(port).map(|()| 0),
            Publication::Loan(_) | Publication::Nothing => Ok(0),
        })
    }

    /// Records that a port has written a value of that number; without a number, that the write was refused
    /// or the value retracted.
    pub(super) fn record_write(&mut self, port: usize, number: Option<u64>, bytes: Option<Vec<u8>>) {
        if let Some(log) = &mut self.read_log
            && let Some(input) = log.inputs.get_mut(port)
        {
            *input = number.map_or(Turn::NO_VALUE, |number| number as u32);
            // The next release must clear it, because it is part of one turn.
            self.has_reads = true;
        }
        if let (Some(writes), Some(number)) = (&mut self.write_log, number) {
            writes.push(PortWrite { port, number, bytes });
        }
    }

    /// Whether the port writes another schema's variable: a command or a child's modulation.
    pub(crate) fn is_foreign_output(&self, port: usize) -> bool {
        matches!(self.ports.get(port), Some(BoundPort::ForeignOutput { .. }))
    }

    /// Retracts the newest value of an export.
    pub(crate) fn retract(&mut self, port: usize) -> Result<(), PortError> {
        match self.ports.get_mut(port) {
            Some(BoundPort::Output(writer)) => {
                writer.retract();
                let newest = writer.variable().newest();
                if let Some(writes) = &mut self.write_log {
                    let (number, bytes) = (newest, None);
                    writes.push(PortWrite { port, number, bytes });
                }
                self.record_write(port, None, None);
                Ok(())
            }
            _ => Err(PortError::WrongPort),
        }
    }

    /// Retracts every export that is not lasting.
    pub(super) fn retract_expiring(&mut self) {
        for port in 0..self.ports.len() {
            if let BoundPort::Output(writer) = &self.ports[port]
                && writer.variable().expires()
            {
                // It fails only for what is no export.
                let _ = self.retract(port);
            }
        }
    }

    /// Releases every value read. The next read shows the newest.
    pub(crate) fn release(&mut self) {
        self.releases += 1;
        self.has_reads = false;
        self.chunks.release();
        for port in &mut self.ports {
            match port {
                BoundPort::Input(reader) => reader.release(),
                BoundPort::Recorded(input) => input.resolved = None,
                BoundPort::Command { reader, in_force, .. } => {
                    reader.release();
                    *in_force = None;
                }
                BoundPort::Unbound
                | BoundPort::Fixed(_)
                | BoundPort::Output(_)
                | BoundPort::ForeignOutput { .. } => {}
            }
        }
        if let Some(log) = &mut self.read_log {
            log.inputs.fill(Turn::UNUSED);
            log.last = None;
        }
    }

    /// Releases all values when the schema awakes, and latches those that stay while it is awake.
    pub(crate) fn relatch(&mut self) {
        for port in &mut self.ports {
            if let BoundPort::Fixed(reader) = port {
                reader.release();
                // A modulation does not expire.
                reader.latch(0);
            }
        }
        self.release();
    }

    /// Whether a value was read since the last release.
    pub(crate) fn has_reads(&self) -> bool {
        self.has_reads
    }

    /// Whether there are unpublished loans.
    pub(crate) fn has_loans(&self) -> bool {
        self.loan_count > 0
    }

    /// Discards unpublished loans.
    pub(crate) fn discard_loans(&mut self) {
        if std::mem::take(&mut self.loan_count) == 0 {
            return;
        }
        self.separated_loans.clear();
        for port in &mut self.ports {
            match port {
                BoundPort::Output(writer) | BoundPort::ForeignOutput { writer, .. } => writer.discard(),
                BoundPort::Unbound
                | BoundPort::Input(_)
                | BoundPort::Fixed(_)
                | BoundPort::Recorded(_)
                | BoundPort::Command { .. } => {}
            }
        }
    }

    /// Returns the time of the newest value read since the last release; 0 without one.
    pub(crate) fn newest(&self) -> Nanos {
        let times = self.ports.iter().filter_map(|port| match port {
            BoundPort::Input(reader) | BoundPort::Command { reader, .. } => {
                reader.latched().map(|latched| latched.stamp.time)
            }
            BoundPort::Recorded(input) => input.resolved.as_ref()?.as_ref().map(|value| value.stamp.time),
            BoundPort::Unbound
            | BoundPort::Fixed(_)
            | BoundPort::Output(_)
            | BoundPort::ForeignOutput { .. } => None,
        });
        times.max().unwrap_or(0)
    }
}

impl From<Option<Arc<HistoricValue>>> for ShownValue {
    fn from(value: Option<Arc<HistoricValue>>) -> Self {
        value.map_or(Self::NoValue, Self::Value)
    }
}

impl ReadLog {
    fn record_read(&mut self, port: usize, sequence: Option<u64>, now: Nanos) {
        if let Some(input @ &mut Turn::UNUSED) = self.inputs.get_mut(port) {
            *input = sequence.map_or(Turn::NO_VALUE, |sequence| sequence as u32);
            self.last = Some((self.journal.last(), now));
        }
    }
}
