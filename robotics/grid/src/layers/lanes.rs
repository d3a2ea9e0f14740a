//! Preferred lanes as costs. A factor below 1 on a lane would break the lower bound of a search, so everything off
//! the lanes costs more instead.

use crate::costmap::{INSCRIBED, LETHAL, MAX_PASSABLE, UNKNOWN};
use crate::price::{Prices, Unknown};

/// Lines along which a way costs less than elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Lanes {
    /// The points of each line and its width, in metres. No line is thinner than a cell.
    pub lines: Vec<(Vec<(f64, f64)>, f64)>,
    /// How many times its length a way along an obstacle costs more, as for [`Prices::new`].
    pub weight: f64,
    /// How many times its length a way off the lanes costs more. Both together count up to
    /// [`MAX_WEIGHT`](crate::MAX_WEIGHT).
    pub aside: f64,
    /// Whether a robot may enter unknown cells.
    pub unknown: Unknown,
}

/// The cost of a cell on or off the lanes, by its cost without them.
pub(super) type Table = [u8; 256];

impl Lanes {
    /// Returns the prices for the costs of a map with these lanes.
    #[must_use]
    pub fn prices(&self) -> Prices {
        Prices::new(self.sum(), self.unknown)
    }

    /// The costs on the lanes if `aside` is 0, and off them if it is [`Lanes::aside`].
    pub(super) fn table(&self, aside: f64) -> Table {
        let most = f64::from(MAX_PASSABLE);
        let scaled = |cost: u8| {
            let weight = f64::from(cost) / most * self.weight + aside;
            // Without any weight nothing costs, and the quotient is not a number, which is 0 as well.
            libm::round(weight / self.sum() * most) as u8
        };
        core::array::from_fn(|cost| match cost as u8 {
            cost @ (LETHAL | INSCRIBED) => cost,
            // What is open costs as what is free; otherwise a way off the lanes would prefer the unknown.
            UNKNOWN => match self.unknown {
                Unknown::Closed => UNKNOWN,
                Unknown::Open => scaled(0),
            },
            cost @ 0..=MAX_PASSABLE => scaled(cost),
        })
    }

    fn sum(&self) -> f64 {
        self.weight + self.aside
    }
}
