//! A repaired field compared with a new one, its prices with distances, and its ways.

use proptest::prelude::*;

use super::*;
use crate::costmap::LETHAL;
use crate::line::walk;
use crate::maps::{costmap, maze};
use crate::price::Unknown;

fn prices() -> Prices {
    Prices::new(2.0, Unknown::Closed)
}

fn settled(costs: &Costmap, goal: Cell) -> Field {
    let mut field = Field::new(costs, &prices(), goal).expect("the goal is open");
    field.settle();
    field
}

/// Asserts that a way begins and ends where it must, and passes open cells only.
fn check_route(costs: &Costmap, route: &Route, start: Cell, goal: Cell) -> Result<(), TestCaseError> {
    let cells: Vec<Cell> = route
        .points
        .iter()
        .map(|&(x, y)| Cell::new(x as u32, y as u32))
        .collect();
    prop_assert_eq!((cells[0], cells[cells.len() - 1]), (start, goal));
    for pair in cells.windows(2) {
        let open = walk(pair[0], pair[1], |cell, _| prices().at(costs, cell) > 0);
        prop_assert!(open, "{:?} to {:?}", pair[0], pair[1]);
    }
    Ok(())
}

#[test]
fn in_the_open_the_price_is_the_distance() {
    let costs = costmap(101, &[0; 101 * 101]);
    let goal = Cell::new(50, 50);
    let field = settled(&costs, goal);
    for cell in [(0, 0), (100, 50), (50, 0), (80, 10), (60, 95)] {
        let cell = Cell::new(cell.0, cell.1);
        let (price, distance) = (field.price(cell).expect("reached"), cell.distance(goal));
        assert!(
            (price - distance).abs() < 0.03 * distance + 0.5,
            "{price} is not {distance}"
        );
    }
}

#[test]
fn what_is_settled_in_parts_equals_what_is_settled_at_once() {
    let costs = costmap(40, &[0; 40 * 40]);
    let goal = Cell::new(3, 30);
    let mut parts = Field::new(&costs, &prices(), goal).expect("the goal is open");
    let mut before = 0;
    while !parts.settle_some(100) {
        assert_eq!(parts.propagated(), before + 100);
        before = parts.propagated();
    }
    let whole = settled(&costs, goal);
    for index in 0..costs.geometry().cells() {
        let cell = costs.geometry().cell(index);
        assert_eq!(parts.price(cell), whole.price(cell), "{cell:?}");
    }
}

#[test]
fn in_the_open_the_way_is_almost_straight() {
    let costs = costmap(200, &[0; 200 * 100]);
    let (start, goal) = (Cell::new(5, 5), Cell::new(190, 70));
    let way = settled(&costs, goal).route(start).expect("a way");
    let (length, distance) = (way.length(), start.distance(goal));
    assert!(length < 1.02 * distance, "{length} cells for {distance}");
}

#[test]
fn a_closed_start_a_closed_goal_and_cells_outside_are_named() {
    let costs = costmap(3, &[0, LETHAL, 0]);
    let new = |x| Field::new(&costs, &prices(), Cell::new(x, 0)).map(|_| ());
    assert_eq!(new(1), Err(PlanError::GoalClosed));
    assert_eq!(new(3), Err(PlanError::GoalOutside));
    let mut field = Field::new(&costs, &prices(), Cell::new(0, 0)).expect("open");
    assert_eq!(field.route(Cell::new(1, 0)), Err(PlanError::StartClosed));
    assert_eq!(field.route(Cell::new(2, 0)), Err(PlanError::Unreachable));
    assert_eq!(field.route(Cell::new(0, 1)), Err(PlanError::StartOutside));
    assert_eq!(field.route(Cell::new(0, 0)).map(|way| way.length()), Ok(0.0));
}

#[test]
fn a_goal_that_closes_later_is_named() {
    let mut field = settled(&costmap(2, &[0, 0]), Cell::new(0, 0));
    field.update(&costmap(2, &[LETHAL, 0]), &[Cell::new(0, 0), Cell::new(9, 9)]);
    assert_eq!(field.route(Cell::new(1, 0)), Err(PlanError::GoalClosed));
    field.settle();
    assert_eq!(field.price(Cell::new(1, 0)), None);
    field.update(&costmap(2, &[0, 0]), &[Cell::new(0, 0)]);
    assert!(field.route(Cell::new(1, 0)).is_ok());
}

#[test]
fn a_way_ahead_of_the_start_is_repaired_without_the_rest_of_the_map() {
    let (width, height) = (300_u32, 200_u32);
    let mut costs = vec![0; (width * height) as usize];
    let goal = Cell::new(290, 100);
    let mut field = settled(&costmap(width, &costs), goal);
    let full = field.propagated();
    let changed: Vec<Cell> = (60..140).map(|y| Cell::new(240, y)).collect();
    for &cell in &changed {
        costs[(cell.y * width + cell.x) as usize] = LETHAL;
    }
    let costs = costmap(width, &costs);
    field.update(&costs, &changed);
    let start = Cell::new(235, 100);
    let way = field.route(start).expect("a way around");
    check_route(&costs, &way, start, goal).expect("open");
    assert!(field.propagated() - full < full / 3);
}

proptest! {
    #[test]
    fn a_repaired_field_equals_a_new_one(
        first in maze(24, 16), second in maze(24, 16), places in prop::collection::vec(0usize..384, 0..30),
    ) {
        let goal = Cell::new(0, 0);
        let mut field = settled(&first, goal);
        let mut costs = first.costs().to_vec();
        for half in places.chunks(10) {
            for &place in half {
                costs[place] = if place == 0 { 0 } else { second.costs()[place] };
            }
            let map = costmap(24, &costs);
            let changed: Vec<Cell> = half.iter().map(|&place| map.geometry().cell(place)).collect();
            field.update(&map, &changed);
            if half.len() > 5 {
                // A partial repair in between changes nothing.
                let _ = field.route(Cell::new(12, 8));
            }
        }
        field.settle();
        let again = settled(&costmap(24, &costs), goal);
        let known = |field: &Field| (0..field.costs.len()).map(|index| field.read(index).known).collect::<Vec<_>>();
        prop_assert_eq!(known(&field), known(&again));
    }

    #[test]
    fn a_way_passes_open_cells_and_ends_at_the_goal(map in maze(24, 16)) {
        let (start, goal) = (Cell::new(23, 15), Cell::new(0, 0));
        match Field::new(&map, &prices(), goal).expect("open").route(start) {
            Ok(way) => check_route(&map, &way, start, goal)?,
            Err(error) => {
                prop_assert_eq!(error, PlanError::Unreachable);
                prop_assert_eq!(settled(&map, goal).price(start), None);
            }
        }
    }
}
