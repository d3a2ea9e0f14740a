//! The polar histogram of VFH+ and the choice of a direction: pure formulas.
//!
//! It differs from the paper in one thing: a sector holds the free distance to the nearest laser point in
//! it instead of a sum over the cells of a grid, so that the result does not depend on the number of beams,
//! and the two thresholds are distances. Directions are in a frame that does not turn with the robot.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use jde_schema::types::{Point2D, normalize_angle};

/// Sectors of the histogram: 5° each, as in the paper.
pub(super) const SECTORS: usize = 72;
const WIDTH: f64 = TAU / SECTORS as f64;

/// The binary histogram, which remembers which sectors were blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Histogram {
    blocked: [bool; SECTORS],
}

/// What the histogram is made of.
pub(super) struct Surroundings<'a> {
    /// The laser points, in the frame of the base, m.
    pub(super) points: &'a [Point2D],
    /// The heading of the base, rad.
    pub(super) heading: f64,
    /// Radius of the robot with its distance to keep, by which each point grows, m.
    pub(super) enlargement: f64,
    /// Free distance below which a sector is blocked, m.
    pub(super) near: f64,
    /// Free distance from which a blocked sector is free again, m.
    pub(super) far: f64,
    /// Radius of the tightest turn at the present speed, m.
    pub(super) turn_radius: f64,
}

/// The masked histogram: the sectors that the robot can take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Free([bool; SECTORS]);

/// Weights of the angles between a direction and others, per radian.
pub(super) struct Costs {
    pub(super) target: f64,
    pub(super) heading: f64,
    pub(super) change: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            blocked: [false; SECTORS],
        }
    }
}

impl Histogram {
    /// Takes in a scan and returns the free sectors.
    pub(super) fn update(&mut self, around: &Surroundings) -> Free {
        let mut distances = [f64::INFINITY; SECTORS];
        // How far the robot can turn to either side before its arc meets a point, rad.
        let (mut left, mut right) = (PI, -PI);
        for point in around.points {
            let (distance, angle) = (libm::hypot(point.x, point.y), libm::atan2(point.y, point.x));
            let free = distance - around.enlargement;
            if free >= around.far {
                continue;
            }
            // The angle that a point covers; a point within the enlarged robot covers half of the horizon.
            let cover = if free > 0.0 {
                libm::asin(around.enlargement / distance)
            } else {
                FRAC_PI_2
            };
            let first = ((around.heading + angle - cover) / WIDTH).floor();
            let last = ((around.heading + angle + cover) / WIDTH).floor();
            for step in 0..=(last - first) as usize {
                let sector = wrapped(first, step);
                distances[sector] = distances[sector].min(free);
            }
            let turn = around.turn_radius;
            if angle >= 0.0 && libm::hypot(point.x, point.y - turn) < turn + around.enlargement {
                left = left.min(angle);
            }
            if angle <= 0.0 && libm::hypot(point.x, point.y + turn) < turn + around.enlargement {
                right = right.max(angle);
            }
        }
        let mut free = [true; SECTORS];
        for (sector, free) in free.iter_mut().enumerate() {
            let threshold = if self.blocked[sector] {
                around.far
            } else {
                around.near
            };
            self.blocked[sector] = distances[sector] < threshold;
            let angle = normalize_angle(middle(sector) - around.heading);
            // At a standstill it turns on the spot, and no arc is in the way.
            let reachable = around.turn_radius == 0.0 || (right..=left).contains(&angle);
            *free = !self.blocked[sector] && reachable;
        }
        Free(free)
    }
}

impl Free {
    /// Returns the cheapest direction for a target at `bearing`, rad; `None` if all sectors are blocked.
    ///
    /// A narrow opening has one candidate, its middle. One of at least `wide` rad has a candidate half of
    /// `wide` from each edge, and the target between them.
    pub(super) fn direction(
        &self,
        bearing: f64,
        heading: f64,
        chosen: f64,
        wide: f64,
        costs: &Costs,
    ) -> Option<f64> {
        let cost = |direction: f64| {
            let angle = |other: f64| normalize_angle(direction - other).abs();
            costs.target * angle(bearing) + costs.heading * angle(heading) + costs.change * angle(chosen)
        };
        let Some(blocked) = self.0.iter().position(|free| !free) else {
            return Some(bearing);
        };
        let mut best: Option<f64> = None;
        let mut consider = |direction: f64| {
            if best.is_none_or(|best| cost(direction) < cost(best)) {
                best = Some(direction);
            }
        };
        let mut opening = 0;
        // Once around from a blocked sector to itself, so that no opening is cut in two.
        for step in 1..=SECTORS {
            if self.0[(blocked + step) % SECTORS] {
                opening += 1;
                continue;
            }
            if opening > 0 {
                let right = (blocked + step - opening) as f64 * WIDTH;
                let width = opening as f64 * WIDTH;
                if width < wide {
                    consider(right + width / 2.0);
                } else {
                    consider(right + wide / 2.0);
                    consider(right + width - wide / 2.0);
                    let target = (bearing - right).rem_euclid(TAU);
                    if (wide / 2.0..=width - wide / 2.0).contains(&target) {
                        consider(bearing);
                    }
                }
            }
            opening = 0;
        }
        best
    }

    /// The middles of the free sectors, rad.
    pub(super) fn middles(&self) -> impl Iterator<Item = f64> + '_ {
        (0..SECTORS).filter(|&sector| self.0[sector]).map(middle)
    }
}

fn middle(sector: usize) -> f64 {
    (sector as f64 + 0.5) * WIDTH
}

fn wrapped(first: f64, step: usize) -> usize {
    (first as i64 + step as i64).rem_euclid(SECTORS as i64) as usize
}
