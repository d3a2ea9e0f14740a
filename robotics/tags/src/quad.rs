//! Quadrilaterals: the edges that four straight lines fit.

use crate::line::{FittedLine, Moments, corners};
use crate::segments::EdgePoint;
use crate::{Gray, Point};

/// Fewest points of an edge: about six pixels for each side.
const LEAST_POINTS: usize = 24;
/// Most corners that are tried: `10 over 4` combinations.
const MOST_CORNERS: usize = 10;
/// The greatest mean squared distance of the points of a side from its line, px².
const SCATTER: f64 = 10.0;
/// The cosine of 10°: the least angle between two sides.
const PARALLEL: f64 = 0.984_807_753_012_208;
/// A smoothing filter: a Gaussian with a standard deviation of one point.
const SMOOTH: [f64; 7] = [
    0.011_109, 0.135_335, 0.606_531, 1.0, 0.606_531, 0.135_335, 0.011_109,
];

/// Returns the corners, clockwise in the picture, of the quadrilateral that an edge is, bright around dark. `least`
/// is the least length of its sides, px. Sorts the edge by the direction from its middle.
pub(crate) fn fit(picture: &Gray<'_>, edge: &mut [EdgePoint], least: f64) -> Option<[Point; 4]> {
    if edge.len() < LEAST_POINTS || edge.len() > 6 * (picture.width + picture.height) {
        return None;
    }
    let (low, high) = edge
        .iter()
        .fold(([i32::MAX; 2], [i32::MIN; 2]), |(low, high), point| {
            let place = point.place;
            (
                [0, 1].map(|axis| low[axis].min(place[axis])),
                [0, 1].map(|axis| high[axis].max(place[axis])),
            )
        });
    if f64::from(high[0] - low[0]) * f64::from(high[1] - low[1]) < least {
        return None;
    }
    // A point of an edge is never exactly in a direction of the middle that the order breaks at.
    let middle = [0, 1].map(|axis| f64::from(low[axis] + high[axis]) / 2.0 + [0.051_18, -0.028_581][axis]);
    let outward: f64 = edge
        .iter()
        .map(|point| {
            let parts = [0, 1]
                .map(|axis| (f64::from(point.place[axis]) - middle[axis]) * f64::from(point.toward[axis]));
            parts[0] + parts[1]
        })
        .sum();
    if outward <= 0.0 {
        return None;
    }
    edge.sort_by_cached_key(|point| {
        let [x, y] = [0, 1].map(|axis| f64::from(point.place[axis]) - middle[axis]);
        direction(x, y)
    });
    let sums = sums(picture, edge);
    let breaks = breaks(&sums)?;
    let sides = best(&sums, &breaks)?;
    let corners = corners(&sides)?;
    is_plausible(&corners, least).then_some(corners)
}

/// Returns a number that grows with the angle of a direction, clockwise in the picture from the left. It is a whole
/// number, for sorting.
fn direction(x: f64, y: f64) -> i64 {
    let slope = y / (x.abs() + y.abs());
    let quarters = match (x < 0.0, y < 0.0) {
        (false, _) => slope,
        (true, true) => -2.0 - slope,
        (true, false) => 2.0 - slope,
    };
    (quarters * 1e15) as i64
}

/// Returns the sums over the points up to each. A point counts by the contrast at its place.
fn sums(picture: &Gray<'_>, edge: &[EdgePoint]) -> Vec<Moments> {
    let mut sum = Moments::default();
    let mut sums = Vec::with_capacity(edge.len());
    for point in edge {
        let place = point.place.map(|part| f64::from(part) / 2.0 + 0.5);
        let [column, row] = place.map(|part| part as usize);
        let inside = column > 0 && row > 0 && column + 1 < picture.width && row + 1 < picture.height;
        let weight = if inside {
            let change = |from: u8, to: u8| f64::from(to) - f64::from(from);
            let x = change(picture.at(column - 1, row), picture.at(column + 1, row));
            let y = change(picture.at(column, row - 1), picture.at(column, row + 1));
            (x * x + y * y).sqrt() + 1.0
        } else {
            1.0
        };
        sum.add(place, weight);
        sums.push(sum);
    }
    sums
}

