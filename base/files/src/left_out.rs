//! What a reader of a file does not understand, in one form for all readers.

use std::collections::BTreeMap;
use std::fmt::Display;

/// Most kinds of things that are named; what is beyond is counted.
const MAX_NAMED: usize = 200;

/// Elements, topics, keys and lines of a file that its reader leaves out: each with the reason, the first place and how
/// often.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    named: BTreeMap<(String, String), Times>,
    others: u64,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Times {
    count: u64,
    first: Option<String>,
}

impl LeftOut {
    /// Counts a thing that is left out: `<actor> "walker"`, `the topic /scan`. `place` is where it stands:
    /// `line 12`, `house/model.sdf:12`.
    pub fn add(&mut self, what: impl Display, place: Option<&dyn Display>, why: impl Display) {
        let key = (what.to_string(), why.to_string());
        if let Some(times) = self.named.get_mut(&key) {
            times.count += 1;
        } else if self.named.len() < MAX_NAMED {
            let first = place.map(ToString::to_string);
            self.named.insert(key, Times { count: 1, first });
        } else {
            self.others += 1;
        }
    }

    /// Counts a thing as [`Self::add`] does, under the reason that the first thing of this name had. For reasons that differ in
    /// numbers from message to message.
    pub fn add_again(&mut self, what: impl Display, why: impl Display) {
        let what = what.to_string();
        let mut known = self.named.range_mut((what.clone(), String::new())..);
        match known.next().filter(|((name, _), _)| *name == what) {
            Some((_, times)) => times.count += 1,
            None => self.add(what, None, why),
        }
    }

    /// Adds what another reader has left out.
    pub fn extend(&mut self, others: &Self) {
        for (key, more) in &others.named {
            if let Some(times) = self.named.get_mut(key) {
                times.count += more.count;
            } else if self.named.len() < MAX_NAMED {
                self.named.insert(key.clone(), more.clone());
            } else {
                self.others += more.count;
            }
        }
        self.others += others.others;
    }

    /// Whether nothing is left out.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.named.is_empty()
    }

    /// Returns how many things are left out.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.named.values().map(|times| times.count).sum::<u64>() + self.others
    }

    /// Returns a line for each kind of thing, in the order of their names.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        let named = self.named.iter().map(|((what, why), times)| {
            let place = match (&times.first, times.count) {
                (None, 1) => String::new(),
                (None, count) => format!(" ({count} times)"),
                (Some(first), 1) => format!(" ({first})"),
                (Some(first), count) => format!(" ({first}, and {} more)", count - 1),
            };
            format!("{what} is left out: {why}{place}")
        });
        let others = (self.others > 0).then(|| format!("{} more things are left out", self.others));
        named.chain(others)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_thing_is_named_with_its_first_place_and_how_often() {
        let mut left_out = LeftOut::default();
        assert!(left_out.is_empty());
        for line in [3, 7, 9] {
            left_out.add("<actor>", Some(&format_args!("line {line}")), "a world has none");
        }
        left_out.add("/tf", None, "its type is not known");
        let lines: Vec<_> = left_out.lines().collect();
        assert_eq!(
            lines,
            [
                "/tf is left out: its type is not known",
                "<actor> is left out: a world has none (line 3, and 2 more)"
            ]
        );
        assert_eq!(left_out.count(), 4);
    }

    #[test]
    fn the_first_reason_stands_for_others_of_the_same_thing() {
        let mut left_out = LeftOut::default();
        left_out.add_again("a message of /map", "it has 300 cells");
        left_out.add_again("a message of /map", "it has 400 cells");
        left_out.add_again("a message of /ma", "it is cut off");
        let mut whole = left_out.clone();
        whole.extend(&left_out);
        let lines: Vec<_> = whole.lines().collect();
        assert_eq!(
            lines,
            [
                "a message of /ma is left out: it is cut off (2 times)",
                "a message of /map is left out: it has 300 cells (4 times)"
            ]
        );
    }

    #[test]
    fn names_are_bounded() {
        let mut left_out = LeftOut::default();
        (0..1000).for_each(|number| left_out.add(number, None, "why"));
        assert_eq!(left_out.count(), 1000);
        assert_eq!(left_out.lines().last().unwrap(), "800 more things are left out");
    }
}
