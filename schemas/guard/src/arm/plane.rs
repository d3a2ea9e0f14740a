//! Distances in the plane between a segment and a zone.

use jde_schema::types::Zone;

type Point = [f64; 2];

/// Returns the distance from a segment to a zone, 0 if they overlap. A zone without a corner is nowhere.
pub(super) fn distance(segment: [Point; 2], zone: &Zone) -> f64 {
    let corners: Vec<Point> = zone.corners.iter().map(|corner| [corner.x, corner.y]).collect();
    if contains(&corners, segment[0]) {
        return 0.0;
    }
    let next = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(next).map(|(&from, &to)| [from, to]);
    edges
        .map(|edge| between(segment, edge))
        .fold(f64::INFINITY, f64::min)
}

/// Returns the distance between two segments.
fn between(one: [Point; 2], other: [Point; 2]) -> f64 {
    if cross(one, other) {
        return 0.0;
    }
    let ends = [
        to_point(one, other[0]),
        to_point(one, other[1]),
        to_point(other, one[0]),
        to_point(other, one[1]),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

fn to_point([from, to]: [Point; 2], point: Point) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let way = [point[0] - from[0], point[1] - from[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = match square > 0.0 {
        true => ((way[0] * along[0] + way[1] * along[1]) / square).clamp(0.0, 1.0),
        false => 0.0,
    };
    libm::hypot(way[0] - share * along[0], way[1] - share * along[1])
}

/// Whether two segments cross within both. Those that only touch have a distance of 0 anyway.
fn cross(one: [Point; 2], other: [Point; 2]) -> bool {
    let separates =
        |line: [Point; 2], points: [Point; 2]| side(line, points[0]) * side(line, points[1]) < 0.0;
    separates(one, other) && separates(other, one)
}

/// Returns on which side of a line a point is: above 0 on the left.
fn side([from, to]: [Point; 2], point: Point) -> f64 {
    (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0])
}

/// Whether a polygon contains a point: a ray from it to the right crosses an odd number of edges.
fn contains(corners: &[Point], [x, y]: Point) -> bool {
    let next = corners.iter().cycle().skip(1);
    let crossed = corners.iter().zip(next).filter(|(from, to)| {
        (from[1] > y) != (to[1] > y) && x < from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0])
    });
    crossed.count() % 2 == 1
}
