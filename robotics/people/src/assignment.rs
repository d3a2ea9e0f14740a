//! The assignment of rows to columns with the least sum of costs: the Hungarian algorithm with potentials, in time by
//! the square of the rows times the columns (Kuhn, 1955; Jonker and Volgenant, 1987).

/// Solves assignments; it keeps its memory from one to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assignment {
    /// The potentials of rows and columns; the first of each belongs to none.
    rows: Vec<f64>,
    columns: Vec<f64>,
    /// The row of each column, from 1; 0 for none.
    row_of: Vec<usize>,
    /// The column before each on the shortest path.
    before: Vec<usize>,
    least: Vec<f64>,
    is_used: Vec<bool>,
}

impl Assignment {
    /// Assigns each row a column of its own, and calls `assigned` with both. There must be at least as many columns as
    /// rows, and the costs must be finite.
    pub(crate) fn solve(
        &mut self,
        (rows, columns): (usize, usize),
        cost: impl Fn(usize, usize) -> f64,
        mut assigned: impl FnMut(usize, usize),
    ) {
        debug_assert!(rows <= columns, "{rows} rows, {columns} columns");
        reset(&mut self.rows, rows, 0.0);
        reset(&mut self.columns, columns, 0.0);
        reset(&mut self.row_of, columns, 0);
        reset(&mut self.before, columns, 0);
        for row in 1..=rows {
            self.add(row, columns, &cost);
        }
        for (column, &row) in self.row_of.iter().enumerate().skip(1) {
            if row > 0 {
                assigned(row - 1, column - 1);
            }
        }
    }

    /// Adds a row along the shortest path to a free column.
    fn add(&mut self, row: usize, columns: usize, cost: &impl Fn(usize, usize) -> f64) {
        reset(&mut self.least, columns, f64::INFINITY);
        reset(&mut self.is_used, columns, false);
        self.row_of[0] = row;
        let mut column = 0;
        while self.row_of[column] != 0 {
            self.is_used[column] = true;
            let row = self.row_of[column];
            let (mut step, mut next) = (f64::INFINITY, 0);
            for other in (1..=columns).filter(|&other| !self.is_used[other]) {
                let reduced = cost(row - 1, other - 1) - self.rows[row] - self.columns[other];
                if reduced < self.least[other] {
                    (self.least[other], self.before[other]) = (reduced, column);
                }
                if self.least[other] < step {
                    (step, next) = (self.least[other], other);
                }
            }
            for other in 0..=columns {
                if self.is_used[other] {
                    self.rows[self.row_of[other]] += step;
                    self.columns[other] -= step;
                } else {
                    self.least[other] -= step;
                }
            }
            column = next;
        }
        while column != 0 {
            let before = self.before[column];
            self.row_of[column] = self.row_of[before];
            column = before;
        }
    }
}

/// Makes a list of `count` values and one before them.
fn reset<T: Clone>(list: &mut Vec<T>, count: usize, value: T) {
    list.clear();
    list.resize(count + 1, value);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The least sum, by all assignments.
    fn least(costs: &[Vec<f64>], row: usize, used: &mut Vec<usize>) -> f64 {
        let Some(own) = costs.get(row) else { return 0.0 };
        let mut best = f64::INFINITY;
        for (column, cost) in own.iter().enumerate() {
            if !used.contains(&column) {
                used.push(column);
                best = best.min(cost + least(costs, row + 1, used));
                used.pop();
            }
        }
        best
    }

    proptest! {
        #[test]
        fn no_other_assignment_costs_less(
            rows in 0_usize..5,
            more in 0_usize..3,
            numbers in proptest::collection::vec(-5.0..50.0_f64, 35),
        ) {
            let columns = rows + more;
            let costs: Vec<Vec<f64>> = (0..rows).map(|row| numbers[row * columns..(row + 1) * columns].to_vec()).collect();
            let mut assignment = Assignment::default();
            // What an assignment before leaves behind does no harm.
            assignment.solve((2, 3), |row, column| (row * column) as f64, |_, _| {});
            let (mut sum, mut taken) = (0.0, Vec::new());
            assignment.solve((rows, columns), |row, column| costs[row][column], |row, column| {
                sum += costs[row][column];
                taken.push((row, column));
            });
            prop_assert_eq!(taken.len(), rows);
            for (index, (row, column)) in taken.iter().enumerate() {
                prop_assert!(taken[..index].iter().all(|other| other.0 != *row && other.1 != *column));
            }
            prop_assert!((sum - least(&costs, 0, &mut Vec::new())).abs() < 1e-9);
        }
    }
}
