//! Robots whose odometry drifts, in worlds that they do not know.

use core::f64::consts::PI;

use jde_types::LaserScan;

use super::*;
use crate::world::World;

/// A robot whose odometry turns too far and goes too far.
struct Robot {
    slam: Slam,
    settings: Settings,
    world: World,
    truth: Pose2D,
    odometry: Pose2D,
    random: fastrand::Rng,
    /// How much the odometry errs, as a part of its usual error.
    drift: f64,
    /// How far it sees within a narrow view, m; all around if there is none.
    reach: Option<f32>,
}

impl Robot {
    fn new(world: World, start: Pose2D) -> Self {
        let mut robot = Self {
            slam: Slam::new(start),
            settings: Settings::default(),
            world,
            truth: start,
            odometry: Pose2D::ORIGIN,
            random: fastrand::Rng::with_seed(7),
            drift: 1.0,
            reach: None,
        };
        robot.step(0.0, 0.0);
        robot
    }

    fn step(&mut self, way: f64, turn: f64) {
        self.truth = self.truth.transform(&Pose2D::new(way, 0.0, turn));
        let drift = Pose2D::new(
            (1.0 + 0.03 * self.drift) * way,
            0.01 * self.drift * way,
            (1.0 + 0.03 * self.drift) * turn + 0.02 * self.drift * way,
        );
        self.odometry = self.odometry.transform(&drift);
        let scan = match self.reach {
            Some(reach) => {
                let seen = narrow(self.world.laser(&self.truth, &mut self.random), reach);
                Scan::new(&seen, |_| Pose2D::ORIGIN, 360, 20.0)
            }
            None => self.world.scan(&self.truth, &mut self.random),
        };
        self.slam.step(&self.settings, &self.odometry, &scan);
        self.slam.advance(&self.settings);
    }

    /// Drives ahead, then turns left.
    fn drive(&mut self, way: f64, turn: f64) {
        (0..(way / 0.1).round() as usize).for_each(|_| self.step(0.1, 0.0));
        (0..10).for_each(|_| self.step(0.0, turn / 10.0));
    }

    fn round(&mut self) {
        for way in [12.0, 10.0, 12.0, 10.0] {
            self.drive(way, core::f64::consts::FRAC_PI_2);
        }
    }

    fn error(&self) -> f64 {
        let anchor = self.slam.anchor(&self.odometry).expect("there is a scan");
        self.slam.place(&anchor).distance_to(&self.truth)
    }

    fn settle(&mut self) {
        for _ in 0..100 {
            self.slam.advance(&self.settings);
        }
        assert!(self.slam.graph().is_settled());
    }

    fn loops(&self) -> usize {
        self.slam.graph().loops().count()
    }
}

fn around() -> Robot {
    Robot::new(World::ring(4), Pose2D::new(-6.0, -5.0, 0.0))
}

#[test]
fn a_ring_closes_and_known_places_add_no_keyframes() {
    let mut robot = around();
    robot.round();
    robot.drive(6.0, 0.0);
    robot.settle();
    assert!(robot.loops() >= 3, "{} loops", robot.loops());
    assert!(robot.error() < 0.15, "{} m", robot.error());
    robot.drive(6.0, core::f64::consts::FRAC_PI_2);
    for way in [10.0, 12.0, 10.0] {
        robot.drive(way, core::f64::consts::FRAC_PI_2);
    }
    let (keyframes, edges) = (robot.slam.scans().len(), robot.slam.graph().edges().len());
    (0..3).for_each(|_| robot.round());
    robot.settle();
    assert!(robot.error() < 0.15, "{} m", robot.error());
    let (more, linked) = (robot.slam.scans().len(), robot.slam.graph().edges().len());
    assert!(more <= keyframes + 3, "{keyframes} became {more} keyframes");
    assert!(linked <= edges + 30, "{edges} became {linked} edges");
}

#[test]
fn the_same_scans_give_the_same_map_to_the_bit() {
    let drive = || {
        let mut robot = around();
        robot.round();
        robot.drive(3.0, 0.0);
        robot.settle();
        robot.slam.graph().poses().to_vec()
    };
    assert_eq!(drive(), drive());
}

