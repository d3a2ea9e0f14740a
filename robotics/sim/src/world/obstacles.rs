//! The things that loose things cannot move: fixed things, movers and robots.
//!
//! A read-only view of the world. A robot counts as the circle around its body.

use parry2d_f64::math::Vector;

use super::World;
use crate::loose::Obstacles;
use crate::mover::Mover;
use crate::scene::Scene;
use crate::solid::Solid;

/// The immovable part of a world, with the robots at their present poses.
pub(super) struct FixedObstacles<'a> {
    scene: &'a Scene,
    movers: &'a [Mover],
    robots: Vec<Solid>,
}

impl World {
    pub(super) fn obstacles(&self) -> FixedObstacles<'_> {
        let robots = self.others(usize::MAX).map(|(_, body)| body.circle());
        FixedObstacles {
            scene: &self.scene,
            movers: &self.movers,
            robots: robots.collect(),
        }
    }
}

impl Obstacles for FixedObstacles<'_> {
    fn nearest(&self, solid: &Solid, center: Vector, reach: f64) -> Option<(Vector, f64)> {
        self.scene
            .beside(solid, reach)
            .chain(self.movers.iter().map(Mover::solid))
            .chain(&self.robots)
            .map(|thing| (thing, thing.distance_to_solid(solid)))
            .filter(|(_, gap)| *gap <= reach)
            .reduce(|a, b| if b.1 < a.1 { b } else { a })
            .map(|(thing, gap)| (thing.nearest(center), gap))
    }
}
