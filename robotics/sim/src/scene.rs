//! The things that never move, in a tree that answers a ray or a distance query in logarithmic time.
//!
//! It is built anew at every change, and holds no movers and no robots.

use std::mem;

use std::cmp::Ordering;

use parry2d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry2d_f64::query::{PointQuery, Ray};

use crate::color::Color;
use crate::cone::Cone;
use crate::footprint::RobotBody;
use crate::probe::Probe;
use crate::shape::{Figure, Outline, Shape};
use crate::solid::{Solid, Surface};
use crate::sweep::{Echo, Sweep};

/// A fixed thing, before it becomes a [`Solid`].
#[derive(Clone, Debug)]
pub(crate) struct Fixture {
    pub(crate) name: String,
    pub(crate) outline: Outline,
    pub(crate) color: Color,
    /// Metres from the floor.
    pub(crate) height: f64,
    /// How bright it is to a laser: 1 for a white surface.
    pub(crate) reflectivity: f64,
    pub(crate) surface: Surface,
}

pub(crate) struct Scene {
    fixtures: Vec<Fixture>,
    solids: Vec<Solid>,
    tree: Bvh,
}

impl Scene {
    pub(crate) fn new(fixtures: Vec<Fixture>) -> Self {
        let solids: Vec<Solid> = fixtures
            .iter()
            .map(|fixture| {
                Solid::new(&fixture.outline)
                    .reflecting(fixture.reflectivity, fixture.surface)
                    .of_height(fixture.height)
            })
            .collect();
        // PLOC builds more slowly than binning and casts faster; a world rarely changes.
        let tree = Bvh::from_iter(BvhBuildStrategy::Ploc, solids.iter().map(Solid::aabb).enumerate());
        Self {
            fixtures,
            solids,
            tree,
        }
    }

    pub(crate) fn add(&mut self, added: impl IntoIterator<Item = Fixture>) {
        let mut fixtures = mem::take(&mut self.fixtures);
        fixtures.extend(added);
        *self = Self::new(fixtures);
    }

    /// Removes all things of a name. Returns whether there was one.
    pub(crate) fn remove(&mut self, name: &str) -> bool {
        let mut fixtures = mem::take(&mut self.fixtures);
        let before = fixtures.len();
        fixtures.retain(|fixture| fixture.name != name);
        let removed = fixtures.len() < before;
        *self = Self::new(fixtures);
        removed
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.solids.is_empty()
    }

    /// Returns the distance along the ray to the first thing nearer than `max`.
    pub(crate) fn cast_ray(&self, ray: &Ray, max: f64) -> Option<f64> {
        let (_, distance) = self.first(ray, max, |solid, best| solid.cast_ray(ray, best))?;
        Some(distance)
    }

    /// Returns the first thing that a ray of light at a height meets nearer than `max`.
    pub(crate) fn light(&self, ray: &Ray, max: f64, height: f64) -> Option<Echo> {
        let (solid, distance) = self.first(ray, max, |solid, best| solid.cast_light(ray, best, height))?;
        Some(Echo::of(solid, distance))
    }

    /// Returns the first thing on a ray that is nearer than `max`, by the distance that `meet` returns.
    fn first(&self, ray: &Ray, max: f64, meet: impl Fn(&Solid, f64) -> Option<f64>) -> Option<(&Solid, f64)> {
        // A ray spends most of its time on boxes that it misses, and parry's own `cast_ray` divides at each
        // of them.
        let probe = Probe::of(ray);
        let (index, distance) = self.tree.find_best(
            max,
            |node, best| probe.range_to_box(&node.aabb(), best).unwrap_or(f64::MAX),
            |index, best| meet(&self.solids[index as usize], best),
        )?;
        Some((&self.solids[index as usize], distance))
    }