/// Two rooms that are the same, at the ends of a corridor.
#[test]
fn rooms_that_look_alike_are_not_joined() {
    let mut world = World::default();
    for x in [0.0, 14.0] {
        world = world.with_box((x + 1.0, 2.4), (x + 1.6, 3.0));
        world.0.extend([((x, 0.0), (x, 3.0)), ((x, 3.0), (x + 4.0, 3.0))]);
        world
            .0
            .extend([((x + 4.0, 3.0), (x + 4.0, 1.5)), ((x, 0.0), (x + 4.0, 0.0))]);
    }
    world
        .0
        .extend([((4.0, 0.0), (14.0, 0.0)), ((4.0, 1.5), (14.0, 1.5))]);
    world.0.push(((18.0, 1.5), (18.0, 0.0)));
    let mut robot = Robot::new(world, Pose2D::new(1.0, 0.75, 0.0));
    robot.drive(15.5, 0.0);
    (0..20).for_each(|_| robot.step(0.0, 0.3));
    robot.settle();
    let edges = robot.slam.graph().edges().iter();
    let longest = edges
        .map(|edge| edge.pose.x.hypot(edge.pose.y))
        .fold(0.0, f64::max);
    assert!(
        longest < 3.0 && robot.error() < 0.3,
        "{longest} and {} m",
        robot.error()
    );
    let poses = robot.slam.graph().poses();
    assert!(poses.iter().any(|pose| pose.x > 12.0), "the rooms are apart");
}

#[test]
fn in_a_full_map_keyframes_that_are_close_together_leave() {
    let mut robot = around();
    robot.settings.most = 16;
    for _ in 0..4 {
        robot.drive(12.0, core::f64::consts::FRAC_PI_2);
        robot.drive(10.0, core::f64::consts::FRAC_PI_2);
        assert!(robot.slam.scans().len() <= 16, "{}", robot.slam.scans().len());
    }
    robot.settle();
    assert!(robot.error() < 0.2, "{} m", robot.error());
    // Without one that may leave, there are as many as there may be.
    let mut robot = around();
    robot.settings.most = 2;
    robot.drive(6.0, 0.0);
    assert!(robot.slam.scans().len() <= 2);
}

/// How many cells of the map are occupied around a place.
fn occupied_around(slam: &Slam, (x, y): (f64, f64), radius: f64) -> usize {
    let mut drawing = crate::MapDrawing::new(slam, 0.05, 1.0).expect("a small building");
    assert!(drawing.advance(slam, usize::MAX));
    let geometry = *drawing.geometry();
    let mut cells = vec![0; geometry.cells()];
    drawing.write_ros(&mut cells);
    let is_near = |&at: &usize| {
        let center = geometry.center(geometry.cell(at));
        libm::hypot(center.0 - x, center.1 - y) < radius
    };
    (0..cells.len())
        .filter(is_near)
        .filter(|&at| cells[at] > 0)
        .count()
}

