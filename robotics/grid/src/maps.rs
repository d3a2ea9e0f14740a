//! Small costmaps for tests, by their costs.

use proptest::prelude::*;

use crate::costmap::{Costmap, LETHAL};
use crate::geometry::Geometry;

/// A costmap with these costs, row by row.
pub(crate) fn costmap(width: u32, costs: &[u8]) -> Costmap {
    let height = costs.len() as u32 / width;
    let geometry = Geometry::new(width, height, 1.0, (0.0, 0.0, 0.0)).expect("valid");
    Costmap::with_costs(geometry, costs)
}

/// Random costs, a third of them walls.
pub(crate) fn maze(width: u32, height: u32) -> impl Strategy<Value = Costmap> {
    let cost = prop_oneof![3 => Just(0u8), 2 => 0u8..=252, 2 => Just(LETHAL)];
    prop::collection::vec(cost, (width * height) as usize).prop_map(move |mut costs| {
        // Both ends are open, so that most maps have a way to look for.
        costs[0] = 0;
        *costs.last_mut().expect("cells") = 0;
        costmap(width, &costs)
    })
}
