//! Things that move on their own along way-points, and give way to robots.
//!
//! A mover never touches a robot by its own motion: it halts when its next step would come nearer to one than its
//! clearance, and turns back along its way when it has waited long enough. Movers pass through one another.

use crate::geometry::Pose2;
use crate::shape::{Outline, Shape};
use crate::solid::Solid;

/// What moves.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Body {
    Circle {
        radius: f64,
    },
    /// Its own x axis lies along the way.
    Box {
        size: [f64; 2],
    },
}

/// What happens after the last way-point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtEnd {
    /// It goes on to the first.
    Loop,
    /// It returns the way it came.
    TurnBack,
}

/// A mover as the world file states it.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) name: String,
    pub(crate) body: Body,
    /// Two or more, each apart from the one before it.
    pub(crate) way: Vec<[f64; 2]>,
    pub(crate) at_end: AtEnd,
    /// Metres a second.
    pub(crate) speed: f64,
    /// The gap it keeps to robots, in metres.
    pub(crate) clearance: f64,
    /// How long it waits before it turns back, in seconds.
    pub(crate) patience: f64,
}

pub(crate) struct Mover {
    plan: Plan,
    /// Metres from the first way-point to each, and after the last the whole length of the way.
    marks: Vec<f64>,
    /// Metres along the way, from 0 to its length.
    position: f64,
    /// 1 toward the later way-points, -1 toward the earlier.
    direction: f64,
    /// Seconds since it halted for a robot.
    waited: f64,
    solid: Solid,
}

/// A robot as movers see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    pub(crate) center: [f64; 2],
    pub(crate) radius: f64,
}

impl Mover {
    pub(crate) fn new(plan: Plan) -> Self {
        let mut marks = vec![0.0];
        let mut length = 0.0;
        for leg in legs(&plan) {
            length += distance(leg);
            marks.push(length);
        }
        let solid = Solid::new(&outline(&plan, &marks, 0.0));
        Self {
            plan,
            marks,
            position: 0.0,
            direction: 1.0,
            waited: 0.0,
            solid,
        }
    }

    /// Moves on by `dt` seconds, or waits for the robots in its way.
    pub(crate) fn step(&mut self, dt: f64, robots: &[Disc]) {
        let (position, direction) = self.ahead(self.plan.speed * dt);
        let next = Solid::new(&outline(&self.plan, &self.marks, position));
        if robots.iter().any(|robot| self.crowds(&next, robot)) {
            self.waited += dt;
            if self.waited >= self.plan.patience {
                self.direction = -self.direction;
                self.waited = 0.0;
            }
        } else {
            (self.position, self.direction, self.solid, self.waited) = (position, direction, next, 0.0);
        }
    }

    pub(crate) fn solid(&self) -> &Solid {
        &self.solid
    }

    pub(crate) fn shape(&self) -> Shape<'_> {
        Shape {
            name: &self.plan.name,
            outline: outline(&self.plan, &self.marks, self.position),
            moving: true,
        }
    }

    /// Where it comes along its way, at steps of `stride` metres.
    pub(crate) fn along(plan: &Plan, stride: f64) -> impl Iterator<Item = Solid> {
        let mover = Self::new(plan.clone());
        let count = (mover.length() / stride).ceil() as usize;
        (0..=count).map(move |index| {
            let position = (index as f64 * stride).min(mover.length());
            Solid::new(&outline(&mover.plan, &mover.marks, position))
        })
    }

    /// Whether a step is too near a robot and nearer than now: going away is always allowed, so that nobody waits for ever.
    fn crowds(&self, next: &Solid, robot: &Disc) -> bool {
        let disc = Solid::new(&Outline::Circle {
            center: robot.center,
            radius: robot.radius,
        });
        let gap = next.distance_to_solid(&disc);
        gap < self.plan.clearance && gap < self.solid.distance_to_solid(&disc)
    }

    fn ahead(&self, stride: f64) -> (f64, f64) {
        let (length, wanted) = (self.length(), self.position + self.direction * stride);
        match self.plan.at_end {
            AtEnd::Loop => (wanted.rem_euclid(length), self.direction),
            AtEnd::TurnBack => {
                // Unfolded there and back, the way is a loop of twice its length.
                let there = if self.direction > 0.0 {
                    self.position
                } else {
                    2.0 * length - self.position
                };
                let unfolded = (there + stride).rem_euclid(2.0 * length);
                if unfolded <= length {
                    (unfolded, 1.0)
                } else {
                    (2.0 * length - unfolded, -1.0)
                }
            }
        }
    }

    fn length(&self) -> f64 {
        self.marks[self.marks.len() - 1]
    }
}

fn outline(plan: &Plan, marks: &[f64], position: f64) -> Outline {
    let pose = place(plan, marks, position);
    let center = [pose.x, pose.y];
    match plan.body {
        Body::Circle { radius } => Outline::Circle { center, radius },
        Body::Box { size } => Outline::Box {
            center,
            size,
            angle: pose.heading,
        },
    }
}

fn place(plan: &Plan, marks: &[f64], position: f64) -> Pose2 {
    let leg = marks[1..marks.len() - 1].partition_point(|&mark| mark <= position);
    let [from, to] = legs(plan).nth(leg).unwrap_or([plan.way[0]; 2]);
    let part = (position - marks[leg]) / (marks[leg + 1] - marks[leg]);
    Pose2::new(
        from[0] + part * (to[0] - from[0]),
        from[1] + part * (to[1] - from[1]),
        libm::atan2(to[1] - from[1], to[0] - from[0]),
    )
}

fn legs(plan: &Plan) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let closing = match plan.at_end {
        AtEnd::Loop => Some([plan.way[plan.way.len() - 1], plan.way[0]]),
        AtEnd::TurnBack => None,
    };
    plan.way.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing)
}

fn distance([from, to]: [[f64; 2]; 2]) -> f64 {
    libm::hypot(to[0] - from[0], to[1] - from[1])
}
