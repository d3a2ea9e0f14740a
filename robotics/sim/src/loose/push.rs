//! How a robot pushes loose things: everything that its body would enter moves away by the least distance
//! that makes room.
//!
//! There is no friction: a thing moves along the line of contact. A pushed thing takes along what it meets.

use parry2d_f64::math::Vector;

use super::{CONTACT_GAP, LooseBodies, LooseBody, LooseShape, Obstacles, penetrates_more};

/// How many times pushed things may come back into the way of the same body, in one piece of its way.
const ROUNDS: usize = 4;

/// A round body that pushes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pusher {
    pub(crate) radius: f64,
    /// The heaviest load that it can push, in kilograms.
    pub(crate) strength: f64,
}

impl LooseBodies {
    /// Makes room for a body at a point that it reaches within `dt` seconds.
    ///
    /// Returns the kilograms that moved. Returns `None` if something blocks the things or they are too heavy;
    /// then nothing has moved.
    pub(crate) fn push_away(
        &mut self,
        pusher: Pusher,
        center: Vector,
        dt: f64,
        firm: &impl Obstacles,
    ) -> Option<f64> {
        if !self
            .bodies
            .iter()
            .any(|body| depth(body, pusher, center).is_some())
        {
            return Some(0.0);
        }
        let before = self.bodies.clone();
        let load = self.push_once(pusher, center, dt, firm);
        if load.is_none() {
            self.bodies = before;
        }
        load
    }

    fn push_once(&mut self, pusher: Pusher, center: Vector, dt: f64, firm: &impl Obstacles) -> Option<f64> {
        let mut moved = vec![false; self.bodies.len()];
        for _ in 0..ROUNDS {
            let mut room = true;
            for index in 0..self.bodies.len() {
                let Some(way) = depth(&self.bodies[index], pusher, center) else {
                    continue;
                };
                room = false;
                self.shift(
                    index,
                    way,
                    dt,
                    &mut vec![false; self.bodies.len()],
                    &mut moved,
                    firm,
                )?;
                if self.weight(&moved) > pusher.strength {
                    return None;
                }
            }
            if room {
                return Some(self.weight(&moved));
            }
        }
        None
    }

    /// Moves a thing, and by the same displacement everything that it meets. `chain` marks the things that
    /// already move so.
    fn shift(
        &mut self,
        index: usize,
        way: Vector,
        dt: f64,
        chain: &mut [bool],
        moved: &mut [bool],
        firm: &impl Obstacles,
    ) -> Option<()> {
        chain[index] = true;
        moved[index] = true;
        let body = &self.bodies[index];
        let next = body.translated(way);
        let gap = firm.gap(&next, body.center + way, CONTACT_GAP);
        if penetrates_more(gap, || firm.gap(&body.solid, body.center, CONTACT_GAP)) {
            return None;
        }
        for other in 0..self.bodies.len() {
            let (body, touched) = (&self.bodies[index], &self.bodies[other]);
            let meets = !chain[other]
                && penetrates_more(touched.solid.distance_to_solid(&next), || {
                    touched.solid.distance_to_solid(&body.solid)
                });
            if meets {
                self.shift(other, way, dt, chain, moved, firm)?;
            }
        }
        let body = &mut self.bodies[index];
        body.translate(way);
        if let LooseShape::Ball { .. } = body.form {
            let (ahead, speed) = (way.normalize(), way.length() / dt);
            // It rolls on at least as fast as it was pushed, and no slower than it rolled before.
            body.velocity += ahead * (speed - body.velocity.dot(ahead)).max(0.0);
        }
        Some(())
    }

    fn weight(&self, moved: &[bool]) -> f64 {
        let heavy = self.bodies.iter().zip(moved).filter(|(_, moved)| **moved);
        heavy.map(|(body, _)| body.mass).sum()
    }
}

/// Returns the displacement that frees a thing from the body at a point, if the body enters the thing.
fn depth(body: &LooseBody, pusher: Pusher, center: Vector) -> Option<Vector> {
    let away = body.solid.nearest(center) - center;
    let gap = away.length() - pusher.radius;
    // A centre inside the thing has no way out. The pieces of a way are too short to get there.
    (gap < 0.0 && away.length() > 0.0).then(|| away.normalize() * (CONTACT_GAP - gap))
}
