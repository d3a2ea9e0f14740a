//! Obstacles that sensors have seen and the map does not have. They belong to a frame and not to a map, so a map that
//! grows or is corrected keeps them. They know no sensor.

use core::time::Duration;
use std::collections::BTreeMap;

use crate::geometry::{Cell, Geometry};
use crate::occupancy::{Occupancy, OccupancyGrid};

/// An obstacle that is seen about so many metres from one of the map is the same one: no localization is more precise.
const SAME_OBSTACLE: f64 = 0.1;
/// How much larger a cell may be than another before it counts as larger: resolutions are single precision in ROS.
const ROUNDING: f64 = 1e-3;

/// A place on the lattice of cells through the origin of the frame: its column and row.
pub type Place = (i32, i32);

/// The places that were seen occupied, each with the time when it was seen last. A place is kept until it is seen
/// free, is forgotten, or is taken for an obstacle of the map.
#[derive(Clone, Debug)]
pub struct SeenObstacles {
    resolution: f64,
    places: BTreeMap<Place, Duration>,
}

impl SeenObstacles {
    /// How many times as large as a place the cell of a view may be.
    pub const MAX_PARTS: u32 = 20;

    /// Returns a memory of places with sides of `resolution` metres in which nothing was seen.
    #[must_use]
    pub fn new(resolution: f64) -> Self {
        Self {
            resolution,
            places: BTreeMap::new(),
        }
    }

    /// Returns the memory of these places, each with the time when it was seen last.
    #[must_use]
    pub fn of(resolution: f64, places: impl IntoIterator<Item = (Place, Duration)>) -> Self {
        let places = places.into_iter().collect();
        Self { resolution, places }
    }

    /// Returns the places, as [`Self::of`] takes them.
    pub fn places(&self) -> impl Iterator<Item = (Place, Duration)> + '_ {
        self.places.iter().map(|(&place, &seen)| (place, seen))
    }

    /// Returns the side of a place, m.
    #[must_use]
    pub const fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Remembers what is seen occupied at the time `now`, and forgets what is seen free. `known` is the map and `view` what
    /// is seen, both in the same frame. Nothing outside `known` is remembered, so its size limits the memory. A view whose
    /// cells are more than [`MAX_PARTS`](Self::MAX_PARTS) times as large as a place is ignored.
    pub fn observe(&mut self, known: &OccupancyGrid, view: &OccupancyGrid, now: Duration) {
        let seen = view.geometry();
        let resolution = self.resolution;
        self.places.retain(|&place, _| {
            let center = center(place, resolution);
            seen.cell_at(center)
                .is_none_or(|cell| view.get(cell) != Occupancy::Free)
                && is_news(known, center)
        });
        // A larger cell covers several places.
        let parts = (seen.resolution() / resolution - ROUNDING).ceil().max(1.0) as u32;
        if parts > Self::MAX_PARTS {
            return;
        }
        let occupied = view.cells().iter().enumerate();
        for (index, _) in occupied.filter(|(_, state)| **state == Occupancy::Occupied) {
            let cell = seen.cell(index);
            for part in 0..parts * parts {
                let within = |part: u32| (f64::from(part) + 0.5) / f64::from(parts);
                let (column, row) = (within(part % parts), within(part / parts));
                let point = seen.to_world((f64::from(cell.x) + column, f64::from(cell.y) + row));
                if is_news(known, point) {
                    self.places.insert(self.place(point), now);
                }
            }
        }
    }

    /// Forgets what was seen last before the time `since`. Returns whether there was any.
    pub fn forget(&mut self, since: Duration) -> bool {
        let before = self.places.len();
        self.places.retain(|_, seen| *seen >= since);
        self.places.len() < before
    }

    /// Forgets what was seen within `radius` of a point, m: where a robot stands is no obstacle.
    pub fn forget_around(&mut self, (x, y): (f64, f64), radius: f64) {
        let resolution = self.resolution;
        self.places.retain(|&place, _| {
            let center = center(place, resolution);
            libm::hypot(center.0 - x, center.1 - y) > radius
        });
    }

    /// Returns the cells of a map at the remembered places. Some may be there twice.
    pub fn cells<'a>(&'a self, geometry: &'a Geometry) -> impl Iterator<Item = Cell> + 'a {
        let places = self.places.keys();
        places.filter_map(|&place| geometry.cell_at(center(place, self.resolution)))
    }

    fn place(&self, (x, y): (f64, f64)) -> Place {
        let along = |value: f64| (value / self.resolution).floor() as i32;
        (along(x), along(y))
    }
}

fn center((column, row): Place, resolution: f64) -> (f64, f64) {
    let middle = |place: i32| (f64::from(place) + 0.5) * resolution;
    (middle(column), middle(row))
}

