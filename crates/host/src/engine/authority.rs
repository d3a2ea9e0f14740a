//! Commands and who may give them: grants and withdrawals of authority (R7), braking and holding (R9).
//!
//! Used only inside transactions. That a withdrawn schema's publish cannot slip in late is the board's doing.

use std::sync::Arc;

use jde_board::{Access, Reader, Variable};
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
    /// The number of the value that stands although its writer lost its authority, held or taken over; 0 if none does.
    pub(super) alone: u64,
    /// For whom that value stands: they alone end it.
    pub(super) heirs: Vec<usize>,
    /// The motor schemas that are bound to it.
    pub(super) commanders: Vec<usize>,
}

/// What becomes of the newest value of a command.
enum Fate<'a> {
    /// It is nobody's business.
    Stays,
    /// It stands without its writer, as written at that time and until then.
    StandsAlone {
        time: Nanos,
        until: Nanos,
        /// For whom.
        heirs: &'a [usize],
    },
    Neutral,
}

/// The newest value of a command.
struct Last {
    writer: u32,
    sequence: u64,
    time: Nanos,
    valid_until: Nanos,
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

    /// Somebody is about to gain authority in a level: what was commanded from there is its now, where one of `heirs` is bound to it,
    /// and neutral elsewhere. Answers with the drivers that have something to carry out, as all of these do.
    pub(super) fn take_over(&mut self, level: &[usize], heirs: &[usize], now: Nanos) -> Vec<usize> {
        self.each(now, |command, last| {
            if !command.belongs(last, level) {
                Fate::Stays
            } else if command.is_bound(heirs) {
                // Not for as long as a loser that was slow by design, or a hold, would have it.
                Fate::StandsAlone {
                    time: last.time,
                    until: last.valid_until.min(now.saturating_add(command.validity())),
                    heirs,
                }
            } else {
                Fate::Neutral
            }
        })
    }

    /// This one has had its first iteration. What it took over, is bound to itself and did not write is neutral; and so is what only
    /// those below it are bound to, if none of them is among those who could act.
    pub(super) fn lapse(
        &mut self,
        instance: usize,
        below: &[usize],
        could_act: impl Fn(usize) -> bool,
        now: Nanos,
    ) -> Vec<usize> {
        self.each(now, |command, last| {
            let mut awaits = command.commanders.iter().filter(|other| below.contains(other));
            let is_awaited = !command.is_bound(&[instance]) && awaits.any(|other| could_act(*other));
            if command.stands_alone(last) && command.belongs(last, below) && !is_awaited {
                Fate::Neutral
            } else {
                Fate::Stays
            }
        })
    }

    /// Sends the neutral value wherever a command belongs to a level.
    pub(super) fn brake(&mut self, level: &[usize], now: Nanos) -> Vec<usize> {
        self.each(now, |command, last| {
            if command.belongs(last, level) {
                Fate::Neutral
            } else {
                Fate::Stays
            }
        })
    }

    /// Keeps the last command of a level in force until then; one whose validity is over stays over, and one that stands alone already
    /// stands no longer for it. What was taken over from elsewhere is neutral.
    pub(super) fn hold(&mut self, level: &[usize], now: Nanos, until: Nanos) -> Vec<usize> {
        self.each(now, |command, last| {
            if !command.belongs(last, level) || last.valid_until < now {
                Fate::Stays
            } else if !level.contains(&last.writer()) {
                Fate::Neutral
            } else {
                let longest = if command.stands_alone(last) {
                    last.valid_until
                } else {
                    Nanos::MAX
                };
                Fate::StandsAlone {
                    time: now,
                    until: until.min(longest),
                    heirs: level,
                }
            }
        })
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

    fn each<'a>(&mut self, now: Nanos, fate: impl Fn(&Command, &Last) -> Fate<'a>) -> Vec<usize> {
        let mut drivers = Vec::new();
        for command in &mut self.commands {
            let Some(last) = command.last() else {
                continue;
            };
            match fate(command, &last) {
                Fate::Stays => {}
                Fate::StandsAlone { time, until, heirs } => {
                    command.heirs = heirs.to_vec();
                    command.stand_alone(&last, time, until);
                }
                Fate::Neutral => {
                    command.put_neutral(now);
                    drivers.push(command.driver);
                }
            }
        }
        drivers
    }
}

impl Last {
    fn writer(&self) -> usize {
        self.writer as usize
    }
}

impl Command {
    fn is_bound(&self, instances: &[usize]) -> bool {
        self.commanders
            .iter()
            .any(|commander| instances.contains(commander))
    }

    /// The newest value, if somebody wrote one.
    fn last(&mut self) -> Option<Last> {
        let last = self.newest.latch().filter(|last| last.stamp.sequence > 0);
        let last = last.map(|last| Last {
            writer: last.stamp.writer,
            sequence: last.stamp.sequence,
            time: last.stamp.time,
            valid_until: last.stamp.valid_until,
        });
        self.newest.release();
        last
    }

    /// Whether its newest value is that of a level: of its writer's; and once it stands alone of those for whom it stands and who are
    /// bound to it, whoever wrote it.
    fn belongs(&self, last: &Last, level: &[usize]) -> bool {
        if !self.stands_alone(last) {
            return level.contains(&last.writer());
        }
        let mut bound = self.commanders.iter();
        bound.any(|commander| level.contains(commander) && self.heirs.contains(commander))
    }

    /// Whether that value is held or was taken over.
    fn stands_alone(&self, last: &Last) -> bool {
        self.alone == last.sequence
    }

    /// Lets the newest value stand although its writer lost its authority, until then.
    fn stand_alone(&mut self, last: &Last, time: Nanos, until: Nanos) {
        self.alone = last.sequence;
        if until == last.valid_until {
            return;
        }
        let bytes = self.newest.latch().map(|last| last.bytes.to_vec());
        self.newest.release();
        if let Some(bytes) = bytes {
            let put = self.variable.put(last.writer, &bytes, time, until);
            self.alone = put.expect("it was published before");
        }
    }

    fn validity(&self) -> Nanos {
        match self.variable.describe().access {
            Access::Command { validity } => validity,
            Access::Export | Access::Modulation => unreachable!("a command is declared as one"),
        }
    }

    fn put_neutral(&self, now: Nanos) {
        let put = self
            .variable
            .put(self.driver as u32, &self.neutral, now, Nanos::MAX);
        put.expect("a neutral value is finite: the board saw to it when it was declared");
    }
}
