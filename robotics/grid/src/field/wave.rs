//! The price of a cell from those of its neighbours, for a wave that passes through it at any angle: one step
//! of fast marching (Sethian, "A fast marching level set method for monotonically advancing fronts", 1996).
//!
//! All in whole units, so that the result grows with every argument without exception of rounding, and is
//! greater than each that it uses. These two make the field of a map unique, whatever the order of updates.

/// The price of a cell that no way reaches.
pub(super) const UNREACHED: u32 = u32::MAX;

/// Returns the price of a cell, which costs `price` to cross and is not closed, from the lower neighbour in
/// its row and the lower one in its column. Prices that exceed 32 bits count as unreached.
#[inline]
pub(super) fn arrival(in_row: u32, in_column: u32, price: u16) -> u32 {
    let (low, high) = (in_row.min(in_column), in_row.max(in_column));
    let price = u32::from(price);
    let apart = high - low;
    if low == UNREACHED || apart >= price {
        return low.saturating_add(price);
    }
    let (price, apart) = (i64::from(price), i64::from(apart));
    // Exact: the squares stay below 2³³, and a square root in 53 bits is correctly rounded.
    let root = ((2 * price * price - apart * apart) as f64).sqrt() as i64;
    let sum = i64::from(low) + i64::from(high) + root;
    u32::try_from((sum + 1) >> 1).unwrap_or(UNREACHED)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_straight_wave_adds_the_price_and_a_diagonal_one_less() {
        assert_eq!(arrival(1000, UNREACHED, 256), 1256);
        assert_eq!(arrival(1000, 1256, 256), 1256);
        // 256 / √2 beyond two equal neighbours, rounded up.
        assert_eq!(arrival(1000, 1000, 256), 1000 + 181);
        assert_eq!(arrival(UNREACHED, UNREACHED, 256), UNREACHED);
        assert_eq!(arrival(UNREACHED - 9, UNREACHED, 256), UNREACHED);
    }

    proptest! {
        #[test]
        fn it_grows_with_both_neighbours_and_exceeds_those_that_it_uses(
            low in 0u32..1 << 31, apart in 0u32..70_000, price in 1u16.., more in (0u32..3, 0u32..3),
        ) {
            let high = low + apart;
            let value = arrival(low, high, price);
            prop_assert_eq!(value, arrival(high, low, price));
            prop_assert!(value > low);
            if value != low + u32::from(price) {
                prop_assert!(value > high);
            }
            prop_assert!(arrival(low + more.0, high + more.1, price) >= value);
        }
    }
}
