//! A closed loop for tests: walls, a laser, and a base of 0.25 m radius that follows its commands within its
//! limits. It has no noise; the applications in the simulator have.

use core::time::Duration;

use jde_motion::{BaseDynamics, Travel};
use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// The radius of the base, m.
pub(crate) const RADIUS: f64 = 0.25;
const DYNAMICS: BaseDynamics = BaseDynamics {
    acceleration: 0.3,
    deceleration: 0.3,
    turn_acceleration: 1.0,
    turn_deceleration: 1.0,
    lag: 0.0,
};
/// Steps of the base for each iteration.
const STEPS: u32 = 5;

/// A wall from one point to another, m.
pub(crate) type Wall = [(f64, f64); 2];

/// The walls of a room from one corner to the opposite one.
pub(crate) fn room(low: (f64, f64), high: (f64, f64)) -> Vec<Wall> {
    let corners = [low, (high.0, low.1), high, (low.0, high.1)];
    (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect()
}

/// A robot among walls, and the schema that drives it.
pub(crate) struct Loop<S: Schema> {
    pub(crate) bench: Bench<S>,
    pub(crate) walls: Vec<Wall>,
    pub(crate) travel: Travel,
    pub(crate) dynamics: BaseDynamics,
    /// The turn rate below which the base does not turn, rad/s.
    pub(crate) dead_band: f64,
    /// The least distance from the robot's edge to a wall so far, m.
    pub(crate) clearance: f64,
    /// The way so far, m.
    pub(crate) distance: f64,
    pub(crate) now: Duration,
}

impl<S: Schema> Loop<S> {
    /// Returns a robot that stands at `pose`; its schema is awake and has its first inputs.
    pub(crate) fn new(walls: Vec<Wall>, pose: Pose2D) -> Self {
        let mut world = Self {
            bench: Bench::new(),
            walls,
            travel: Travel {
                pose,
                ..Travel::default()
            },
            dynamics: DYNAMICS,
            dead_band: 0.0,
            clearance: f64::INFINITY,
            distance: 0.0,
            now: Duration::ZERO,
        };
        world.bench.import("dynamics", &DYNAMICS);
        world.bench.awake().expect("it awakes");
        world.sense();
        world
    }

    /// Drives for `seconds`, at most while `more` holds.
    pub(crate) fn drive_while(&mut self, seconds: u32, more: impl Fn(&Self) -> bool) {
        for _ in 0..10 * seconds {
            if !more(self) {
                return;
            }
            self.sense();
            self.bench.check().expect("the check succeeds");
            self.bench.iterate().expect("the iteration succeeds");
            let mut command: Twist = self.bench.commanded("base").expect("a command");
            if command.angular.z.abs() < self.dead_band {
                command.angular.z = 0.0;
            }
            for _ in 0..STEPS {
                let before = self.travel.pose;
                self.travel = self
                    .travel
                    .after(0.1 / f64::from(STEPS), &command, &self.dynamics);
                self.distance += before.distance_to(&self.travel.pose);
                self.clearance = self.clearance.min(self.nearest() - RADIUS);
            }
            self.now += Duration::from_millis(100);
        }
    }

    /// Gives the schema the scan, the pose and the time.
    pub(crate) fn sense(&mut self) {
        let Travel { pose, velocity, .. } = self.travel;
        let scan = scan(&self.walls, &pose);
        self.bench.set_now(self.now);
        self.bench.import("laser", &scan);
        self.bench
            .import("pose", &Odometry::planar(self.now, pose, velocity));
    }

    fn nearest(&self) -> f64 {
        let Pose2D { x, y, .. } = self.travel.pose;
        let distance = |[a, b]: &Wall| {
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let along = ((x - a.0) * dx + (y - a.1) * dy) / (dx * dx + dy * dy);
            let along = along.clamp(0.0, 1.0);
            libm::hypot(x - a.0 - along * dx, y - a.1 - along * dy)
        };
        self.walls.iter().map(distance).fold(f64::INFINITY, f64::min)
    }
}

/// What a laser of 181 beams over half a turn sees.
pub(crate) fn scan(walls: &[Wall], pose: &Pose2D) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -core::f32::consts::FRAC_PI_2,
        angle_increment: 1_f32.to_radians(),
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(181);
    for beam in 0..181 {
        let (sin, cos) = libm::sincos(pose.theta + scan.angle(beam));
        let hit = |[a, b]: &Wall| {
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let (ax, ay) = (a.0 - pose.x, a.1 - pose.y);
            let cross = cos * dy - sin * dx;
            let (range, along) = ((ax * dy - ay * dx) / cross, (ax * sin - ay * cos) / cross);
            (range >= 0.0 && (0.0..=1.0).contains(&along)).then_some(range)
        };
        let range = walls.iter().filter_map(hit).fold(f64::INFINITY, f64::min);
        scan.ranges.as_mut_slice()[beam] = if range <= 8.0 { range as f32 } else { f32::INFINITY };
    }
    scan.state_last_angle();
    scan
}
