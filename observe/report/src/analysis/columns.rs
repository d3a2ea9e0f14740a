//! Time divided into columns, so that the memory for a recording is bounded by what a picture can show.

use jde_core::Nanos;

/// A time range, divided into columns of the same width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Columns {
    /// The beginning.
    pub(crate) from: Nanos,
    /// The end; later than the beginning.
    pub(crate) to: Nanos,
    /// The number of columns; not 0.
    pub(crate) count: usize,
}

impl Columns {
    /// A range of at least a microsecond, since a single instant has no columns.
    pub(crate) fn new(from: Nanos, to: Nanos, count: usize) -> Self {
        Self {
            from,
            to: to.max(from.saturating_add(1000)),
            count: count.max(1),
        }
    }

    /// The length, s.
    pub(crate) fn seconds(self) -> f64 {
        (self.to - self.from) as f64 / 1e9
    }

    /// Whether a time is within the range.
    pub(crate) fn has(self, time: Nanos) -> bool {
        (self.from..=self.to).contains(&time)
    }

    /// The position of a time in columns, clamped to the range.
    pub(crate) fn place(self, time: Nanos) -> f64 {
        let since = time.clamp(self.from, self.to) - self.from;
        since as f64 / (self.to - self.from) as f64 * self.count as f64
    }

    /// The column of a time; the first or the last for times outside of the range.
    pub(crate) fn column(self, time: Nanos) -> usize {
        (self.place(time) as usize).min(self.count - 1)
    }

    /// Each column that a time range overlaps, with the share of the column that it covers.
    pub(crate) fn covered(self, from: Nanos, to: Nanos) -> impl Iterator<Item = (usize, f64)> {
        let (begin, end) = (self.place(from), self.place(to));
        let last = (end.ceil() as usize).min(self.count);
        (begin as usize..last).filter_map(move |column| {
            let share = end.min((column + 1) as f64) - begin.max(column as f64);
            (share > 0.0).then_some((column, share))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_range_covers_its_columns_and_parts_of_those_at_its_ends() {
        let columns = Columns::new(1000, 11_000, 10);
        let covered: Vec<_> = columns.covered(2500, 5000).collect();
        assert_eq!(covered, [(1, 0.5), (2, 1.0), (3, 1.0)]);
        assert_eq!(columns.covered(0, 1000).count(), 0);
        assert_eq!(columns.covered(10_500, 99_000).collect::<Vec<_>>(), [(9, 0.5)]);
    }

    #[test]
    fn every_time_has_a_column() {
        let columns = Columns::new(500, 500, 0);
        assert_eq!(
            (columns.column(0), columns.column(u64::MAX), columns.count),
            (0, 0, 1)
        );
        let columns = Columns::new(0, 1_000_000, 4);
        assert_eq!(
            [0, 250_000, 999_999, 1_000_000].map(|time| columns.column(time)),
            [0, 1, 3, 3]
        );
    }
}
