//! Where a robot in a room is said to be, and what makes it say nothing.

mod search;

use core::f64::consts::FRAC_PI_2;

use jde_schema::bench::Bench;
use jde_schema::panel::{Button, Touch};
use jde_schema::types::Start;

use super::Mcl;
use jde_schema::prelude::*;

/// The sides of the room, m.
const ROOM_WIDTH: f64 = 5.0;
const ROOM_HEIGHT: f64 = 3.6;
/// A pillar makes every place different: its lower left corner and its side, m.
const PILLAR: (f64, f64, f64) = (3.4, 0.6, 0.8);
const RESOLUTION: f64 = 0.1;

fn is_occupied(x: f64, y: f64) -> bool {
    let is_inside = x > 0.0 && y > 0.0 && x < ROOM_WIDTH && y < ROOM_HEIGHT;
    let (left, low, side) = PILLAR;
    !is_inside || ((left..left + side).contains(&x) && (low..low + side).contains(&y))
}

/// The room with a wall of one cell, in the frame of the map with this origin.
fn room() -> Box<OccupancyGrid> {
    let mut map = OccupancyGrid::boxed();
    map.header = Header::new(Time::default(), "map");
    map.info.resolution = RESOLUTION as f32;
    (map.info.width, map.info.height) = (52, 38);
    map.info.origin = Pose2D::new(-RESOLUTION, -RESOLUTION, 0.0).into();
    for index in 0..52 * 38 {
        let at = |number: usize| (number as f64 - 0.5) * RESOLUTION;
        let is_occupied = is_occupied(at(index % 52), at(index / 52));
        map.data.push(if is_occupied { 100 } else { 0 }).expect("it fits");
    }
    map
}

/// What a laser sees from here: a beam every three degrees.
fn scan(pose: &Pose2D) -> LaserScan {
    let mut scan = LaserScan {
        angle_increment: 3_f32.to_radians(),
        range_min: 0.05,
        range_max: 8.0,
        ..LaserScan::default()
    };
    for beam in 0..120 {
        let (sin, cos) = (pose.theta + scan.angle(beam)).sin_cos();
        let way = |step: u32| f64::from(step) * 0.01;
        let hit = (0..800)
            .map(way)
            .find(|way| is_occupied(pose.x + way * cos, pose.y + way * sin));
        scan.ranges
            .push(hit.map_or(f32::INFINITY, |way| way as f32))
            .expect("it fits");
    }
    scan.state_last_angle();
    scan
}

/// A robot in the room, whose odometry begins at zero.
struct Robot {
    bench: Bench<Mcl>,
    start: Pose2D,
    truth: Pose2D,
    now: Duration,
}

impl Robot {
    fn new(start: Pose2D, initial: Option<Pose2D>) -> Self {
        let mut bench = Bench::new();
        bench.import("map", &*room());
        bench.set("initial_pose", initial.map_or(Start::NONE, Start::at));
        bench.awake().expect("it awakes");
        let now = Duration::ZERO;
        Self {
            bench,
            start,
            truth: start,
            now,
        }
    }

    fn odometry(&self) -> Odometry {
        Odometry::planar(self.now, self.start.localize(&self.truth), Twist::ZERO)
    }

    /// Goes ahead and turns, and sees what is around.
    fn step(&mut self, ahead: f64, turn: f64) {
        self.truth = self.truth.transform(&Pose2D::new(ahead, 0.0, turn));
        self.bench.import("odometry", &self.odometry());
        self.bench.import("laser", &scan(&self.truth));
        self.iterate();
    }

    fn iterate(&mut self) {
        self.now += Duration::from_millis(100);
        self.bench.set_now(self.now);
        self.bench.iterate().expect("the iteration succeeds");
    }

    /// Drives in a circle of 0.6 m around where it is.
    fn drive(&mut self, steps: usize) {
        (0..steps).for_each(|_| self.step(0.06, 0.1));
    }

    fn pose(&self) -> Option<Odometry> {
        self.bench.exported("pose")
    }

