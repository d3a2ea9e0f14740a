//! Reports the progress of a campaign to standard error: one updated line on a terminal, a line now and then
//! in a pipe.

use std::io::{IsTerminal as _, Write as _, stderr};

use jde_faults::campaign::{Campaign, Progress};
use jde_faults::case::Case;
use jde_faults::run::Report;

/// Faults between two lines in a pipe.
const EVERY: u64 = 50;

/// The output.
pub(crate) struct Screen {
    terminal: bool,
    /// Every fault is printed, for a single case.
    closely: bool,
    count: u64,
    told: u64,
    broken: u64,
}

impl Screen {
    pub(crate) fn new(campaign: &Campaign) -> Self {
        Self {
            terminal: stderr().is_terminal(),
            closely: campaign.case.is_some(),
            count: campaign.count,
            told: 0,
            broken: 0,
        }
    }

    /// Clears the line.
    pub(crate) fn end(&self) {
        if self.terminal {
            self.say("\r\x1b[K");
        }
    }

    fn say(&self, text: &str) {
        // The campaign continues even if standard error is closed.
        let _ = stderr().write_all(text.as_bytes());
        let _ = stderr().flush();
    }
}

impl Progress for Screen {
    fn begins(&mut self, case: Case, injected: u64) {
        let count = self.count;
        if self.terminal && !self.closely {
            self.say(&format!(
                "\r\x1b[K{injected} of {count} faults, {} broken  {case}",
                self.broken
            ));
        } else if !self.closely && injected >= self.told + EVERY {
            self.told = injected - injected % EVERY;
            self.say(&format!("{injected} of {count} faults, {} broken\n", self.broken));
        }
    }

    fn ended(&mut self, report: &Report) {
        self.broken += report.broken.len() as u64;
        if self.closely {
            for injected in &report.faults {
                let whom = injected.whom.as_deref().unwrap_or("nobody");
                let slept = if injected.struck {
                    ""
                } else {
                    " (it took no effect)"
                };
                self.say(&format!("`{whom}`: {}{slept}\n", injected.fault.words()));
            }
        }
    }
}
