//! A number over time: for each column the least and greatest value, and those at both ends. Like a shared
//! variable, a trace holds its value until the next. Where there is no value, it has a gap.

use jde_core::Nanos;
use jde_log::DecodeError;

use super::columns::Columns;

/// A number in a recording over time.
pub struct Series {
    /// The topic whose messages contain it.
    pub topic: String,
    /// The variable that contains it.
    pub variable: String,
    /// Its displayed name.
    pub name: String,
    /// Its unit; empty if there is none.
    pub unit: String,
    /// Extracts it from a message; returns `None` if it is absent.
    pub number: Number,
}

/// Extracts a number from a message. It fails if that is no value of its type.
pub type Number = Box<dyn Fn(&[u8]) -> Result<Option<f64>, DecodeError> + Send>;

/// A number over time.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    cells: Vec<Option<ColumnRange>>,
    now: Option<(f64, Nanos)>,
    /// The number of values.
    pub(crate) count: u64,
}

/// The values of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColumnRange {
    pub(crate) first: f64,
    pub(crate) least: f64,
    pub(crate) greatest: f64,
    pub(crate) last: f64,
}

impl Trace {
    pub(crate) fn new(columns: Columns) -> Self {
        Self {
            cells: vec![None; columns.count],
            now: None,
            count: 0,
        }
    }

    /// Records a value from a time on, or none.
    pub(crate) fn add(&mut self, columns: Columns, time: Nanos, value: Option<f64>) {
        let value = value.filter(|value| value.is_finite());
        self.hold(columns, time);
        if columns.has(time)
            && let Some(value) = value
        {
            self.count += 1;
            self.add_to_cell(columns.column(time), value);
        }
        self.now = value.map(|value| (value, time));
    }

    /// Extends the last value to the end.
    pub(crate) fn finish(&mut self, columns: Columns) {
        self.hold(columns, columns.to);
    }

    /// The columns.
    pub(crate) fn cells(&self) -> &[Option<ColumnRange>] {
        &self.cells
    }

    /// The least and greatest of all values; none without values.
    pub(crate) fn range(&self) -> Option<(f64, f64)> {
        let ranges = self.cells.iter().flatten();
        ranges
            .map(|cell| (cell.least, cell.greatest))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Extends the present value up to a time.
    fn hold(&mut self, columns: Columns, until: Nanos) {
        let Some((value, since)) = self.now else { return };
        if until <= columns.from || since >= columns.to {
            return;
        }
        for column in columns.column(since)..=columns.column(until) {
            self.add_to_cell(column, value);
        }
    }

    fn add_to_cell(&mut self, column: usize, value: f64) {
        let cell = self.cells[column].get_or_insert(ColumnRange {
            first: value,
            least: value,
            greatest: value,
            last: value,
        });
        cell.least = cell.least.min(value);
        cell.greatest = cell.greatest.max(value);
        cell.last = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(first: f64, least: f64, greatest: f64, last: f64) -> Option<ColumnRange> {
        Some(ColumnRange {
            first,
            least,
            greatest,
            last,
        })
    }

    #[test]
    fn a_column_keeps_the_extremes_of_all_its_values() {
        let columns = Columns::new(0, 10_000, 2);
        let mut trace = Trace::new(columns);
        for (time, value) in [(0, 1.0), (1000, 9.0), (2000, -3.0), (4000, 2.0), (9000, 4.0)] {
            trace.add(columns, time, Some(value));
        }
        trace.finish(columns);
        assert_eq!(
            trace.cells(),
            [cell(1.0, -3.0, 9.0, 2.0), cell(2.0, 2.0, 4.0, 4.0)]
        );
        assert_eq!((trace.range(), trace.count), (Some((-3.0, 9.0)), 5));
    }

    #[test]
    fn a_value_holds_until_the_next_and_a_missing_value_is_a_gap() {
        let columns = Columns::new(0, 10_000, 5);
        let mut trace = Trace::new(columns);
        trace.add(columns, 2500, Some(7.0));
        trace.add(columns, 4500, Some(f64::NAN));
        trace.add(columns, 8500, Some(1.0));
        trace.finish(columns);
        let seven = cell(7.0, 7.0, 7.0, 7.0);
        assert_eq!(
            trace.cells(),
            [None, seven, seven, None, cell(1.0, 1.0, 1.0, 1.0)]
        );
    }

    #[test]
    fn a_value_in_force_at_the_beginning_counts_and_a_later_one_than_the_end_does_not() {
        let columns = Columns::new(4000, 8000, 2);
        let mut trace = Trace::new(columns);
        trace.add(columns, 1000, Some(5.0));
        trace.add(columns, 9000, Some(6.0));
        trace.finish(columns);
        let five = cell(5.0, 5.0, 5.0, 5.0);
        assert_eq!((trace.cells(), trace.count), ([five, five].as_slice(), 0));
    }
}
