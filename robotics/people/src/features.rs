//! The geometry of a segment in numbers: those of Arras et al. that are known for a few points, and others.

use core::f64::consts::PI;

use crate::segments::{Hit, Segment};

/// How many features a segment has.
pub const FEATURES: usize = 16;
/// The largest radius of a circle through a segment, m; that of a straight one.
const MOST_RADIUS: f64 = 1.0;

/// The features of a segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features(pub [f64; FEATURES]);

impl Features {
    /// What each feature is.
    pub const NAMES: [&str; FEATURES] = [
        "hits",
        "range, m",
        "standard deviation of the hits, m",
        "distance between the ends, m",
        "depth toward the laser, m",
        "depth away from the laser, m",
        "deviation from a line, m",
        "radius of a circle, m",
        "deviation from a circle, m",
        "length of the boundary, m",
        "standard deviation of the steps, m",
        "mean turn from step to step, rad",
        "mean inscribed angle, rad",
        "standard deviation of the inscribed angles, rad",
        "smaller jump beside it, m",
        "larger jump beside it, m",
    ];

    /// Returns the features of a segment. Those that need more hits than it has are 0.
    #[must_use]
    pub fn new(hits: &[Hit], segment: &Segment) -> Self {
        let hits = &hits[segment.hits.clone()];
        let (Some(first), Some(last)) = (hits.first(), hits.last()) else {
            return Self::default();
        };
        let count = hits.len() as f64;
        let (x, y) = mean(hits);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for hit in hits {
            let (dx, dy) = (hit.x - x, hit.y - y);
            (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        }
        let least = 0.5 * (xx + yy - libm::hypot(xx - yy, 2.0 * xy));
        let line = (least / count).max(0.0).sqrt();
        let (width, chord) = chord(first, last);
        // The laser is at the origin: which side of the chord it is on.
        let side = (chord.0 * -first.y - chord.1 * -first.x).signum();
        let depths = hits
            .iter()
            .map(|hit| side * (chord.0 * (hit.y - first.y) - chord.1 * (hit.x - first.x)));
        let (toward, away) = depths.fold((0.0_f64, 0.0_f64), |(toward, away), depth| {
            (toward.max(depth), away.min(depth))
        });
        let (radius, round) = circle(hits, (x, y), (xx, xy, yy)).unwrap_or((MOST_RADIUS, line));
        let steps = || hits.windows(2).map(|pair| distance(&pair[0], &pair[1]));
        let boundary: f64 = steps().sum();
        let (_, irregularity) = statistics(steps());
        let turns = hits
            .windows(3)
            .map(|three| angle(&three[0], &three[1], &three[2]));
        let (turn, _) = statistics(turns.map(|inside| PI - inside));
        let interior = hits.get(1..hits.len() - 1).unwrap_or_default();
        let (inscribed, variation) = statistics(interior.iter().map(|hit| angle(first, hit, last)));
        let [before, after] = segment.jumps;
        Self([
            count,
            libm::hypot(x, y),
            ((xx + yy) / count).sqrt(),
            width,
            toward,
            -away,
            line,
            radius,
            round,
            boundary,
            irregularity,
            turn,
            inscribed,
            variation,
            before.min(after),
            before.max(after),
        ])
    }
}

/// Returns the mean of some hits.
pub(crate) fn mean(hits: &[Hit]) -> (f64, f64) {
    let (x, y) = hits.iter().fold((0.0, 0.0), |(x, y), hit| (x + hit.x, y + hit.y));
    (x / hits.len() as f64, y / hits.len() as f64)
}

pub(crate) fn distance(a: &Hit, b: &Hit) -> f64 {
    libm::hypot(b.x - a.x, b.y - a.y)
}

/// Returns the distance between two hits and the direction from one to the other.
fn chord(first: &Hit, last: &Hit) -> (f64, (f64, f64)) {
    let width = distance(first, last);
    let scale = width.max(f64::EPSILON);
    (width, ((last.x - first.x) / scale, (last.y - first.y) / scale))
}

/// Returns the angle at `b` between `a` and `c`, from 0 to π.
fn angle(a: &Hit, b: &Hit, c: &Hit) -> f64 {
    let (ax, ay, cx, cy) = (a.x - b.x, a.y - b.y, c.x - b.x, c.y - b.y);
    libm::atan2((ax * cy - ay * cx).abs(), ax * cx + ay * cy)
}

/// Returns mean and standard deviation.
fn statistics(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        (count, sum, squares) = (count + 1.0, sum + value, squares + value * value);
    }
    if count == 0.0 {
        return (0.0, 0.0);
    }
    let mean = sum / count;
    (mean, (squares / count - mean * mean).max(0.0).sqrt())
}