/// Returns the line through the points from one to another, both included, going around.
fn line(sums: &[Moments], from: usize, to: usize) -> FittedLine {
    let before = |index: usize| index.checked_sub(1).map(|index| sums[index]).unwrap_or_default();
    let part = sums[to].plus(&before(from), -1.0);
    if from <= to {
        part
    } else {
        part.plus(&sums[sums.len() - 1], 1.0)
    }
    .line()
}

/// Returns where the edge bends, in its order: the points around which a straight line fits worst.
fn breaks(sums: &[Moments]) -> Option<Vec<usize>> {
    let count = sums.len();
    let reach = (count / 12).min(20);
    if reach < 2 {
        return None;
    }
    let misfits: Vec<f64> = (0..count)
        .map(|index| line(sums, (index + count - reach) % count, (index + reach) % count).scatter)
        .collect();
    let smooth: Vec<f64> = (0..count)
        .map(|index| {
            let around = SMOOTH.iter().enumerate();
            around
                .map(|(at, weight)| weight * misfits[(index + count + at - SMOOTH.len() / 2) % count])
                .sum()
        })
        .collect();
    let mut peaks: Vec<usize> = (0..count)
        .filter(|&index| {
            let [before, after] = [(index + count - 1) % count, (index + 1) % count];
            smooth[index] > smooth[before] && smooth[index] > smooth[after]
        })
        .collect();
    if peaks.len() > MOST_CORNERS {
        peaks.sort_by(|&a, &b| smooth[b].total_cmp(&smooth[a]).then(a.cmp(&b)));
        peaks.truncate(MOST_CORNERS);
        peaks.sort_unstable();
    }
    (peaks.len() >= 4).then_some(peaks)
}

/// Returns the four sides between four of the breaks that fit best.
fn best(sums: &[Moments], breaks: &[usize]) -> Option<[FittedLine; 4]> {
    let count = breaks.len();
    // The line from each break to each other one, with its squared distances.
    let mut lines = vec![None; count * count];
    for from in 0..count {
        for to in (0..count).filter(|&to| to != from) {
            let line = line(sums, breaks[from], breaks[to]);
            let points = (breaks[to] + sums.len() - breaks[from]) % sums.len() + 1;
            lines[from * count + to] =
                (line.scatter <= SCATTER).then_some((line, line.scatter * points as f64));
        }
    }
    let side = |from: usize, to: usize| lines[from * count + to];
    let mut best: Option<([FittedLine; 4], f64)> = None;
    for a in 0..count {
        for b in a + 1..count {
            let Some(first) = side(a, b) else { continue };
            for c in b + 1..count {
                let Some(second) = side(b, c) else { continue };
                let [u, v] = [first.0.normal, second.0.normal];
                if (u[0] * v[0] + u[1] * v[1]).abs() > PARALLEL {
                    continue;
                }
                for d in c + 1..count {
                    let (Some(third), Some(fourth)) = (side(c, d), side(d, a)) else {
                        continue;
                    };
                    let misfit = first.1 + second.1 + third.1 + fourth.1;
                    if best.is_none_or(|(_, least)| misfit < least) {
                        best = Some(([first.0, second.0, third.0, fourth.0], misfit));
                    }
                }
            }
        }
    }
    let (lines, misfit) = best?;
    (misfit / sums.len() as f64 <= SCATTER).then_some(lines)
}

/// Returns whether four corners are those of a convex quadrilateral that is large enough, without a very sharp or
/// very flat corner.
fn is_plausible(corners: &[Point; 4], least: f64) -> bool {
    let side = |index: usize| {
        let [from, to] = [corners[index % 4], corners[(index + 1) % 4]];
        [to[0] - from[0], to[1] - from[1]]
    };
    let cross = |a: Point, b: Point| a[0] * b[1] - a[1] * b[0];
    let area = (cross(side(0), side(1)) + cross(side(2), side(3))) / 2.0;
    let bends = (0..4).all(|index| {
        let (a, b) = (side(index), side(index + 1));
        let lengths = ((a[0] * a[0] + a[1] * a[1]) * (b[0] * b[0] + b[1] * b[1])).sqrt();
        let cosine = (a[0] * b[0] + a[1] * b[1]) / lengths;
        cosine.abs() < PARALLEL && cross(a, b) > 0.0
    });
    bends && area >= 0.95 * least * least
}