/// Two rooms, and a person in the door between them, who goes.
#[test]
fn a_person_who_stood_in_a_door_leaves_the_map_and_its_walls_stay() {
    let mut world = World::default().with_box((0.0, 0.0), (10.0, 6.0));
    // Legs of a table, 4 cm wide, and the wall with the door.
    for (x, y) in [(2.0, 4.5), (2.6, 4.5), (7.5, 1.5), (8.2, 4.0)] {
        world = world.with_box((x, y), (x + 0.04, y + 0.04));
    }
    world
        .0
        .extend([((5.0, 0.0), (5.0, 2.5)), ((5.0, 3.4), (5.0, 6.0))]);
    let empty = world.0.len();
    let mut robot = Robot::new(
        world.with_box((4.85, 2.8), (5.15, 3.15)),
        Pose2D::new(1.0, 3.0, 0.0),
    );
    robot.drive(3.0, PI);
    let keyframes = robot.slam.scans().len();
    assert!(
        occupied_around(&robot.slam, (5.0, 2.97), 0.2) > 3,
        "it is on the map"
    );
    robot.world.0.truncate(empty);
    robot.drive(2.5, -PI);
    assert_eq!(occupied_around(&robot.slam, (5.0, 2.97), 0.2), 0, "it has gone");
    assert!(
        robot.slam.scans().len() <= keyframes + 1,
        "although no scan became a keyframe"
    );
    // For hours the robot goes to and fro: walls and legs stay.
    for _ in 0..40 {
        robot.drive(7.5, PI);
        robot.drive(7.5, -PI);
    }
    robot.settle();
    assert!(robot.error() < 0.1, "{} m", robot.error());
    for (place, radius) in [
        ((5.0, 1.0), 0.2),
        ((5.0, 2.4), 0.1),
        ((5.0, 5.0), 0.2),
        ((3.0, 0.0), 0.2),
        ((8.0, 6.0), 0.2),
        ((2.02, 4.52), 0.12),
        ((2.62, 4.52), 0.12),
        ((7.52, 1.52), 0.12),
        ((8.22, 4.02), 0.12),
    ] {
        assert!(occupied_around(&robot.slam, place, radius) > 0, "{place:?}");
    }
}

#[test]
fn a_keyframe_that_has_lost_much_is_replaced_by_what_is_there_now() {
    let mut robot = Robot::new(World::room(1), Pose2D::new(-1.0, -1.0, 0.0));
    let round = |robot: &mut Robot| (0..4).for_each(|_| robot.drive(2.0, core::f64::consts::FRAC_PI_2));
    round(&mut robot);
    let furniture = robot.world.0.split_off(4);
    (0..6).for_each(|_| round(&mut robot));
    assert!(robot.error() < 0.1, "{} m", robot.error());
    for &((x, y), to) in &furniture {
        let middle = (f64::midpoint(x, to.0), f64::midpoint(y, to.1));
        if middle.0.abs() > 3.7 || middle.1.abs() > 2.7 {
            continue;
        }
        assert_eq!(occupied_around(&robot.slam, middle, 0.05), 0, "{middle:?}");
    }
    let before = robot.slam.revision();
    round(&mut robot);
    assert_eq!(robot.slam.revision(), before, "nothing is left to forget");
    let most = robot
        .slam
        .scans()
        .iter()
        .map(Scan::forgotten_share)
        .fold(0.0, f64::max);
    assert!(most < 0.15, "{most} of the points of a keyframe were lost");
}

/// A room whose furniture changes again and again.
#[test]
fn a_room_that_is_changed_for_hours_takes_no_more_memory_and_the_pose_is_right() {
    let mut robot = Robot::new(World::room(1), Pose2D::new(-1.0, -1.0, 0.0));
    let mut most = (0, 0);
    let sizes = |slam: &Slam| (slam.scans().len(), slam.graph().edges().len());
    for round in 0..60 {
        // Of the furniture, one piece is somewhere else.
        let walls = &mut robot.world.0;
        let piece = 4 + 4 * (round % 5);
        let other = World::room(2 + round as u64).0;
        walls[piece..piece + 4].copy_from_slice(&other[piece..piece + 4]);
        for _ in 0..4 {
            robot.drive(2.0, core::f64::consts::FRAC_PI_2);
        }
        assert!(robot.error() < 0.15, "{} m in round {round}", robot.error());
        if round == 10 {
            most = sizes(&robot.slam);
        }
    }
    robot.settle();
    let (keyframes, edges) = sizes(&robot.slam);
    assert!(
        keyframes <= most.0 + 3 && edges <= most.1 + 30,
        "{most:?} became {keyframes}, {edges}"
    );
    let shown = |scan: &Scan| scan.points().len() + scan.free().len();
    assert!(robot.slam.scans().iter().all(|scan| shown(scan) <= 180));
}

