//! The newest lines of what happened: switches with their reasons, and events. Each has a number, so that a page that reads
//! slowly learns how many it missed.

use std::collections::VecDeque;

use jde_records::RunRecord;
use jde_timeline::{MarkKind, Severity};
use serde::Serialize;

/// Lines that are kept: more than anybody scrolls through on a phone.
const MAX_LINES: usize = 300;
/// The longest line, in characters.
const MAX_TEXT: usize = 400;

/// A line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LogLine {
    pub(crate) number: u64,
    time_s: f64,
    pub(crate) text: String,
    pub(crate) because: String,
    pub(crate) severity: &'static str,
}

/// The newest lines.
#[derive(Default)]
pub(crate) struct Log {
    lines: VecDeque<LogLine>,
    last: u64,
}

impl Log {
    /// Adds a record, if it is one that people read.
    pub(crate) fn add(&mut self, record: &RunRecord) {
        match record {
            RunRecord::Decision(decision) if decision.changed => {
                let text = format!(
                    "{}: {} › {}",
                    decision.group,
                    decision.before_name(),
                    decision.choice_name()
                );
                self.push(decision.time_s, &text, &decision.reason, Severity::Good);
            }
            RunRecord::Other(event) => {
                let kind = MarkKind::of(&event.what);
                if kind != MarkKind::Other {
                    let owner = event
                        .what
                        .schema()
                        .map_or_else(String::new, |schema| format!("{schema}: "));
                    self.push(event.time_s(), &(owner + &event.text()), "", kind.severity());
                }
            }
            RunRecord::Decision(_) | RunRecord::State(_) => {}
        }
    }

    fn push(&mut self, time_s: f64, text: &str, because: &str, severity: Severity) {
        // Who drives by hand says the same many times a second.
        if let Some(last) = self.lines.back_mut()
            && last.text == text
            && last.because == because
        {
            return;
        }
        if self.lines.len() == MAX_LINES {
            self.lines.pop_front();
        }
        self.last += 1;
        let cut = |text: &str| text.chars().take(MAX_TEXT).collect();
        self.lines.push_back(LogLine {
            number: self.last,
            time_s,
            text: cut(text),
            because: cut(because),
            severity: severity_word(severity),
        });
    }

    /// Returns the number of the newest line; 0 before the first.
    pub(crate) fn last(&self) -> u64 {
        self.last
    }

    /// Returns the oldest lines after a number, at most this many.
    pub(crate) fn after(&self, number: u64, most: usize) -> Vec<LogLine> {
        let first = self.lines.partition_point(|line| line.number <= number);
        self.lines.range(first..).take(most).cloned().collect()
    }
}

/// Returns how bad something is as the page names it.
pub(crate) fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Good => "good",
        Severity::Warning => "warning",
        Severity::Bad => "bad",
    }
}

#[cfg(test)]
mod tests {
    use jde_records::Decision;

    use super::*;

    fn switch(number: u64) -> RunRecord {
        RunRecord::Decision(Decision {
            number,
            time_s: number as f64,
            group: "roots".to_owned(),
            choice: Some(format!("schema{number}")),
            reason: "it is ready".to_owned(),
            changed: true,
            ..Decision::default()
        })
    }

    #[test]
    fn the_newest_lines_are_kept_and_a_slow_reader_sees_the_gap() {
        let mut log = Log::default();
        for number in 1..=2 * MAX_LINES as u64 {
            log.add(&switch(number));
        }
        let lines = log.after(0, 10);
        assert_eq!((lines.len(), lines[0].number), (10, MAX_LINES as u64 + 1));
        assert_eq!(
            lines[0].text,
            format!("roots: nobody › schema{}", lines[0].number)
        );
        assert!(log.after(2 * MAX_LINES as u64, 10).is_empty());
    }

    #[test]
    fn what_changes_nothing_or_repeats_itself_is_no_line() {
        let mut log = Log::default();
        log.add(&RunRecord::Decision(Decision::default()));
        log.add(&RunRecord::retracted(0, "goon.command"));
        assert!(log.after(0, 10).is_empty());
        log.add(&switch(1));
        log.add(&switch(1));
        assert_eq!(log.after(0, 10).len(), 1);
    }
}
