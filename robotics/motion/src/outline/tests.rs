//! Distances known by hand, footprints that are refused, and distances as properties.

use core::f64::consts::TAU;

use jde_types::Seq;
use proptest::prelude::*;

use super::*;

fn footprint(points: &[(f64, f64)], radius: f64) -> Footprint {
    let points: Vec<Point2D> = points.iter().map(|&(x, y)| Point2D { x, y }).collect();
    Footprint {
        radius,
        points: Seq::from_slice(&points).expect("at most 32 points"),
    }
}

fn outline(points: &[(f64, f64)], radius: f64) -> Outline {
    Outline::try_from(&footprint(points, radius)).expect("a valid footprint")
}

const BOX: [(f64, f64); 4] = [(0.4, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.4, -0.2)];

#[test]
fn the_distance_to_a_circle_is_that_to_its_middle_less_the_radius() {
    let circle = outline(&[], 0.25);
    assert!((circle.distance(3.0, 4.0) - 4.75).abs() < 1e-12);
    assert!((circle.distance(0.1, 0.0) + 0.15).abs() < 1e-12);
    assert_eq!((circle.reach(), circle.swing()), (0.25, 0.0));
}

#[test]
fn the_distance_to_a_polygon_is_that_to_its_nearest_side_or_corner() {
    for points in [BOX, [BOX[3], BOX[2], BOX[1], BOX[0]]] {
        let shape = outline(&points, 0.0);
        for (x, y, expected) in [
            (1.4, 0.0, 1.0),
            (0.7, 0.6, 0.5),
            (-0.3, 0.1, 0.1),
            (0.3, 0.0, -0.1),
        ] {
            assert!((shape.distance(x, y) - expected).abs() < 1e-12, "at {x}, {y}");
        }
    }
    assert_eq!(
        outline(&BOX, 0.25),
        outline(&BOX, 0.0),
        "the radius is that of a circle"
    );
}

#[test]
fn a_footprint_that_is_no_convex_area_is_refused() {
    let star: Vec<(f64, f64)> = (0..5)
        .map(|i| (f64::from(i) * 2.0 * TAU / 5.0).sin_cos())
        .collect();
    for (points, radius, expected) in [
        (&[][..], 0.0, FootprintError::Empty),
        (&BOX[..2], 0.1, FootprintError::Empty),
        (&[], f64::NAN, FootprintError::NotFinite),
        (&[], -0.1, FootprintError::NotFinite),
        (
            &[(0.0, 0.0), (1.0, f64::INFINITY), (0.0, 1.0)],
            0.0,
            FootprintError::NotFinite,
        ),
        (
            &[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)],
            0.0,
            FootprintError::NotConvex,
        ),
        (
            &[(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)],
            0.0,
            FootprintError::NotConvex,
        ),
        (
            &[(1.0, 0.0), (0.1, 0.1), (0.0, 1.0), (-1.0, -1.0)],
            0.0,
            FootprintError::NotConvex,
        ),
        (&star, 0.0, FootprintError::NotConvex),
    ] {
        assert_eq!(
            Outline::try_from(&footprint(points, radius)),
            Err(expected),
            "{points:?}"
        );
    }
}

#[test]
fn the_clearance_at_a_pose_is_that_of_the_nearest_point() {
    let shape = outline(&BOX, 0.0);
    let points = [Point2D { x: 5.0, y: 0.0 }, Point2D { x: 1.0, y: 2.9 }];
    let pose = Pose2D::new(1.0, 2.0, TAU / 4.0);
    assert!((shape.clearance(&pose, &points) - 0.5).abs() < 1e-12);
    assert_eq!(shape.clearance(&pose, &[]), f64::INFINITY);
}

proptest! {
    #[test]
    fn the_distance_is_the_least_to_the_edges_when_outside(
        sides in 3_u32..12, radius in 0.1..1.0, shift in -0.5..0.5, x in -2.0_f64..2.0, y in -2.0_f64..2.0,
    ) {
        let ring: Vec<(f64, f64)> = (0..sides)
            .map(|i| (f64::from(i) * TAU / f64::from(sides)).sin_cos())
            .map(|(sin, cos)| (shift + radius * cos, radius * sin))
            .collect();
        let shape = outline(&ring, 0.0);
        let edges = || (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]));
        let inside = edges().all(|(a, b)| (b.0 - a.0) * (y - a.1) - (b.1 - a.1) * (x - a.0) > 0.0);
        let sampled = edges()
            .flat_map(|(a, b)| (0..=1000).map(move |i| (a, b, f64::from(i) / 1000.0)))
            .map(|(a, b, t)| (x - a.0 - t * (b.0 - a.0)).hypot(y - a.1 - t * (b.1 - a.1)))
            .fold(f64::INFINITY, f64::min);
        let distance = shape.distance(x, y);
        prop_assert_eq!(distance < 0.0, inside);
        prop_assert!((distance.abs() - sampled).abs() < 3e-3, "{} is not {}", distance, sampled);
    }

    #[test]
    fn the_clearance_equals_the_least_distance(
        places in prop::collection::vec((-3.0..3.0, -3.0..3.0), 1..60), theta in -3.0..3.0,
    ) {
        let shape = outline(&BOX, 0.0);
        let points: Vec<Point2D> = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let pose = Pose2D::new(0.3, -0.2, theta);
        let least = points
            .iter()
            .map(|point| pose.localize(&Pose2D::new(point.x, point.y, 0.0)))
            .map(|local| shape.distance(local.x, local.y))
            .fold(f64::INFINITY, f64::min);
        let clearance = shape.clearance(&pose, &points);
        prop_assert!((clearance - least).abs() < 1e-9);
    }
}

#[test]
fn discs_cover_the_outline_and_exceed_it_by_little() {
    let circle: Vec<_> = outline(&[], 0.3).discs().collect();
    assert_eq!(circle, [(Point2D::default(), 0.3)]);
    let wide = BOX.map(|(x, y)| (y, x));
    for points in [&BOX[..], &wide, &[(0.6, 0.0), (-0.3, 0.25), (-0.3, -0.25)]] {
        let shape = outline(points, 0.0);
        let covered = |x: f64, y: f64| {
            shape
                .discs()
                .any(|(middle, radius)| (x - middle.x).hypot(y - middle.y) <= radius + 1e-9)
        };
        for (x, y) in
            (-70..=70).flat_map(|x| (-70..=70).map(move |y| (f64::from(x) / 100.0, f64::from(y) / 100.0)))
        {
            assert!(
                shape.distance(x, y) > 0.0 || covered(x, y),
                "{x}, {y} of {points:?}"
            );
        }
    }
    assert!(outline(&BOX, 0.0).discs().all(|(_, radius)| radius < 1.13 * 0.2));
}
