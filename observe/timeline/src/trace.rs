//! A number over time, while it is watched: its newest values. Each holds until the next.

use std::collections::VecDeque;

/// The newest values of a number, each with its time, s, in the order of their times. A value that is not finite is a gap.
#[derive(Clone, Debug)]
pub struct Trace {
    values: VecDeque<(f64, f64)>,
    most: usize,
}

impl Trace {
    /// Creates a trace without a value that keeps at most so many.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self {
            values: VecDeque::new(),
            most: most.max(1),
        }
    }

    /// Adds a value. Values of its time or later are removed first: time went back.
    pub fn add(&mut self, time: f64, value: f64) {
        while self.values.pop_back_if(|last| last.0 >= time).is_some() {}
        if self.values.len() == self.most {
            self.values.pop_front();
        }
        self.values.push_back((time, value));
    }

    /// Removes all values.
    pub fn clear(&mut self) {
        self.values.clear();
    }

    /// Returns the value in force at a time; `None` in a gap.
    #[must_use]
    pub fn at(&self, time: f64) -> Option<f64> {
        let after = self.values.partition_point(|value| value.0 <= time);
        let (_, value) = self.values.get(after.checked_sub(1)?)?;
        value.is_finite().then_some(*value)
    }

    /// Returns the values from the one in force at a time until another time.
    pub fn between(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
        let first = self.values.partition_point(|value| value.0 <= from);
        let values = self.values.range(first.saturating_sub(1)..).copied();
        values.take_while(move |(time, _)| *time <= to)
    }
}

/// Returns the least and the greatest of the finite values; `None` without any.
pub fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let values = values.filter(|value| value.is_finite());
    values
        .map(|value| (value, value))
        .reduce(|(least, greatest), (value, _)| (least.min(value), greatest.max(value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_holds_until_the_next_one_and_a_jump_back_in_time_removes_later_values() {
        let mut trace = Trace::new(3);
        for (time, value) in [(1.0, 10.0), (2.0, 20.0), (3.0, 30.0)] {
            trace.add(time, value);
        }
        assert_eq!(
            [0.5, 1.0, 2.9, 9.0].map(|time| trace.at(time)),
            [None, Some(10.0), Some(20.0), Some(30.0)]
        );
        trace.add(1.5, 15.0);
        assert_eq!(trace.at(9.0), Some(15.0));
        trace.add(4.0, f64::NAN);
        assert_eq!((trace.at(5.0), trace.at(3.0)), (None, Some(15.0)));
        trace.add(5.0, 50.0);
        assert_eq!(trace.at(1.0), None, "it keeps the newest three");
        let shown: Vec<_> = trace.between(3.0, 4.5).map(|(time, _)| time).collect();
        assert_eq!(shown, [1.5, 4.0]);
        assert_eq!(
            range(trace.between(0.0, 9.0).map(|(_, value)| value)),
            Some((15.0, 50.0))
        );
    }
}
