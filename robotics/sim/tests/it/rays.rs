//! Rays and cones, compared with formulas and with an independent implementation that checks every thing.

use jde_sim::{Outline, World};
use proptest::prelude::*;

fn world(text: &str) -> World {
    World::parse(text, "rays.toml", 0).unwrap()
}

fn cast(text: &str, origin: [f64; 2], degrees: f64) -> Option<f64> {
    world(text).cast_ray(origin, degrees.to_radians(), 100.0, None)
}

fn assert_near(found: Option<f64>, expected: f64) {
    let found = found.expect("the ray hits something");
    assert!(
        (found - expected).abs() < 1e-9,
        "found {found}, expected {expected}"
    );
}

#[test]
fn a_ray_hits_a_box_at_its_face() {
    let text = "boxes = [{ center = [4, 0], size = [2, 2] }]";
    assert_near(cast(text, [0.0, 0.0], 0.0), 3.0);
    // 30 degrees from (0, -1): the ray hits the face x = 3 at y = -1 + 3 tan 30.
    assert_near(cast(text, [0.0, -1.0], 30.0), 3.0 / 30f64.to_radians().cos());
    assert_eq!(cast(text, [0.0, 0.0], 90.0), None);
}

#[test]
fn a_ray_hits_a_turned_box_at_its_corner() {
    let text = "boxes = [{ center = [4, 0], size = [2, 2], angle_deg = 45 }]";
    assert_near(cast(text, [0.0, 0.0], 0.0), 4.0 - 2f64.sqrt());
}

#[test]
fn a_ray_hits_a_circle_where_the_chord_begins() {
    let text = "circles = [{ center = [5, 1], radius = 2 }]";
    assert_near(cast(text, [0.0, 0.0], 0.0), 5.0 - 3f64.sqrt());
    assert_eq!(cast(text, [0.0, 0.0], 180.0), None);
}

#[test]
fn a_ray_hits_a_wall_at_the_intersection() {
    let text = "walls = [{ points = [[2, -1], [4, 1]] }]";
    // The wall is the line y = x - 3; the ray y = 0 crosses it at x = 3.
    assert_near(cast(text, [0.0, 0.0], 0.0), 3.0);
    assert_near(cast(text, [6.0, 0.0], 180.0), 3.0);
    assert_eq!(cast(text, [0.0, 1.1], 0.0), None);
}

#[test]
fn a_ray_from_inside_a_solid_has_length_0() {
    assert_near(
        cast("circles = [{ center = [0, 0], radius = 2 }]", [0.5, 0.0], 10.0),
        0.0,
    );
    assert_near(
        cast("boxes = [{ center = [0, 0], size = [1, 1] }]", [0.2, 0.0], 10.0),
        0.0,
    );
}

#[test]
fn the_nearest_thing_hides_the_others() {
    let text = "walls = [{ points = [[3, -1], [3, 1]] }]\ncircles = [{ center = [2, 0], radius = 0.5 }]";
    assert_near(cast(text, [0.0, 0.0], 0.0), 1.5);
}

#[test]
fn no_ray_leaves_a_closed_room_through_a_corner() {
    let room = world("walls = [{ points = [[0, 0], [7.3, 0.1], [6.9, 5.7], [0.3, 4.9]], closed = true }]");
    for origin in [[1.0, 1.0], [3.3, 2.7], [6.1, 5.1]] {
        for corner in [[0.0, 0.0], [7.3, 0.1], [6.9, 5.7], [0.3, 4.9]] {
            let angle = f64::atan2(corner[1] - origin[1], corner[0] - origin[0]);
            for tilt in -50..=50 {
                let ray = angle + f64::from(tilt) * 1e-16;
                assert!(
                    room.cast_ray(origin, ray, 100.0, None).is_some(),
                    "no hit at {corner:?} from {origin:?}"
                );
            }
        }
    }
}

/// Returns the distance to a segment by Cramer's rule.
fn to_segment(o: [f64; 2], d: [f64; 2], a: [f64; 2], b: [f64; 2]) -> Option<f64> {
    let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
    let determinant = ex * d[1] - d[0] * ey;
    let (wx, wy) = (a[0] - o[0], a[1] - o[1]);
    let along_ray = (ex * wy - wx * ey) / determinant;
    let along_wall = (d[0] * wy - wx * d[1]) / determinant;
    (along_ray >= 0.0 && (0.0..=1.0).contains(&along_wall)).then_some(along_ray)
}

fn to_outline(o: [f64; 2], d: [f64; 2], outline: &Outline) -> Option<f64> {
    match *outline {
        Outline::Segment { from, to } => to_segment(o, d, from, to),
        Outline::Circle { center, radius } => {
            let (x, y) = (o[0] - center[0], o[1] - center[1]);
            let (half_b, c) = (x * d[0] + y * d[1], x * x + y * y - radius * radius);
            if c <= 0.0 {
                return Some(0.0);
            }
            let root = half_b * half_b - c;
            (root >= 0.0 && half_b < 0.0).then(|| -half_b - root.sqrt())
        }
        Outline::Box { center, size, angle } => {
            let (sin, cos) = angle.sin_cos();
            let corner = |sx: f64, sy: f64| {
                let (x, y) = (sx * size[0] / 2.0, sy * size[1] / 2.0);
                [center[0] + cos * x - sin * y, center[1] + sin * x + cos * y]
            };
            let (dx, dy) = (o[0] - center[0], o[1] - center[1]);
            let own = [cos * dx + sin * dy, cos * dy - sin * dx];
            if own[0].abs() <= size[0] / 2.0 && own[1].abs() <= size[1] / 2.0 {
                return Some(0.0);
            }
            let corners = [
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
            ];
            (0..4)
                .filter_map(|side| to_segment(o, d, corners[side], corners[(side + 1) % 4]))
                .reduce(f64::min)
        }
    }
}

