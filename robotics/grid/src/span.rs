//! The parts of a row that a drawn shape covers, in columns and rows with fractions. It knows no cells.

use crate::route::Point;

/// Returns the part of the row at height `y` that is no farther than `radius` from the segment.
pub(crate) fn near_segment((a, b): (Point, Point), radius: f64, y: f64) -> Option<(f64, f64)> {
    // Such points form a convex shape: a disc around each end, and a band between them.
    let disc = |(x, center): Point| {
        let square = radius * radius - (y - center) * (y - center);
        (square >= 0.0).then(|| (x - libm::sqrt(square), x + libm::sqrt(square)))
    };
    let parts = [disc(a), disc(b), band((a, b), radius, y)];
    parts.into_iter().flatten().reduce(hull)
}

/// The part of the row whose points are beside the segment, not beyond its ends.
fn band((a, b): (Point, Point), radius: f64, y: f64) -> Option<(f64, f64)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = libm::hypot(dx, dy);
    if length == 0.0 {
        return None;
    }
    let (dx, dy, up) = (dx / length, dy / length, y - a.1);
    let along = within(dx, up * dy, (0.0, length))?;
    let across = within(-dy, up * dx, (-radius, radius))?;
    let (from, to) = (along.0.max(across.0), along.1.min(across.1));
    (from <= to).then_some((a.0 + from, a.0 + to))
}

/// The numbers x for which `slope · x + offset` is within the limits.
fn within(slope: f64, offset: f64, (least, most): (f64, f64)) -> Option<(f64, f64)> {
    if slope == 0.0 {
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        return (least <= offset && offset <= most).then_some(all);
    }
    let (p, q) = ((least - offset) / slope, (most - offset) / slope);
    Some((p.min(q), p.max(q)))
}

fn hull(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Returns the parts of the row at height `y` within a polygon: all that its outline goes around, in either
/// direction.
pub(crate) fn inside(corners: &[Point], y: f64) -> Vec<(f64, f64)> {
    let next = corners.iter().cycle().skip(1);
    let mut crossings: Vec<(f64, i32)> = corners
        .iter()
        .zip(next)
        .filter(|(a, b)| (a.1 <= y) != (b.1 <= y))
        .map(|(a, b)| {
            let x = a.0 + (b.0 - a.0) * (y - a.1) / (b.1 - a.1);
            (x, if a.1 < b.1 { 1 } else { -1 })
        })
        .collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut turns, mut begin, mut parts) = (0, 0.0, Vec::new());
    for (x, turn) in crossings {
        if turns == 0 {
            begin = x;
        }
        turns += turn;
        if turns == 0 {
            parts.push((begin, x));
        }
    }
    parts
}
