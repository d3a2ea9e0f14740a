//! How a scan fits at a pose: how many beams agree with the map there, and how far the scan speaks for the pose or
//! against it.

use crate::beams::{Beam, Beams};
use crate::field::LikelihoodField;
use crate::sensor::Likelihoods;

/// For how much a beam counts that ends at an obstacle of the map although another is on its way: what was there may have
/// been taken away.
const THROUGH: f32 = 0.5;
/// A beam says the more of a place the longer it is, up to this length, m: short ones fit into any corner.
const FAR: f32 = 1.0;
/// By how many halves a fit goes from its first step to its last.
const HALVES: usize = 3;
/// The first step of a heading, rad: half the distance of the headings of a search.
const TURN: f32 = 0.044;
/// The most rounds of each step. A pose that is not found then is as good as another start.
const ROUNDS: usize = 10;

/// How a scan fits at a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Fit {
    /// The share of the beams that end within the tolerance of an obstacle, and before which the map has none.
    pub(crate) agreeing: f32,
    /// The mean of what the beams say of the pose. A beam that ends at an obstacle speaks for it, by up to 1, the closer
    /// the more. A beam that passes through an obstacle and ends at none speaks against it, by 1: there is a wall. One
    /// that ends where the map is free says nothing: something new stands there.
    pub(crate) support: f32,
}

/// A scan on a map.
#[derive(Clone, Copy)]
pub(crate) struct Comparison<'a> {
    pub(crate) field: &'a LikelihoodField,
    pub(crate) likelihoods: &'a Likelihoods,
    pub(crate) beams: &'a Beams,
    /// How far the end of a beam that agrees may be from an obstacle, in cells.
    pub(crate) tolerance: f32,
}

impl Comparison<'_> {
    /// How the scan fits at a pose in cells.
    pub(crate) fn fit(&self, [x, y, heading]: [f32; 3]) -> Fit {
        let count = self.beams.as_slice().len().max(1) as f32;
        if !self.field.is_free(x, y) {
            return Fit {
                agreeing: 0.0,
                support: -1.0,
            };
        }
        let cell = self.likelihoods.cell();
        let (sin, cos) = libm::sincosf(heading);
        let turn = |(ahead, left): (f32, f32)| (cos * ahead - sin * left, sin * ahead + cos * left);
        let mount = turn(self.beams.mount());
        let from = (x + mount.0 / cell, y + mount.1 / cell);
        let (mut agreeing, mut support) = (0.0, 0.0);
        for Beam {
            end,
            direction,
            range,
        } in self.beams.as_slice()
        {
            let end = turn(*end);
            let length = (range / cell - self.tolerance).max(0.0);
            let distance = self.field.distance(x + end.0 / cell, y + end.1 / cell);
            let is_near = distance <= self.tolerance;
            let is_free = self.field.cast(from, turn(*direction), length) >= length;
            // At the tolerance it says nothing; a tolerance of 0 leaves what is exact.
            let close = 1.0 - distance / self.tolerance.max(f32::EPSILON);
            agreeing += f32::from(u8::from(is_near && is_free));
            let says = match (is_near, is_free) {
                (true, true) => close.max(0.0),
                (true, false) => THROUGH * close.max(0.0),
                (false, true) => 0.0,
                (false, false) => -1.0,
            };
            support += says * (range / FAR).min(1.0);
        }
        Fit {
            agreeing: agreeing / count,
            support: support / count,
        }
    }

    /// How well the ends of the beams fit at a pose.
    pub(crate) fn ends(&self, pose: [f32; 3]) -> f32 {
        self.likelihoods.of_ends(self.field, self.beams, pose)
    }

    /// Returns the pose near this one at which the ends of the beams fit best: it climbs, at first by steps of `reach`
    /// cells.
    pub(crate) fn climb(&self, mut pose: [f32; 3], reach: f32) -> [f32; 3] {
        let mut best = self.ends(pose);
        let (mut way, mut turn) = (reach, TURN);
        for _ in 0..HALVES {
            for _ in 0..ROUNDS {
                let before = best;
                for (part, step) in [(0, way), (1, way), (2, turn)] {
                    for step in [step, -step] {
                        let mut next = pose;
                        next[part] += step;
                        let score = self.ends(next);
                        if score > best {
                            (pose, best) = (next, score);
                        }
                    }
                }
                if best <= before {
                    break;
                }
            }
            (way, turn) = (way / 2.0, turn / 2.0);
        }
        pose
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{LaserScan, Pose2D};

    use super::*;
    use crate::field::tests::map;
    use crate::sensor::Sensor;

    /// In a corridor with a pillar: beams straight ahead of this length, m.
    fn at(range: f32) -> Fit {
        let field = LikelihoodField::new(&map(&[
            "####################",
            "#.....#........#   #",
            "####################",
        ]));
        let mut scan = LaserScan {
            // Too little to matter.
            angle_increment: 1e-9,
            range_max: 40.0,
            ..LaserScan::default()
        };
        (0..12).for_each(|_| scan.ranges.push(range).expect("few beams"));
        scan.state_last_angle();
        let mut beams = Beams::new(12);
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        let likelihoods = Likelihoods::new(Sensor::default(), 1.0);
        let scan = Comparison {
            field: &field,
            likelihoods: &likelihoods,
            beams: &beams,
            tolerance: 0.5,
        };
        scan.fit([1.5, 1.5, 0.0])
    }

    #[test]
    fn what_is_new_says_nothing_and_what_lies_behind_a_wall_speaks_against_a_place() {
        let fit = |agreeing, support| Fit { agreeing, support };
        // At the pillar, before it where it is free, at the wall behind it, and in the middle between both.
        assert_eq!(at(4.6), fit(1.0, 1.0));
        assert_eq!(at(2.0), fit(0.0, 0.0));
        assert_eq!(at(13.6), fit(0.0, THROUGH));
        assert_eq!(at(9.0), fit(0.0, -1.0));
    }

    #[test]
    fn short_beams_say_little() {
        let field = LikelihoodField::new(&map(&["###", "#.#", "###"]));
        let mut beams = Beams::new(12);
        let mut scan = LaserScan {
            angle_increment: core::f32::consts::TAU / 12.0,
            range_max: 8.0,
            ..LaserScan::default()
        };
        (0..12).for_each(|_| scan.ranges.push(0.2).expect("few beams"));
        scan.state_last_angle();
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        let likelihoods = Likelihoods::new(Sensor::default(), 0.2);
        let scan = Comparison {
            field: &field,
            likelihoods: &likelihoods,
            beams: &beams,
            tolerance: 1.25,
        };
        let fit = scan.fit([1.5, 1.5, 0.0]);
        assert!(fit.agreeing == 1.0 && fit.support <= 0.21, "{fit:?}");
    }
}
