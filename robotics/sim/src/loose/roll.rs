//! How balls roll: they slow down, and bounce softly off what they meet.
//!
//! The energy of a ball never grows by itself; only a robot that pushes it adds energy.

use parry2d_f64::math::Vector;

use super::{CONTACT_GAP, LooseBodies, LooseShape, Obstacles, penetrates_more};

/// The deceleration of rolling, in m/s²: a light ball on a carpet.
const ROLLING: f64 = 0.2;
/// The part of its speed that a ball keeps when it bounces: a soft ball.
const RESTITUTION: f64 = 0.5;
/// The greatest part of its radius that a ball rolls in one step, so that it cannot pass through a wall.
const STRIDE: f64 = 0.5;

/// What a ball meets.
enum Contact {
    /// An immovable thing, with the direction from it to the ball.
    Obstacle(Vector),
    /// Another ball.
    Ball(usize),
}

impl LooseBodies {
    /// Rolls every ball for `dt` seconds, in the order of the file.
    pub(crate) fn roll(&mut self, dt: f64, firm: &impl Obstacles) {
        for index in 0..self.bodies.len() {
            let body = &mut self.bodies[index];
            let LooseShape::Ball { radius } = body.form else {
                continue;
            };
            let speed = body.velocity.length();
            let slower = (speed - ROLLING * dt).max(0.0).min(STRIDE * radius / dt);
            if slower == 0.0 {
                body.velocity = Vector::ZERO;
                continue;
            }
            body.velocity *= slower / speed;
            let way = body.velocity * dt;
            match self.first_contact(index, way, firm) {
                Some(contact) => self.bounce(index, contact),
                None => self.bodies[index].translate(way),
            }
        }
    }

    /// Returns the nearest thing to a ball's next place, if that thing would be too near.
    fn first_contact(&self, index: usize, way: Vector, firm: &impl Obstacles) -> Option<Contact> {
        let body = &self.bodies[index];
        let (center, solid) = (body.center + way, body.translated(way));
        let firm = firm
            .nearest(&solid, center, CONTACT_GAP)
            .filter(|(_, gap)| penetrates_more(*gap, || firm.gap(&body.solid, body.center, CONTACT_GAP)))
            .map(|(point, gap)| (gap, Contact::Obstacle(center - point)));
        let others = self
            .bodies
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index);
        let loose = others.filter_map(|(other, near)| {
            let gap = near.solid.distance_to_solid(&solid);
            let meets = penetrates_more(gap, || near.solid.distance_to_solid(&body.solid));
            meets.then(|| {
                if near.is_ball() {
                    (gap, Contact::Ball(other))
                } else {
                    (gap, Contact::Obstacle(center - near.solid.nearest(center)))
                }
            })
        });
        loose
            .chain(firm)
            .reduce(|a, b| if b.0 < a.0 { b } else { a })
            .map(|(_, contact)| contact)
    }

    /// Reflects the velocity of a ball. The ball stays in place, and rolls away in the next step.
    fn bounce(&mut self, index: usize, contact: Contact) {
        match contact {
            Contact::Obstacle(away) => {
                let body = &mut self.bodies[index];
                let away = away.try_normalize().unwrap_or(Vector::ZERO);
                let nearing = body.velocity.dot(away);
                if nearing < 0.0 {
                    body.velocity -= away * ((1.0 + RESTITUTION) * nearing);
                } else {
                    // The ball has passed the point of a corner and moves away from it, yet it came too near
                    // on the way.
                    body.velocity *= -RESTITUTION;
                }
            }
            Contact::Ball(other) => {
                let apart = self.bodies[index].center - self.bodies[other].center;
                let away = apart.try_normalize().unwrap_or(Vector::ZERO);
                let nearing = (self.bodies[index].velocity - self.bodies[other].velocity).dot(away);
                if nearing < 0.0 {
                    let (mass, other_mass) = (self.bodies[index].mass, self.bodies[other].mass);
                    let impulse = -(1.0 + RESTITUTION) * nearing / (1.0 / mass + 1.0 / other_mass);
                    self.bodies[index].velocity += away * (impulse / mass);
                    self.bodies[other].velocity -= away * (impulse / other_mass);
                }
            }
        }
    }
}
