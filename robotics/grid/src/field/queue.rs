//! Cells by price, in buckets of nearly equal ones (Dial, "Algorithm 360: shortest-path forest with topological
//! ordering", 1969). Within a bucket the order is arbitrary: a cell may then be propagated again, and the result
//! is the same (Yatziv, Bartesaghi and Sapiro, "O(N) implementation of the fast marching algorithm", 2006).

/// Prices of a bucket, as a power of two: one step through the cheapest cell. In wider ones too many cells are
/// propagated again, and in narrower ones too many are entered again when their price falls.
const SHIFT: u32 = 8;
/// The buckets of the ring. A wave adds less than the greatest price of a cell, so that its cells are in the ring.
const RING: u32 = 2 * (u16::MAX as u32 >> SHIFT) + 2;

/// Cells to propagate. It does not know their prices, only the buckets.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// The buckets from `current` on, at their number modulo the size.
    ring: Vec<Vec<u32>>,
    /// The bucket that is taken from. None below has an entry in the ring.
    current: u32,
    /// Entries in the ring.
    count: usize,
    /// Entries outside the ring, with their buckets, and the least of these.
    far: Vec<(u32, u32)>,
    nearest_far: u32,
}

/// The bucket of a price.
pub(super) const fn bucket(price: u32) -> u32 {
    price >> SHIFT
}

impl Default for Queue {
    fn default() -> Self {
        Self {
            ring: vec![Vec::new(); RING as usize],
            current: 0,
            count: 0,
            far: Vec::new(),
            nearest_far: u32::MAX,
        }
    }
}

impl Queue {
    /// Adds a cell to a bucket.
    #[inline]
    pub(super) fn push(&mut self, bucket: u32, cell: u32) {
        if bucket.wrapping_sub(self.current) < RING {
            self.ring[(bucket % RING) as usize].push(cell);
            self.count += 1;
        } else {
            self.far.push((bucket, cell));
            self.nearest_far = self.nearest_far.min(bucket);
        }
    }

    /// The first bucket that has an entry; `None` if there is none.
    #[inline]
    pub(super) fn first(&mut self) -> Option<u32> {
        loop {
            if self.nearest_far <= self.current || self.count == 0 {
                self.gather()?;
            }
            if !self.ring[(self.current % RING) as usize].is_empty() {
                return Some(self.current);
            }
            self.current += 1;
        }
    }

    /// Takes an entry of the bucket that [`Queue::first`] returned.
    #[inline]
    pub(super) fn take(&mut self) -> Option<u32> {
        let cell = self.ring[(self.current % RING) as usize].pop();
        self.count -= usize::from(cell.is_some());
        cell
    }

    /// Moves the ring to where the first entries are; `None` if there are none.
    fn gather(&mut self) -> Option<()> {
        if self.nearest_far < self.current || self.count == 0 {
            for bucket in self.current..self.current.saturating_add(RING) {
                let cells = self.ring[(bucket % RING) as usize].drain(..);
                self.far.extend(cells.map(|cell| (bucket, cell)));
            }
            self.count = 0;
            self.current = self.far.iter().map(|&(bucket, _)| bucket).min()?;
        }
        self.nearest_far = u32::MAX;
        let mut far = core::mem::take(&mut self.far);
        far.retain(|&(bucket, cell)| {
            let stays = bucket - self.current >= RING;
            if stays {
                self.nearest_far = self.nearest_far.min(bucket);
            } else {
                self.ring[(bucket % RING) as usize].push(cell);
                self.count += 1;
            }
            stays
        });
        self.far = far;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_first_bucket_comes_first_even_if_lower_ones_follow(
            buckets in prop::collection::vec(
                prop::option::of(prop_oneof![0u32..9, 0..3 * RING, 0..=bucket(u32::MAX)]), 1..300,
            ),
        ) {
            let mut queue = Queue::default();
            let mut expected = BTreeMap::<u32, u32>::new();
            for bucket in buckets {
                if let Some(bucket) = bucket {
                    queue.push(bucket, bucket / 2);
                    *expected.entry(bucket).or_default() += 1;
                    continue;
                }
                let first = expected.first_key_value().map(|(&bucket, _)| bucket);
                prop_assert_eq!(queue.first(), first);
                if let Some(bucket) = first {
                    prop_assert_eq!(queue.take(), Some(bucket / 2));
                    let left = expected.get_mut(&bucket).expect("counted");
                    *left -= 1;
                    if *left == 0 {
                        expected.remove(&bucket);
                    }
                }
            }
        }
    }
}
