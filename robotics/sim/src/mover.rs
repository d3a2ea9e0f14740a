//! Things that move on their own along way-points, and keep a clearance to robots.
//!
//! A mover never touches a robot by its own motion. It halts when its next step would come nearer to a robot
//! than its clearance, and turns back along its way after it has waited long enough. Movers pass through one
//! another. A person is a mover with a body for sonars and bumpers, and two legs for a laser.

use std::f64::consts::PI;

use crate::color::Color;
use crate::geometry::Pose2;
use crate::loose::LooseBodies;
use crate::person::{self, Person};
use crate::shape::{Figure, Outline, Shape};
use crate::solid::Solid;

/// The body of a mover.
#[derive(Clone, Copy, Debug)]
pub(crate) enum MoverShape {
    Circle {
        radius: f64,
    },
    /// Its own x axis lies along the way.
    Box {
        size: [f64; 2],
    },
    /// Round, on two legs.
    Person {
        radius: f64,
        sits: bool,
        /// The colour that it raises.
        signal: Color,
    },
}

/// The behaviour after the last way-point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EndBehavior {
    /// It continues to the first.
    Loop,
    /// It returns the way it came.
    TurnBack,
}

/// A mover as the world file describes it.
#[derive(Clone, Debug)]
pub(crate) struct MoverConfig {
    pub(crate) name: String,
    pub(crate) body: MoverShape,
    /// Two or more points, each at a distance from the one before it.
    pub(crate) path: Vec<[f64; 2]>,
    pub(crate) at_end: EndBehavior,
    /// Metres a second.
    pub(crate) speed: f64,
    /// The gap that it keeps to robots, in metres.
    pub(crate) clearance: f64,
    /// The time that it waits before it turns back, in seconds.
    pub(crate) patience: f64,
    /// The time that it rests at every way-point, in seconds.
    pub(crate) pause: f64,
    pub(crate) color: Color,
    /// Metres above the floor.
    pub(crate) height: f64,
}

pub(crate) struct Mover {
    config: MoverConfig,
    /// Metres from the first way-point to each way-point. The last entry is the whole length of the way.
    distances: Vec<f64>,
    /// Metres along the way, from 0 to its length.
    position: f64,
    /// 1 toward the later way-points, -1 toward the earlier ones.
    direction: f64,
    /// Seconds since a robot or a loose thing halted it.
    waited: f64,
    /// Remaining seconds of its rest at a way-point.
    resting: f64,
    /// Metres that it has walked.
    walked: f64,
    halted: bool,
    /// Whether it raises its colour.
    raised: bool,
    solid: Solid,
    /// `Some` for a person only.
    legs: Option<[Solid; 2]>,
}

impl Mover {
    pub(crate) fn new(plan: MoverConfig) -> Self {
        let mut marks = vec![0.0];
        let mut length = 0.0;
        for leg in legs(&plan) {
            length += distance(leg);
            marks.push(length);
        }
        let solid = Solid::new(&outline(&plan, &marks, 0.0));
        let mut mover = Self {
            config: plan,
            distances: marks,
            position: 0.0,
            direction: 1.0,
            waited: 0.0,
            resting: 0.0,
            walked: 0.0,
            halted: false,
            raised: false,
            solid,
            legs: None,
        };
        mover.legs = mover.person().map(|person| person.legs());
        mover
    }

    /// Moves by `dt` seconds, or waits for the robots and loose things in its way.
    pub(crate) fn step(&mut self, dt: f64, robots: &[Solid], loose: &LooseBodies) {
        if self.halted {
            return;
        }
        // Half a step of tolerance: the sum of many steps is not a round number.
        if self.resting > dt / 2.0 {
            self.resting -= dt;
            return;
        }
        let stride = self.config.speed * dt;
        let (position, direction, rests) = self.rest(stride).unwrap_or_else(|| {
            let (position, direction) = self.ahead(stride);
            (position, direction, 0.0)
        });
        let next = Solid::new(&outline(&self.config, &self.distances, position));
        if robots.iter().any(|robot| self.comes_too_near(&next, robot)) || loose.blocks(&self.solid, &next) {
            self.waited += dt;
            if self.waited >= self.config.patience {
                self.direction = -self.direction;
                self.waited = 0.0;
            }
        } else {
            (self.position, self.direction, self.solid, self.waited) = (position, direction, next, 0.0);
            self.resting = rests;
            self.walked += stride;
            self.legs = self.person().map(|person| person.legs());
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.config.name
    }

    /// Stops it where it is, or lets it continue: its rest and its wait, too.
    pub(crate) fn halt(&mut self, halted: bool) {
        self.halted = halted;
    }

    /// Lets a person raise its colour or lower it.
    pub(crate) fn signal(&mut self, raised: bool) {
        self.raised = raised;
    }

    pub(crate) fn solid(&self) -> &Solid {
        &self.solid
    }

    /// Returns what a ray of light hits just above the floor.
    pub(crate) fn feet(&self) -> &[Solid] {
        match &self.legs {
            Some(legs) => legs,
            None => std::slice::from_ref(&self.solid),
        }
    }

    /// Returns the person; `None` for another body.
    pub(crate) fn person(&self) -> Option<Person> {
        let MoverShape::Person { radius, sits, signal } = self.config.body else {
            return None;
        };
        let along = place(&self.config, &self.distances, self.position);
        let turned = if self.direction > 0.0 { 0.0 } else { PI };
        Some(Person {
            pose: Pose2::new(along.x, along.y, along.heading + turned),
            stride: person::stride(self.walked),
            sits,
            radius,
            height: self.config.height,
            color: self.config.color,
            raises: self.raised.then_some(signal),
        })
    }

    pub(crate) fn shape(&self) -> Shape<'_> {
        Shape {
            name: &self.config.name,
            outline: outline(&self.config, &self.distances, self.position),
            color: self.config.color,
            height: self.config.height,
            moving: true,
            figure: self.person().map_or(Figure::Upright, |person| Figure::Person {
                heading: person.pose.heading,
            }),
        }
    }

