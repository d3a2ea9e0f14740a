//! Following a line as a closed loop: bends, gaps, crossings, obstacles, and input that must not move the
//! robot.

use core::f64::consts::PI;

use jde_motion::{BaseDynamics, Travel};
use jde_schema::bench::Bench;
use jde_schema::types::{Footprint, Point2D};

use super::*;
use crate::bench::scan;

const DYNAMICS: BaseDynamics = BaseDynamics {
    acceleration: 2.5,
    deceleration: 2.5,
    turn_acceleration: 3.2,
    turn_deceleration: 3.2,
    lag: 0.0,
};
/// Half the width of the line, m.
const HALF_WIDTH: f64 = 0.01;

/// A small robot with eight cells ahead, and the distance of a point from the middle of the line, m.
struct Drive {
    bench: Bench<Line>,
    travel: Travel,
    now: Duration,
    /// The greatest distance of the base from the line so far, m.
    farthest: f64,
    line: fn(Point2D) -> f64,
}

impl Drive {
    fn new(pose: Pose2D, line: fn(Point2D) -> f64) -> Self {
        let mut bench = Bench::new();
        bench.unbind("laser");
        bench.unbind("dynamics");
        bench.set("footprint", Footprint::circle(0.1));
        bench.set("ax_max", 2.5);
        bench.set("az_max", 3.2);
        bench.awake().expect("it awakes");
        let travel = Travel {
            pose,
            ..Travel::default()
        };
        let now = Duration::ZERO;
        let mut drive = Self {
            bench,
            travel,
            now,
            farthest: 0.0,
            line,
        };
        drive.sense();
        drive
    }

    fn sense(&mut self) {
        let Travel { pose, velocity, .. } = self.travel;
        let mut sensor = LineSensor::default();
        for cell in 0..8 {
            let cell = Point2D {
                x: 0.03,
                y: 0.0333 - 0.0095 * f64::from(cell),
            };
            let (sin, cos) = pose.theta.sin_cos();
            let seen = Point2D {
                x: pose.x + cos * cell.x - sin * cell.y,
                y: pose.y + sin * cell.x + cos * cell.y,
            };
            // The edge of the line is 5 mm wide for a cell.
            let dark = ((HALF_WIDTH - (self.line)(seen)) / 0.005 + 0.5).clamp(0.0, 1.0);
            sensor.cells.push(cell).expect("there is room");
            sensor
                .brightness
                .push((0.5 - 0.5 * dark) as f32)
                .expect("there is room");
        }
        self.bench.set_now(self.now);
        self.bench.import("line_sensor", &sensor);
        self.bench
            .import("pose", &Odometry::planar(self.now, pose, velocity));
    }

    /// Drives for `seconds`, at most while it is ready. Returns whether it still is.
    fn drive(&mut self, seconds: u32) -> bool {
        for _ in 0..20 * seconds {
            self.sense();
            if !self.bench.check().expect("the check succeeds").ready {
                return false;
            }
            let command = command(&mut self.bench);
            self.travel = self.travel.after(0.05, &command, &DYNAMICS);
            self.now += Duration::from_millis(50);
            let Pose2D { x, y, .. } = self.travel.pose;
            self.farthest = self.farthest.max((self.line)(Point2D { x, y }));
        }
        true
    }
}

fn command(bench: &mut Bench<Line>) -> Twist {
    bench.iterate().expect("the iteration succeeds");
    bench.commanded("base").expect("a command")
}

fn straight(point: Point2D) -> f64 {
    point.y.abs()
}

#[test]
fn it_settles_on_the_line_from_either_side() {
    for (y, turn) in [(0.02, 0.3), (-0.02, -0.3), (0.03, -0.4), (0.0, 0.5)] {
        let mut drive = Drive::new(Pose2D::new(0.0, y, turn), straight);
        assert!(drive.drive(5), "from {y} m");
        assert!(drive.farthest < 0.05, "{} m from the line", drive.farthest);
        drive.farthest = 0.0;
        assert!(drive.drive(5));
        assert!(drive.farthest < 0.005, "{} m from the line", drive.farthest);
        assert!(drive.travel.pose.x > 1.5, "{:?}", drive.travel.pose);
    }
}

#[test]
fn it_keeps_to_bends_and_is_slower_in_narrow_ones() {
    let mut before = 0.0;
    for (radius, line) in [
        (
            0.15,
            (|point| (point.x.hypot(point.y) - 0.15).abs()) as fn(Point2D) -> f64,
        ),
        (0.3, |point| (point.x.hypot(point.y) - 0.3).abs()),
        (1.0, |point| (point.x.hypot(point.y) - 1.0).abs()),
    ] {
        for left in [1.0, -1.0] {
            let mut drive = Drive::new(Pose2D::new(0.0, -left * radius, 0.0), line);
            assert!(drive.drive(20), "it lost the bend of {radius} m");
            assert!(
                drive.farthest < 0.02,
                "{} m from a bend of {radius} m",
                drive.farthest
            );
            let speed = drive.travel.velocity.linear.x;
            assert!(
                left < 0.0 || speed > before,
                "{speed} m/s in a bend of {radius} m"
            );
            before = speed;
        }
    }
}

