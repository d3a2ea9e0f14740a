//! Reports the progress of a campaign to standard error: one updated line on a terminal, a line every 50
//! faults in a pipe.

use std::io::{IsTerminal as _, Write as _, stderr};

use jde_faults::campaign::{Campaign, Progress};
use jde_faults::case::Case;
use jde_faults::run::CaseResult;

/// Faults between two lines in a pipe.
const REPORT_PERIOD: u64 = 50;

/// The output.
pub(crate) struct ProgressDisplay {
    terminal: bool,
    /// Every fault is printed, for a single case.
    verbose: bool,
    count: u64,
    last_reported: u64,
    broken: u64,
}

impl ProgressDisplay {
    pub(crate) fn new(campaign: &Campaign) -> Self {
        Self {
            terminal: stderr().is_terminal(),
            verbose: campaign.case.is_some(),
            count: campaign.count,
            last_reported: 0,
            broken: 0,
        }
    }

    /// Clears the line.
    pub(crate) fn clear(&self) {
        if self.terminal {
            self.print("\r\x1b[K");
        }
    }

    fn print(&self, text: &str) {
        // The campaign continues even if standard error is closed.
        let _ = stderr().write_all(text.as_bytes());
        let _ = stderr().flush();
    }
}

impl Progress for ProgressDisplay {
    fn begins(&mut self, case: Case, injected: u64) {
        let count = self.count;
        if self.terminal && !self.verbose {
            self.print(&format!(
                "\r\x1b[K{injected} of {count} faults, {} broken  {case}",
                self.broken
            ));
        } else if !self.verbose && injected >= self.last_reported + REPORT_PERIOD {
            self.last_reported = injected - injected % REPORT_PERIOD;
            self.print(&format!("{injected} of {count} faults, {} broken\n", self.broken));
        }
    }

    fn ended(&mut self, report: &CaseResult) {
        self.broken += report.violations.len() as u64;
        if self.verbose {
            for injected in &report.faults {
                let target = injected.target.as_deref().unwrap_or("no schema");
                let effect = if injected.took_effect {
                    ""
                } else {
                    " (it took no effect)"
                };
                self.print(&format!("`{target}`: {}{effect}\n", injected.fault.describe()));
            }
        }
    }
}
