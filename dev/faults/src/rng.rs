//! Reproducible pseudorandom numbers, which choose the faults, their schemas and times.

/// SplitMix64 (Steele, Lea and Flood, 2014): small, and sufficient to choose faults.
#[derive(Clone, Debug)]
pub struct Rng {
    state: u64,
}

impl Rng {
    /// The generator for a seed and a purpose.
    #[must_use]
    pub fn new(seed: u64, purpose: &str) -> Self {
        // FNV-1a gives the same number for the same text on every machine.
        let mixed = purpose.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        let mut rng = Self { state: seed ^ mixed };
        rng.next_u64();
        rng
    }

    /// The next number.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from `least` to `most`, both included.
    pub fn between(&mut self, least: u64, most: u64) -> u64 {
        least + self.next_u64() % (most - least + 1)
    }

    /// `true` with a probability of one in `times`.
    pub fn one_in(&mut self, times: u64) -> bool {
        self.next_u64().is_multiple_of(times)
    }

    /// One of the elements.
    ///
    /// # Panics
    /// If `all` is empty.
    pub fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.next_u64() as usize % all.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::Rng;

    #[test]
    fn equal_seeds_and_purposes_give_equal_numbers() {
        let first = |seed, purpose| Rng::new(seed, purpose).next_u64();
        assert_eq!(first(1, "a"), first(1, "a"));
        assert_ne!(first(1, "a"), first(1, "b"));
        assert_ne!(first(1, "a"), first(2, "a"));
    }

    #[test]
    fn both_ends_of_a_range_occur() {
        let mut rng = Rng::new(1, "ends");
        let numbers: std::collections::BTreeSet<_> = (0..100).map(|_| rng.between(3, 5)).collect();
        assert_eq!(numbers.into_iter().collect::<Vec<_>>(), [3, 4, 5]);
    }
}
