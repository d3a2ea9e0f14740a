//! Cells by price: a radix heap (Ahuja, Mehlhorn, Orlin and Tarjan, "Faster algorithms for the shortest path
//! problem", 1990). A wave takes prices that never fall, so that each entry moves down through a few buckets and
//! no comparison of entries is needed.

/// The number of buckets: one for each bit of a price, and one for the least price.
const BUCKETS: usize = u32::BITS as usize + 1;

/// Entries of a price and a cell.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// By the highest bit in which a price differs from `least`; the first has equal ones.
    buckets: [Vec<(u32, u32)>; BUCKETS],
    /// No entry has a lower price.
    least: u32,
}

impl Default for Queue {
    fn default() -> Self {
        Self {
            buckets: [const { Vec::new() }; BUCKETS],
            least: 0,
        }
    }
}

impl Queue {
    pub(super) fn push(&mut self, price: u32, cell: u32) {
        if price < self.least {
            // A change after a wave: further ones may be lower still.
            self.begin_anew();
        }
        self.buckets[self.bucket(price)].push((price, cell));
    }

    /// The least price and one of its cells.
    #[inline]
    pub(super) fn peek(&mut self) -> Option<(u32, u32)> {
        match self.buckets[0].last() {
            Some(&entry) => Some(entry),
            None => self.refill(),
        }
    }

    /// Removes what [`Queue::peek`] returned.
    #[inline]
    pub(super) fn pop(&mut self) {
        self.buckets[0].pop();
    }

    /// Moves the entries of the first bucket that has any to lower ones, the least to the first.
    fn refill(&mut self) -> Option<(u32, u32)> {
        let first = self.buckets.iter().position(|bucket| !bucket.is_empty())?;
        let mut entries = core::mem::take(&mut self.buckets[first]);
        self.least = entries.iter().map(|&(price, _)| price).min()?;
        for (price, cell) in entries.drain(..) {
            self.buckets[self.bucket(price)].push((price, cell));
        }
        // The memory stays with the bucket.
        self.buckets[first] = entries;
        self.buckets[0].last().copied()
    }

    fn begin_anew(&mut self) {
        self.least = 0;
        for from in 0..BUCKETS {
            let entries = core::mem::take(&mut self.buckets[from]);
            for (price, cell) in entries {
                self.buckets[self.bucket(price)].push((price, cell));
            }
        }
    }

    fn bucket(&self, price: u32) -> usize {
        (u32::BITS - (price ^ self.least).leading_zeros()) as usize
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_least_price_comes_first_even_if_lower_ones_follow(
            prices in prop::collection::vec(prop::option::of(prop_oneof![0u32..50, 0u32..=u32::MAX]), 1..200),
        ) {
            let mut queue = Queue::default();
            let mut expected = BTreeMap::<u32, u32>::new();
            for price in prices {
                if let Some(price) = price {
                    queue.push(price, price / 2);
                    *expected.entry(price).or_default() += 1;
                    continue;
                }
                let first = expected.first_key_value().map(|(&price, _)| (price, price / 2));
                prop_assert_eq!(queue.peek(), first);
                if let Some((price, _)) = first {
                    queue.pop();
                    let left = expected.get_mut(&price).expect("counted");
                    *left -= 1;
                    if *left == 0 {
                        expected.remove(&price);
                    }
                }
            }
        }
    }
}
