//! Scans of rooms with furniture and people that are made up, and which of their segments are legs.

use std::f64::consts::TAU;

use fastrand::Rng;
use jde_people::{DetectorSettings, Features, Segments};
use jde_types::LaserScan;

use crate::boosting::Example;

/// What a beam meets.
enum SceneShape {
    Line([[f64; 2]; 2]),
    /// Middle, semi-axes, and the angle of the first.
    Ellipse([f64; 2], [f64; 2], f64),
}

struct Scene {
    /// What there is, and whether it is a leg.
    shapes: Vec<(SceneShape, bool)>,
}

/// The lasers: the angle that they see, beams, and noise, degrees and m.
const LASERS: [(f64, usize, f64); 5] = [
    (180.0, 180, 0.005),
    (270.0, 810, 0.01),
    (360.0, 720, 0.01),
    (240.0, 683, 0.02),
    (180.0, 361, 0.012),
];
const RANGE_MAX: f64 = 12.0;
/// The share of the hits of a segment from which on it is a leg, and up to which it is none.
const SHARES: [f64; 2] = [0.7, 0.1];

/// Adds the segments of some scans to the examples.
pub(crate) fn simulate(
    scans: usize,
    settings: &DetectorSettings,
    random: &mut Rng,
    examples: &mut Vec<Example>,
) {
    let mut segments = Segments::default();
    for _ in 0..scans {
        let scene = Scene::furnished(random);
        let (degrees, beams, noise) = LASERS[random.usize(..LASERS.len())];
        let (scan, labels) = scene.scan(degrees.to_radians(), beams, noise, random);
        if segments.update(&scan, settings.jump).is_err() {
            continue;
        }
        for segment in segments.segments() {
            let features = Features::new(segments.hits(), segment);
            let hits = &segments.hits()[segment.hits.clone()];
            if !settings.admits(hits) {
                continue;
            }
            let legs = hits.iter().filter(|hit| labels[hit.beam]).count() as f64;
            let share = legs / hits.len() as f64;
            if share >= SHARES[0] || share <= SHARES[1] {
                examples.push(Example {
                    features,
                    is_leg: share >= SHARES[0],
                });
            }
        }
    }
}

fn between(random: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}

impl Scene {
    /// A room around the origin, with a laser there.
    fn furnished(random: &mut Rng) -> Self {
        let mut scene = Self { shapes: Vec::new() };
        let turn = between(random, 0.0, TAU);
        let place = |x: f64, y: f64| [x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos()];
        let [left, right, low, high] = [-1.0, 1.0, -1.0, 1.0].map(|side| side * between(random, 1.2, 9.0));
        let corners = [(left, low), (right, low), (right, high), (left, high)];
        for side in 0..4 {
            let ((ax, ay), (bx, by)) = (corners[side], corners[(side + 1) % 4]);
            let at = |share: f64| place(ax + share * (bx - ax), ay + share * (by - ay));
            // A door, and piers that stand out from the wall.
            let door = between(random, 0.1, 0.8);
            scene.line(at(0.0), at(door));
            scene.line(at((door + 0.12).min(1.0)), at(1.0));
            for _ in 0..random.usize(..3) {
                let [x, y] = at(random.f64());
                scene.block(
                    [x, y],
                    between(random, 0.05, 0.4),
                    between(random, 0.05, 0.4),
                    turn,
                );
            }
        }
        for _ in 0..random.usize(..10) {
            let middle = scene.anywhere(random, 0.8);
            scene.furniture(middle, random);
        }
        for _ in 0..random.usize(1..7) {
            let middle = scene.anywhere(random, 0.5);
            scene.person(middle, random);
        }
        scene
    }

    fn anywhere(&self, random: &mut Rng, least: f64) -> [f64; 2] {
        let (angle, range) = (between(random, 0.0, TAU), between(random, least, 8.0));
        [range * angle.cos(), range * angle.sin()]
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.shapes.push((SceneShape::Line([from, to]), false));
    }

    /// A rectangle.
    fn block(&mut self, [x, y]: [f64; 2], length: f64, width: f64, turn: f64) {
        let corner = |a: f64, b: f64| {
            let (a, b) = (a * length / 2.0, b * width / 2.0);
            [
                x + a * turn.cos() - b * turn.sin(),
                y + a * turn.sin() + b * turn.cos(),
            ]
        };
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        for side in 0..4 {
            self.line(corners[side], corners[(side + 1) % 4]);
        }
    }

    fn round(&mut self, middle: [f64; 2], radius: f64) {
        self.shapes
            .push((SceneShape::Ellipse(middle, [radius; 2], 0.0), false));
    }

