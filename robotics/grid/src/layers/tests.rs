//! Zones cell by cell compared with their definition, and changes compared with new layers.

use proptest::prelude::*;

use super::*;
use crate::maps::{costmap, maze};
use crate::route::away;
use crate::{Field, UNIT, Unknown};

/// Corners of zones on maps of 24 × 16 cells with sides of 1 m, some of them outside.
fn zones() -> impl Strategy<Value = Vec<Vec<Point>>> {
    let corner = (-6.0..30.0f64, -6.0..22.0f64);
    prop::collection::vec(prop::collection::vec(corner, 3..7), 0..4)
}

/// Lanes along these lines, with the same prices.
fn lanes(lines: Vec<Vec<Point>>) -> Lanes {
    Lanes {
        lines: lines.into_iter().map(|line| (line, 1.5)).collect(),
        weight: 2.0,
        aside: 1.0,
        unknown: Unknown::Closed,
    }
}

/// How often the outline goes around a point, and how far it is from it.
fn around(corners: &[Point], (x, y): Point) -> (i32, f64) {
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    let angle = |(a, b): (&Point, &Point)| {
        let (a, b) = ((a.0 - x, a.1 - y), (b.0 - x, b.1 - y));
        (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1)
    };
    let turns = edges().map(angle).sum::<f64>() / core::f64::consts::TAU;
    let near = edges().map(|(&a, &b)| away((x, y), a, b));
    (turns.round() as i32, near.fold(f64::INFINITY, f64::min))
}

#[test]
fn a_zone_closes_free_and_unknown_cells_and_leaves_obstacles() {
    let base = costmap(5, &[0, 100, UNKNOWN, LETHAL, 0]);
    let drawing = Drawing {
        zones: vec![vec![(1.4, -1.0), (3.6, -1.0), (3.6, 2.0), (1.4, 2.0)]],
        ..Drawing::default()
    };
    let layers = Layers::new(&base, drawing);
    assert_eq!(layers.costs().costs(), [0, INSCRIBED, INSCRIBED, LETHAL, 0]);
    let zone = (0..6).map(|x| layers.is_in_zone(Cell::new(x, 0)));
    assert_eq!(zone.collect::<Vec<_>>(), [false, true, true, true, false, false]);
}

#[test]
fn no_way_passes_a_zone_thinner_than_a_cell() {
    let base = costmap(20, &[0; 400]);
    let drawing = Drawing {
        zones: vec![vec![(-1.0, 3.3), (21.0, 14.9), (21.0, 14.91)]],
        ..Drawing::default()
    };
    let layers = Layers::new(&base, drawing);
    let prices = lanes(vec![]).prices();
    let mut field = Field::new(layers.costs(), &prices, Cell::new(0, 19)).expect("open");
    field.settle();
    assert_eq!(field.price(Cell::new(19, 0)), None);
}

#[test]
fn what_is_off_the_lanes_costs_more_by_the_stated_share_of_its_length() {
    let base = costmap(
        4,
        &[
            0,
            MAX_PASSABLE,
            UNKNOWN,
            LETHAL,
            0,
            MAX_PASSABLE,
            UNKNOWN,
            INSCRIBED,
        ],
    );
    for unknown in [Unknown::Closed, Unknown::Open] {
        let lanes = Lanes {
            unknown,
            ..lanes(vec![vec![(-1.0, 0.5), (9.0, 0.5)]])
        };
        let prices = lanes.prices();
        let lanes = Some(lanes);
        let layers = Layers::new(
            &base,
            Drawing {
                lanes,
                ..Drawing::default()
            },
        );
        let price = |x, y| f64::from(prices.at(layers.costs(), Cell::new(x, y))) / f64::from(UNIT);
        // The lane is 1.5 m wide, so that the centres of the second row are off it.
        let open = if unknown == Unknown::Open { 1.0 } else { 0.0 };
        for (x, on, off) in [(0, 1.0, 2.0), (1, 3.0, 4.0), (2, open, 2.0 * open), (3, 0.0, 0.0)] {
            assert!(
                (price(x, 0) - on).abs() < 0.01,
                "{x}: {} on the lane",
                price(x, 0)
            );
            assert!(
                (price(x, 1) - off).abs() < 0.01,
                "{x}: {} off the lane",
                price(x, 1)
            );
        }
    }
}

