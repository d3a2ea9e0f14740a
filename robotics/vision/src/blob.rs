//! Connected components of pixels, built from runs. Adjacent pixels of a row form one run. Runs of
//! neighbouring rows that touch, also at a corner, form one component. It does not depend on colours or
//! distances.
//!
//! It takes one pass over the pixels and one over the runs, so that a picture of pure noise costs little more
//! than one of few components.

use core::ops::Range;

/// Finds components, and reuses its buffers from picture to picture.
#[derive(Debug, Default)]
pub struct Blobs {
    runs: Vec<PixelRun>,
    components: Vec<Component>,
}

/// Adjacent pixels of one row.
#[derive(Clone, Copy, Debug)]
pub struct PixelRun {
    /// The row.
    pub row: usize,
    /// The first column, and the one after the last.
    pub columns: [usize; 2],
    /// Index of an earlier run of the same component, or of this run if it is the first.
    parent: usize,
}

/// The size of a component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Component {
    /// Number of pixels.
    pub count: usize,
    /// The first column and the one after the last.
    pub columns: [usize; 2],
    /// The first row and the one after the last.
    pub rows: [usize; 2],
}

impl Component {
    /// The share that it fills of the disc of its larger side: 1 for a ball, 0.5 for half of one, less for
    /// long, hollow or irregular components.
    #[must_use]
    pub fn roundness(&self) -> f64 {
        let side = (self.columns[1] - self.columns[0]).max(self.rows[1] - self.rows[0]) as f64;
        self.count as f64 / (core::f64::consts::FRAC_PI_4 * side * side)
    }

    fn add(&mut self, run: &PixelRun) {
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
    /// Finds the components of a picture of some columns and rows. `selected` chooses the pixels by row and
    /// column.
    pub fn find(&mut self, [width, height]: [usize; 2], selected: impl Fn(usize, usize) -> bool) {
        self.runs.clear();
        // Index of the first run of the row above.
        let mut begin = 0;
        for row in 0..height {
            let mut above = begin..self.runs.len();
            begin = above.end;
            let mut column = 0;
            while column < width {
                if !selected(row, column) {
                    column += 1;
                    continue;
                }
                let from = column;
                while column < width && selected(row, column) {
                    column += 1;
                }
                self.add(row, [from, column], &mut above);
            }
        }
        self.components.clear();
        self.components.resize(self.runs.len(), Component::default());
        for index in 0..self.runs.len() {
            // The parent is an earlier run, so its own parent is already the root.
            let root = self.runs[self.runs[index].parent].parent;
            self.runs[index].parent = root;
            self.components[root].add(&self.runs[index]);
        }
    }

    /// Returns the components that were found, each with its number.
    pub fn components(&self) -> impl Iterator<Item = (usize, &Component)> {
        let components = self.components.iter().enumerate();
        components.filter(|(_, component)| component.count > 0)
    }

    /// Returns the runs of a component, by its number.
    pub fn runs(&self, number: usize) -> impl Iterator<Item = &PixelRun> {
        self.runs.iter().filter(move |run| run.parent == number)
    }

    /// Finds the largest component for which `accept` returns true, and returns it with its runs.
    pub fn largest(
        &mut self,
        size: [usize; 2],
        selected: impl Fn(usize, usize) -> bool,
        accept: impl Fn(&Component) -> bool,
    ) -> Option<(Component, impl Iterator<Item = &PixelRun>)> {
        self.find(size, selected);
        let accepted = self.components().filter(|(_, component)| accept(component));
        let (number, component) = accepted.max_by_key(|(_, component)| component.count)?;
        Some((*component, self.runs(number)))
    }

    /// Adds a run to the right of the others in its row, and joins it with the runs of the row above that
    /// touch it. Removes from `above` the runs that no later run of this row can touch.
    fn add(&mut self, row: usize, columns: [usize; 2], above: &mut Range<usize>) {
        let new = self.runs.len();
        self.runs.push(PixelRun {
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
            let (root, new_root) = (self.root(other), self.root(new));
            // The earlier run becomes the root, so that every chain ends.
            self.runs[root.max(new_root)].parent = root.min(new_root);
        }
    }

    /// Returns the first run of a run's component. Shortens the chain on its way.
    fn root(&mut self, mut run: usize) -> usize {
        while self.runs[run].parent != run {
            let parent = self.runs[run].parent;
            self.runs[run].parent = self.runs[parent].parent;
            run = parent;
        }
        run
    }
}
