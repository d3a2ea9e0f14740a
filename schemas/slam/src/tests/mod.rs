//! What is said of a robot in a room that it maps, and what makes it say nothing.

mod files;

use jde_schema::bench::Bench;

use super::Slam;
use jde_schema::prelude::*;
use jde_schema::types::{Body, Mount};

/// The room and a pillar in it, lower left and upper right corners, m.
const ROOM: [f64; 4] = [0.0, 0.0, 6.0, 4.0];
const PILLAR: [f64; 4] = [3.8, 0.8, 4.6, 1.5];

fn is_in([left, low, right, high]: [f64; 4], x: f64, y: f64) -> bool {
    x > left && y > low && x < right && y < high
}

/// What a laser sees from here: a beam every two degrees.
fn scan(pose: &Pose2D) -> LaserScan {
    scan_beside(pose, &[PILLAR])
}

/// The same with other things in the room.
fn scan_beside(pose: &Pose2D, things: &[[f64; 4]]) -> LaserScan {
    let mut scan = LaserScan {
        angle_increment: 2_f32.to_radians(),
        range_min: 0.05,
        range_max: 12.0,
        ..LaserScan::default()
    };
    for beam in 0..180 {
        let (sin, cos) = (pose.theta + scan.angle(beam)).sin_cos();
        let way = |step: u32| f64::from(step) * 0.005;
        let is_free = |way: &f64| {
            let (x, y) = (pose.x + way * cos, pose.y + way * sin);
            is_in(ROOM, x, y) && !things.iter().any(|thing| is_in(*thing, x, y))
        };
        let hit = (0..2000)
            .map(way)
            .find(|way| !is_free(way))
            .expect("walls all around");
        scan.ranges.push(hit as f32).expect("it fits");
    }
    scan.state_last_angle();
    scan
}

/// A robot in the room, whose odometry begins at zero and turns too far.
struct Robot {
    bench: Bench<Slam>,
    truth: Pose2D,
    odometry: Pose2D,
    now: Duration,
}

const START: Pose2D = Pose2D::new(1.5, 1.2, 0.3);

impl Robot {
    fn new() -> Self {
        Self::with(|_| {})
    }

    fn with(set: impl FnOnce(&mut Bench<Slam>)) -> Self {
        let mut bench = Bench::new();
        bench.set("map_start_pose", START);
        set(&mut bench);
        bench.awake().expect("it awakes");
        Self {
            bench,
            truth: START,
            odometry: Pose2D::ORIGIN,
            now: Duration::ZERO,
        }
    }

    fn measured(&self) -> Odometry {
        Odometry::planar(self.now, self.odometry, Twist::ZERO)
    }

    /// Goes ahead and turns.
    fn go(&mut self, ahead: f64, turn: f64) {
        self.truth = self.truth.transform(&Pose2D::new(ahead, 0.0, turn));
        self.odometry = self.odometry.transform(&Pose2D::new(ahead, 0.0, 1.03 * turn));
    }

    /// Goes ahead and turns, and sees what is around.
    fn step(&mut self, ahead: f64, turn: f64) {
        self.go(ahead, turn);
        let laser = scan(&self.truth);
        self.look(&laser);
    }

    fn look(&mut self, laser: &LaserScan) {
        self.bench.import("odometry", &self.measured());
        self.bench.import("laser", laser);
        self.iterate();
    }

    fn iterate(&mut self) {
        self.now += Duration::from_millis(100);
        self.bench.set_now(self.now);
        self.bench.iterate().expect("the iteration succeeds");
    }

    /// Drives in a circle of 0.6 m around where it is.
    fn drive(&mut self, steps: usize) {
        self.step(0.0, 0.0);
        (0..steps).for_each(|_| self.step(0.06, 0.1));
    }

    fn pose(&self) -> Option<Odometry> {
        self.bench.exported("pose")
    }

    fn words(&self) -> String {
        let words = self.bench.exported::<Text<160>>("state").expect("a state");
        words.as_str().to_owned()
    }

    #[track_caller]
    fn is_right(&self) {
        let pose = self.pose().unwrap_or_else(|| panic!("no pose: {}", self.words()));
        let away = pose.pose2d().distance_to(&self.truth);
        let turned = normalize_angle(pose.pose2d().theta - self.truth.theta).abs();
        assert!(away < 0.05 && turned < 0.03, "{away} m, {turned} rad away");
    }

    #[track_caller]
    fn says_nothing(&self, words: &str) {
        assert_eq!(self.pose(), None, "{words}");
        assert_eq!(self.bench.exported::<PoseStamped>("correction"), None, "{words}");
        assert!(self.words().contains(words), "{} for {words}", self.words());
    }
}

