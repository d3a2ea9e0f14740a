//! Connected masses of pixels, by runs: the pixels of a row that touch one another are one run, and runs of neighbouring rows
//! that touch, also by a corner, are one mass. It knows no colours and no distances.
//!
//! One pass over the pixels, then one over the runs: a picture that is all noise costs little more than one of few masses.

use core::ops::Range;

/// Finds masses, and keeps its memory from picture to picture.
#[derive(Debug, Default)]
pub(crate) struct Blobs {
    runs: Vec<Run>,
    masses: Vec<Mass>,
}

/// Pixels of one row that touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) row: usize,
    /// The first column, and the one after the last.
    pub(crate) columns: [usize; 2],
    /// An earlier run of the same mass, or this one.
    parent: usize,
}

/// How large a mass is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mass {
    /// Pixels.
    pub(crate) count: usize,
    /// First column and the one after the last, first row and the one after the last.
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Mass {
    /// How much it fills of the disc that is as wide or high as it is: 1 for a ball, 0.5 for half of one, less for what is long,
    /// hollow or ragged.
    pub(crate) fn roundness(&self) -> f64 {
        let side = (self.columns[1] - self.columns[0]).max(self.rows[1] - self.rows[0]) as f64;
        self.count as f64 / (core::f64::consts::FRAC_PI_4 * side * side)
    }

    fn add(&mut self, run: &Run) {
        let [from, to] = run.columns;
        if self.count == 0 {
            *self = Self {
                count: to - from,
                columns: run.columns,
                rows: [run.row, run.row + 1],
            };
            return;
        }
        self.count += to - from;
        self.columns = [self.columns[0].min(from), self.columns[1].max(to)];
        self.rows[1] = run.row + 1;
    }
}

impl Blobs {
    /// The runs of the largest mass among those that are `good`, in a picture of rows of `width` pixels, of which `wanted` says
    /// by row and column which count.
    pub(crate) fn largest(
        &mut self,
        [width, height]: [usize; 2],
        wanted: impl Fn(usize, usize) -> bool,
        good: impl Fn(&Mass) -> bool,
    ) -> Option<(Mass, impl Iterator<Item = &Run>)> {
        self.runs.clear();
        // Where the runs of the row above begin.
        let mut begin = 0;
        for row in 0..height {
            let mut above = begin..self.runs.len();
            begin = above.end;
            let mut column = 0;
            while column < width {
                if !wanted(row, column) {
                    column += 1;
                    continue;
                }
                let from = column;
                while column < width && wanted(row, column) {
                    column += 1;
                }
                self.add(row, [from, column], &mut above);
            }
        }
        self.masses.clear();
        self.masses.resize(self.runs.len(), Mass::default());
        for index in 0..self.runs.len() {
            // The parent is an earlier run, so that it is, or has by now, the root itself.
            let root = self.runs[self.runs[index].parent].parent;
            self.runs[index].parent = root;
            self.masses[root].add(&self.runs[index]);
        }
        let masses = self.masses.iter().enumerate();
        let (best, mass) = masses
            .filter(|(_, mass)| mass.count > 0 && good(mass))
            .max_by_key(|(_, mass)| mass.count)?;
        Some((*mass, self.runs.iter().filter(move |run| run.parent == best)))
    }

    /// Adds a run to the right of those before it, and joins it with those of the row above that touch it; drops those of
    /// `above` that no later one can touch.
    fn add(&mut self, row: usize, columns: [usize; 2], above: &mut Range<usize>) {
        let new = self.runs.len();
        self.runs.push(Run {
            row,
            columns,
            parent: new,
        });
        above.start += self.runs[above.clone()]
            .iter()
            .take_while(|run| run.columns[1] < columns[0])
            .count();
        for other in above.clone() {
            if self.runs[other].columns[0] > columns[1] {
                break;
            }
            let (one, two) = (self.root(other), self.root(new));
            // The earlier is the root, so that every chain ends.
            self.runs[one.max(two)].parent = one.min(two);
        }
    }

    /// The first run of the mass that a run belongs to; makes the way there shorter.
    fn root(&mut self, mut run: usize) -> usize {
        while self.runs[run].parent != run {
            let parent = self.runs[run].parent;
            self.runs[run].parent = self.runs[parent].parent;
            run = parent;
        }
        run
    }
}
