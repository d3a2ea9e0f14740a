//! What schemas print: lines of the log, at most so many a second. It keeps no clock and writes nothing.

use std::collections::HashMap;

/// The tracing target of what the processes of schemas print.
pub(super) const PRINTED_TARGET: &str = "jde::printed";

/// Most lines of a schema that are shown in a second of the application: more than anybody reads.
const MAX_LINES: u64 = 50;

/// How many lines each schema printed in its last second.
#[derive(Debug, Default)]
pub(super) struct PrintedLines(HashMap<String, PrintedSecond>);

#[derive(Debug, Default)]
struct PrintedSecond {
    /// The second of the application.
    second: i64,
    lines: u64,
}

impl PrintedLines {
    /// Counts a line that a schema prints at a time, s. Returns whether it is shown, and before it what is said of the
    /// lines that were not.
    pub(super) fn take(&mut self, schema: &str, now: f64) -> (bool, Option<String>) {
        let second = now.floor() as i64;
        let printed = self.0.entry(schema.to_owned()).or_default();
        let mut hidden = None;
        if printed.second != second {
            hidden = printed.hidden();
            *printed = PrintedSecond { second, lines: 0 };
        }
        printed.lines += 1;
        (printed.lines <= MAX_LINES, hidden)
    }

    /// Returns what is said of the lines that were not shown, by schema, and forgets all.
    pub(super) fn rest(&mut self) -> Vec<(String, String)> {
        let printed = std::mem::take(&mut self.0).into_iter();
        printed
            .filter_map(|(schema, printed)| Some((schema, printed.hidden()?)))
            .collect()
    }
}

impl PrintedSecond {
    fn hidden(&self) -> Option<String> {
        let hidden = self.lines.saturating_sub(MAX_LINES);
        (hidden > 0).then(|| format!("{hidden} more lines in that second; {MAX_LINES} are shown"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_lines_of_each_second_are_shown_and_the_others_counted() {
        let mut printed = PrintedLines::default();
        let mut take = |now: f64| printed.take("hog", now);
        let shown = (0..80).filter(|_| take(1.5).0).count();
        assert_eq!(shown, 50);
        let said = "30 more lines in that second; 50 are shown";
        assert_eq!(take(2.0), (true, Some(said.to_owned())));
        assert_eq!(take(3.0), (true, None));
        (0..52).for_each(|_| drop(take(3.0)));
        let rest = ("hog".to_owned(), said.replace("30 more", "3 more"));
        assert_eq!(printed.rest(), [rest]);
    }
}
