//! Worlds of walls for tests, and what a laser sees in them.

use core::f64::consts::TAU;

use jde_types::{LaserScan, Pose2D};

use crate::scan::Scan;

pub(crate) type Wall = ((f64, f64), (f64, f64));

/// Walls, m.
#[derive(Clone, Debug, Default)]
pub(crate) struct World(pub(crate) Vec<Wall>);

impl World {
    /// The four walls between two corners.
    pub(crate) fn with_box(mut self, (left, low): (f64, f64), (right, high): (f64, f64)) -> Self {
        self.0.extend([
            ((left, low), (right, low)),
            ((right, low), (right, high)),
            ((right, high), (left, high)),
            ((left, high), (left, low)),
        ]);
        self
    }

    /// A room of 8 × 6 m with boxes at random places, none of them near its middle.
    pub(crate) fn room(seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut world = Self::default().with_box((-4.0, -3.0), (4.0, 3.0));
        while world.0.len() < 24 {
            let (x, y) = (8.0 * random.f64() - 4.0, 6.0 * random.f64() - 3.0);
            let (wide, high) = (0.2 + random.f64(), 0.2 + random.f64());
            if libm::hypot(x, y) > 2.5 {
                world = world.with_box((x, y), (x + wide, y + high));
            }
        }
        world
    }

    /// A corridor 2 m wide around a block of 10 × 8 m, with niches by which its places differ.
    pub(crate) fn ring(seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut world = Self::default()
            .with_box((-7.0, -6.0), (7.0, 6.0))
            .with_box((-5.0, -4.0), (5.0, 4.0));
        for _ in 0..14 {
            let along = 12.0 * random.f64() - 6.0;
            let size = 0.2 + 0.3 * random.f64();
            let place = match random.u8(..4) {
                0 => (along, -6.0),
                1 => (along, 6.0 - size),
                2 => (-7.0, 0.8 * along),
                _ => (7.0 - size, 0.8 * along),
            };
            world = world.with_box(place, (place.0 + size, place.1 + size));
        }
        world
    }

    /// What a laser sees all around with a beam every two degrees, with a standard deviation of 1 cm.
    pub(crate) fn laser(&self, pose: &Pose2D, random: &mut fastrand::Rng) -> LaserScan {
        let mut scan = LaserScan {
            angle_min: -core::f32::consts::PI,
            angle_increment: (TAU / 180.0) as f32,
            range_min: 0.05,
            range_max: 12.0,
            ..LaserScan::default()
        };
        for beam in 0..180 {
            let (sin, cos) = libm::sincos(pose.theta + scan.angle(beam));
            let ways = self.0.iter().filter_map(|&(from, to)| {
                let (dx, dy) = (to.0 - from.0, to.1 - from.1);
                let (x, y) = (from.0 - pose.x, from.1 - pose.y);
                let across = cos * dy - sin * dx;
                let (way, share) = ((x * dy - y * dx) / across, (x * sin - y * cos) / across);
                (way > 0.0 && (0.0..=1.0).contains(&share)).then_some(way)
            });
            let way = ways.fold(f64::INFINITY, f64::min);
            let noise = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
            scan.ranges.push((way + 0.01 * noise) as f32).expect("few beams");
        }
        scan.state_last_angle();
        scan
    }

    pub(crate) fn scan(&self, pose: &Pose2D, random: &mut fastrand::Rng) -> Scan {
        Scan::new(&self.laser(pose, random), |_| Pose2D::ORIGIN, 360, 20.0)
    }
}
