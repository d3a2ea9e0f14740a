//! A list of bounded length. When it is full, every other item is dropped, and from then on only every
//! second, fourth, eighth item is stored.

/// Items in their order, evenly decimated.
#[derive(Clone, Debug)]
pub(crate) struct Decimated<T> {
    items: Vec<T>,
    capacity: usize,
    step: u64,
    seen: u64,
}

impl<T> Decimated<T> {
    /// Creates a list of at most `capacity` items, at least two.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            items: Vec::new(),
            capacity: capacity.max(2),
            step: 1,
            seen: 0,
        }
    }

    /// Adds the next item.
    pub(crate) fn add(&mut self, item: T) {
        if self.seen.is_multiple_of(self.step) {
            if self.items.len() == self.capacity {
                let mut place = 0_usize;
                self.items.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.step *= 2;
            }
            if self.seen.is_multiple_of(self.step) {
                self.items.push(item);
            }
        }
        self.seen += 1;
    }

    /// Returns the number of added items for each stored one.
    pub(crate) fn step(&self) -> u64 {
        self.step
    }

    /// Returns the stored items.
    pub(crate) fn items(&self) -> &[T] {
        &self.items
    }

    /// As [`Self::items`].
    pub(crate) fn into_items(self) -> Vec<T> {
        self.items
    }
}

#[cfg(test)]
mod tests {
    use super::Decimated;

    #[test]
    fn the_list_stays_bounded_and_evenly_spaced() {
        for count in [0, 1, 9, 10, 11, 1000, 12_345_u64] {
            let mut list = Decimated::new(10);
            (0..count).for_each(|item| list.add(item));
            let step = list.step();
            let items = list.into_items();
            assert!(items.len() <= 10, "{count}: {items:?}");
            let even: Vec<u64> = (0..count).step_by(step as usize).collect();
            assert_eq!(items, even);
        }
    }
}