fn driven() -> Robot {
    let mut robot = Robot::new();
    robot.drive(70);
    robot.is_right();
    robot
}

#[test]
fn it_says_where_the_robot_is_in_the_frame_of_the_map() {
    let mut robot = driven();
    let pose = robot.pose().expect("a pose");
    assert_eq!(
        (pose.header.frame_id.as_str(), pose.child_frame_id.as_str()),
        ("map", "base_link")
    );
    let [xx, yy, turn] = [0, 7, 35].map(|at| pose.pose.covariance[at]);
    assert!(xx > 0.0 && xx < 0.01 && yy > 0.0 && yy < 0.01 && turn > 0.0 && turn < 0.01);
    let correction: PoseStamped = robot.bench.exported("correction").expect("there is a pose");
    let corrected = Pose2D::from(correction.pose).transform(&robot.odometry);
    assert!(corrected.distance_to(&pose.pose2d()) < 1e-9);
    assert!(robot.words().contains("on known surfaces"), "{}", robot.words());
    // Between two scans it goes on with the odometry.
    robot.go(0.05, 0.0);
    robot.bench.import("odometry", &robot.measured());
    robot.iterate();
    robot.is_right();
}

#[test]
fn the_map_shows_the_walls_and_the_pillar_where_they_are() {
    let robot = driven();
    let map: &OccupancyGrid = robot.bench.exported_in_place("map").expect("a map");
    assert_eq!(map.header.frame_id.as_str(), "map");
    let origin = Pose2D::from(map.info.origin);
    let resolution = f64::from(map.info.resolution);
    let near = |x: f64, y: f64| {
        let cells = (-2..=2).flat_map(|row| (-2..=2).map(move |column| (column, row)));
        let number = |(column, row): (i32, i32)| {
            let at = |at: f64, by: i32| (at / resolution).floor() as i64 + i64::from(by);
            let cell = at(y - origin.y, row) * i64::from(map.info.width) + at(x - origin.x, column);
            map.data[usize::try_from(cell).expect("on the map")]
        };
        cells.map(number).collect::<Vec<i8>>()
    };
    for (x, y) in [(0.0, 2.0), (6.0, 2.5), (2.0, 4.0), (3.8, 1.2), (2.0, 0.0)] {
        assert!(near(x, y).contains(&100), "a wall at {x}, {y}");
    }
    for (x, y) in [(1.5, 1.2), (2.5, 2.5), (5.5, 3.5)] {
        assert!(near(x, y).iter().all(|&number| number == 0), "free at {x}, {y}");
    }
    assert!(
        near(4.3, 1.2).contains(&-1),
        "nobody saw the inside of the pillar"
    );
}

#[test]
fn a_person_who_has_gone_leaves_the_map() {
    let person = [2.8, 2.2, 3.2, 2.5];
    let mut robot = Robot::new();
    let drive = |robot: &mut Robot, things: &[[f64; 4]]| {
        for ahead in core::iter::once(0.0).chain([0.06; 70]) {
            robot.go(ahead, ahead / 0.6);
            let laser = scan_beside(&robot.truth, things);
            robot.look(&laser);
        }
        let map: &OccupancyGrid = robot.bench.exported_in_place("map").expect("a map");
        let origin = Pose2D::from(map.info.origin);
        let resolution = f64::from(map.info.resolution);
        let is_there = |&at: &usize| {
            let (column, row) = (at % map.info.width as usize, at / map.info.width as usize);
            let at = |origin: f64, cell: usize| origin + (cell as f64 + 0.5) * resolution;
            is_in([2.7, 2.1, 3.3, 2.6], at(origin.x, column), at(origin.y, row))
        };
        let cells = (0..map.data.len()).filter(is_there);
        cells.filter(|&at| map.data[at] == 100).count()
    };
    assert!(drive(&mut robot, &[PILLAR, person]) > 5, "it is on the map");
    assert_eq!(drive(&mut robot, &[PILLAR]), 0, "it has gone");
    robot.is_right();
}

#[test]
fn a_map_with_too_many_cells_gets_larger_ones_and_is_whole() {
    let mut robot = Robot::with(|bench| {
        bench.set("resolution", 0.02);
        bench.set("margin", 100.0);
    });
    robot.drive(20);
    let map = robot
        .bench
        .exported_in_place::<OccupancyGrid>("map")
        .expect("a map");
    assert!(
        (map.info.resolution - 0.08).abs() < 1e-6,
        "{} m",
        map.info.resolution
    );
    assert!(map.data.contains(&100), "it shows the room");
    let words: Vec<&String> = robot.bench.log().iter().map(|(_, words)| words).collect();
    assert_eq!(
        words,
        ["the map has more than 4096 × 4096 cells: from now on, it is drawn with cells of 0.08 m"]
    );
}