/// Returns points of an outline. One of them is the nearest point in a cone, unless that point is on an edge
/// of the cone.
fn candidates(o: [f64; 2], outline: &Outline) -> Vec<[f64; 2]> {
    let segment = |a: [f64; 2], b: [f64; 2]| {
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let along = ((o[0] - a[0]) * ex + (o[1] - a[1]) * ey) / (ex * ex + ey * ey);
        let along = along.clamp(0.0, 1.0);
        [a, b, [a[0] + along * ex, a[1] + along * ey]]
    };
    match *outline {
        Outline::Segment { from, to } => segment(from, to).to_vec(),
        Outline::Circle { center, radius } => {
            let (x, y) = (o[0] - center[0], o[1] - center[1]);
            let scale = radius / x.hypot(y);
            vec![[center[0] + x * scale, center[1] + y * scale]]
        }
        Outline::Box { center, size, angle } => {
            let (sin, cos) = angle.sin_cos();
            let corner = |[sx, sy]: [f64; 2]| {
                let (x, y) = (sx * size[0] / 2.0, sy * size[1] / 2.0);
                [center[0] + cos * x - sin * y, center[1] + sin * x + cos * y]
            };
            let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(corner);
            (0..4)
                .flat_map(|side| segment(corners[side], corners[(side + 1) % 4]))
                .collect()
        }
    }
}

/// Returns the distance to an outline in a cone around a direction, by its edges and its candidates.
fn in_cone(o: [f64; 2], heading: f64, cone: f64, outline: &Outline) -> Option<f64> {
    let edges = [-0.5, 0.5].map(|side| {
        let (sin, cos) = (heading + side * cone).sin_cos();
        to_outline(o, [cos, sin], outline)
    });
    let points = candidates(o, outline).into_iter().filter_map(|[x, y]| {
        let (x, y) = (x - o[0], y - o[1]);
        let (sin, cos) = (y.atan2(x) - heading).sin_cos();
        (sin.atan2(cos).abs() <= cone / 2.0).then_some(x.hypot(y))
    });
    edges.into_iter().flatten().chain(points).reduce(f64::min)
}

fn coordinate() -> impl Strategy<Value = f64> {
    -10.0..10.0f64
}

fn thing() -> impl Strategy<Value = String> {
    prop_oneof![
        (
            coordinate(),
            coordinate(),
            0.1..4.0f64,
            0.1..4.0f64,
            -180.0..180.0f64
        )
            .prop_map(|(x, y, w, h, a)| {
                format!("[[boxes]]\ncenter = [{x:?}, {y:?}]\nsize = [{w:?}, {h:?}]\nangle_deg = {a:?}\n")
            }),
        (coordinate(), coordinate(), 0.05..2.0f64)
            .prop_map(|(x, y, r)| format!("[[circles]]\ncenter = [{x:?}, {y:?}]\nradius = {r:?}\n")),
        (coordinate(), coordinate(), coordinate(), coordinate())
            .prop_map(|(a, b, c, d)| format!("[[walls]]\npoints = [[{a:?}, {b:?}], [{c:?}, {d:?}]]\n")),
    ]
}

proptest! {
    #[test]
    fn a_ray_has_the_same_distance_as_a_check_of_every_thing(
        things in proptest::collection::vec(thing(), 1..40),
        x in coordinate(),
        y in coordinate(),
        angle in 0.0..std::f64::consts::TAU,
    ) {
        let world = world(&things.concat());
        let direction = [angle.cos(), angle.sin()];
        let expected = world.shapes().filter_map(|shape| to_outline([x, y], direction, &shape.outline)).reduce(f64::min);
        let found = world.cast_ray([x, y], angle, 1000.0, None);
        match (found, expected) {
            (Some(found), Some(expected)) => prop_assert!((found - expected).abs() < 1e-6, "{found} {expected}"),
            (found, expected) => prop_assert_eq!(found, expected),
        }
    }

    #[test]
    fn a_cone_has_the_same_distance_as_a_check_of_every_thing(
        things in proptest::collection::vec(thing(), 1..20),
        x in coordinate(),
        y in coordinate(),
        heading in 0.0..std::f64::consts::TAU,
        cone in 0.0..std::f64::consts::PI,
    ) {
        let world = world(&things.concat());
        let outlines: Vec<_> = world.shapes().map(|shape| shape.outline).collect();
        let expected = outlines.iter().filter_map(|outline| in_cone([x, y], heading, cone, outline)).reduce(f64::min);
        let found = world.cast_cone([x, y], heading, cone, 1000.0, None);
        match (found, expected) {
            // From inside a solid the distance is 0.
            (Some(0.0), _) => prop_assert_eq!(world.cast_ray([x, y], heading, 1000.0, None), Some(0.0)),
            (Some(found), Some(expected)) => prop_assert!((found - expected).abs() < 1e-6, "{found} {expected}"),
            (found, expected) => prop_assert_eq!(found, expected),
        }
        for ray in 0..=60 {
            let angle = heading + cone * (f64::from(ray) / 60.0 - 0.5);
            let range = world.cast_ray([x, y], angle, 1000.0, None).unwrap_or(1000.0);
            prop_assert!(found.unwrap_or(1000.0) <= range + 1e-6, "a ray in the cone is shorter");
        }
    }
}