    fn words(&self) -> String {
        self.bench
            .exported::<Text<160>>("state")
            .expect("a state")
            .as_str()
            .to_owned()
    }

    #[track_caller]
    fn is_right(&self) {
        let pose = self.pose().unwrap_or_else(|| panic!("no pose: {}", self.words()));
        let away = pose.pose2d().distance_to(&self.truth);
        let turned = normalize_angle(pose.pose2d().theta - self.truth.theta).abs();
        assert!(away < 0.1 && turned < 0.05, "{away} m, {turned} rad away");
    }

    #[track_caller]
    fn says_nothing(&self, words: &str) {
        assert_eq!(self.pose(), None, "{words}");
        assert_eq!(self.bench.exported::<PoseStamped>("correction"), None, "{words}");
        assert!(self.words().contains(words), "{} for {words}", self.words());
    }
}

const START: Pose2D = Pose2D::new(1.5, 1.2, 0.3);

fn tracked() -> Robot {
    let mut robot = Robot::new(START, Some(Pose2D::new(1.6, 1.1, 0.35)));
    robot.drive(20);
    robot.is_right();
    robot
}

#[test]
fn it_follows_from_where_an_operator_says() {
    let mut robot = tracked();
    let pose = robot.pose().expect("a pose");
    assert_eq!(
        (pose.header.frame_id.as_str(), pose.child_frame_id.as_str()),
        ("map", "base_link")
    );
    let [xx, yy, turn] = [0, 7, 35].map(|at| pose.pose.covariance[at]);
    assert!(xx > 0.0 && xx < 0.01 && yy > 0.0 && yy < 0.01 && turn > 0.0 && turn < 0.01);
    let correction: PoseStamped = robot.bench.exported("correction").expect("it is sure");
    let corrected = Pose2D::from(correction.pose).transform(&robot.odometry().pose2d());
    assert!(corrected.distance_to(&pose.pose2d()) < 1e-9);
    assert!(robot.words().starts_with("sure to"), "{}", robot.words());
    // Between two scans it goes on with the odometry.
    robot.truth = robot.truth.transform(&Pose2D::new(0.05, 0.0, 0.0));
    robot.bench.import("odometry", &robot.odometry());
    robot.iterate();
    robot.is_right();
}

#[test]
fn the_velocity_bridges_the_time_between_scan_and_odometry() {
    let mut robot = tracked();
    // The odometry is 0.3 s newer than the scan, in which the robot turned by 0.6 rad.
    for _ in 0..8 {
        robot.bench.import("laser", &scan(&robot.truth));
        robot.now += Duration::from_millis(300);
        robot.bench.set_now(robot.now);
        robot.truth = robot.truth.transform(&Pose2D::new(0.0, 0.0, 0.6));
        let mut odometry = robot.odometry();
        odometry.twist.twist = Twist::planar(0.0, 2.0);
        robot.bench.import("odometry", &odometry);
        robot.bench.iterate().expect("the iteration succeeds");
    }
    robot.is_right();
}

