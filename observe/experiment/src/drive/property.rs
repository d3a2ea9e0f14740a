//! Properties: what must hold during a drive, over the values of expressions at its instants. A monitor
//! decides as soon as it can; it reads nothing itself.

use jde_core::Nanos;

/// A property. The numbers are places in [`Experiment::expressions`](crate::Experiment::expressions).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Property {
    /// What must hold.
    pub kind: PropertyKind,
    /// The text of the decisive expression, for messages.
    pub text: String,
    /// Instants before this time do not count, ns.
    pub from: Nanos,
}

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropertyKind {
    /// True at every instant from the first at which it has a value.
    Always(usize),
    /// True at no instant.
    Never(usize),
    /// True at some instant.
    Eventually(usize),
    /// Whenever `of` becomes true, `holds` is true at that instant or within `time` after it.
    Within {
        /// The longest time, ns.
        time: Nanos,
        /// The cause.
        of: usize,
        /// The effect.
        holds: usize,
    },
    /// `holds` is true at every instant before `until` is, and `until` is true at some instant.
    Until {
        /// What ends the obligation.
        until: usize,
        /// The obligation.
        holds: usize,
    },
}

/// A property during one drive.
#[derive(Clone, Debug)]
pub struct Monitor {
    property: Property,
    state: MonitorState,
}

#[derive(Clone, Debug, PartialEq)]
enum MonitorState {
    /// Nothing has happened yet that matters.
    Open,
    /// The expression of `always` has had a value.
    Begun,
    /// The cause of `within` became true and still is; its effect has occurred.
    Caused,
    /// The effect of `within` must occur by this time; whether the cause is still true.
    Due { by: Nanos, is_true: bool },
    /// It holds, whatever follows.
    Holds,
    /// It does not hold since this time, for this reason.
    Violated { at: Nanos, why: String },
}

impl Monitor {
    /// Begins to watch a property.
    #[must_use]
    pub fn new(property: &Property) -> Self {
        Self {
            property: property.clone(),
            state: MonitorState::Open,
        }
    }

    /// Takes the values of all expressions at an instant. Instants come in order.
    pub fn observe(&mut self, now: Nanos, values: &[Option<f64>]) {
        if now < self.property.from
            || matches!(self.state, MonitorState::Holds | MonitorState::Violated { .. })
        {
            return;
        }
        let is_true = |expression: usize| values[expression].is_some_and(|value| value != 0.0);
        match self.property.kind {
            PropertyKind::Always(expression) => match (values[expression], &self.state) {
                (None, MonitorState::Open) => {}
                (None, _) => self.violate(now, "has no value"),
                (Some(0.0), _) => self.violate(now, "is false"),
                (Some(_), _) => self.state = MonitorState::Begun,
            },
            PropertyKind::Never(expression) if is_true(expression) => self.violate(now, "is true"),
            PropertyKind::Eventually(expression) if is_true(expression) => self.state = MonitorState::Holds,
            PropertyKind::Never(_) | PropertyKind::Eventually(_) => {}
            PropertyKind::Within { time, of, holds } => {
                self.observe_within(now, time, is_true(of), is_true(holds))
            }
            PropertyKind::Until { until, .. } if is_true(until) => self.state = MonitorState::Holds,
            PropertyKind::Until { holds, .. } => {
                if !is_true(holds) {
                    self.violate(now, "is false");
                }
            }
        }
    }

    /// Ends the drive: decides what is still open. An effect that is due later than `now` counts as in time.
    pub fn finish(&mut self, now: Nanos) {
        match (self.property.kind, &self.state) {
            (PropertyKind::Eventually(_) | PropertyKind::Until { .. }, MonitorState::Open) => {
                self.violate(now, "was never true");
            }
            (_, MonitorState::Due { by, .. }) if now > *by => self.violate(*by, "was not true in time"),
            _ => {}
        }
    }

    /// Returns when and why the property does not hold, as far as it is decided.
    #[must_use]
    pub fn violation(&self) -> Option<(Nanos, &str)> {
        match &self.state {
            MonitorState::Violated { at, why } => Some((*at, why)),
            MonitorState::Open
            | MonitorState::Begun
            | MonitorState::Caused
            | MonitorState::Due { .. }
            | MonitorState::Holds => None,
        }
    }

