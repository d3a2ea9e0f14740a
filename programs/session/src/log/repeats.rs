//! Warnings that say the same again and again: shown once, then counted. It keeps no clock and writes nothing.

use std::collections::HashMap;
use std::mem::take;

/// How long a warning is counted before it is shown again, s.
const COUNTED_SECONDS: f64 = 60.0;
/// Most different warnings that are remembered.
const MAX_KNOWN: usize = 500;

/// The warnings that were shown.
#[derive(Debug, Default)]
pub(super) struct Repeats {
    known: HashMap<String, Warning>,
}

#[derive(Debug)]
struct Warning {
    /// When it was shown, s.
    shown: f64,
    /// How often it came since.
    more: u64,
    schema: String,
    /// What it said last.
    text: String,
}

/// A warning that was counted.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Counted {
    /// The schema that warned.
    pub(super) schema: String,
    /// What it said last, and how often.
    pub(super) text: String,
}

impl Repeats {
    /// Counts a warning of a schema that comes at a time, s. Returns whether it is shown. Two warnings of a schema are the same
    /// if only their numbers differ.
    pub(super) fn is_shown(&mut self, schema: &str, text: &str, now: f64) -> bool {
        let key = format!("{schema}: {}", without_numbers(text));
        if let Some(warning) = self.known.get_mut(&key) {
            warning.more += 1;
            text.clone_into(&mut warning.text);
            return false;
        }
        if self.known.len() < MAX_KNOWN {
            let warning = Warning {
                shown: now,
                more: 0,
                schema: schema.to_owned(),
                text: text.to_owned(),
            };
            self.known.insert(key, warning);
        }
        true
    }

    /// Returns what the warnings said last that were counted for long enough at this time, and how often they came. One that
    /// has not come again is forgotten.
    pub(super) fn due(&mut self, now: f64) -> Vec<Counted> {
        let mut due = Vec::new();
        self.known.retain(|_, warning| {
            // The time is another one when an application begins or ends.
            if (0.0..COUNTED_SECONDS).contains(&(now - warning.shown)) {
                return true;
            }
            due.extend(warning.count());
            let is_kept = warning.more > 0;
            (warning.shown, warning.more) = (now, 0);
            is_kept
        });
        due
    }

    /// Returns all that were counted, and forgets them.
    pub(super) fn rest(&mut self) -> Vec<Counted> {
        take(&mut self.known)
            .into_values()
            .filter_map(|warning| warning.count())
            .collect()
    }
}

impl Warning {
    fn count(&self) -> Option<Counted> {
        let Self { text, more, .. } = self;
        let times = if *more == 1 { "time" } else { "times" };
        (*more > 0).then(|| Counted {
            schema: self.schema.clone(),
            text: format!("{text} ({more} more {times})"),
        })
    }
}

/// Returns the text with one zero for each run of digits.
fn without_numbers(line: &str) -> String {
    let mut last = ' ';
    let mut key = String::with_capacity(line.len());
    for c in line.chars() {
        let is_number = |c: char| c.is_ascii_digit() || c == '.';
        match is_number(c) {
            true if is_number(last) => {}
            true => key.push('0'),
            false => key.push(c),
        }
        last = c;
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(text: &str) -> Counted {
        Counted {
            schema: "slam".to_owned(),
            text: text.to_owned(),
        }
    }

    #[test]
    fn a_warning_is_shown_once_and_then_counted() {
        let mut repeats = Repeats::default();
        let shown = |repeats: &mut Repeats, seconds: f64, way: f64| {
            let due = repeats.due(seconds);
            (
                repeats.is_shown("slam", &format!("the odometry jumped by {way:.2} m"), seconds),
                due,
            )
        };
        assert_eq!(shown(&mut repeats, 1.0, 0.28), (true, vec![]));
        for tick in 1..300 {
            assert_eq!(
                shown(&mut repeats, 1.0 + f64::from(tick) / 5.0, 12.0),
                (false, vec![])
            );
        }
        let count = counted("the odometry jumped by 12.00 m (299 more times)");
        assert_eq!(shown(&mut repeats, 61.0, 0.5), (false, vec![count]));
        assert!(
            repeats.is_shown("slam2", "the odometry jumped by 0.28 m", 61.0),
            "another schema"
        );
        assert_eq!(
            repeats.rest(),
            [counted("the odometry jumped by 0.50 m (1 more time)")]
        );
    }

    #[test]
    fn a_warning_that_comes_seldom_is_shown_each_time() {
        let mut repeats = Repeats::default();
        for minute in 0..9 {
            let now = 61.0 * f64::from(minute);
            assert_eq!(repeats.due(now), []);
            assert!(repeats.is_shown("a", "late", now));
        }
        // The time of another application begins.
        assert_eq!(repeats.due(0.0), []);
        assert!(repeats.is_shown("a", "late", 0.0));
    }

    #[test]
    fn what_is_remembered_is_bounded() {
        let mut repeats = Repeats::default();
        for length in 0..2000 {
            assert!(repeats.is_shown("a", &"x".repeat(length), 0.0));
        }
        assert_eq!(repeats.known.len(), MAX_KNOWN);
    }
}
