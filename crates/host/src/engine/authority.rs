//! Commands and who may give them: grants and withdrawals of authority (R7), braking and holding (R9).
//!
//! Used only inside transactions. That a withdrawn schema's publish cannot slip in late is the board's doing.

use std::sync::Arc;

use jde_board::{Reader, Variable};
use jde_core::Nanos;

/// Every command of every driver.
#[derive(Default)]
pub(crate) struct Commands {
    commands: Vec<Command>,
}

pub(super) struct Command {
    pub(super) driver: usize,
    pub(super) variable: Arc<Variable>,
    pub(super) newest: Reader,
    pub(super) neutral: Vec<u8>,
    /// The motor schemas that are bound to it.
    pub(super) commanders: Vec<usize>,
}

impl Commands {
    pub(super) fn new(commands: Vec<Command>) -> Self {
        Self { commands }
    }

    pub(super) fn grant(&mut self, instance: usize) {
        for command in self
            .commands
            .iter()
            .filter(|command| command.commanders.contains(&instance))
        {
            command.variable.grant(instance as u32);
        }
    }

    pub(super) fn withdraw(&mut self, instance: usize) {
        for command in self
            .commands
            .iter()
            .filter(|command| command.commanders.contains(&instance))
        {
            command.variable.withdraw(instance as u32);
        }
    }

    /// Sends the neutral value wherever one of `instances` commanded last; answers with the drivers concerned.
    pub(super) fn brake(&mut self, instances: &[usize], now: Nanos) -> Vec<usize> {
        let mut drivers = Vec::new();
        for command in &mut self.commands {
            if command.last_from(instances) {
                command.put_neutral(now);
                drivers.push(command.driver);
            }
        }
        drivers
    }

    /// Sends the neutral value everywhere.
    pub(super) fn brake_all(&mut self, now: Nanos) -> Vec<usize> {
        for command in &mut self.commands {
            for commander in &command.commanders {
                command.variable.withdraw(*commander as u32);
            }
            command.put_neutral(now);
        }
        let mut drivers: Vec<usize> = self.commands.iter().map(|command| command.driver).collect();
        drivers.dedup();
        drivers
    }

    /// Keeps the last command of `instances` in force until then; one whose validity is over stays over.
    pub(super) fn hold(&mut self, instances: &[usize], now: Nanos, until: Nanos) {
        for command in &mut self.commands {
            if !command.last_from(instances) {
                continue;
            }
            let last = command
                .newest
                .latch()
                .filter(|last| last.stamp.valid_until >= now)
                .map(|last| (last.stamp.writer, last.bytes.to_vec()));
            command.newest.release();
            if let Some((writer, bytes)) = last {
                command
                    .variable
                    .put(writer, &bytes, now, until)
                    .expect("it was published before");
            }
        }
    }
}

impl Command {
    fn last_from(&mut self, instances: &[usize]) -> bool {
        let last = self
            .newest
            .latch()
            .filter(|last| last.stamp.sequence > 0)
            .map(|last| last.stamp.writer);
        self.newest.release();
        last.is_some_and(|writer| instances.contains(&(writer as usize)))
    }

    fn put_neutral(&self, now: Nanos) {
        let put = self
            .variable
            .put(self.driver as u32, &self.neutral, now, Nanos::MAX);
        put.expect("a neutral value is finite: the board saw to it when it was declared");
    }
}