#[test]
fn what_cannot_be_used_leaves_no_pose_and_says_why() {
    type Spoil = fn(&mut Robot);
    let spoiled: [(&str, Spoil); 9] = [
        ("there is no odometry", |robot| robot.bench.retract("odometry")),
        ("there is no odometry", |robot| {
            let nowhere = Pose2D::new(f64::NAN, 0.0, 0.0);
            robot
                .bench
                .import("odometry", &Odometry::planar(robot.now, nowhere, Twist::ZERO));
        }),
        ("there is no map", |robot| robot.bench.retract("map")),
        ("no cell of the map is free", |robot| {
            let mut map = room();
            map.data.as_mut_slice().fill(-1);
            robot.bench.import("map", &*map);
        }),
        ("the grid has 0 x 38 cells", |robot| {
            let mut map = room();
            map.info.width = 0;
            robot.bench.import("map", &*map);
        }),
        ("the map has 1976 of 380 cells", |robot| {
            let mut map = room();
            map.info.width = 10;
            robot.bench.import("map", &*map);
        }),
        ("no scan that can be used", |robot| {
            let mut turned = scan(&robot.truth);
            turned.angle_increment = f32::NAN;
            robot.bench.import("laser", &turned);
            (0..11).for_each(|_| robot.iterate());
        }),
        ("no scan that can be used", |robot| {
            robot.bench.retract("laser");
            (0..11).for_each(|_| robot.iterate());
        }),
        ("no scan that can be used", |robot| {
            // Time jumps by an hour.
            robot.now += Duration::from_secs(3600);
        }),
    ];
    for (words, spoil) in spoiled {
        let mut robot = tracked();
        spoil(&mut robot);
        robot.iterate();
        robot.says_nothing(words);
        // It goes on when all is well again.
        robot.bench.import("map", &*room());
        robot.drive(2);
        robot.is_right();
    }
}

#[test]
fn scans_that_say_nothing_are_as_none() {
    for range in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        let mut robot = tracked();
        for _ in 0..12 {
            let mut blind = scan(&robot.truth);
            blind.ranges.as_mut_slice().fill(range);
            robot.bench.import("laser", &blind);
            robot.iterate();
        }
        robot.says_nothing("no scan that can be used");
        robot.bench.import("laser", &LaserScan::default());
        robot.iterate();
        robot.says_nothing("no scan that can be used");
    }
}

#[test]
fn an_odometry_that_jumps_is_no_motion() {
    let mut robot = tracked();
    let turned = robot.odometry().pose2d().transform(&Pose2D::new(0.0, 0.0, 3.0));
    for odometry in [turned, Pose2D::new(30.0, -20.0, FRAC_PI_2)] {
        robot.start = robot.truth.transform(&odometry.localize(&Pose2D::ORIGIN));
        robot.bench.import("odometry", &robot.odometry());
        robot.iterate();
        robot.says_nothing("not been compared");
        robot.step(0.06, 0.1);
        robot.is_right();
    }
}

#[test]
fn a_map_of_another_room_is_not_believed() {
    // It is 0.8 m wider and higher, and its pillar is elsewhere.
    let mut map = room();
    (map.info.width, map.info.height) = (60, 46);
    map.data.clear();
    for index in 0..60 * 46 {
        let at = |number: usize| (number as f64 - 0.5) * RESOLUTION;
        let (x, y) = (at(index % 60), at(index / 60));
        let is_pillar = (1.0..2.0).contains(&x) && (2.4..3.2).contains(&y);
        let is_inside = x > 0.0 && y > 0.0 && x < ROOM_WIDTH + 0.8 && y < ROOM_HEIGHT + 0.8;
        let value = if is_pillar || !is_inside { 100 } else { 0 };
        map.data.push(value).expect("it fits");
    }
    let starts = [
        START,
        Pose2D::new(1.5, 1.2, 1.3),
        Pose2D::new(2.5, 1.0, 0.3),
        Pose2D::new(1.0, 1.0, 0.0),
    ];
    let sure = |start: &Pose2D, threshold: f64| {
        let mut robot = Robot::new(*start, None);
        robot.bench.set("sure_agreement", threshold);
        robot.bench.import("map", &*map);
        (0..300).any(|_| {
            robot.step(0.06, 0.1);
            robot.pose().is_some()
        })
    };
    assert!(
        starts.iter().any(|start| sure(start, 0.5)),
        "more than half of the beams agree"
    );
    assert!(!starts.iter().any(|start| sure(start, 0.7)));
}

#[test]
fn maps_of_one_cell_and_without_obstacles_say_nothing() {
    let mut one = room();
    (one.info.width, one.info.height) = (1, 1);
    one.data.clear();
    one.data.push(0).expect("it fits");
    let mut empty = room();
    empty.data.as_mut_slice().fill(0);
    for map in [one, empty] {
        let mut robot = Robot::new(START, Some(START));
        robot.bench.import("map", &*map);
        for _ in 0..30 {
            robot.step(0.06, 0.1);
            robot.says_nothing("");
        }
    }
}

