//! Tests of rolling balls and their energy.

use parry2d_f64::math::Vector;
use proptest::prelude::*;

use super::{LooseBodies, LooseBody, LooseShape, Obstacles};
use crate::color::Color;
use crate::shape::Outline;
use crate::solid::Solid;

/// A square of walls around the origin, with sides of 2 m.
struct Pen([Solid; 4]);

impl Pen {
    fn new() -> Self {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        Self([0, 1, 2, 3].map(|side| {
            Solid::new(&Outline::Segment {
                from: corners[side],
                to: corners[(side + 1) % 4],
            })
        }))
    }
}

impl Obstacles for Pen {
    fn nearest(&self, solid: &Solid, center: Vector, reach: f64) -> Option<(Vector, f64)> {
        let gaps = self
            .0
            .iter()
            .map(|wall| (wall.nearest(center), wall.distance_to_solid(solid)));
        gaps.filter(|(_, gap)| *gap <= reach)
            .reduce(|a, b| if b.1 < a.1 { b } else { a })
    }
}

fn ball(center: [f64; 2], mass: f64, velocity: [f64; 2]) -> LooseBody {
    let mut body = LooseBody::new(
        String::new(),
        LooseShape::Ball { radius: 0.1 },
        center,
        mass,
        Color::new(0, 0, 0),
    );
    body.velocity = Vector::from(velocity);
    body
}

fn energy(loose: &LooseBodies) -> f64 {
    loose
        .bodies
        .iter()
        .map(|body| body.mass * body.velocity.length_squared())
        .sum()
}

#[test]
fn a_ball_that_hits_one_at_rest_transfers_its_speed() {
    let mut loose = LooseBodies::new(vec![
        ball([-0.5, 0.0], 1.0, [1.0, 0.0]),
        ball([0.0, 0.0], 1.0, [0.0, 0.0]),
    ]);
    for _ in 0..40 {
        loose.roll(0.01, &Pen::new());
    }
    let [first, second] = [0, 1].map(|index| loose.bodies[index].velocity.x);
    assert!(second > 2.0 * first && first > 0.0, "{first} {second}");
}

#[test]
fn a_ball_rolls_along_a_wall_that_it_touches() {
    let mut loose = LooseBodies::new(vec![ball([-0.8, -0.9 + super::CONTACT_GAP], 1.0, [0.8, 0.0])]);
    for _ in 0..50 {
        loose.roll(0.01, &Pen::new());
    }
    let center = loose.bodies[0].center;
    assert!(center.x > -0.5 && (center.y + 0.9).abs() < 1e-5, "{center:?}");
}

proptest! {
    #[test]
    fn the_energy_of_balls_never_grows_and_they_never_overlap(
        balls in proptest::collection::vec((0.1..3.0f64, -4.0..4.0f64, -4.0..4.0f64), 9),
    ) {
        let centers = (0..9).map(|index| [f64::from(index % 3) * 0.5 - 0.5, f64::from(index / 3) * 0.5 - 0.5]);
        let bodies = centers.zip(balls).map(|(center, (mass, x, y))| ball(center, mass, [x, y]));
        let mut loose = LooseBodies::new(bodies.collect());
        let pen = Pen::new();
        let mut before = energy(&loose);
        for _ in 0..400 {
            loose.roll(0.01, &pen);
            let after = energy(&loose);
            prop_assert!(after <= before * (1.0 + 1e-12), "{} after {}", after, before);
            before = after;
            for (index, body) in loose.bodies.iter().enumerate() {
                prop_assert!(body.center.x.abs() < 0.9 && body.center.y.abs() < 0.9, "{:?}", body);
                for other in &loose.bodies[..index] {
                    prop_assert!(body.center.distance(other.center) > 0.2, "{:?} {:?}", body, other);
                }
            }
        }
    }
}