    /// Lets the things meet the rays of a sweep, those nearer than its length.
    pub(crate) fn sweep(&self, sweep: &mut Sweep) {
        let near = self
            .tree
            .leaves(|node| sweep.range_to_box(&node.aabb()).is_some())
            .map(|index| {
                let solid = &self.solids[index as usize];
                (sweep.range_to_box(&solid.aabb()), solid)
            })
            .take(sweep.rays().len() + 1);
        let mut near: Vec<(Option<f64>, &Solid)> = near.collect();
        let max = sweep.max();
        if near.len() > sweep.rays().len() {
            // Among many small things a ray meets few, and the tree finds them.
            let echoes: Vec<Option<Echo>> = sweep
                .rays()
                .iter()
                .map(|ray| self.light(ray, max, sweep.height()))
                .collect();
            sweep.echoes_mut().copy_from_slice(&echoes);
            return;
        }
        // What is near hides what is behind it.
        near.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap_or(Ordering::Equal));
        for (_, solid) in near {
            sweep.meet(solid);
        }
        for echo in sweep.echoes_mut() {
            echo.take_if(|echo| echo.distance >= max);
        }
    }

    /// Returns the distance to the nearest thing in a cone that is nearer than `max`.
    pub(crate) fn nearest_in(&self, cone: &Cone, max: f64) -> Option<f64> {
        self.tree
            .find_best(
                max,
                |node, best| cone.range_to_box(&node.aabb(), best).unwrap_or(f64::MAX),
                |index, best| cone.range_to(&self.solids[index as usize], best),
            )
            .map(|(_, distance)| distance)
    }

    /// Returns the thing nearest to a body, and the gap: negative on overlap.
    pub(crate) fn nearest_to(&self, body: &RobotBody) -> Option<(&str, f64)> {
        self.tree
            .find_best(
                f64::MAX,
                |node, _| node.aabb().distance_to_local_point(body.center(), true) - body.radius(),
                |index, _| Some(body.gap_to(&self.solids[index as usize])),
            )
            .map(|(index, gap)| (self.fixtures[index as usize].name.as_str(), gap))
    }

    /// Returns the thing nearest to a point, and its distance: 0 for a point inside it.
    pub(crate) fn nearest(&self, point: Vector) -> Option<(&str, f64)> {
        self.tree
            .find_best(
                f64::MAX,
                |node, _| node.aabb().distance_to_local_point(point, true),
                |index, _| Some(self.solids[index as usize].distance_to_point(point)),
            )
            .map(|(index, distance)| (self.fixtures[index as usize].name.as_str(), distance))
    }

    /// Returns the things whose bounding boxes come within `reach` of a point.
    pub(crate) fn around(&self, point: Vector, reach: f64) -> impl Iterator<Item = &Solid> {
        let area = Aabb::from_half_extents(point, Vector::splat(reach));
        self.tree
            .leaves(move |node| node.aabb().intersects(&area))
            .map(|index| &self.solids[index as usize])
    }

    /// Returns the things whose bounding boxes come within `reach` of a solid's.
    pub(crate) fn beside(&self, solid: &Solid, reach: f64) -> impl Iterator<Item = &Solid> {
        let area = solid.aabb().loosened(reach);
        self.tree
            .leaves(move |node| node.aabb().intersects(&area))
            .map(|index| &self.solids[index as usize])
    }

    /// Returns the names of the things that are no farther from a solid than `gap`.
    pub(crate) fn near<'a>(&'a self, solid: &'a Solid, gap: f64) -> impl Iterator<Item = &'a str> {
        let area = solid.aabb().loosened(gap);
        self.tree
            .leaves(move |node| node.aabb().intersects(&area))
            .map(|index| index as usize)
            .filter(move |&index| self.solids[index].distance_to_solid(solid) <= gap)
            .map(|index| self.fixtures[index].name.as_str())
    }

    pub(crate) fn fixtures(&self) -> &[Fixture] {
        &self.fixtures
    }

    pub(crate) fn shapes(&self) -> impl Iterator<Item = Shape<'_>> {
        self.fixtures.iter().map(|fixture| Shape {
            name: &fixture.name,
            outline: fixture.outline,
            color: fixture.color,
            height: fixture.height,
            moving: false,
            figure: Figure::Upright,
        })
    }

    pub(crate) fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        (!self.is_empty())
            .then(|| self.tree.root_aabb())
            .into_iter()
            .flat_map(|area| [area.mins, area.maxs])
            .map(Into::into)
    }
}