#[test]
fn without_a_scan_that_fits_the_odometry_says_where_the_robot_is() {
    let mut robot = around();
    robot.drive(2.0, 0.0);
    let keyframes = robot.slam.scans().len();
    let settings = robot.settings;
    let blind = robot.slam.step(&settings, &robot.odometry, &Scan::default());
    assert_eq!(blind, State::Blind, "although it did not move");
    let moved = robot.odometry.transform(&Pose2D::new(0.3, 0.0, 0.0));
    let before = robot.slam.anchor(&robot.odometry).expect("a pose");
    assert_eq!(robot.slam.step(&settings, &moved, &Scan::default()), State::Blind);
    let after = robot.slam.anchor(&moved).expect("a pose");
    assert!((before.pose.distance_to(&after.pose) - 0.3).abs() < 1e-9);
    assert_eq!(robot.slam.scans().len(), keyframes);
    // A scan of another world.
    let other = World::default().with_box((-0.3, -0.3), (0.4, 0.5));
    let scan = other.scan(&Pose2D::ORIGIN, &mut robot.random);
    let state = robot.slam.step(&settings, &moved, &scan);
    assert!(matches!(state, State::Differs(_)), "{state}");
    let last = robot.slam.anchor(&moved).expect("a pose");
    assert!(robot.slam.place(&last).distance_to(&robot.slam.place(&after)) < 1e-9);
}

#[test]
fn a_robot_that_is_carried_while_it_stands_is_noticed() {
    let mut robot = around();
    robot.drive(2.0, 0.0);
    let settings = robot.settings;
    let standing = robot.world.scan(&robot.truth, &mut robot.random);
    let mut states = |scan: &Scan| [(); 20].map(|()| robot.slam.step(&settings, &robot.odometry, scan));
    let fits = |state: &State| matches!(state, State::Fits(share) if *share > 0.8);
    assert!(states(&standing).iter().all(fits));
    let elsewhere = Pose2D::new(6.0, 4.0, 0.5);
    let last = states(&robot.world.scan(&elsewhere, &mut robot.random))[19];
    assert!(matches!(last, State::Differs(_)), "{last}");
}

#[test]
fn a_robot_in_doubt_is_matched_where_it_stands() {
    let mut robot = around();
    robot.drive(2.0, 0.0);
    // It is pushed by less than what is still searched, and most of what it sees is near where it was.
    robot.truth = robot.truth.transform(&Pose2D::new(0.1, 0.08, 0.05));
    robot.slam.doubt();
    assert!(robot.slam.covariance(&robot.settings, &robot.odometry)[0][0] > 0.09);
    robot.step(0.0, 0.0);
    assert!(robot.error() < 0.05, "{} m", robot.error());
    assert!(robot.slam.covariance(&robot.settings, &robot.odometry)[0][0] < 0.01);
}

#[test]
fn along_a_corridor_without_features_the_robot_is_less_certain() {
    let mut robot = Robot::new(
        World::default().with_box((-20.0, -1.0), (40.0, 1.0)),
        Pose2D::ORIGIN,
    );
    for _ in 0..4 {
        robot.drive(5.0, 0.0);
        let [[along, ..], [_, across, _], _] = robot.slam.covariance(&robot.settings, &robot.odometry);
        assert!(across < along, "{across} m², {along} m²");
        // The odometry alone says how far it went: its error is within three standard deviations.
        assert!(
            robot.error() < 3.0 * along.sqrt(),
            "{} m, {along} m²",
            robot.error()
        );
    }
}

#[test]
fn while_no_scan_fits_the_robot_is_ever_less_certain() {
    let mut robot = around();
    robot.drive(2.0, 0.0);
    let other = World::default().with_box((-0.3, -0.3), (0.4, 0.5));
    let scan = other.scan(&Pose2D::ORIGIN, &mut robot.random);
    let settings = robot.settings;
    let mut last = 0.0;
    for _ in 0..20 {
        robot.odometry = robot.odometry.transform(&Pose2D::new(0.5, 0.0, 0.0));
        let state = robot.slam.step(&settings, &robot.odometry, &scan);
        assert!(matches!(state, State::Differs(_)), "{state}");
        let variance = robot.slam.covariance(&settings, &robot.odometry)[0][0];
        assert!(variance > last && variance > 0.09, "{variance} after {last} m²");
        last = variance;
    }
}