    /// Returns its solids along its way, `stride` metres apart. On a long way the stride grows, so that there
    /// are `most` pieces.
    pub(crate) fn along(plan: &MoverConfig, stride: f64, most: usize) -> impl Iterator<Item = Solid> {
        let mover = Self::new(plan.clone());
        let stride = stride.max(mover.length() / most as f64);
        let count = (mover.length() / stride).ceil() as usize;
        (0..=count).map(move |index| {
            let position = (index as f64 * stride).min(mover.length());
            Solid::new(&outline(&mover.config, &mover.distances, position))
        })
    }

    /// Returns whether a step comes too near to a robot and nearer than now. A step away is always allowed,
    /// so that no mover waits forever. A step that leaves no gap is never a step away, even from where there
    /// was none.
    fn comes_too_near(&self, next: &Solid, robot: &Solid) -> bool {
        let gap = next.distance_to_solid(robot);
        gap < self.config.clearance && (gap == 0.0 || gap < self.solid.distance_to_solid(robot))
    }

    /// Returns its next position, direction and rest in seconds, if this stride reaches a way-point where it
    /// rests.
    fn rest(&self, stride: f64) -> Option<(f64, f64, f64)> {
        if self.config.pause == 0.0 {
            return None;
        }
        // A way-point that a rounding error misses counts as reached.
        let next = self.position + self.direction * (stride + 1e-9);
        let current = self.position;
        let between = |mark: f64| {
            if self.direction > 0.0 {
                current < mark && mark <= next
            } else {
                next <= mark && mark < current
            }
        };
        let mut marks = self.distances.iter().copied();
        // A stride may pass several way-points. The first one counts.
        let mark = if self.direction > 0.0 {
            marks.find(|&mark| between(mark))?
        } else {
            marks.rfind(|&mark| between(mark))?
        };
        // The end of a loop is its beginning.
        let start = self.config.at_end == EndBehavior::Loop && mark == self.length();
        Some((if start { 0.0 } else { mark }, self.direction, self.config.pause))
    }

    fn ahead(&self, stride: f64) -> (f64, f64) {
        let (length, target) = (self.length(), self.position + self.direction * stride);
        match self.config.at_end {
            EndBehavior::Loop => (target.rem_euclid(length), self.direction),
            EndBehavior::TurnBack => {
                // The way forward and back, unfolded, is a loop of twice its length.
                let current = if self.direction > 0.0 {
                    self.position
                } else {
                    2.0 * length - self.position
                };
                let unfolded = (current + stride).rem_euclid(2.0 * length);
                if unfolded <= length {
                    (unfolded, 1.0)
                } else {
                    (2.0 * length - unfolded, -1.0)
                }
            }
        }
    }

    fn length(&self) -> f64 {
        self.distances[self.distances.len() - 1]
    }
}

fn outline(plan: &MoverConfig, marks: &[f64], position: f64) -> Outline {
    let pose = place(plan, marks, position);
    let center = [pose.x, pose.y];
    match plan.body {
        MoverShape::Circle { radius } | MoverShape::Person { radius, .. } => {
            Outline::Circle { center, radius }
        }
        MoverShape::Box { size } => Outline::Box {
            center,
            size,
            angle: pose.heading,
        },
    }
}

fn place(plan: &MoverConfig, marks: &[f64], position: f64) -> Pose2 {
    let leg = marks[1..marks.len() - 1].partition_point(|&mark| mark <= position);
    let [from, to] = legs(plan).nth(leg).unwrap_or([plan.path[0]; 2]);
    let part = (position - marks[leg]) / (marks[leg + 1] - marks[leg]);
    Pose2::new(
        from[0] + part * (to[0] - from[0]),
        from[1] + part * (to[1] - from[1]),
        libm::atan2(to[1] - from[1], to[0] - from[0]),
    )
}

fn legs(plan: &MoverConfig) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let closing = match plan.at_end {
        EndBehavior::Loop => Some([plan.path[plan.path.len() - 1], plan.path[0]]),
        EndBehavior::TurnBack => None,
    };
    plan.path.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing)
}

fn distance([from, to]: [[f64; 2]; 2]) -> f64 {
    libm::hypot(to[0] - from[0], to[1] - from[1])
}
