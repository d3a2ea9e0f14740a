//! What a trajectory costs: its distance from the path and how far behind it stays, obstacles, driving backward
//! or sideways, and turning.

use wide::f32x8;

use crate::base::{Base, Disc, Lanes, Motion};
use crate::clearance::Clearance;
use crate::guide::Guide;

/// The cost of a step in contact with an obstacle. It outweighs all that a whole trajectory can cost otherwise.
const CONTACT: f32 = 200.0;
/// Each of so many steps is compared with the path. At 50 ms a step, the path is compared every 0.2 s.
const STRIDE: usize = 4;

/// The weights of the critics, each for its unit. A critic of weight 0 has no effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Of the mean distance to the path, 1/m.
    pub path: f32,
    /// Of the mean way by which it stays behind one that drives along the path at full speed, 1/m.
    pub progress: f32,
    /// Of the error of the last heading, 1/rad, if the guide has one.
    pub heading: f32,
    /// Of the mean squared lack of clearance, as a share of [`Situation::near`].
    pub obstacle: f32,
    /// Of the mean speed backward and to a side, s/m.
    pub forward: f32,
    /// Of the mean squared turn rate, s²/rad².
    pub effort: f32,
}

/// Weights that suit an indoor robot of half a metre per second.
impl Default for Weights {
    fn default() -> Self {
        Self {
            path: 2.0,
            progress: 15.0,
            heading: 3.0,
            obstacle: 4.0,
            forward: 5.0,
            effort: 0.3,
        }
    }
}

/// What a controller plans for.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Where the base is and how it moves.
    pub start: Motion,
    /// What the base can do.
    pub base: Base,
    /// The discs that cover the footprint.
    pub discs: &'a [Disc],
    /// The obstacles.
    pub clearance: &'a Clearance,
    /// The path.
    pub guide: &'a Guide,
    /// Clearance below which a trajectory counts as in contact, m.
    pub margin: f32,
    /// Clearance below which a trajectory costs more, m.
    pub near: f32,
    /// The weights of the critics.
    pub weights: Weights,
}

impl Situation<'_> {
    /// Rolls out the commands of eight trajectories with steps of `step` s, and returns their costs.
    pub(crate) fn cost(&self, commands: &[[f32x8; 3]], step: f32) -> f32x8 {
        let mut lanes = Lanes::all(&self.start);
        let (mut near, mut contact, mut aside, mut effort) =
            (f32x8::ZERO, f32x8::ZERO, f32x8::ZERO, f32x8::ZERO);
        let (mut away, mut behind, mut compared) = (f32x8::ZERO, f32x8::ZERO, 0);
        let (margin, scale) = (f32x8::splat(self.margin), f32x8::splat(1.0 / self.near.max(1e-3)));
        for (place, command) in commands.iter().enumerate() {
            self.base.advance(&mut lanes, command, step);
            let clearance = self.clearance(&lanes);
            let lack = (f32x8::ONE - clearance * scale).fast_max(f32x8::ZERO);
            near += lack * lack;
            contact += clearance.simd_lt(margin) & f32x8::ONE;
            let [ahead, left, turn] = lanes.velocity;
            aside += (-ahead).fast_max(f32x8::ZERO) + left.abs();
            effort += turn * turn;
            if (place + 1) % STRIDE == 0 {
                let reach = self.base.fast * step * (place + 1) as f32;
                let (square, way) = self.guide.nearest(lanes.x, lanes.y, reach);
                away += square.sqrt();
                behind += f32x8::splat(reach.min(self.guide.length())) - way;
                compared += 1;
            }
        }
        let Weights {
            path,
            progress,
            heading,
            obstacle,
            forward,
            effort: turning,
        } = self.weights;
        let (steps, compared) = (commands.len().max(1) as f32, compared.max(1) as f32);
        let mean = |sum: f32x8, count: f32, weight: f32| sum * f32x8::splat(weight / count);
        let mut cost = contact * f32x8::splat(CONTACT)
            + mean(near, steps, obstacle)
            + mean(aside, steps, forward)
            + mean(effort, steps, turning)
            + mean(away, compared, path)
            + mean(behind, compared, progress);
        if let Some(goal) = self.guide.heading {
            let (sin, cos) = libm::sincosf(goal);
            let (sin, cos) = (f32x8::splat(sin), f32x8::splat(cos));
            let error = (lanes.sin * cos - lanes.cos * sin).atan2(lanes.cos * cos + lanes.sin * sin);
            cost += error.abs() * f32x8::splat(heading);
        }
        cost
    }

    /// The distances from the footprints to the nearest obstacles, m.
    fn clearance(&self, lanes: &Lanes) -> f32x8 {
        let mut least = f32x8::splat(f32::MAX);
        for disc in self.discs {
            let (ahead, left) = (f32x8::splat(disc.x), f32x8::splat(disc.y));
            let x = lanes.x + lanes.cos * ahead - lanes.sin * left;
            let y = lanes.y + lanes.sin * ahead + lanes.cos * left;
            least = least.fast_min(self.clearance.at(x, y) - f32x8::splat(disc.radius));
        }
        least
    }
}