#[test]
fn an_odometry_that_jumps_moves_nothing() {
    let mut robot = around();
    robot.drive(3.0, 0.0);
    let jumped = Pose2D::new(40.0, -7.0, 2.0);
    robot.slam.jump(&robot.odometry, &jumped);
    robot.odometry = jumped;
    assert!(robot.error() < 0.1, "{} m", robot.error());
    robot.drive(2.0, 0.0);
    assert!(robot.error() < 0.1, "{} m", robot.error());
}

#[test]
fn an_empty_map_waits_for_a_scan() {
    let mut slam = Slam::new(Pose2D::ORIGIN);
    let settings = Settings::default();
    assert_eq!(
        slam.step(&settings, &Pose2D::ORIGIN, &Scan::default()),
        State::Empty
    );
    assert!(!slam.advance(&settings) && slam.anchor(&Pose2D::ORIGIN).is_none());
}

/// What a camera of depths sees: a narrow part of the scan, and not far.
fn narrow(mut scan: LaserScan, reach: f32) -> LaserScan {
    for beam in 0..scan.ranges.len() {
        let is_seen = normalize_angle(scan.angle(beam)).abs() <= 0.5;
        let range = &mut scan.ranges[beam];
        *range = match *range {
            _ if !is_seen => f32::NAN,
            far if far > reach => f32::INFINITY,
            near => near,
        };
    }
    scan.range_max = reach;
    scan
}

#[test]
fn a_narrow_view_shows_what_is_new_and_the_odometry_leads_there() {
    let mut robot = around();
    robot.reach = Some(4.0);
    robot.slam = Slam::new(robot.truth);
    let mut new = 0;
    for way in [12.0, 10.0, 12.0, 10.0] {
        for (ahead, turn) in [(0.1, 0.0); 120]
            .into_iter()
            .take((way * 10.0) as usize)
            .chain([(0.0, 0.157); 10])
        {
            robot.step(ahead, turn);
            new += usize::from(matches!(robot.slam.state(), State::New(_)));
            assert!(
                !matches!(robot.slam.state(), State::Differs(_)),
                "{}",
                robot.slam.state()
            );
        }
        let covariance = robot.slam.covariance(&robot.settings, &robot.odometry);
        let deviation = covariance[0][0].max(covariance[1][1]).sqrt();
        assert!(
            robot.error() < 3.0 * deviation.max(0.3),
            "{} m, {deviation} m",
            robot.error()
        );
    }
    assert!(new > 0, "around a corner nothing is known");
}

/// A robot that is turned by 103 degrees while it stands, or whose wheels slip so far: the rest of the building is not drawn over it.
#[test]
fn a_turn_that_the_odometry_does_not_tell_turns_no_part_of_the_map() {
    let mut robot = around();
    robot.drive(12.0, core::f64::consts::FRAC_PI_2);
    robot.settle();
    let keyframes = robot.slam.scans().len();
    robot.truth = robot.truth.transform(&Pose2D::new(0.0, 0.0, 1.8));
    // As long as it stands, few scans are looked at.
    (0..3).for_each(|_| robot.step(0.05, 0.0));
    for _ in 0..37 {
        let state = robot.slam.state();
        assert!(
            matches!(state, State::Differs(_)) || robot.error() < 0.3,
            "{state}, {} m",
            robot.error()
        );
        robot.step(0.05, 0.0);
    }
    assert_eq!(robot.slam.scans().len(), keyframes, "what is there is not known");
}

#[test]
fn along_an_endless_corridor_the_map_is_as_long_as_an_exact_odometry_says() {
    let mut robot = Robot::new(
        World::default().with_box((-100.0, -1.0), (200.0, 1.0)),
        Pose2D::ORIGIN,
    );
    robot.drift = 0.0;
    robot.drive(60.0, 0.0);
    assert!(robot.error() < 0.2, "{} m", robot.error());
}
