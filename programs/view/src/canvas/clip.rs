//! Clips lines and convex polygons to a rectangle, in double precision. At a high zoom, coordinates on the
//! screen exceed what graphics can represent.

/// A rectangle of the screen: the least x and y, and the greatest.
pub(super) type Bounds = [[f64; 2]; 2];

/// The part of a line segment inside a rectangle, or `None` if it lies outside.
pub(super) fn segment(from: [f64; 2], to: [f64; 2], [least, greatest]: Bounds) -> Option<[[f64; 2]; 2]> {
    // Liang and Barsky, 1984: the fractions of the segment at which it enters and leaves.
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (start, extent) = (from[axis], to[axis] - from[axis]);
        if extent == 0.0 {
            if start < least[axis] || start > greatest[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((least[axis] - start) / extent, (greatest[axis] - start) / extent);
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    if enters > leaves {
        return None;
    }
    let at = |share: f64| {
        [
            from[0] + share * (to[0] - from[0]),
            from[1] + share * (to[1] - from[1]),
        ]
    };
    Some([
        if enters == 0.0 { from } else { at(enters) },
        if leaves == 1.0 { to } else { at(leaves) },
    ])
}

/// The part of a convex polygon inside a rectangle; empty if it lies outside.
pub(super) fn polygon(corners: Vec<[f64; 2]>, [least, greatest]: Bounds) -> Vec<[f64; 2]> {
    // Sutherland and Hodgman, 1974: clips at one side of the rectangle after the other.
    let mut corners = corners;
    for (axis, limit, sign) in [
        (0, least[0], 1.0),
        (0, greatest[0], -1.0),
        (1, least[1], 1.0),
        (1, greatest[1], -1.0),
    ] {
        let inside = |corner: &[f64; 2]| sign * (corner[axis] - limit) >= 0.0;
        if corners.iter().all(inside) {
            continue;
        }
        let mut clipped = Vec::with_capacity(corners.len() + 1);
        for (place, corner) in corners.iter().enumerate() {
            let previous = &corners[(place + corners.len() - 1) % corners.len()];
            if inside(corner) != inside(previous) {
                let share = (limit - previous[axis]) / (corner[axis] - previous[axis]);
                clipped.push([
                    previous[0] + share * (corner[0] - previous[0]),
                    previous[1] + share * (corner[1] - previous[1]),
                ]);
            }
            if inside(corner) {
                clipped.push(*corner);
            }
        }
        corners = clipped;
    }
    corners
}

/// Whether the box from `low` to `high` overlaps a rectangle.
pub(super) fn overlaps(low: [f64; 2], high: [f64; 2], [least, greatest]: Bounds) -> bool {
    (0..2).all(|axis| high[axis] >= least[axis] && low[axis] <= greatest[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = [[0.0, 0.0], [10.0, 5.0]];

    #[test]
    fn a_line_is_clipped_where_it_enters_and_leaves() {
        assert_eq!(
            segment([-10.0, 2.0], [20.0, 2.0], BOUNDS),
            Some([[0.0, 2.0], [10.0, 2.0]])
        );
        assert_eq!(
            segment([1.0, 1.0], [2.0, 3.0], BOUNDS),
            Some([[1.0, 1.0], [2.0, 3.0]])
        );
        assert_eq!(segment([-1.0, 1.0], [-1.0, 3.0], BOUNDS), None);
        assert_eq!(segment([-4.0, 4.0], [4.0, 12.0], BOUNDS), None);
    }

    #[test]
    fn a_polygon_around_the_rectangle_becomes_the_rectangle() {
        let huge = vec![[-1e9, -1e9], [1e9, -1e9], [1e9, 1e9], [-1e9, 1e9]];
        let mut cut = polygon(huge, BOUNDS);
        cut.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(cut, [[0.0, 0.0], [0.0, 5.0], [10.0, 0.0], [10.0, 5.0]]);
        assert!(polygon(vec![[20.0, 0.0], [30.0, 0.0], [30.0, 4.0]], BOUNDS).is_empty());
    }
}
