//! A* compared with Dijkstra's algorithm, Theta* with A*, and what is refused.

use proptest::prelude::*;

use super::*;
use crate::costmap::LETHAL;
use crate::maps::{costmap, maze};
use crate::price::Unknown;

/// Dijkstra's algorithm without a heap: prices settle until none improves.
fn by_relaxation(costs: &Costmap, prices: &Prices, start: Cell, goal: Cell) -> Option<f64> {
    let search = PathSearch::new(costs, prices, Angles::Eight, goal);
    let geometry = costs.geometry();
    let mut known = vec![f64::INFINITY; geometry.cells()];
    known[geometry.index(start)] = 0.0;
    let mut settled = false;
    while !settled {
        settled = true;
        for index in 0..geometry.cells() {
            if known[index].is_infinite() {
                continue;
            }
            let cell = geometry.cell(index);
            for next in STEPS
                .map(|step| search.neighbour(cell, step))
                .into_iter()
                .flatten()
            {
                let through = known[index] + search.line(cell, next).expect("a step is open");
                if through + 1e-9 < known[geometry.index(next)] {
                    known[geometry.index(next)] = through;
                    settled = false;
                }
            }
        }
    }
    Some(known[geometry.index(goal)]).filter(|price| price.is_finite())
}

fn free_segments(costs: &Costmap, prices: &Prices, route: &Route) -> bool {
    let search = PathSearch::new(costs, prices, Angles::Any, Cell::new(0, 0));
    let cell = |point: (f64, f64)| Cell::new(point.0 as u32, point.1 as u32);
    route
        .points
        .windows(2)
        .all(|pair| search.line(cell(pair[0]), cell(pair[1])).is_some())
}

#[test]
fn a_diagonal_step_needs_both_cells_beside_it() {
    let prices = Prices::new(0.0, Unknown::Closed);
    let (start, goal) = (Cell::new(0, 0), Cell::new(1, 1));
    for angles in [Angles::Eight, Angles::Any] {
        let price =
            |costs: &[u8]| plan(&costmap(2, costs), &prices, angles, start, goal).map(|way| way.price);
        assert_eq!(price(&[0, 0, 0, 0]), Ok(core::f64::consts::SQRT_2));
        assert_eq!(price(&[0, LETHAL, 0, 0]), Ok(2.0), "around the corner");
        assert_eq!(price(&[0, LETHAL, LETHAL, 0]), Err(PlanError::Unreachable));
    }
}

#[test]
fn ends_outside_and_in_walls_are_named() {
    let prices = Prices::new(1.0, Unknown::Closed);
    let costs = costmap(3, &[0, LETHAL, 255]);
    for (start, goal, error) in [
        (0, 1, PlanError::GoalClosed),
        (0, 2, PlanError::GoalClosed),
        (0, 3, PlanError::GoalOutside),
        (1, 0, PlanError::StartClosed),
        (9, 0, PlanError::StartOutside),
    ] {
        let way = plan(
            &costs,
            &prices,
            Angles::Eight,
            Cell::new(start, 0),
            Cell::new(goal, 0),
        );
        assert_eq!(way, Err(error));
    }
}

#[test]
fn a_map_of_one_cell_has_a_way_of_one_point() {
    let cell = Cell::new(0, 0);
    for angles in [Angles::Eight, Angles::Any] {
        let way = plan(
            &costmap(1, &[0]),
            &Prices::new(1.0, Unknown::Closed),
            angles,
            cell,
            cell,
        );
        assert_eq!(
            way,
            Ok(Route {
                points: vec![(0.5, 0.5)],
                price: 0.0
            })
        );
    }
}

#[test]
fn an_expensive_corridor_is_avoided() {
    // The straight way through the middle costs more than the way around it.
    let mut costs = [0; 35];
    costs[14..21].fill(252);
    costs[14] = 0;
    costs[20] = 0;
    let costs = costmap(7, &costs);
    for angles in [Angles::Eight, Angles::Any] {
        let way = |weight| {
            let prices = Prices::new(weight, Unknown::Closed);
            plan(&costs, &prices, angles, Cell::new(0, 2), Cell::new(6, 2)).expect("there is a way")
        };
        assert_eq!(way(0.0).length(), 6.0);
        assert!(way(5.0).length() > 6.0, "{:?}", way(5.0));
    }
}

proptest! {
    #[test]
    fn a_star_costs_as_much_as_dijkstra(map in maze(16, 12), weight in 0.0..5.0f64) {
        let prices = Prices::new(weight, Unknown::Closed);
        let (start, goal) = (Cell::new(0, 0), Cell::new(15, 11));
        let way = plan(&map, &prices, Angles::Eight, start, goal);
        match by_relaxation(&map, &prices, start, goal) {
            Some(price) => {
                let way = way.expect("there is a way");
                prop_assert!((way.price - price).abs() < 1e-4, "{} is not {price}", way.price);
                prop_assert!(free_segments(&map, &prices, &way));
            }
            None => prop_assert_eq!(way, Err(PlanError::Unreachable)),
        }
    }

    #[test]
    fn theta_star_never_costs_more_than_a_star(map in maze(24, 20), weight in 0.0..5.0f64) {
        for weight in [0.0, weight] {
            let prices = Prices::new(weight, Unknown::Closed);
            let way = |angles| plan(&map, &prices, angles, Cell::new(0, 0), Cell::new(23, 19));
            match (way(Angles::Eight), way(Angles::Any)) {
                (Ok(eight), Ok(any)) => {
                    prop_assert!(any.price <= eight.price + 1e-4, "{} > {}", any.price, eight.price);
                    prop_assert!(free_segments(&map, &prices, &any));
                    if weight == 0.0 {
                        prop_assert!((any.length() - any.price).abs() < 1e-6);
                        prop_assert!(any.length() <= eight.length() + 1e-4);
                    }
                }
                (eight, any) => prop_assert_eq!(eight.map(|_| ()), any.map(|_| ())),
            }
        }
    }
}
