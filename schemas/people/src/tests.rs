//! Who is exported, in which frame and when, and what makes the schema say nothing.

use core::f64::consts::TAU;

use jde_motion::arc;
use jde_schema::bench::Bench;

use super::*;

/// The sides of the room from the middle, m.
const HALF_SIDE: f64 = 5.0;
const BEAMS: usize = 720;

/// A robot in a room before somebody who walks across.
struct Robot {
    bench: Bench<People>,
    now: Duration,
    /// The pose of the odometry's frame in the room, and of the robot there.
    origin: Pose2D,
    truth: Pose2D,
    velocity: Twist,
    /// How far the walker has come, m.
    walked: f64,
}

impl Robot {
    fn new() -> Self {
        let mut bench = Bench::new();
        bench.set("mount", Pose2D::new(-0.1, 0.05, 0.4));
        bench.awake().expect("it awakes");
        Self {
            bench,
            now: Duration::ZERO,
            origin: Pose2D::new(1.0, -2.0, 0.7),
            truth: Pose2D::new(0.0, 0.0, 0.2),
            velocity: Twist::ZERO,
            walked: 0.0,
        }
    }

    fn walker(&self) -> [f64; 2] {
        [2.0, self.walked - 2.0]
    }

    /// What the laser sees of the room and of both legs.
    fn scan(&self) -> LaserScan {
        let sensor = self.truth.transform(&Pose2D::new(-0.1, 0.05, 0.4));
        let mut scan = LaserScan {
            header: Header::new(self.now, "laser"),
            angle_increment: (TAU / BEAMS as f64) as f32,
            range_min: 0.05,
            range_max: 12.0,
            ..LaserScan::default()
        };
        let [x, y] = self.walker();
        let swing = 0.15 * (TAU * self.walked / 1.3).sin();
        let legs = [[x - 0.1, y + swing], [x + 0.1, y - swing]];
        for beam in 0..BEAMS {
            let (sin, cos) = (sensor.theta + scan.angle(beam)).sin_cos();
            let wall = |at: f64, way: f64| (HALF_SIDE.copysign(way) - at) / way;
            let walls = wall(sensor.x, cos).min(wall(sensor.y, sin));
            let leg = |[x, y]: &[f64; 2]| {
                let (x, y) = (x - sensor.x, y - sensor.y);
                let (along, aside) = (x * cos + y * sin, y * cos - x * sin);
                let inside = 0.065_f64.powi(2) - aside * aside;
                (along > 0.0 && inside > 0.0).then(|| along - inside.sqrt())
            };
            let range = legs.iter().filter_map(leg).fold(walls, f64::min);
            scan.ranges.push(range as f32).expect("few beams");
        }
        scan.state_last_angle();
        scan
    }

    fn odometry(&self) -> Odometry {
        Odometry::planar(self.now, self.origin.localize(&self.truth), self.velocity)
    }

    /// Lets 0.1 s pass.
    fn step(&mut self) {
        self.now += Duration::from_millis(100);
        self.walked += 0.08;
        self.truth = self.truth.transform(&arc(&self.velocity, 0.1));
        self.bench.set_now(self.now);
        self.bench.import("laser", &self.scan());
        self.bench.import("odometry", &self.odometry());
        self.iterate();
    }

    fn iterate(&mut self) {
        self.bench.set_now(self.now);
        self.bench.iterate().expect("the iteration succeeds");
    }

    fn persons(&self) -> Option<Persons> {
        self.bench.exported("persons")
    }

    /// Asserts that the walker alone is exported, with this number.
    #[track_caller]
    fn is_right(&self, id: u32) {
        let persons = self.persons().expect("persons are exported").persons;
        let [person] = persons.as_slice() else {
            panic!("{persons:?}")
        };
        let [x, y] = self.walker();
        let expected = self.origin.localize(&Pose2D::new(x, y, 0.0));
        let away = (person.position.x - expected.x).hypot(person.position.y - expected.y);
        assert!(away < 0.2, "{away} m away: {person:?}");
        assert_eq!(person.id, id);
    }

    #[track_caller]
    fn says_nothing(&mut self, words: &str) {
        assert_eq!(self.persons(), None, "{words}");
        let panel = self.bench.draw().expect("the panel is drawn");
        assert!(
            panel.texts()[0].contains(words),
            "{:?} for {words}",
            panel.texts()
        );
    }
}

fn tracked() -> Robot {
    let mut robot = Robot::new();
    (0..20).for_each(|_| robot.step());
    robot.is_right(1);
    robot
}

#[test]
fn a_walker_is_a_person_in_the_frame_of_the_odometry() {
    let mut robot = tracked();
    let (mut along, mut speed) = ([0.0; 2], 0.0);
    for _ in 0..15 {
        robot.step();
        robot.is_right(1);
        let persons = robot.persons().expect("a person");
        assert_eq!(persons.header, Header::new(robot.now, "odom"));
        let velocity = persons.persons[0].velocity;
        along = [along[0] + velocity[0] / 15.0, along[1] + velocity[1] / 15.0];
        speed += velocity[0].hypot(velocity[1]) / 15.0;
    }
    assert!((speed - 0.8).abs() < 0.15, "{speed}");
    let expected = core::f64::consts::FRAC_PI_2 - robot.origin.theta;
    assert!((along[1].atan2(along[0]) - expected).abs() < 0.2, "{along:?}");
}