    fn furniture(&mut self, middle: [f64; 2], random: &mut Rng) {
        let turn = between(random, 0.0, TAU);
        let at = |ahead: f64, left: f64| {
            let [x, y] = middle;
            [
                x + ahead * turn.cos() - left * turn.sin(),
                y + ahead * turn.sin() + left * turn.cos(),
            ]
        };
        match random.usize(..6) {
            // A cupboard or a box.
            0 | 1 => self.block(middle, between(random, 0.1, 2.0), between(random, 0.1, 0.8), turn),
            // A pillar, a bin, a plant.
            2 => self.round(middle, between(random, 0.1, 0.4)),
            // A chair or a table on four legs, round or square.
            3 | 4 => {
                let (length, width) = (between(random, 0.35, 1.6), between(random, 0.35, 0.8));
                let (thick, is_round) = (between(random, 0.01, 0.035), random.bool());
                for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                    let foot = at(a * length, b * width);
                    if is_round {
                        self.round(foot, thick);
                    } else {
                        self.block(foot, 2.0 * thick, 2.0 * thick, turn);
                    }
                }
            }
            // A chair on a star of five feet.
            _ => {
                self.round(middle, between(random, 0.025, 0.04));
                for foot in 0..5 {
                    let (sin, cos) = (f64::from(foot) * TAU / 5.0).sin_cos();
                    self.line(at(0.04 * cos, 0.04 * sin), at(0.3 * cos, 0.3 * sin));
                }
            }
        }
    }

    /// Two legs at some moment of a step, or a long coat.
    fn person(&mut self, [x, y]: [f64; 2], random: &mut Rng) {
        let heading = between(random, 0.0, TAU);
        let (sin, cos) = heading.sin_cos();
        if random.usize(..12) == 0 {
            let axes = [between(random, 0.12, 0.18), between(random, 0.15, 0.25)];
            self.shapes
                .push((SceneShape::Ellipse([x, y], axes, heading), true));
            return;
        }
        let (aside, stride) = (between(random, 0.06, 0.15), between(random, -0.3, 0.3));
        let axes = [between(random, 0.045, 0.1), between(random, 0.04, 0.075)];
        for side in [1.0, -1.0] {
            let (ahead, left) = (side * stride, side * aside);
            let middle = [x + ahead * cos - left * sin, y + ahead * sin + left * cos];
            let turned = heading + between(random, -0.4, 0.4);
            self.shapes
                .push((SceneShape::Ellipse(middle, axes, turned), true));
        }
    }

    /// Returns a scan from the origin, and which of its beams hit a leg.
    fn scan(&self, view: f64, beams: usize, noise: f64, random: &mut Rng) -> (LaserScan, Vec<bool>) {
        let mut scan = LaserScan {
            angle_min: (-view / 2.0) as f32,
            angle_increment: (view / beams as f64) as f32,
            range_min: 0.05,
            range_max: RANGE_MAX as f32,
            ..LaserScan::default()
        };
        let noise = noise * between(random, 0.5, 2.0);
        // Some lasers measure between two objects when a beam meets the edge of one.
        let mixes = random.bool();
        // Others have beams that overlap, and measure the same distance twice.
        let repeats = random.bool();
        let mut labels = Vec::new();
        let mut ranges: Vec<f64> = Vec::new();
        for beam in 0..beams {
            let (sin, cos) = scan.angle(beam).sin_cos();
            let hits = self
                .shapes
                .iter()
                .filter_map(|(shape, is_leg)| Some((shape.hit(cos, sin)?, *is_leg)));
            let (range, is_leg) = hits.fold((f64::INFINITY, false), |a, b| if b.0 < a.0 { b } else { a });
            let before = ranges.last().copied().unwrap_or(range);
            let is_mixed = mixes && (range - before).abs() > 0.1 && random.usize(..3) == 0;
            let error = noise * (0..12).map(|_| random.f64() - 0.5).sum::<f64>();
            let last = scan.ranges.last().map_or(f64::INFINITY, |&last| last.into());
            let measured =
                if repeats && last.is_finite() && (range - last).abs() < 0.05 && random.usize(..3) > 0 {
                    last
                } else if is_mixed && range.is_finite() && before.is_finite() {
                    between(random, range.min(before), range.max(before))
                } else {
                    range + error
                };
            ranges.push(range);
            labels.push(is_leg && !is_mixed);
            let is_return = measured < RANGE_MAX;
            let measured = if is_return { measured } else { f64::INFINITY };
            scan.ranges.push(measured as f32).expect("few beams");
        }
        scan.state_last_angle();
        (scan, labels)
    }
}

impl SceneShape {
    /// Returns how far a ray from the origin goes until it meets the shape.
    fn hit(&self, cos: f64, sin: f64) -> Option<f64> {
        match *self {
            Self::Line([[ax, ay], [bx, by]]) => {
                let (dx, dy) = (bx - ax, by - ay);
                let cross = cos * dy - sin * dx;
                let (range, along) = ((ax * dy - ay * dx) / cross, (ax * sin - ay * cos) / cross);
                (range > 0.0 && (0.0..=1.0).contains(&along)).then_some(range)
            }
            Self::Ellipse([x, y], [a, b], angle) => {
                let (s, c) = angle.sin_cos();
                // In the frame of its axes, scaled to a circle of radius 1.
                let scaled = |x: f64, y: f64| [(c * x + s * y) / a, (c * y - s * x) / b];
                let ([dx, dy], [mx, my]) = (scaled(cos, sin), scaled(x, y));
                let (square, along) = (dx * dx + dy * dy, dx * mx + dy * my);
                let root = along * along - square * (mx * mx + my * my - 1.0);
                let range = (along - root.max(0.0).sqrt()) / square;
                (root >= 0.0 && range > 0.0).then_some(range)
            }
        }
    }
}
