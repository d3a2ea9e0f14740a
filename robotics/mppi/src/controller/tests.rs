//! Closed loops among obstacles for every kind of base, and the repetition of a run.

use super::*;
use crate::base::{Disc, Lanes};
use crate::{Clearance, Guide, Motion, Weights};

const DIFFERENTIAL: Base = Base {
    fast: 0.5,
    reverse: 0.0,
    sideways: 0.0,
    turn: 1.0,
    turning_radius: 0.0,
    acceleration: 0.5,
    turn_acceleration: 2.0,
    lag: 0.0,
};
const SPREAD: Spread = Spread {
    deviation: [0.3, 0.2, 0.6],
    temperature: 0.1,
};
const SHAPE: Shape = Shape {
    samples: 400,
    steps: 56,
    step: 0.05,
};
const RADIUS: f32 = 0.2;
const RESOLUTION: f32 = 0.05;
const WIDTH: usize = 160;

/// A square of 8 m with obstacles, and a path through it.
struct World {
    base: Base,
    obstacles: Vec<(f32, f32)>,
    clearance: Clearance,
    path: Vec<(f32, f32)>,
    motion: Motion,
    controller: Controller,
    /// The least distance from the robot's edge to the middle of an obstacle so far, m.
    nearest: f32,
}

impl World {
    fn new(base: Base, pose: [f32; 3], path: &[(f32, f32)], obstacles: &[(f32, f32)]) -> Self {
        let mut clearance = Clearance::new(WIDTH, RESOLUTION);
        let squares: Vec<u32> = (0..WIDTH * WIDTH)
            .map(|cell| {
                let center = |at: usize| (at as f32 + 0.5) * RESOLUTION;
                let (x, y) = (center(cell % WIDTH), center(cell / WIDTH));
                let square = |&(ox, oy): &(f32, f32)| {
                    (((ox - x).powi(2) + (oy - y).powi(2)) / (RESOLUTION * RESOLUTION)) as u32
                };
                obstacles.iter().map(square).min().unwrap_or(u32::MAX)
            })
            .collect();
        clearance.set_squares(&squares);
        Self {
            base,
            obstacles: obstacles.to_vec(),
            clearance,
            path: path.to_vec(),
            motion: Motion {
                pose,
                ..Motion::default()
            },
            controller: Controller::new(SHAPE, 7),
            nearest: f32::MAX,
        }
    }

    /// The path from the place nearest to the robot on, in steps of 5 cm.
    fn guide(&self) -> Guide {
        let [x, y, _] = self.motion.pose;
        let places: Vec<(f32, f32)> = self
            .path
            .windows(2)
            .flat_map(|ends| {
                let [(ax, ay), (bx, by)] = [ends[0], ends[1]];
                let count = (libm::hypotf(bx - ax, by - ay) / 0.05) as usize;
                (0..=count).map(move |at| {
                    let share = at as f32 / count as f32;
                    (ax + share * (bx - ax), ay + share * (by - ay))
                })
            })
            .collect();
        let away = |place: &(f32, f32)| libm::hypotf(place.0 - x, place.1 - y);
        let nearest = (0..places.len()).min_by(|&a, &b| away(&places[a]).total_cmp(&away(&places[b])));
        let mut guide = Guide::new();
        // As far as the robot drives in its horizon.
        let places = places[nearest.expect("a path")..].iter().take(32).copied();
        guide.follow(self.motion.pose, places);
        guide
    }

    fn command(&mut self) -> Command {
        let guide = self.guide();
        let situation = Situation {
            start: self.motion,
            base: self.base,
            discs: &[Disc {
                x: 0.0,
                y: 0.0,
                radius: RADIUS,
            }],
            clearance: &self.clearance,
            guide: &guide,
            margin: 0.05,
            near: 0.4,
            weights: Weights::default(),
        };
        self.controller.command(&situation, &SPREAD, SHAPE.step)
    }

    fn drive(&mut self, steps: usize) {
        for _ in 0..steps {
            let command = self.command();
            let [ahead, _, turn] = command;
            assert!(
                turn.abs() * self.base.turning_radius <= ahead.abs() + 1e-6,
                "{command:?}"
            );
            let mut lanes = Lanes::all(&self.motion);
            self.base
                .advance(&mut lanes, &command.map(f32x8::splat), SHAPE.step);
            let first = |value: f32x8| value.to_array()[0];
            let (x, y) = (first(lanes.x), first(lanes.y));
            self.motion = Motion {
                pose: [x, y, libm::atan2f(first(lanes.sin), first(lanes.cos))],
                velocity: lanes.velocity.map(first),
                lead: core::array::from_fn(|part| first(lanes.target[part] - lanes.velocity[part])),
            };
            let away = |&(ox, oy): &(f32, f32)| libm::hypotf(ox - x, oy - y) - RADIUS;
            self.nearest = self.obstacles.iter().map(away).fold(self.nearest, f32::min);
        }
    }