/// Returns the radius of the circle with the least squares of `x² + y² - ...` (Kåsa, 1976) and the deviation of the
/// hits from it; `None` for hits on a line.
fn circle(hits: &[Hit], (x, y): (f64, f64), (xx, xy, yy): (f64, f64, f64)) -> Option<(f64, f64)> {
    let (mut xq, mut yq) = (0.0, 0.0);
    for hit in hits {
        let (dx, dy) = (hit.x - x, hit.y - y);
        let square = dx * dx + dy * dy;
        (xq, yq) = (xq + dx * square, yq + dy * square);
    }
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-12 * (xx + yy) * (xx + yy) {
        return None;
    }
    let middle = (
        (xq * yy - yq * xy) / (2.0 * determinant),
        (yq * xx - xq * xy) / (2.0 * determinant),
    );
    let count = hits.len() as f64;
    let radius = (middle.0 * middle.0 + middle.1 * middle.1 + (xx + yy) / count).sqrt();
    if radius >= MOST_RADIUS {
        return None;
    }
    let errors = hits.iter().map(|hit| {
        let error = libm::hypot(hit.x - x - middle.0, hit.y - y - middle.1) - radius;
        error * error
    });
    Some((radius, (errors.sum::<f64>() / count).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hits on an arc of 0.06 m radius 2 m ahead, from right to left, and their features.
    fn arc(round: f64) -> Features {
        let hits: Vec<Hit> = (0..9)
            .map(|index| {
                let angle = (f64::from(index) - 4.0) * 0.3;
                let (x, y) = (2.0 - round * 0.06 * angle.cos(), 0.06 * angle.sin());
                Hit {
                    x,
                    y,
                    range: x.hypot(y),
                    beam: 0,
                }
            })
            .collect();
        let segment = Segment {
            hits: 0..9,
            jumps: [0.5, 1.0],
        };
        Features::new(&hits, &segment)
    }

    fn feature(features: &Features, name: &str) -> f64 {
        let index = Features::NAMES.iter().position(|known| known.starts_with(name));
        features.0[index.expect("the feature is known")]
    }

    #[test]
    fn an_arc_has_its_radius_and_its_depth() {
        let arc = arc(1.0);
        assert!((feature(&arc, "radius") - 0.06).abs() < 1e-9, "{arc:?}");
        assert!(feature(&arc, "deviation from a circle") < 1e-9);
        let expected = 0.06 * (1.0 - 1.2_f64.cos());
        assert!((feature(&arc, "depth toward") - expected).abs() < 1e-9);
        assert!(feature(&arc, "depth away").abs() < 1e-9);
        // All inscribed angles over one chord are equal.
        assert!(feature(&arc, "standard deviation of the inscribed") < 1e-6);
        assert_eq!(feature(&arc, "smaller jump"), 0.5);
    }

    #[test]
    fn a_hollow_arc_is_deep_on_the_other_side_and_a_line_on_none() {
        let hollow = arc(-1.0);
        assert!(feature(&hollow, "depth toward").abs() < 1e-9);
        assert!(feature(&hollow, "depth away") > 0.03);
        let line = arc(0.0);
        assert!(feature(&line, "deviation from a line") < 1e-9);
        assert_eq!(feature(&line, "radius"), MOST_RADIUS);
        assert!((feature(&line, "mean inscribed") - PI).abs() < 1e-6);
    }

    #[test]
    fn a_segment_of_one_hit_has_finite_features() {
        let hits = [Hit {
            x: 1.0,
            y: 0.0,
            range: 1.0,
            beam: 0,
        }];
        let segment = Segment {
            hits: 0..1,
            jumps: [0.0; 2],
        };
        let Features(values) = Features::new(&hits, &segment);
        assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
    }
}
