//! The ports of an instance where guards judge (R18): commands on their way to a judgement and from it, commands in
//! force, and what the state of a guard was made of. It judges nothing.

use std::sync::Arc;

use jde_board::{Access, LASTING, Latched, Reader};
use jde_core::{Nanos, SchemaId};
use jde_loader::AlignedBytes;

use super::bound_port::{BoundPort, Guarded, PortError};
use super::command_limits::CommandLimits;
use super::guard::{CommandInForce, Guarding, PortGuard, Refusal, UnjudgedCommand, UnjudgedInForce};
use super::ports::Ports;

impl Ports {
    /// Makes these the ports of a guard.
    pub(crate) fn guard(&mut self, guarding: Guarding) {
        self.guarding = Some(guarding);
    }

    /// Returns the refusal of a command that was read since the last call of this function.
    pub(crate) fn take_refusal(&mut self) -> Option<Refusal> {
        self.refusal.take()
    }

    /// Returns the newest command that each port gave and guards judge.
    pub(crate) fn newest_commands(&self, now: Nanos) -> Vec<UnjudgedCommand> {
        let newest = self.ports.iter().filter_map(|port| {
            let BoundPort::ForeignOutput { writer, guards, .. } = port else {
                return None;
            };
            Some(UnjudgedCommand {
                guards: Arc::clone(guards),
                bytes: AlignedBytes::new(writer.variable().reader("replay").latch(now)?.bytes),
            })
        });
        newest.collect()
    }

    /// Returns the state of a guard and the commands in force that it has not judged by that state.
    pub(crate) fn commands_in_force(&mut self, now: Nanos) -> Option<UnjudgedInForce> {
        let Guarding {
            state,
            commands,
            judged_by,
            ..
        } = self.guarding.as_mut()?;
        let state = state.newest(now);
        let number = state.as_ref().map_or(0, |state| state.sequence);
        if number > 0 && std::mem::replace(judged_by, number) == number {
            return None;
        }
        let in_force = commands.iter_mut().filter_map(|(reader, commanders)| {
            let variable = Arc::clone(reader.variable());
            let Latched { bytes, stamp } = reader.latch_newest(now)?;
            let judges = stamp.sequence > 0 && stamp.valid_until >= now && commanders.contains(&stamp.writer);
            let commander = SchemaId(stamp.writer);
            judges.then(|| {
                let command = CommandInForce {
                    variable,
                    sequence: stamp.sequence,
                    commander,
                };
                (command, AlignedBytes::new(bytes))
            })
        });
        Some(UnjudgedInForce {
            state,
            commands: in_force.collect(),
        })
    }

    /// Publishes the loan and returns its number. A command is in force for at least `least`,
    /// so that the command of a slow schema does not expire between its turns. A command that guards judge is not
    /// published, but returned with the error, for [`Self::publish_judged`].
    pub(crate) fn publish(
        &mut self,
        port: usize,
        time: Nanos,
        now: Nanos,
        least: Nanos,
    ) -> Result<u64, PortError> {
        if let Some(BoundPort::ForeignOutput {
            writer,
            guards,
            limits,
            ..
        }) = self.ports.get_mut(port)
            && writer.is_loaned()
        {
            self.is_limited = limits.as_ref().is_some_and(|limits| limits.apply(writer.loan()));
            if !guards.is_empty() {
                return Err(PortError::Guarded(Box::new(Guarded::Unjudged(UnjudgedCommand {
                    guards: Arc::clone(guards),
                    bytes: AlignedBytes::new(writer.loan()),
                }))));
            }
        }
        match &self.guarding {
            Some(guarding) if guarding.port == port => self.publish_state(port, time, now),
            Some(_) | None => self.publish_loan(port, time, now, least),
        }
    }