    fn observe_within(&mut self, now: Nanos, time: Nanos, cause: bool, effect: bool) {
        let (due, was_true) = match self.state {
            MonitorState::Due { by, is_true } => (Some(by), is_true),
            MonitorState::Caused => (None, true),
            _ => (None, false),
        };
        if let Some(by) = due.filter(|by| now > *by) {
            return self.violate(by, "was not true in time");
        }
        let due = match due {
            Some(by) => Some(by),
            None if cause && !was_true => Some(now.saturating_add(time)),
            None => None,
        };
        self.state = match due.filter(|_| !effect) {
            Some(by) => MonitorState::Due { by, is_true: cause },
            None if cause => MonitorState::Caused,
            None => MonitorState::Open,
        };
    }

    fn violate(&mut self, at: Nanos, how: &str) {
        let why = format!("`{}` {how}", self.property.text);
        self.state = MonitorState::Violated { at, why };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds one or two expressions, an instant each second, and returns when the property is violated, s.
    fn violated(kind: PropertyKind, from: Nanos, instants: &[[Option<f64>; 2]]) -> Option<u64> {
        let mut monitor = Monitor::new(&Property {
            kind,
            text: String::from("e"),
            from: from * SECOND,
        });
        for (second, values) in instants.iter().enumerate() {
            monitor.observe(second as Nanos * SECOND, values);
        }
        monitor.finish(instants.len() as Nanos * SECOND);
        monitor.violation().map(|(at, _)| at / SECOND)
    }

    const SECOND: Nanos = 1_000_000_000;

    /// `-` is no value, `0` and `1` are values; one row for each expression.
    fn rows(a: &str, b: &str) -> Vec<[Option<f64>; 2]> {
        let value = |letter: char| letter.to_digit(10).map(f64::from);
        a.chars()
            .zip(b.chars())
            .map(|(a, b)| [value(a), value(b)])
            .collect()
    }

    #[test]
    fn always_begins_with_the_first_value() {
        let always = |row: &str| violated(PropertyKind::Always(0), 0, &rows(row, row));
        assert_eq!(always("--111"), None);
        assert_eq!(always("--101"), Some(3));
        assert_eq!(always("11-11"), Some(2), "a value that is lost is not true");
        assert_eq!(always("----"), None, "it never had a value");
    }

    #[test]
    fn never_and_eventually_are_opposites_where_there_are_values() {
        for row in ["000", "010", "1--", "---"] {
            let never = violated(PropertyKind::Never(0), 0, &rows(row, row));
            let eventually = violated(PropertyKind::Eventually(0), 0, &rows(row, row));
            assert_eq!(never.is_none(), eventually.is_some(), "{row}");
        }
        assert_eq!(
            violated(PropertyKind::Never(0), 0, &rows("0100", "0000")),
            Some(1)
        );
        assert_eq!(
            violated(PropertyKind::Eventually(0), 0, &rows("000", "000")),
            Some(3)
        );
    }

    #[test]
    fn nothing_counts_before_from() {
        assert_eq!(violated(PropertyKind::Never(0), 2, &rows("1100", "0000")), None);
        assert_eq!(
            violated(PropertyKind::Never(0), 2, &rows("1110", "0000")),
            Some(2)
        );
    }

    #[test]
    fn within_demands_the_effect_after_each_rise_of_the_cause() {
        let within = |of: &str, holds: &str| {
            let kind = PropertyKind::Within {
                time: 2 * SECOND,
                of: 0,
                holds: 1,
            };
            violated(kind, 0, &rows(of, holds))
        };
        assert_eq!(within("0111000", "0001000"), None);
        assert_eq!(within("0100000", "0100000"), None, "at the same instant");
        assert_eq!(within("0100000", "0001000"), None, "at the last moment");
        assert_eq!(within("0100000", "0000100"), Some(3), "too late");
        assert_eq!(
            within("0101000", "0010000"),
            Some(5),
            "each rise has an effect of its own"
        );
        assert_eq!(within("0111111", "0010000"), None, "no new rise");
        assert_eq!(within("000001", "000000"), None, "not due before the end");
    }

    #[test]
    fn until_demands_the_obligation_before_and_the_end_of_it() {
        let until = |until: &str, holds: &str| {
            violated(PropertyKind::Until { until: 0, holds: 1 }, 0, &rows(until, holds))
        };
        assert_eq!(until("0010", "1100"), None);
        assert_eq!(until("0010", "1000"), Some(1));
        assert_eq!(until("0000", "1111"), Some(4), "the end never came");
        assert_eq!(until("1000", "0000"), None);
    }
}