#[test]
fn a_way_takes_a_lane_that_is_worth_the_detour_and_a_zone_closes_it() {
    let base = costmap(60, &[0; 60 * 40]);
    let drawing = |zones| Drawing {
        zones,
        lanes: Some(Lanes {
            aside: 3.0,
            ..lanes(vec![vec![(5.0, 5.0), (5.0, 30.0), (55.0, 30.0), (55.0, 5.0)]])
        }),
        ..Drawing::default()
    };
    let highest = |drawing: Drawing| {
        let prices = drawing.lanes.as_ref().expect("lanes").prices();
        let layers = Layers::new(&base, drawing);
        let mut field = Field::new(layers.costs(), &prices, Cell::new(55, 5)).expect("open");
        let way = field.route(Cell::new(5, 5)).expect("a way");
        way.points.iter().fold(0.0, |y: f64, point| y.max(point.1))
    };
    let on = highest(drawing(vec![]));
    assert!((29.0..31.5).contains(&on), "{on}");
    let across = vec![(28.0, 20.0), (32.0, 20.0), (32.0, 50.0), (28.0, 50.0)];
    let closed = highest(drawing(vec![across]));
    assert!(closed < 20.0, "{closed}");
}

proptest! {
    #[test]
    fn a_cell_is_in_a_zone_if_its_centre_is_inside_or_within_the_margin(zones in zones(), margin in 0.8..3.0f64) {
        let base = costmap(24, &[0; 24 * 16]);
        let layers = Layers::new(&base, Drawing { zones: zones.clone(), margin, lanes: None });
        for index in 0..base.geometry().cells() {
            let cell = base.geometry().cell(index);
            let around: Vec<_> = zones.iter().map(|zone| around(zone, base.geometry().center(cell))).collect();
            // At the very edge rounding decides.
            if around.iter().all(|&(_, near)| (near - margin).abs() > 1e-6) {
                let expected = around.iter().any(|&(turns, near)| turns != 0 || near < margin);
                prop_assert_eq!(layers.is_in_zone(cell), expected, "{:?}", cell);
            }
        }
    }

    #[test]
    fn a_field_that_follows_drawings_and_the_map_equals_a_new_one(
        maps in (maze(24, 16), maze(24, 16)),
        drawn in prop::collection::vec((zones(), 0.0..2.0f64, prop::option::of(zones())), 1..4),
        places in prop::collection::vec(0usize..384, 0..20),
    ) {
        let (mut base, second) = maps;
        let goal = Cell::new(0, 0);
        let prices = lanes(vec![]).prices();
        let mut layers = Layers::new(&base, Drawing::default());
        let mut field = Field::new(layers.costs(), &prices, goal).expect("the goal is open");
        let changed: Vec<Cell> = places.iter().map(|&place| base.geometry().cell(place)).collect();
        for (zones, margin, lines) in drawn {
            let lanes = lines.map(lanes);
            let cells = layers.draw(&base, Drawing { zones, margin, lanes });
            field.update(layers.costs(), &cells);
            let _ = field.route(Cell::new(23, 15));
            for &cell in &changed {
                base.set(cell, second.get(cell));
            }
            let cells = layers.update(&base, &changed);
            field.update(layers.costs(), &cells);
        }
        prop_assert_eq!(&layers, &Layers::new(&base, layers.drawing.clone()));
        field.settle();
        let again = Field::new(layers.costs(), &prices, goal).map(|mut field| {
            field.settle();
            field
        });
        for index in 0..base.geometry().cells() {
            let cell = base.geometry().cell(index);
            let price = again.as_ref().ok().and_then(|field| field.price(cell));
            prop_assert_eq!(field.price(cell), price);
        }
    }
}