    /// Publishes the state of a guard, which is as old as the oldest value that it was made of.
    #[cold]
    fn publish_state(&mut self, port: usize, time: Nanos, now: Nanos) -> Result<u64, PortError> {
        let state = self.guarding.as_ref().map(|guarding| Arc::clone(&guarding.state));
        let (oldest, until) = self.sources();
        let published = self.publish_loan(port, time.min(oldest), now, 0)?;
        // An export that fails publishes nothing, which has the number 0.
        if let (Some(state), 1..) = (state, published) {
            state.record_published(now, until);
        }
        Ok(published)
    }

    /// Publishes a command that its guards have judged: these bytes, whatever is in the loan since.
    pub(crate) fn publish_judged(
        &mut self,
        port: usize,
        command: &AlignedBytes,
        time: Nanos,
        now: Nanos,
        least: Nanos,
    ) -> Result<u64, PortError> {
        self.loan(port)?.copy_from_slice(command.bytes());
        self.publish_loan(port, time, now, least)
    }

    /// Discards and counts a command that a guard refuses.
    pub(crate) fn refuse(&mut self, port: usize) {
        if let Some(BoundPort::ForeignOutput { writer, .. }) = self.ports.get_mut(port)
            && writer.is_loaned()
        {
            writer.refuse();
            self.loan_count -= 1;
        }
        self.record_write(port, None, None);
    }

    /// Returns the limits that the last published command of a port exceeded.
    pub(crate) fn take_exceeded(&mut self, port: usize) -> Option<Arc<CommandLimits>> {
        if !std::mem::take(&mut self.is_limited) {
            return None;
        }
        match self.ports.get(port) {
            Some(BoundPort::ForeignOutput { limits, .. }) => limits.clone(),
            _ => None,
        }
    }

    /// Records that a command of a port is limited now. Returns whether it is the first for `quiet`.
    pub(crate) fn record_limited(&mut self, port: usize, now: Nanos, quiet: Nanos) -> bool {
        match self.ports.get_mut(port) {
            Some(BoundPort::ForeignOutput { limited_at, .. }) => {
                let last = limited_at.replace(now);
                last.is_none_or(|last| now > last.saturating_add(quiet))
            }
            _ => false,
        }
    }

    /// Returns the time of the oldest imported value read since the last release, and until when all of them are
    /// valid. A value that does not expire, such as a map, is never old.
    pub(super) fn sources(&self) -> (Nanos, Nanos) {
        let stamps = self.ports.iter().filter_map(|port| match port {
            BoundPort::Input(reader) if is_import(reader) => reader.latched().map(|latched| latched.stamp),
            BoundPort::Recorded(input) if input.is_import => Some(input.resolved.as_ref()?.as_ref()?.stamp),
            BoundPort::Input(_)
            | BoundPort::Recorded(_)
            | BoundPort::Command { .. }
            | BoundPort::Unbound
            | BoundPort::Fixed(_)
            | BoundPort::Output(_)
            | BoundPort::ForeignOutput { .. } => None,
        });
        let ending = stamps.filter(|stamp| stamp.valid_until != LASTING);
        ending.fold((Nanos::MAX, Nanos::MAX), |(oldest, until), stamp| {
            (oldest.min(stamp.time), until.min(stamp.valid_until))
        })
    }
}

/// Whether a reader is of an import, and not of a modulation.
pub(super) fn is_import(reader: &Reader) -> bool {
    match reader.variable().describe().access {
        Access::Export { .. } => true,
        Access::Modulation | Access::Command { .. } => false,
    }
}

/// Refuses a command in force while a guard of its commander has no state (R18).
pub(super) fn refuse_without_state(guards: &[PortGuard], now: Nanos, commander: u32) -> Option<Refusal> {
    let mut guards = guards.iter().filter(|guard| guard.judges(commander));
    guards.find_map(|PortGuard { guard, state, .. }| {
        let reason = state.newest(now).err()?;
        Some(Refusal {
            commander: SchemaId(commander),
            guard: *guard,
            reason,
            in_force: None,
        })
    })
}
