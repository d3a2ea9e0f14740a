//! Collections whose size does not grow with the recording.

use std::collections::{BTreeMap, VecDeque};

/// The first and the last of many items. Those in between are only counted.
#[derive(Clone, Debug)]
pub(crate) struct Ends<T> {
    pub(crate) first: Vec<T>,
    pub(crate) last: VecDeque<T>,
    /// The number of items in between.
    pub(crate) left_out: u64,
    most_first: usize,
    most_last: usize,
}

impl<T> Ends<T> {
    /// Creates a list of so many of the first items, and of the last.
    pub(crate) fn new(most_first: usize, most_last: usize) -> Self {
        Self {
            first: Vec::new(),
            last: VecDeque::new(),
            left_out: 0,
            most_first,
            most_last,
        }
    }

    pub(crate) fn add(&mut self, item: T) {
        if self.first.len() < self.most_first {
            self.first.push(item);
            return;
        }
        self.last.push_back(item);
        if self.last.len() > self.most_last {
            self.last.pop_front();
            self.left_out += 1;
        }
    }

    /// The stored items.
    pub(crate) fn kept(&self) -> impl DoubleEndedIterator<Item = &T> {
        self.first.iter().chain(&self.last)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.first.is_empty()
    }
}

/// Counts a key. A new key counts only while there are fewer than `most`.
pub(super) fn count<K: Ord + Clone>(counts: &mut BTreeMap<K, u64>, key: &K, most: usize) {
    if let Some(count) = counts.get_mut(key) {
        *count += 1;
    } else if counts.len() < most {
        counts.insert(key.clone(), 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_items_are_kept_and_the_others_counted() {
        let mut ends = Ends::new(4, 1);
        for number in 0..6 {
            ends.add(number);
        }
        assert_eq!(ends.kept().copied().collect::<Vec<_>>(), [0, 1, 2, 3, 5]);
        assert_eq!(ends.left_out, 1);
    }

    #[test]
    fn a_new_key_beyond_the_limit_is_not_counted() {
        let mut counts = BTreeMap::new();
        for key in ["a", "b", "a", "c"] {
            count(&mut counts, &key, 2);
        }
        assert_eq!(counts, BTreeMap::from([("a", 2), ("b", 1)]));
    }
}
