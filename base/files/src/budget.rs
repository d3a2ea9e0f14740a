//! What a reader of one file may take: memory, work and depth. It counts sums, so that many small things cost as much
//! as one large thing.

/// What a reader takes beyond is an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Exceeded {
    /// The values of the file would hold more memory.
    #[error("what it holds needs more than {} MiB of memory", .0 >> 20)]
    Bytes(u64),
    /// Its reader would do more work.
    #[error("reading it needs more than {0} steps")]
    Steps(u64),
    /// Its parts contain each other more deeply.
    #[error("its parts contain each other more than {0} levels deep")]
    Depth(usize),
}

/// The limits of a reader of one file, and what it has taken until now.
///
/// Each reader takes from it before it allocates, repeats or descends. One budget serves a file and all files that it
/// includes.
#[derive(Clone, Debug)]
pub struct Budget {
    bytes: u64,
    steps: u64,
    depth: usize,
    most_bytes: u64,
    most_steps: u64,
    most_depth: usize,
}

impl Default for Budget {
    /// 256 MiB, fifty million steps (seconds, not minutes, at up to 100 ns each), and 64 levels, which fit the stack of any
    /// thread.
    fn default() -> Self {
        Self::new(256 << 20, 50_000_000, 64)
    }
}

impl Budget {
    /// Returns a budget of which nothing is taken.
    #[must_use]
    pub const fn new(most_bytes: u64, most_steps: u64, most_depth: usize) -> Self {
        Self {
            bytes: 0,
            steps: 0,
            depth: 0,
            most_bytes,
            most_steps,
            most_depth,
        }
    }

    /// Takes memory, bytes. It is never given back.
    ///
    /// # Errors
    /// All that was taken exceeds the limit. The reader ends then; what it would have allocated was not counted.
    pub const fn hold(&mut self, bytes: usize) -> Result<(), Exceeded> {
        let bytes = self.bytes.saturating_add(bytes as u64);
        if bytes > self.most_bytes {
            return Err(Exceeded::Bytes(self.most_bytes));
        }
        self.bytes = bytes;
        Ok(())
    }

    /// Takes work: elements visited, lines expanded, cells drawn.
    ///
    /// # Errors
    /// All work exceeds the limit.
    pub const fn work(&mut self, steps: usize) -> Result<(), Exceeded> {
        let steps = self.steps.saturating_add(steps as u64);
        if steps > self.most_steps {
            return Err(Exceeded::Steps(self.most_steps));
        }
        self.steps = steps;
        Ok(())
    }

    /// Reads a part that is contained in the present one.
    ///
    /// # Errors
    /// The part is too deep, or what `read` returns.
    pub fn descend<T, E: From<Exceeded>>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, E>,
    ) -> Result<T, E> {
        if self.depth >= self.most_depth {
            return Err(Exceeded::Depth(self.most_depth).into());
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_limited_and_not_only_single_sizes() {
        let mut budget = Budget::new(100, 3, 2);
        assert_eq!(budget.hold(60), Ok(()));
        assert_eq!(budget.hold(60), Err(Exceeded::Bytes(100)));
        assert_eq!(budget.hold(40), Ok(()));
        assert_eq!(budget.hold(usize::MAX), Err(Exceeded::Bytes(100)));
        assert_eq!(budget.work(2), Ok(()));
        assert_eq!(budget.work(2), Err(Exceeded::Steps(3)));
    }

    #[test]
    fn depth_counts_what_contains_and_not_what_follows() {
        fn nested(budget: &mut Budget, levels: usize) -> Result<(), Exceeded> {
            match levels {
                0 => Ok(()),
                _ => budget.descend(|budget| nested(budget, levels - 1)),
            }
        }
        let mut budget = Budget::new(0, 0, 2);
        assert_eq!(nested(&mut budget, 2), Ok(()));
        assert_eq!(nested(&mut budget, 2), Ok(()));
        assert_eq!(nested(&mut budget, 20_000), Err(Exceeded::Depth(2)));
        assert_eq!(nested(&mut budget, 2), Ok(()));
    }
}
