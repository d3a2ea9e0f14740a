//! What a cell costs a planner: the length of its way, longer where the costmap has a cost.
//!
//! It sets no cost to an obstacle: such a cell is closed.

use crate::costmap::{Costmap, INSCRIBED, LETHAL, MAX_PASSABLE, UNKNOWN};
use crate::geometry::Cell;

/// The price of a way of one cell where the costmap has no cost. A power of two, so that shares of it are
/// exact; 256 steps keep the rounding of a long way below 0.4 %, and the sum of 1.6 million cells at the
/// highest price within 32 bits.
pub const UNIT: u32 = 256;

/// The greatest weight of costs: prices stay below 2¹⁶.
pub const MAX_WEIGHT: f64 = 100.0;

/// Whether a robot may enter unknown cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// As if they were walls.
    Closed,
    /// As if they were free.
    Open,
}

/// The price of a way of one cell, by its cost in the costmap.
#[derive(Clone, Debug, PartialEq)]
pub struct Prices([u16; 256]);

impl Prices {
    /// Returns the prices with which a way through cells of the greatest passable cost counts 1 + `weight`
    /// times its length. A weight outside 0 to [`MAX_WEIGHT`] counts as the nearest limit, and NaN as 0.
    #[must_use]
    pub fn new(weight: f64, unknown: Unknown) -> Self {
        let weight = if weight.is_nan() {
            0.0
        } else {
            weight.clamp(0.0, MAX_WEIGHT)
        };
        let unit = f64::from(UNIT);
        Self(core::array::from_fn(|cost| match cost as u8 {
            LETHAL | INSCRIBED => 0,
            UNKNOWN => match unknown {
                Unknown::Closed => 0,
                Unknown::Open => UNIT as u16,
            },
            cost @ 0..=MAX_PASSABLE => {
                let share = f64::from(cost) / f64::from(MAX_PASSABLE);
                (unit + unit * weight * share) as u16
            }
        }))
    }

    /// Returns the price of a cell with this cost, in units of 1/[`UNIT`] cells; 0 if it is closed.
    #[must_use]
    pub const fn of(&self, cost: u8) -> u16 {
        self.0[cost as usize]
    }

    /// Returns the price of a cell; 0 if it is closed or outside.
    pub(crate) fn at(&self, costs: &Costmap, cell: Cell) -> u16 {
        if costs.geometry().contains(cell) {
            self.of(costs.costs()[costs.geometry().index(cell)])
        } else {
            0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_price_grows_with_the_cost_up_to_the_weight() {
        let prices = Prices::new(3.0, Unknown::Closed);
        assert_eq!(prices.of(0), 256);
        assert_eq!(prices.of(MAX_PASSABLE), 1024);
        assert!((1..=MAX_PASSABLE).all(|cost| prices.of(cost) >= prices.of(cost - 1)));
        assert_eq!(
            [INSCRIBED, LETHAL, UNKNOWN].map(|cost| prices.of(cost)),
            [0, 0, 0]
        );
        assert_eq!(Prices::new(3.0, Unknown::Open).of(UNKNOWN), 256);
    }

    #[test]
    fn weights_out_of_range_count_as_the_nearest_limit() {
        let open = |weight| Prices::new(weight, Unknown::Open);
        assert_eq!(open(f64::NAN), open(0.0));
        assert_eq!(open(-1.0), open(0.0));
        assert_eq!(open(f64::INFINITY), open(MAX_WEIGHT));
    }
}
