//! Random rooms that are covered, and maps that move.

use proptest::prelude::*;

use super::*;
use crate::costmap::{Inflation, MAX_PASSABLE};
use crate::geometry::SIDES;
use crate::occupancy::{Occupancy, OccupancyGrid};
use crate::price::Unknown;

/// A tool of this radius and tracks at this distance, in cells.
const RADIUS: f64 = 3.0;
const DISTANCE: u32 = 5;

/// A room of 40 × 30 cells of 0.1 m with boxes in it: column, row, width and height of each.
fn room(boxes: &[(u32, u32, u32, u32)]) -> Costmap {
    let geometry = Geometry::new(40, 30, 0.1, (0.0, 0.0, 0.0)).expect("valid");
    let mut grid = OccupancyGrid::filled(geometry, Occupancy::Free);
    for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
        let is_in = |&(left, low, width, height): &(u32, u32, u32, u32)| {
            (left..left + width).contains(&x) && (low..low + height).contains(&y)
        };
        if x == 0 || y == 0 || x == 39 || y == 29 || boxes.iter().any(is_in) {
            grid.set(Cell::new(x, y), Occupancy::Occupied);
        }
    }
    Costmap::new(&grid, &Inflation::circle(0.2)).expect("valid")
}

fn floor(costs: &Costmap, start: Cell) -> Result<Floor, PlanError> {
    Floor::new(costs, &Prices::new(0.0, Unknown::Closed), start, RADIUS, DISTANCE)
}

/// Drives along all strokes from a cell. Returns what is covered, and the cells that were driven along.
fn cover(costs: &Costmap, start: Cell) -> (CellSet, Vec<Cell>) {
    let geometry = *costs.geometry();
    let mut covered = CellSet::none(geometry);
    let mut driven = vec![start];
    let mut strokes = 0;
    while let Some(stroke) = floor(costs, *driven.last().expect("a start"))
        .expect("the robot is where it can be")
        .next(&covered, &CellSet::none(geometry), 1)
    {
        strokes += 1;
        assert!(strokes < 500, "it comes to no end");
        let way = stroke.way.iter().map(|&(x, y)| Cell::new(x as u32, y as u32));
        driven.extend(way.chain(stroke.cells.iter().copied()));
        for pair in stroke.cells.windows(2) {
            covered.sweep(geometry.center(pair[0]), geometry.center(pair[1]), RADIUS * 0.1);
        }
        let first = geometry.center(stroke.cells[0]);
        covered.sweep(first, first, RADIUS * 0.1);
    }
    (covered, driven)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn every_place_that_the_robot_can_reach_is_covered_and_it_is_never_elsewhere(
        boxes in prop::collection::vec((0_u32..38, 0_u32..28, 1_u32..12, 1_u32..12), 0..5),
    ) {
        let costs = room(&boxes);
        let geometry = *costs.geometry();
        let is_open = |cell: Cell| costs.get(cell) <= MAX_PASSABLE;
        let start = (0..geometry.cells()).map(|index| geometry.cell(index)).find(|&cell| is_open(cell));
        prop_assume!(start.is_some());
        let start = start.expect("assumed");
        // The definition: a flood over the open cells.
        let mut is_reached = vec![false; geometry.cells()];
        let mut reached = vec![start];
        let mut at = 0;
        while let Some(&cell) = reached.get(at) {
            at += 1;
            for (x, y) in SIDES {
                let next = cell.offset(x, y).filter(|&next| geometry.contains(next) && is_open(next));
                if let Some(next) = next && !core::mem::replace(&mut is_reached[geometry.index(next)], true) {
                    reached.push(next);
                }
            }
        }
        let (covered, driven) = cover(&costs, start);
        for cell in &driven {
            prop_assert!(*cell == start || is_reached[geometry.index(*cell)], "{cell:?} is out of reach");
        }
        for index in 0..geometry.cells() {
            let cell = geometry.cell(index);
            let within = |&from: &Cell| from.distance(cell) <= RADIUS - 1.0;
            if costs.get(cell) != LETHAL && reached.iter().any(within) {
                prop_assert!(covered.at(cell), "{cell:?} is not covered");
            }
        }
    }
}

#[test]
fn an_empty_room_is_covered_by_its_contour_and_tracks_without_much_overlap() {
    let costs = room(&[]);
    let start = Cell::new(3, 3);
    let (covered, driven) = cover(&costs, start);
    let (done, all) = floor(&costs, start)
        .expect("open")
        .share(&covered)
        .expect("one map");
    assert_eq!(done, all);
    let way: f64 = driven.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let swept = way * 2.0 * RADIUS;
    assert!(swept < 1.6 * all as f64, "{swept} for {all}");
}

#[test]
fn what_is_done_is_not_driven_to() {
    let costs = room(&[]);
    let covered = CellSet::none(*costs.geometry());
    let mut floor = floor(&costs, Cell::new(3, 3)).expect("open");
    let mut done = covered.clone();
    done.sweep((0.95, 0.0), (0.95, 3.0), 1.0);
    let stroke = floor.next(&covered, &done, 1).expect("a stroke");
    assert!(stroke.cells.iter().all(|cell| cell.x >= 19));
    assert_eq!(stroke.way.first(), Some(&(3.5, 3.5)));
    done.sweep((0.0, 1.5), (4.0, 1.5), 2.0);
    assert_eq!(floor.next(&covered, &done, 1), None);
}

#[test]
fn a_map_that_moves_or_is_saved_keeps_what_is_covered() {
    let at = |x: f64| Geometry::new(20, 10, 0.1, (x, 0.0, 0.0)).expect("valid");
    let mut covered = CellSet::none(at(0.0));
    covered.sweep((0.55, 0.55), (1.55, 0.55), 0.1);
    let bits = covered.to_bits();
    assert_eq!(CellSet::from_bits(at(0.0), &bits).as_ref(), Some(&covered));
    assert_eq!(CellSet::from_bits(at(0.0), &bits[1..]), None, "another size");
    covered.follow(at(0.5));
    let mut expected = CellSet::none(at(0.5));
    expected.sweep((0.55, 0.55), (1.55, 0.55), 0.1);
    assert_eq!(covered, expected);
}

#[test]
fn a_robot_in_an_obstacle_has_no_floor() {
    let costs = room(&[]);
    assert_eq!(floor(&costs, Cell::new(0, 0)).err(), Some(PlanError::GoalClosed));
}
