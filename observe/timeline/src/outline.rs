//! The outline of a robot as windows and pages draw it. It draws nothing.

use std::f64::consts::TAU;

use jde_types::Body;

/// Number of corners of a round body.
const ROUND_CORNERS: u32 = 32;
/// Radius of the disc that stands for an unknown body, in m.
const UNKNOWN_RADIUS: f64 = 0.2;

/// The corners of a body in its own frame, in m; those of a disc while nobody has published it.
#[must_use]
pub fn outline(body: Option<&Body>) -> Vec<[f64; 2]> {
    let footprint = body.map(|body| body.footprint).unwrap_or_default();
    let points = footprint.points.iter().map(|point| [point.x, point.y]);
    let points: Vec<_> = points
        .filter(|point| point.iter().all(|at| at.is_finite()))
        .collect();
    if points.len() > 2 {
        return points;
    }
    let is_known = footprint.radius.is_finite() && footprint.radius > 0.0;
    round(if is_known {
        footprint.radius
    } else {
        UNKNOWN_RADIUS
    })
}

/// The corners of a disc.
#[must_use]
pub fn round(radius: f64) -> Vec<[f64; 2]> {
    let corner = |corner| {
        let (sin, cos) = (TAU * f64::from(corner) / f64::from(ROUND_CORNERS)).sin_cos();
        [radius * cos, radius * sin]
    };
    (0..ROUND_CORNERS).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use jde_types::{Footprint, Point2D, Seq};

    use super::*;

    #[test]
    fn an_outline_is_the_polygon_or_the_circle_of_the_body_or_a_disc_if_it_is_unknown() {
        let of = |footprint| {
            outline(Some(&Body {
                footprint,
                ..Body::default()
            }))
        };
        let polygon = [[0.3, 0.2], [-0.1, 0.2], [-0.1, -0.2]];
        let points: Seq<_, 32> = polygon.iter().map(|&[x, y]| Point2D { x, y }).collect();
        assert_eq!(of(Footprint { radius: 0.5, points }), polygon);
        assert_eq!(of(Footprint::circle(0.17))[0], [0.17, 0.0]);
        for unknown in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(of(Footprint::circle(unknown)), outline(None), "{unknown}");
        }
    }
}