#[test]
fn the_velocity_bridges_the_time_between_scan_and_odometry() {
    let mut robot = Robot::new();
    robot.velocity = Twist::planar(0.0, 1.5);
    for _ in 0..30 {
        robot.now += Duration::from_millis(100);
        robot.walked += 0.08;
        robot.truth = robot.truth.transform(&arc(&robot.velocity, 0.1));
        robot.bench.set_now(robot.now);
        robot.bench.import("laser", &robot.scan());
        // The odometry is 0.2 s newer than the scan.
        let (now, truth) = (robot.now, robot.truth);
        robot.now += Duration::from_millis(200);
        robot.truth = truth.transform(&arc(&robot.velocity, 0.2));
        robot.bench.set_now(robot.now);
        robot.bench.import("odometry", &robot.odometry());
        robot.iterate();
        (robot.now, robot.truth) = (now, truth);
    }
    robot.is_right(1);
}

#[test]
fn what_cannot_be_used_leaves_no_persons_and_says_why() {
    type Spoil = fn(&mut Robot);
    let spoiled: [(&str, Spoil); 5] = [
        ("there is no odometry", |robot| robot.bench.retract("odometry")),
        ("there is no odometry", |robot| {
            let nowhere = Pose2D::new(f64::NAN, 0.0, 0.0);
            robot
                .bench
                .import("odometry", &Odometry::planar(robot.now, nowhere, Twist::ZERO));
        }),
        ("no scan that can be used", |robot| {
            robot.bench.retract("laser");
            robot.now += Duration::from_secs(4);
        }),
        ("no scan that can be used", |robot| {
            for _ in 0..31 {
                robot.now += Duration::from_millis(100);
                let mut blind = robot.scan();
                blind.ranges.as_mut_slice().fill(f32::NAN);
                robot.bench.import("laser", &blind);
                robot.iterate();
            }
        }),
        ("no scan that can be used", |robot| {
            robot.now += Duration::from_secs(3600);
        }),
    ];
    for (words, spoil) in spoiled {
        let mut robot = tracked();
        spoil(&mut robot);
        robot.iterate();
        robot.says_nothing(words);
        // It goes on when all is well again.
        (0..20).for_each(|_| robot.step());
        assert_eq!(
            robot.persons().expect("persons are exported").persons.len(),
            1,
            "after: {words}"
        );
    }
}

#[test]
fn a_scan_that_fails_for_a_moment_keeps_everybody() {
    let mut robot = tracked();
    for _ in 0..3 {
        robot.now += Duration::from_millis(100);
        robot.walked += 0.08;
        robot.bench.import("laser", &LaserScan::default());
        robot.iterate();
    }
    robot.step();
    robot.is_right(1);
}

#[test]
fn persons_are_not_exported_while_the_laser_is_silent_and_keep_their_numbers() {
    let mut robot = tracked();
    for tenths in 1..=10 {
        robot.now += Duration::from_millis(100);
        robot.walked += 0.08;
        robot.iterate();
        assert_eq!(robot.persons().is_some(), tenths <= 5, "after {tenths} tenths");
    }
    robot.says_nothing("no scan that can be used");
    robot.step();
    robot.is_right(1);
}

#[test]
fn scans_that_are_equal_because_nothing_is_in_range_are_usable() {
    let mut robot = Robot::new();
    let mut free = robot.scan();
    free.ranges.as_mut_slice().fill(f32::INFINITY);
    robot.velocity = Twist::planar(0.5, 0.0);
    for _ in 0..20 {
        robot.now += Duration::from_millis(100);
        robot.truth = robot.truth.transform(&arc(&robot.velocity, 0.1));
        free.header = Header::new(robot.now, "laser");
        robot.bench.set_now(robot.now);
        robot.bench.import("laser", &free);
        robot.bench.import("odometry", &robot.odometry());
        robot.iterate();
        assert_eq!(robot.persons().map(|persons| persons.persons.len()), Some(0));
    }
}

#[test]
fn an_odometry_that_jumps_makes_everybody_new() {
    let mut robot = tracked();
    let turned = robot.origin.transform(&Pose2D::new(0.0, 0.0, 2.0));
    for (number, origin) in [(2, Pose2D::new(30.0, -20.0, 2.0)), (3, turned)] {
        robot.walked = 0.0;
        robot.origin = origin;
        robot.step();
        assert!(robot.persons().expect("a list").persons.is_empty());
        (0..20).for_each(|_| robot.step());
        robot.is_right(number);
    }
}

#[test]
fn what_was_seen_before_a_sleep_is_out_of_date() {
    let mut robot = tracked();
    robot.bench.sleep().expect("it sleeps");
    assert_eq!(robot.persons(), None);
    robot.bench.awake().expect("it awakes");
    robot.iterate();
    robot.says_nothing("no scan that can be used");
    // No number is used again.
    (0..20).for_each(|_| robot.step());
    robot.is_right(2);
}

#[test]
fn an_odometry_that_jumps_leaves_nobody_before_the_next_scan() {
    let mut robot = tracked();
    robot.now += Duration::from_millis(50);
    robot.origin = Pose2D::new(30.0, -20.0, 2.0);
    robot.bench.set_now(robot.now);
    robot.bench.import("odometry", &robot.odometry());
    robot.iterate();
    assert_eq!(robot.persons(), None);
}

#[test]
fn a_reload_uses_no_number_again() {
    let mut robot = tracked();
    let saved = robot.bench.save().expect("it saves");
    let mut next = Robot::new();
    next.bench.restore(&saved).expect("it restores");
    (0..20).for_each(|_| next.step());
    next.is_right(2);
}

#[test]
fn the_panel_draws_each_person_with_a_number() {
    let mut robot = tracked();
    let panel = robot.bench.draw().expect("the panel is drawn");
    assert!(panel.has("around") && panel.has("persons"));
    assert!(panel.texts().is_empty(), "nothing is wrong: {:?}", panel.texts());
}