#[test]
fn what_cannot_be_used_leaves_no_pose_and_says_why() {
    type Spoil = fn(&mut Robot);
    let spoiled: [(&str, Spoil); 6] = [
        ("there is no odometry", |robot| robot.bench.retract("odometry")),
        ("there is no odometry", |robot| {
            let nowhere = Pose2D::new(f64::NAN, 0.0, 0.0);
            let odometry = Odometry::planar(robot.now, nowhere, Twist::ZERO);
            robot.bench.import("odometry", &odometry);
        }),
        ("no scan that can be used", |robot| {
            robot.bench.retract("laser");
            (0..21).for_each(|_| robot.iterate());
        }),
        ("no scan that can be used", |robot| {
            // Time jumps by an hour.
            robot.now += Duration::from_secs(3600);
        }),
        ("the scan has too few points", |robot| {
            let mut last = 0.0;
            for _ in 0..21 {
                robot.go(0.06, 0.1);
                let mut few = scan(&robot.truth);
                few.ranges.as_mut_slice()[4..].fill(f32::NAN);
                robot.look(&few);
                let Some(pose) = robot.pose() else { continue };
                let covariance = pose.pose.covariance[0] + pose.pose.covariance[7];
                assert!(
                    covariance > last,
                    "the odometry alone is less certain with each step"
                );
                last = covariance;
            }
        }),
        ("of the points are on known surfaces", |robot| {
            // A box around the laser.
            for _ in 0..30 {
                robot.go(0.02, 0.03);
                let mut laser = scan(&robot.truth);
                let mut number = 100.0 * robot.truth.x as f32;
                for range in laser.ranges.as_mut_slice() {
                    number += 1.0;
                    *range = 0.5 + 0.1 * f32::sin(number);
                }
                robot.look(&laser);
            }
        }),
    ];
    for (words, spoil) in spoiled {
        let mut robot = driven();
        spoil(&mut robot);
        robot.iterate();
        robot.says_nothing(words);
        let warnings = robot
            .bench
            .log()
            .iter()
            .filter(|(_, line)| line.starts_with("no pose: "));
        assert_eq!(warnings.count(), usize::from(words.contains("points")), "{words}");
        // It goes on when all is well again.
        robot.drive(4);
        robot.is_right();
    }
}

#[test]
fn it_waits_for_the_first_scan_that_shows_something() {
    let mut robot = Robot::new();
    robot.iterate();
    robot.says_nothing("there is no odometry");
    for range in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        let mut blind = scan(&robot.truth);
        blind.ranges.as_mut_slice().fill(range);
        robot.look(&blind);
        robot.says_nothing("no scan that can be used");
    }
    robot.drive(2);
    robot.is_right();
}

#[test]
fn an_odometry_that_jumps_is_no_motion() {
    let mut robot = driven();
    let laser = scan(&robot.truth);
    robot.look(&laser);
    robot.odometry = Pose2D::new(30.0, -20.0, 2.0);
    robot.bench.import("odometry", &robot.measured());
    robot.iterate();
    robot.is_right();
    // It stands, and sees the same to the bit.
    (0..30).for_each(|_| robot.look(&laser));
    robot.is_right();
    robot.drive(2);
    robot.is_right();
}

#[test]
fn the_velocity_bridges_the_time_between_scan_and_odometry() {
    let mut robot = driven();
    // The odometry is 0.3 s newer than the scan, in which the robot turned by 0.6 rad.
    for _ in 0..8 {
        let laser = LaserScan {
            header: Header::new(robot.now, "laser"),
            ..scan(&robot.truth)
        };
        robot.bench.import("laser", &laser);
        robot.now += Duration::from_millis(300);
        robot.bench.set_now(robot.now);
        robot.go(0.0, 0.6);
        let mut odometry = robot.measured();
        odometry.twist.twist = Twist::planar(0.0, 2.0);
        robot.bench.import("odometry", &odometry);
        robot.bench.iterate().expect("the iteration succeeds");
    }
    robot.is_right();
}

#[test]
fn the_same_scans_give_the_same_poses_to_the_bit() {
    assert_eq!(driven().pose(), driven().pose());
}

