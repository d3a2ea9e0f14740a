//! Straight lines through weighted points: total least squares.

use crate::Point;

/// Sums over weighted points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    weight: f64,
    first: [f64; 2],
    /// Of xx, xy and yy.
    second: [f64; 3],
}

/// A straight line, with the scatter of the points that it was fitted to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FittedLine {
    /// The weighted middle of the points.
    middle: Point,
    /// Across the line, of length 1.
    pub(crate) normal: Point,
    /// The mean of the squared distances, px².
    pub(crate) scatter: f64,
}

impl Moments {
    pub(crate) fn add(&mut self, [x, y]: Point, weight: f64) {
        *self = self.plus(
            &Self {
                weight,
                first: [weight * x, weight * y],
                second: [weight * x * x, weight * x * y, weight * y * y],
            },
            1.0,
        );
    }

    /// Returns these sums and those of other points, times `sign`.
    pub(crate) fn plus(&self, other: &Self, sign: f64) -> Self {
        Self {
            weight: self.weight + sign * other.weight,
            first: [0, 1].map(|index| self.first[index] + sign * other.first[index]),
            second: [0, 1, 2].map(|index| self.second[index] + sign * other.second[index]),
        }
    }

    /// Returns the line with the least squared distances.
    pub(crate) fn line(&self) -> FittedLine {
        let middle = self.first.map(|sum| sum / self.weight);
        let xx = self.second[0] / self.weight - middle[0] * middle[0];
        let xy = self.second[1] / self.weight - middle[0] * middle[1];
        let yy = self.second[2] / self.weight - middle[1] * middle[1];
        let root = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
        let [least, greatest] = [-1.0, 1.0].map(|sign| (xx + yy + sign * root) / 2.0);
        // Both are eigenvectors of the least eigenvalue: the longer is the more exact one.
        let [a, b] = [[xx - greatest, xy], [xy, yy - greatest]];
        let [along_a, along_b] = [a, b].map(|[x, y]: Point| (x * x + y * y).sqrt());
        let (normal, length) = if along_a > along_b {
            (a, along_a)
        } else {
            (b, along_b)
        };
        FittedLine {
            middle,
            normal: normal.map(|part| part / length),
            scatter: least.max(0.0),
        }
    }
}

impl FittedLine {
    /// Returns where two lines cross; `None` if they are nearly parallel.
    pub(crate) fn crossing(&self, other: &Self) -> Option<Point> {
        /// The sine of the least angle of two lines.
        const MIN_SINE: f64 = 1e-3;
        let ([a, b], [c, d]) = (self.normal, other.normal);
        let sine = a * d - b * c;
        let [along, across] =
            [self, other].map(|line| line.normal[0] * line.middle[0] + line.normal[1] * line.middle[1]);
        (sine.abs() > MIN_SINE).then(|| [(along * d - across * b) / sine, (a * across - c * along) / sine])
    }
}

/// Returns the corners of four lines, each where a line and the next cross.
pub(crate) fn corners(lines: &[FittedLine; 4]) -> Option<[Point; 4]> {
    let mut corners = [[0.0; 2]; 4];
    for (index, corner) in corners.iter_mut().enumerate() {
        *corner = lines[index].crossing(&lines[(index + 1) % 4])?;
    }
    Some(corners)
}