#[test]
fn a_map_of_200_m_is_taken() {
    let mut map = room();
    (map.info.width, map.info.height) = (4000, 4000);
    map.data.resize(4000 * 4000).fill(-1);
    let room = room();
    for (row, cells) in room.data.chunks_exact(52).enumerate() {
        map.data.as_mut_slice()[row * 4000..][..52].copy_from_slice(cells);
    }
    let mut robot = Robot::new(START, Some(START));
    robot.bench.import("map", &*map);
    robot.drive(10);
    robot.is_right();
}

#[test]
fn the_panel_says_where_the_robot_is_or_lets_it_be_searched() {
    let mut robot = tracked();
    let panel = robot.bench.draw().expect("the panel is drawn");
    assert!(panel.texts()[0].starts_with("sure to"));
    // A click on another place, on the right one, and on one without free cells, for which all are searched.
    for (at, is_right) in [
        ([4.6, 3.2, 0.0], false),
        ([1.4, 1.4, 0.0], true),
        ([40.0, 3.2, 0.0], true),
    ] {
        let touch = Touch::Clicked {
            at,
            button: Button::Primary,
        };
        robot.bench.touch("map", touch).expect("the gesture is handled");
        robot.iterate();
        assert_eq!(robot.pose(), None);
        if is_right {
            robot.drive(60);
            robot.is_right();
        }
    }
    robot
        .bench
        .touch("anywhere", Touch::Pressed)
        .expect("the gesture is handled");
    robot.iterate();
    assert_eq!(robot.pose(), None);
    robot.drive(60);
    robot.is_right();
}

#[test]
fn a_pose_that_an_operator_writes_replaces_the_estimate() {
    let mut robot = tracked();
    robot
        .bench
        .set("initial_pose", Start::at(Pose2D::new(4.5, 3.2, 0.0)));
    robot.step(0.0, 0.0);
    assert_eq!(robot.pose(), None, "{}", robot.words());
    robot.bench.set("initial_pose", Start::at(robot.truth));
    robot.drive(3);
    robot.is_right();
}

#[test]
fn the_same_seed_gives_the_same_poses_to_the_bit() {
    let drive = || {
        let mut robot = Robot::new(START, None);
        robot.drive(60);
        robot.pose()
    };
    let pose = drive();
    assert!(pose.is_some());
    assert_eq!(pose, drive());
}

#[test]
fn what_the_robot_drove_while_it_slept_is_no_jump() {
    let mut robot = tracked();
    robot.bench.sleep().expect("it sleeps");
    robot.truth = Pose2D::new(4.5, 3.0, -2.0);
    robot.bench.import("map", &*room());
    robot.bench.awake().expect("it awakes");
    robot.step(0.0, 0.0);
    robot.is_right();
}

#[test]
fn a_reload_keeps_the_place_and_a_sleep_makes_it_unsure() {
    let mut robot = tracked();
    let saved = robot.bench.save().expect("it saves");
    let mut reloaded = Robot::new(START, None);
    reloaded.bench.restore(&saved).expect("it restores");
    // It is reloaded again before it iterates.
    let saved = reloaded.bench.save().expect("it saves");
    let mut reloaded = Robot::new(START, None);
    reloaded.bench.restore(&saved).expect("it restores");
    reloaded.truth = robot.truth;
    reloaded.drive(2);
    reloaded.is_right();
    robot.bench.sleep().expect("it sleeps");
    assert_eq!(
        robot.pose(),
        None,
        "nobody takes an old pose for one that is sure"
    );
    assert_eq!(robot.bench.exported::<PoseStamped>("correction"), None);
    robot.bench.awake().expect("it awakes");
    robot.iterate();
    robot.says_nothing("no scan that can be used");
    robot.drive(1);
    robot.is_right();
}