#[test]
fn a_sleep_keeps_the_map() {
    let mut robot = driven();
    robot.bench.sleep().expect("it sleeps");
    assert_eq!(robot.pose(), None, "while it sleeps");
    assert_eq!(robot.bench.exported::<PoseStamped>("correction"), None);
    // Another schema drives meanwhile.
    let elsewhere = Pose2D::new(3.0, 3.2, -0.5);
    robot.odometry = robot.odometry.transform(&robot.truth.localize(&elsewhere));
    robot.truth = elsewhere;
    robot.bench.import("odometry", &robot.measured());
    robot.bench.awake().expect("it awakes");
    robot.iterate();
    robot.says_nothing("no scan that can be used");
    robot.step(0.0, 0.0);
    robot.is_right();
}

#[test]
fn a_reload_keeps_the_place() {
    let mut robot = driven();
    let saved = robot.bench.save().expect("it saves");
    let mut reloaded = Robot::new();
    reloaded.bench.restore(&saved).expect("it restores");
    (reloaded.truth, reloaded.odometry) = (robot.truth, robot.odometry);
    reloaded.drive(2);
    reloaded.is_right();
}

#[test]
fn a_build_that_goes_on_after_a_new_one_failed_has_its_map() {
    let mut robot = driven();
    let keyframes = robot.bench.schema().slam.scans().len();
    let saved = robot.bench.save().expect("it saves");
    robot.bench.sleep().expect("it sleeps");
    robot.bench.awake().expect("it awakes");
    robot.bench.restore(&saved).expect("it restores");
    assert_eq!(robot.bench.schema().slam.scans().len(), keyframes);
    robot.drive(2);
    robot.is_right();
}

#[test]
fn a_reload_before_the_first_odometry_keeps_the_place() {
    let mut before = driven();
    let saved = before.bench.save().expect("it saves");
    let mut robot = Robot::new();
    robot.bench.restore(&saved).expect("it restores");
    (robot.truth, robot.odometry) = (before.truth, before.odometry);
    robot.drive(35);
    // It sleeps, and is reloaded as it awakes, before its base says anything.
    robot.bench.sleep().expect("it sleeps");
    robot.bench.awake().expect("it awakes");
    let saved = robot.bench.save().expect("it saves");
    let mut reloaded = Robot::new();
    reloaded.bench.restore(&saved).expect("it restores");
    (reloaded.truth, reloaded.odometry) = (robot.truth, robot.odometry);
    reloaded.drive(2);
    reloaded.is_right();
}

#[test]
fn a_robot_that_is_carried_away_has_no_pose() {
    let mut robot = driven();
    let elsewhere = scan(&Pose2D::new(5.0, 3.0, 2.0));
    (0..40).for_each(|_| robot.look(&elsewhere));
    robot.says_nothing("of the points are on known surfaces");
    let mut blocked = scan(&robot.truth);
    blocked.ranges.as_mut_slice()[4..].fill(f32::NAN);
    let mut robot = driven();
    (0..40).for_each(|_| robot.look(&blocked));
    robot.says_nothing("the scan has too few points");
}

#[test]
fn a_mount_far_from_the_base_is_refused() {
    for (x, count) in [(0.3, 0), (1e8, 1)] {
        let mut bench = Bench::<Slam>::new();
        bench.set("mount", Pose2D::new(x, 0.0, 0.0));
        assert_eq!(bench.inspect().expect("it inspects").len(), count, "{x}");
        assert_eq!(bench.awake().is_err(), count > 0, "{x}");
    }
}

#[test]
fn a_body_takes_the_place_of_the_mount() {
    let mount = Pose2D::new(0.4, 0.1, 0.5);
    let laser = Mount {
        pose: mount,
        ..Mount::default()
    };
    let body = Body {
        lasers: [laser].into_iter().collect(),
        ..Body::default()
    };
    let map = |set: &dyn Fn(&mut Bench<Slam>)| {
        let mut robot = Robot::with(|bench| set(bench));
        robot.look(&scan(&START.transform(&mount)));
        (0..20).for_each(|_| robot.iterate());
        let map: &OccupancyGrid = robot.bench.exported_in_place("map").expect("a map");
        map.data.to_vec()
    };
    let stated = map(&|bench| bench.set("mount", mount));
    assert_ne!(stated, map(&|_| {}), "the mount counts");
    assert_eq!(stated, map(&|bench| bench.import("body", &body)));
}

#[test]
fn the_panel_shows_the_map_and_has_a_button_if_there_is_a_file() {
    let mut robot = driven();
    let panel = robot.bench.draw().expect("the panel is drawn");
    assert!(panel.texts()[0].contains("keyframes"), "{:?}", panel.texts());
    assert!(panel.value("keyframes") > 3.0 && !panel.has("save"));
}
