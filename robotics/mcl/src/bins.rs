//! KLD-sampling: the bins of a histogram over poses in which particles lie, and how many particles so many bins need.
//! Bins that are neighbours make clusters.

use core::f32::consts::TAU;

/// The side of a bin, m, as in the paper.
const SIDE: f32 = 0.5;
/// The bins of a whole turn: 15 degrees each, as in the paper.
const TURNS: f32 = 24.0;
/// The key of no bin.
const NONE: u64 = u64::MAX;

/// Returns how many particles keep the Kullback-Leibler distance between the sampled and the true distribution below
/// `error`, with the probability whose upper quantile of the standard normal distribution is `quantile`, if samples
/// lie in this many bins (Fox 2001, equation 7: the transformation of Wilson and Hilferty).
#[must_use]
pub fn bound(bins: usize, error: f64, quantile: f64) -> usize {
    if bins < 2 {
        return 1;
    }
    let degrees = (bins - 1) as f64;
    let part = 2.0 / (9.0 * degrees);
    let root = 1.0 - part + libm::sqrt(part) * quantile;
    libm::ceil(degrees / (2.0 * error) * root * root * root) as usize
}

/// A set of bins, in a table of fixed size.
#[derive(Clone, Debug)]
pub(crate) struct Bins {
    keys: Vec<u64>,
    labels: Vec<u32>,
    occupied: usize,
    /// The bins whose neighbours are not looked at yet.
    open: Vec<u64>,
    scale: f32,
}

impl Bins {
    /// Returns room for `most` bins on a map with cells of `cell` m.
    pub(crate) fn new(most: usize, cell: f64) -> Self {
        let size = (2 * most.max(1)).next_power_of_two();
        Self {
            keys: vec![NONE; size],
            labels: vec![0; size],
            occupied: 0,
            open: Vec::with_capacity(most),
            scale: cell as f32 / SIDE,
        }
    }

    pub(crate) fn clear(&mut self) {
        self.keys.fill(NONE);
        self.labels.fill(0);
        self.occupied = 0;
    }

    /// How many bins there are.
    pub(crate) const fn len(&self) -> usize {
        self.occupied
    }

    /// Adds the bin of a pose in cells, and returns its place in the table.
    pub(crate) fn add(&mut self, [x, y, heading]: [f32; 3]) -> usize {
        let turn = libm::floorf(heading * (TURNS / TAU)) as i32;
        let column = |at: f32| libm::floorf(at * self.scale) as i32;
        let key = key(column(x), column(y), turn);
        let (place, found) = self.find(key);
        if !found {
            self.keys[place] = key;
            self.occupied += 1;
        }
        place
    }

    /// The number of the cluster of a bin, from 0 on; `next` is that of a new cluster, to which all bins belong then
    /// that neighbours lead to.
    pub(crate) fn cluster(&mut self, place: usize, next: u32) -> u32 {
        if self.labels[place] == 0 {
            self.labels[place] = next + 1;
            self.open.push(self.keys[place]);
            while let Some(open) = self.open.pop() {
                self.label_neighbours(open, next + 1);
            }
        }
        self.labels[place] - 1
    }

    fn label_neighbours(&mut self, around: u64, label: u32) {
        let (x, y, turn) = parts(around);
        for (dx, dy, dturn) in (0..27).map(|at| (at / 9 - 1, at / 3 % 3 - 1, at % 3 - 1)) {
            let (place, found) = self.find(key(x + dx, y + dy, turn + dturn));
            if found && self.labels[place] == 0 {
                self.labels[place] = label;
                self.open.push(self.keys[place]);
            }
        }
    }

    /// The place of a key, and whether it is there; otherwise that is free for it. At least half of the table is free.
    fn find(&self, key: u64) -> (usize, bool) {
        let mask = self.keys.len() - 1;
        let mut place = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        while self.keys[place] != NONE && self.keys[place] != key {
            place = (place + 1) & mask;
        }
        (place, self.keys[place] == key)
    }
}

/// 24 bits for each of column and row, and 8 for the turn.
fn key(x: i32, y: i32, turn: i32) -> u64 {
    let part = |at: i32| u64::from(at as u32 & 0xff_ffff);
    part(x) << 32 | part(y) << 8 | turn.rem_euclid(TURNS as i32) as u64
}

fn parts(key: u64) -> (i32, i32, i32) {
    // The sign is that of 24 bits.
    let part = |at: u64| ((at as u32) << 8) as i32 >> 8;
    (part(key >> 32), part(key >> 8), (key & 0xff) as i32)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Quantiles of the chi-square distribution from tables, by degrees of freedom and probability.
    #[test]
    fn the_bound_is_that_of_the_chi_square_distribution() {
        for (bins, quantile, chi_square) in [
            (2, 2.326_35, 6.635),
            (3, 2.326_35, 9.210),
            (11, 2.326_35, 23.209),
            (31, 2.326_35, 50.892),
            (101, 2.326_35, 135.807),
            (11, 1.644_85, 18.307),
            (101, 1.644_85, 124.342),
        ] {
            for error in [0.01, 0.05] {
                let (found, exact) = (bound(bins, error, quantile) as f64, chi_square / (2.0 * error));
                assert!(
                    (found - exact).abs() < 0.015 * exact + 1.0,
                    "{bins}: {found} for {exact}"
                );
            }
        }
        assert_eq!((bound(0, 0.05, 2.3), bound(1, 0.05, 2.3)), (1, 1));
    }

    #[test]
    fn neighbours_make_a_cluster_across_the_half_turn() {
        let mut bins = Bins::new(8, 1.0);
        let places = [
            [0.1, 0.1, 3.1],
            [0.7, -0.3, -3.1],
            [9.1, 0.1, 3.1],
            [0.1, 0.1, 0.0],
            [0.2, 0.2, 3.1],
        ]
        .map(|pose| bins.add(pose));
        assert_eq!(bins.len(), 4);
        let clusters: Vec<u32> = (0..)
            .zip(places)
            .map(|(next, place)| bins.cluster(place, next))
            .collect();
        assert_eq!(clusters, [0, 0, 2, 3, 0]);
    }

    proptest! {
        #[test]
        fn more_bins_need_more_particles(bins in 1usize..5000, error in 0.001..0.5f64) {
            prop_assert!(bound(bins + 1, error, 2.326) >= bound(bins, error, 2.326));
        }

        #[test]
        fn keys_name_their_bins(x in -9000i32..9000, y in -9000i32..9000, turn in -50i32..50) {
            prop_assert_eq!(parts(key(x, y, turn)), (x, y, turn.rem_euclid(24)));
        }
    }
}
