//! A value over time: the states of a schema, the winners of a group. It is a list of intervals, each of which ends where
//! the next begins, so that they neither overlap nor leave a gap.

use std::collections::VecDeque;

use jde_core::{Nanos, State};

/// A value from a time on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval<T> {
    /// When it began, ns since the application's start.
    pub from: Nanos,
    /// The value since then.
    pub value: T,
}

/// An interval of a schema that has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The schema.
    pub schema: usize,
    /// Its state.
    pub state: State,
    /// From when, ns.
    pub from: Nanos,
    /// Until when, ns.
    pub to: Nanos,
}

impl<T> Interval<T> {
    /// When it began, s since the application's start.
    #[must_use]
    pub fn from_s(&self) -> f64 {
        self.from as f64 / 1e9
    }
}

/// The intervals of a value, oldest first. The last one lasts until now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Track<T> {
    intervals: VecDeque<Interval<T>>,
    most: usize,
}

impl<T: Copy + PartialEq> Track<T> {
    /// Creates a track without a value that keeps the newest `most` intervals; at least one.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self {
            intervals: VecDeque::new(),
            most: most.max(1),
        }
    }

    /// Returns the number of intervals.
    #[must_use]
    pub fn len(&self) -> usize {
        self.intervals.len()
    }

    /// Returns whether no value is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.intervals.is_empty()
    }

    /// Returns an interval by its place.
    #[must_use]
    pub fn get(&self, place: usize) -> Option<Interval<T>> {
        self.intervals.get(place).copied()
    }

    /// Returns the present interval.
    #[must_use]
    pub fn last(&self) -> Option<Interval<T>> {
        self.intervals.back().copied()
    }

    /// Returns the intervals, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = Interval<T>> + ExactSizeIterator {
        self.intervals.iter().copied()
    }

    /// Returns the interval at a time, s; `None` before the first.
    #[must_use]
    pub fn at_s(&self, time_s: f64) -> Option<(Interval<T>, Option<Interval<T>>)> {
        let place = self
            .intervals
            .partition_point(|interval| interval.from_s() <= time_s);
        let place = place.checked_sub(1)?;
        Some((self.intervals[place], self.get(place + 1)))
    }

    /// Returns the number of the first intervals for which a condition holds. It holds for none after one for which it does
    /// not hold.
    #[must_use]
    pub fn partition_point(&self, holds: impl Fn(Interval<T>) -> bool) -> usize {
        self.intervals.partition_point(|interval| holds(*interval))
    }

    /// Returns the last `count` slices of `slice` ns until now, oldest first: the greatest level of a value in each, so that
    /// a value that was shorter than a slice is visible; `None` where no value is known.
    ///
    /// Slices begin at whole multiples of their length, so that past slices do not change while time advances.
    #[must_use]
    pub fn slices<L: Copy + Ord>(
        &self,
        now: Nanos,
        slice: Nanos,
        count: usize,
        level: impl Fn(T) -> L,
    ) -> Vec<Option<L>> {
        let mut slices = vec![None; count];
        let slice = slice.max(1);
        let first = (now / slice + 1).saturating_sub(count as u64);
        let offset = count as u64 - (now / slice + 1 - first);
        let mut end = now + 1;
        for interval in self.intervals.iter().rev() {
            if end <= first * slice {
                break;
            }
            if interval.from < end {
                for index in (interval.from / slice).max(first)..=(end - 1) / slice {
                    let entry = &mut slices[(index - first + offset) as usize];
                    *entry = (*entry).max(Some(level(interval.value)));
                }
            }
            end = interval.from;
        }
        slices
    }

    /// Begins an interval, unless the value is the present one. Of two values of one instant the last is kept. A time
    /// before the present interval counts as its beginning.
    ///
    /// Returns the interval that ended and is kept no more, with its end.
    pub(crate) fn set(&mut self, from: Nanos, value: T) -> Option<(Interval<T>, Nanos)> {
        match self.intervals.back_mut() {
            Some(last) if last.value == value => return None,
            Some(last) if last.from >= from => {
                last.value = value;
                let place = self.intervals.len().checked_sub(2);
                // The interval before may have this value already.
                if place.is_some_and(|place| self.intervals[place].value == value) {
                    self.intervals.pop_back();
                }
                return None;
            }
            Some(_) | None => {}
        }
        self.intervals.push_back(Interval { from, value });
        if self.intervals.len() <= self.most {
            return None;
        }
        let oldest = self.intervals.pop_front()?;
        Some((oldest, self.intervals.front()?.from))
    }

    /// Removes the intervals that begin after a time.
    pub(crate) fn rewind(&mut self, now: Nanos) {
        while self.intervals.pop_back_if(|last| last.from > now).is_some() {}
    }
}

impl<T: Copy + PartialEq> FromIterator<(Nanos, T)> for Track<T> {
    fn from_iter<I: IntoIterator<Item = (Nanos, T)>>(values: I) -> Self {
        let mut track = Self::new(usize::MAX);
        for (from, value) in values {
            track.set(from, value);
        }
        track
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    fn slices(values: &[(Nanos, u8)], now: Nanos, count: usize) -> Vec<Option<u8>> {
        let mut track = Track::new(100);
        for (time, value) in values {
            track.set(time * MS, *value);
        }
        track.slices(now * MS, 100 * MS, count, |value| value)
    }

    #[test]
    fn a_slice_shows_the_greatest_value_in_it() {
        assert_eq!(slices(&[(450, 1)], 450, 3), [None, None, Some(1)]);
        let lasting = slices(&[(0, 0), (210, 2), (399, 2)], 399, 4);
        assert_eq!(lasting, [Some(0), Some(0), Some(2), Some(2)]);
        let short = slices(&[(0, 1), (130, 3), (150, 1)], 250, 3);
        assert_eq!(short, [Some(1), Some(3), Some(1)]);
        assert_eq!(slices(&[(0, 3), (100, 0)], 150, 2), [Some(3), Some(0)]);
        assert_eq!(slices(&[(0, 3), (1000, 0)], 1199, 3), [Some(3), Some(0), Some(0)]);
        assert_eq!(slices(&[], 100, 2), [None, None]);
    }

    #[test]
    fn of_two_values_of_one_instant_the_last_is_kept() {
        let mut track = Track::new(100);
        for (time, value) in [(0, 1), (5, 2), (5, 1), (9, 3), (9, 4)] {
            track.set(time, value);
        }
        let intervals: Vec<_> = track
            .iter()
            .map(|interval| (interval.from, interval.value))
            .collect();
        assert_eq!(intervals, [(0, 1), (9, 4)]);
        assert_eq!(track.at_s(1e-9).map(|(interval, _)| interval.value), Some(1));
    }
}
