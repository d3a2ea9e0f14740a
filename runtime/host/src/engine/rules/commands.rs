//! Commands and the authority to write them: grants and withdrawals (R7), braking and holding (R9).
//!
//! Used only inside transactions. The board ensures that a withdrawn schema cannot publish late.

use std::sync::Arc;

use jde_board::{Access, Reader, Variable};
use jde_core::{Nanos, SchemaId};
use jde_isolation::authority::AuthorityTable;

/// Every command of every driver.
#[derive(Default)]
pub(crate) struct Commands {
    commands: Vec<Command>,
    /// Shows grants to schemas in processes of their own, if there are any.
    authority: Option<Arc<AuthorityTable>>,
}

pub(crate) struct Command {
    pub(crate) driver: SchemaId,
    pub(crate) variable: Arc<Variable>,
    pub(crate) newest: Reader,
    pub(crate) neutral: Vec<u8>,
    /// The sequence number of a value that stays in force without its writer's authority, held or taken over;
    /// 0 if none does.
    pub(crate) held_sequence: u64,
    /// The instances for which that value stays in force. Only they end it.
    pub(crate) holders: Vec<SchemaId>,
    /// The motor schemas that are bound to the command.
    pub(crate) commanders: Vec<SchemaId>,
}

/// What happens to the newest value of a command.
enum CommandChange<'a> {
    /// The value is left as it is.
    Unchanged,
    /// The value stays in force without its writer, written at `time` and valid until `until`.
    Hold {
        time: Nanos,
        until: Nanos,
        /// The instances for which it stays in force.
        holders: &'a [SchemaId],
    },
    Neutral,
}

/// The newest value of a command.
struct NewestCommand {
    writer: u32,
    sequence: u64,
    time: Nanos,
    valid_until: Nanos,
}

impl Commands {
    pub(crate) fn new(commands: Vec<Command>) -> Self {
        Self {
            commands,
            authority: None,
        }
    }

    pub(crate) fn show_authority(&mut self, authority: Option<Arc<AuthorityTable>>) {
        self.authority = authority;
    }

    pub(super) fn grant(&mut self, instance: SchemaId) {
        for command in self
            .commands
            .iter()
            .filter(|command| command.commanders.contains(&instance))
        {
            command.variable.grant(instance.0);
        }
        if let Some(authority) = &self.authority {
            authority.set(instance, true);
        }
    }

    pub(super) fn withdraw(&mut self, instance: SchemaId) {
        if let Some(authority) = &self.authority {
            authority.set(instance, false);
        }
        for command in self
            .commands
            .iter()
            .filter(|command| command.commanders.contains(&instance))
        {
            command.variable.withdraw(instance.0);
        }
    }

    /// Prepares a level for a new WINNER. A command of the level now belongs to the heir that is bound to it,
    /// and becomes neutral if no heir is. Returns the drivers that received neutral values; all such methods
    /// return these.
    pub(super) fn take_over(
        &mut self,
        level: &[SchemaId],
        successors: &[SchemaId],
        now: Nanos,
    ) -> Vec<SchemaId> {
        self.update_each(now, |command, last| {
            if !command.belongs(last, level) {
                CommandChange::Unchanged
            } else if command.is_bound(successors) {
                // Limits the time, which a slow loser or a hold may have set longer.
                CommandChange::Hold {
                    time: last.time,
                    until: last.valid_until.min(now.saturating_add(command.validity())),
                    holders: successors,
                }
            } else {
                CommandChange::Neutral
            }
        })
    }

    /// Ends what an instance took over, after its first iteration. A command that the instance took over, is
    /// bound to and did not write becomes neutral. A command to which only schemas below it are bound becomes
    /// neutral if none of those could act.
    pub(super) fn end_taken_over(
        &mut self,
        instance: SchemaId,
        below: &[SchemaId],
        could_act: impl Fn(SchemaId) -> bool,
        now: Nanos,
    ) -> Vec<SchemaId> {
        self.update_each(now, |command, last| {
            let mut awaits = command.commanders.iter().filter(|other| below.contains(other));
            let is_awaited = !command.is_bound(&[instance]) && awaits.any(|other| could_act(*other));
            if command.is_held(last) && command.belongs(last, below) && !is_awaited {
                CommandChange::Neutral
            } else {
                CommandChange::Unchanged
            }
        })
    }

    /// Sends the neutral value to each command that belongs to a level.
    pub(super) fn brake(&mut self, level: &[SchemaId], now: Nanos) -> Vec<SchemaId> {
        self.update_each(now, |command, last| {
            if command.belongs(last, level) {
                CommandChange::Neutral
            } else {
                CommandChange::Unchanged
            }
        })
    }

    /// Keeps the last commands of a level in force until `until`. An expired command stays expired, and a
    /// value that already stays in force without its writer does so no longer than before. A command that was
    /// taken over from elsewhere becomes neutral.
    pub(super) fn hold(&mut self, level: &[SchemaId], now: Nanos, until: Nanos) -> Vec<SchemaId> {
        self.update_each(now, |command, last| {
            if !command.belongs(last, level) || last.valid_until < now {
                CommandChange::Unchanged
            } else if !level.contains(&last.writer()) {
                CommandChange::Neutral
            } else {
                let longest = if command.is_held(last) {
                    last.valid_until
                } else {
                    Nanos::MAX
                };
                CommandChange::Hold {
                    time: now,
                    until: until.min(longest),
                    holders: level,
                }
            }
        })
    }