#[test]
fn it_crosses_a_gap_and_a_crossing_line() {
    let line = |point: Point2D| match point.x {
        // A gap of 6 cm, then a line across.
        0.5..0.56 => 1.0,
        _ => point.y.abs().min((point.x - 1.0).abs()),
    };
    let mut drive = Drive::new(Pose2D::new(0.0, 0.01, 0.0), line);
    assert!(drive.drive(12));
    assert!(drive.travel.pose.x > 1.2, "{:?}", drive.travel.pose);
    assert!(drive.travel.pose.y.abs() < 0.005, "{:?}", drive.travel.pose);
}

#[test]
fn it_finds_a_line_that_turns_off_at_a_corner() {
    // Along x, then up along y.
    let line = |point: Point2D| {
        let along = if point.x < 0.5 { point.y.abs() } else { 1.0 };
        let up = if point.y > 0.0 { (point.x - 0.5).abs() } else { 1.0 };
        along.min(up)
    };
    let mut drive = Drive::new(Pose2D::ORIGIN, line);
    assert!(drive.drive(12));
    assert!(drive.travel.pose.y > 0.4, "{:?}", drive.travel.pose);
}

#[test]
fn at_the_end_of_the_line_it_searches_over_its_distance_and_gives_up() {
    let line = |point: Point2D| if point.x < 0.5 { point.y.abs() } else { 1.0 };
    let mut drive = Drive::new(Pose2D::ORIGIN, line);
    assert_eq!(
        drive.bench.draw().expect("the panel is drawn").texts(),
        ["sees no line"]
    );
    assert!(!drive.drive(20), "it is not ready at the end");
    let beyond = drive.travel.pose.x - (0.5 - 0.03);
    assert!((0.14..0.2).contains(&beyond), "{beyond} m beyond the end");
    assert_eq!(command(&mut drive.bench), Twist::ZERO);
    assert_eq!(drive.bench.exported::<f64>("offset"), None);
}

#[test]
fn a_bright_line_on_a_dark_floor_is_a_line_too() {
    let mut bench = Drive::new(Pose2D::ORIGIN, straight).bench;
    bench.set("line", 1.0);
    bench.set("floor", 0.1);
    let mut sensor = LineSensor::default();
    for (y, brightness) in [(0.02, 0.1), (0.01, 1.0), (0.0, 0.55), (-0.01, 0.1)] {
        sensor.cells.push(Point2D { x: 0.0, y }).expect("there is room");
        sensor.brightness.push(brightness).expect("there is room");
    }
    bench.import("line_sensor", &sensor);
    assert!(command(&mut bench).angular.z > 0.0);
    let offset: f64 = bench.exported("offset").expect("it sees the line");
    assert!((offset - 0.01 / 1.5).abs() < 1e-6, "{offset} m");
    assert_eq!(bench.inspect(), Ok(vec![]));
    bench.set("floor", 0.98);
    let problems = bench.inspect().expect("it inspects");
    assert!(
        problems[0].words.contains("the floor is as bright, 0.98"),
        "{problems:?}"
    );
    bench.awake().expect("it awakes");
    assert!(!bench.check().expect("the check succeeds").ready);
    assert_eq!(command(&mut bench), Twist::ZERO);
}

#[test]
fn it_stops_before_an_obstacle_and_goes_on_when_it_is_gone() {
    let mut drive = Drive::new(Pose2D::ORIGIN, straight);
    let wall = vec![[(0.6, -1.0), (0.6, 1.0)]];
    for (walls, seconds, range) in [(&wall, 10, 0.35..0.46), (&Vec::new(), 5, 0.8..1.6)] {
        for _ in 0..20 * seconds {
            drive.bench.import("laser", &scan(walls, &drive.travel.pose));
            drive.sense();
            let command = command(&mut drive.bench);
            drive.travel = drive.travel.after(0.05, &command, &DYNAMICS);
            drive.now += Duration::from_millis(50);
        }
        assert!(range.contains(&drive.travel.pose.x), "{:?}", drive.travel.pose);
    }
}

#[test]
fn without_a_line_a_pose_or_a_scan_that_is_bound_it_is_not_ready_and_stands_still() {
    let far = |_: Point2D| 1.0;
    for spoil in [
        &(|drive: &mut Drive| {
            drive.line = far;
            drive.sense();
        }) as &dyn Fn(&mut Drive),
        &|drive| drive.bench.retract("line_sensor"),
        &|drive| drive.bench.retract("pose"),
        &|drive| {
            let mut blind = scan(&[], &Pose2D::ORIGIN);
            blind.ranges.as_mut_slice().fill(f32::NAN);
            drive.bench.import("laser", &blind);
        },
    ] {
        let mut drive = Drive::new(Pose2D::new(0.0, 0.0, PI), straight);
        spoil(&mut drive);
        assert!(!drive.bench.check().expect("the check succeeds").ready);
        assert_eq!(command(&mut drive.bench), Twist::ZERO);
    }
}