/// Whether the map has this point, and no obstacle there.
fn is_news(known: &OccupancyGrid, point: (f64, f64)) -> bool {
    let Some(cell) = known.geometry().cell_at(point) else {
        return false;
    };
    let reach = (SAME_OBSTACLE / known.geometry().resolution()).round() as i32;
    let mut around = (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy)));
    !around.any(|(dx, dy)| {
        cell.offset(dx, dy)
            .is_some_and(|near| known.get(near) == Occupancy::Occupied)
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn grid(side: u32, resolution: f64, origin: (f64, f64, f64), state: Occupancy) -> OccupancyGrid {
        let geometry = Geometry::new(side, side, resolution, origin).expect("valid");
        OccupancyGrid::filled(geometry, state)
    }

    fn cells(seen: &SeenObstacles, map: &OccupancyGrid) -> BTreeSet<(u32, u32)> {
        seen.cells(map.geometry()).map(|cell| (cell.x, cell.y)).collect()
    }

    const NOW: Duration = Duration::from_secs(10);

    #[test]
    fn an_obstacle_is_kept_out_of_sight_until_it_is_seen_free_or_forgotten() {
        let known = grid(40, 0.1, (0.0, 0.0, 0.0), Occupancy::Free);
        let mut view = grid(20, 0.1, (1.0, 1.0, 0.0), Occupancy::Free);
        view.set(Cell::new(5, 5), Occupancy::Occupied);
        let mut seen = SeenObstacles::new(0.1);
        seen.observe(&known, &view, NOW);
        assert_eq!(cells(&seen, &known), BTreeSet::from([(15, 15)]));
        let elsewhere = grid(5, 0.1, (0.0, 0.0, 0.0), Occupancy::Free);
        seen.observe(&known, &elsewhere, 2 * NOW);
        assert!(!seen.forget(NOW));
        let unknown = grid(20, 0.1, (1.0, 1.0, 0.0), Occupancy::Unknown);
        seen.observe(&known, &unknown, 2 * NOW);
        assert_eq!(cells(&seen, &known), BTreeSet::from([(15, 15)]), "out of sight");
        assert!(seen.clone().forget(2 * NOW), "too old");
        seen.observe(&known, &grid(20, 0.1, (1.0, 1.0, 0.0), Occupancy::Free), 2 * NOW);
        assert_eq!(cells(&seen, &known), BTreeSet::new(), "seen free");
    }

    #[test]
    fn an_obstacle_of_the_map_is_not_seen_once_more_beside_it() {
        let mut known = grid(40, 0.1, (0.0, 0.0, 0.0), Occupancy::Free);
        known.set(Cell::new(15, 15), Occupancy::Occupied);
        let mut view = grid(40, 0.1, (0.0, 0.0, 0.0), Occupancy::Free);
        view.set(Cell::new(16, 16), Occupancy::Occupied);
        view.set(Cell::new(17, 15), Occupancy::Occupied);
        let mut seen = SeenObstacles::new(0.1);
        seen.observe(&known, &view, NOW);
        assert_eq!(cells(&seen, &known), BTreeSet::from([(17, 15)]));
    }

    #[test]
    fn a_larger_cell_covers_all_places_below_it_and_none_outside_the_map() {
        let known = grid(10, 0.05, (0.0, 0.0, 0.0), Occupancy::Free);
        let mut view = grid(10, 0.1, (0.0, 0.0, 0.0), Occupancy::Free);
        view.set(Cell::new(1, 2), Occupancy::Occupied);
        view.set(Cell::new(8, 8), Occupancy::Occupied);
        let mut seen = SeenObstacles::new(0.05);
        seen.observe(&known, &view, NOW);
        let expected = BTreeSet::from([(2, 4), (3, 4), (2, 5), (3, 5)]);
        assert_eq!(cells(&seen, &known), expected);
        assert_eq!(seen.places.len(), 4, "nothing outside the map is remembered");
    }

    proptest! {
        /// Whatever was seen before, a view decides about all that it shows.
        #[test]
        fn what_is_in_view_is_as_the_view_shows_it(
            before in prop::collection::vec(any::<bool>(), 100),
            after in prop::collection::vec(0u8..3, 100),
        ) {
            let known = grid(10, 0.5, (0.0, 0.0, 0.0), Occupancy::Free);
            let mut view = known.clone();
            for (index, occupied) in before.iter().enumerate() {
                let state = if *occupied { Occupancy::Occupied } else { Occupancy::Free };
                view.set(known.geometry().cell(index), state);
            }
            let mut seen = SeenObstacles::new(0.5);
            seen.observe(&known, &view, NOW);
            for (index, state) in after.iter().enumerate() {
                let state = [Occupancy::Free, Occupancy::Occupied, Occupancy::Unknown][usize::from(*state)];
                view.set(known.geometry().cell(index), state);
            }
            seen.observe(&known, &view, 2 * NOW);
            let kept = cells(&seen, &known);
            for (index, was_occupied) in before.into_iter().enumerate() {
                let cell = known.geometry().cell(index);
                let expected = match view.get(cell) {
                    Occupancy::Free => false,
                    Occupancy::Occupied => true,
                    Occupancy::Unknown => was_occupied,
                };
                prop_assert_eq!(kept.contains(&(cell.x, cell.y)), expected, "{:?}", cell);
            }
        }
    }
}