    /// Sends the neutral value of a command that a guard refused, if it is still the newest.
    pub(super) fn end_refused(
        &mut self,
        variable: &Arc<Variable>,
        sequence: u64,
        now: Nanos,
    ) -> Vec<SchemaId> {
        self.update_each(now, |command, last| {
            if Arc::ptr_eq(&command.variable, variable) && last.sequence == sequence {
                CommandChange::Neutral
            } else {
                CommandChange::Unchanged
            }
        })
    }

    /// Replaces a command by the one to which a guard limits it, if it is still the newest. All else about it stays.
    pub(super) fn limit(&mut self, variable: &Arc<Variable>, sequence: u64, limited: &[u8]) -> Vec<SchemaId> {
        let mut commands = self.commands.iter_mut();
        let Some(command) = commands.find(|command| Arc::ptr_eq(&command.variable, variable)) else {
            return Vec::new();
        };
        let Some(last) = command.last().filter(|last| last.sequence == sequence) else {
            return Vec::new();
        };
        let is_held = command.is_held(&last);
        match command
            .variable
            .put(last.writer, limited, last.time, last.valid_until)
        {
            Ok(put) if is_held => command.held_sequence = put,
            Ok(_) => {}
            // A guard that limits to what is no command is wrong, and what it judged does not go on.
            Err(_) => command.put_neutral(last.time),
        }
        vec![command.driver]
    }

    /// Withdraws all authority and sends every command its neutral value.
    pub(super) fn brake_all(&mut self, now: Nanos) -> Vec<SchemaId> {
        if let Some(authority) = &self.authority {
            authority.clear();
        }
        for command in &mut self.commands {
            for commander in &command.commanders {
                command.variable.withdraw(commander.0);
            }
            command.put_neutral(now);
        }
        let mut drivers: Vec<SchemaId> = self.commands.iter().map(|command| command.driver).collect();
        drivers.dedup();
        drivers
    }

    fn update_each<'a>(
        &mut self,
        now: Nanos,
        fate: impl Fn(&Command, &NewestCommand) -> CommandChange<'a>,
    ) -> Vec<SchemaId> {
        let mut drivers = Vec::new();
        for command in &mut self.commands {
            let Some(last) = command.last() else {
                continue;
            };
            match fate(command, &last) {
                CommandChange::Unchanged => {}
                CommandChange::Hold {
                    time,
                    until,
                    holders: successors,
                } => {
                    command.holders = successors.to_vec();
                    command.hold_value(&last, time, until);
                }
                CommandChange::Neutral => {
                    command.put_neutral(now);
                    drivers.push(command.driver);
                }
            }
        }
        drivers
    }
}

impl NewestCommand {
    fn writer(&self) -> SchemaId {
        SchemaId(self.writer)
    }
}

impl Command {
    fn is_bound(&self, instances: &[SchemaId]) -> bool {
        self.commanders
            .iter()
            .any(|commander| instances.contains(commander))
    }

    /// The newest value, if any was written.
    fn last(&mut self) -> Option<NewestCommand> {
        let last = self.newest.latch(0).filter(|last| last.stamp.sequence > 0);
        let last = last.map(|last| NewestCommand {
            writer: last.stamp.writer,
            sequence: last.stamp.sequence,
            time: last.stamp.time,
            valid_until: last.stamp.valid_until,
        });
        self.newest.release();
        last
    }

    /// Whether the newest value belongs to a level. It belongs to the level of its writer. A value that stays
    /// in force without its writer belongs to the levels of its successors that are bound to the command, whatever
    /// schema wrote it.
    fn belongs(&self, last: &NewestCommand, level: &[SchemaId]) -> bool {
        if !self.is_held(last) {
            return level.contains(&last.writer());
        }
        let mut bound = self.commanders.iter();
        bound.any(|commander| level.contains(commander) && self.holders.contains(commander))
    }

    /// Whether the value was held or taken over.
    fn is_held(&self, last: &NewestCommand) -> bool {
        self.held_sequence == last.sequence
    }

    /// Keeps the newest value in force until `until` without its writer's authority.
    fn hold_value(&mut self, last: &NewestCommand, time: Nanos, until: Nanos) {
        self.held_sequence = last.sequence;
        if until == last.valid_until {
            return;
        }
        let bytes = self.newest.latch(0).map(|last| last.bytes.to_vec());
        self.newest.release();
        let held = bytes.and_then(|bytes| self.variable.put(last.writer, &bytes, time, until).ok());
        match held {
            Some(sequence) => self.held_sequence = sequence,
            // What cannot be repeated is not held.
            None => self.put_neutral(time),
        }
    }

    fn validity(&self) -> Nanos {
        match self.variable.describe().access {
            Access::Command { validity } => validity,
            // Not a command.
            Access::Export { .. } | Access::Modulation => 0,
        }
    }

    fn put_neutral(&self, now: Nanos) {
        let put = self.variable.put(self.driver.0, &self.neutral, now, Nanos::MAX);
        debug_assert!(put.is_ok(), "the board checked it when it was declared: {put:?}");
    }
}