    /// Drives until it is at its goal, where a robot would stop.
    fn arrives(&mut self, steps: usize) -> bool {
        let goal = self.path[self.path.len() - 1];
        (0..steps).any(|_| {
            self.drive(1);
            self.distance_to(goal) < 0.15
        })
    }

    fn distance_to(&self, (x, y): (f32, f32)) -> f32 {
        libm::hypotf(self.motion.pose[0] - x, self.motion.pose[1] - y)
    }
}

#[test]
fn along_a_free_path_it_drives_straight_at_nearly_full_speed_and_ends_there() {
    let mut world = World::new(DIFFERENTIAL, [1.0, 4.0, 0.0], &[(1.0, 4.0), (6.0, 4.0)], &[]);
    world.drive(100);
    assert!(world.motion.velocity[0] > 0.45, "{:?}", world.motion);
    assert!((world.motion.pose[1] - 4.0).abs() < 0.05, "{:?}", world.motion);
    world.drive(160);
    assert!(world.distance_to((6.0, 4.0)) < 0.1, "{:?}", world.motion);
}

#[test]
fn every_kind_of_base_goes_around_what_stands_on_its_path() {
    let omnidirectional = Base {
        sideways: 0.3,
        ..DIFFERENTIAL
    };
    let car = Base {
        turning_radius: 0.6,
        ..DIFFERENTIAL
    };
    let lagging = Base {
        lag: 0.3,
        ..DIFFERENTIAL
    };
    let bases = [DIFFERENTIAL, omnidirectional, car, lagging];
    for (base, middle) in bases
        .into_iter()
        .flat_map(|base| [3.7, 4.0, 4.1].map(|middle| (base, middle)))
    {
        let path = [(1.0, 4.0), (6.0, 4.0)];
        let obstacles = [(3.5, middle - 0.05), (3.5, middle + 0.05)];
        let mut world = World::new(base, [1.0, 4.0, 0.0], &path, &obstacles);
        assert!(world.arrives(300), "{base:?}, {middle}: {:?}", world.motion);
        assert!(
            world.nearest > 0.03,
            "{base:?} came as near as {} m",
            world.nearest
        );
    }
}

#[test]
fn before_a_wall_it_stands() {
    let wall: Vec<(f32, f32)> = (0..160).map(|at| (4.0, 0.05 * at as f32)).collect();
    let mut world = World::new(DIFFERENTIAL, [1.0, 4.0, 0.0], &[(1.0, 4.0), (7.0, 4.0)], &wall);
    world.drive(400);
    assert!(world.nearest > 0.0, "{} m", world.nearest);
    assert!(world.motion.velocity[0].abs() < 0.1, "{:?}", world.motion);
}

#[test]
fn a_path_behind_is_faced_by_a_turn() {
    for heading in [core::f32::consts::PI, -2.0, 2.0] {
        let mut world = World::new(DIFFERENTIAL, [2.0, 4.0, heading], &[(2.0, 4.0), (6.0, 4.0)], &[]);
        assert!(world.arrives(400), "{heading}: {:?}", world.motion);
    }
}

#[test]
fn the_same_seed_repeats_a_run_to_the_bit_and_another_does_not() {
    let run = |seed| {
        let mut world = World::new(
            DIFFERENTIAL,
            [1.0, 4.0, 0.5],
            &[(1.0, 4.0), (6.0, 4.0)],
            &[(3.0, 4.2)],
        );
        world.controller = Controller::new(SHAPE, seed);
        world.drive(20);
        let [x, y, heading] = world.motion.pose.map(f32::to_bits);
        (x, y, heading)
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn the_noise_has_mean_zero_and_deviation_one() {
    let mut random = fastrand::Rng::with_seed(3);
    let values: Vec<f32> = (0..4000)
        .flat_map(|_| {
            let (a, b) = normal_pair(&mut random);
            [a.to_array(), b.to_array()].concat()
        })
        .collect();
    let count = values.len() as f32;
    let mean = values.iter().sum::<f32>() / count;
    let variance = values.iter().map(|value| value * value).sum::<f32>() / count;
    let beyond = values.iter().filter(|value| value.abs() > 2.0).count() as f32 / count;
    assert!(
        mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03,
        "{mean}, {variance}"
    );
    assert!((beyond - 0.0455).abs() < 0.004, "{beyond} beyond two deviations");
}

#[test]
fn after_a_pause_the_sequence_is_as_much_farther() {
    let mut controller = Controller::new(SHAPE, 1);
    for (at, command) in controller.sequence.iter_mut().enumerate() {
        command[0] = at as f32;
    }
    controller.pass(0.125);
    assert!((controller.sequence[0][0] - 2.5).abs() < 1e-4);
    controller.pass(f32::INFINITY);
    assert_eq!(controller.sequence[0][0], 55.0);
    controller.stand();
    assert_eq!(controller.sequence[55], [0.0; 3]);
}
