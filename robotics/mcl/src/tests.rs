//! Drives of a robot that sees another world than the map, or is carried through it.

use core::f32::consts::TAU;

use jde_types::{LaserScan, Pose2D, normalize_angle};

use crate::field::tests::map;
use crate::{Beams, Doubt, LikelihoodField, Localizer, Settings, State};

/// Cells of 1 m: two rooms with a door, and what stands in them.
const HALL: [&str; 14] = [
    "##############################",
    "#..............#.............#",
    "#..##..........#........##...#",
    "#..##....##....#........##...#",
    "#........##....#.............#",
    "#..............#.....##......#",
    "#....................##......#",
    "#..............#.............#",
    "#...#..........#.............#",
    "#...#......##..#..##.....#...#",
    "#..........##..#..##.....#...#",
    "#..............#.............#",
    "#..............#.............#",
    "##############################",
];
/// The same walls with other things.
const REFURNISHED: [&str; 14] = [
    "##############################",
    "#..............#....##.......#",
    "#..##..........#....##..##...#",
    "#..##..#.......#........##.#.#",
    "#..............#...........#.#",
    "#...........##.#.............#",
    "#...........##.......#.......#",
    "#..............#.............#",
    "#..............#.............#",
    "#..........##..#.....##...#..#",
    "#..........##..#.....##...#..#",
    "#...##.........#..#..........#",
    "#..............#.............#",
    "##############################",
];
/// Two equal rooms off a corridor with an end on one side.
const TWINS: [&str; 14] = [
    "##############################",
    "#.........#........#.........#",
    "#.........#........#.........#",
    "#....##...#........#....##...#",
    "#....##...#........#....##...#",
    "#.........#........#.........#",
    "#.........#........#.........#",
    "#.........#........#.........#",
    "####..#####........####..#####",
    "#............................#",
    "#............................#",
    "#.........####...............#",
    "#.........####...............#",
    "##############################",
];

struct Robot {
    world: LikelihoodField,
    localizer: Localizer,
    settings: Settings,
    truth: Pose2D,
    odometry: Pose2D,
    state: State,
}

impl Robot {
    fn new(rows: &[&str], world: &[&str], truth: Pose2D) -> Self {
        let mut localizer = Localizer::new(LikelihoodField::new(&map(rows)), 2000, 7);
        localizer.start_anywhere();
        Self {
            world: LikelihoodField::new(&map(world)),
            localizer,
            settings: Settings::default(),
            truth,
            odometry: Pose2D::ORIGIN,
            state: State::Unsure(Doubt::Nowhere),
        }
    }

    fn beams(&self) -> Beams {
        let mut scan = LaserScan {
            angle_increment: TAU / 120.0,
            range_max: 40.0,
            ..LaserScan::default()
        };
        for beam in 0..120 {
            let (sin, cos) = libm::sincosf((self.truth.theta + scan.angle(beam)) as f32);
            let from = (self.truth.x as f32, self.truth.y as f32);
            scan.ranges
                .push(self.world.cast(from, (cos, sin), 60.0))
                .expect("few beams");
        }
        scan.state_last_angle();
        let mut beams = Beams::new(60);
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        beams
    }

    /// Moves, and sees what is around. A search goes on in two calls before the next scan.
    fn drive(&mut self, ahead: f64, turn: f64) {
        let motion = Pose2D::new(ahead, 0.0, turn);
        self.truth = self.truth.transform(&motion);
        self.odometry = self.odometry.transform(&motion);
        let beams = self.beams();
        self.state = self.localizer.step(&self.settings, &self.odometry, &beams);
        for _ in 0..2 {
            self.state = self.localizer.search(&self.settings).unwrap_or(self.state);
        }
    }

    /// The same. A sure pose is right.
    fn step(&mut self, ahead: f64, turn: f64) {
        self.drive(ahead, turn);
        let error = self.error();
        assert!(!self.is_sure() || error < 0.5, "sure and {error} m away");
    }

    fn error(&self) -> f64 {
        let pose = self.localizer.pose(&self.odometry).unwrap_or(Pose2D::ORIGIN);
        let turned = normalize_angle(pose.theta - self.truth.theta).abs();
        pose.distance_to(&self.truth) + turned
    }

    fn is_sure(&self) -> bool {
        self.state == State::Sure
    }
}

const START: Pose2D = Pose2D::new(7.0, 7.0, 0.4);

/// A robot that is sure when the furniture changes.
fn refurnished() -> Robot {
    let mut robot = Robot::new(&HALL, &HALL, START);
    robot.localizer.start_at(&START, 0.3, 0.2);
    robot.step(0.0, 0.0);
    assert!(robot.is_sure(), "{:?}", robot.state);
    robot.world = LikelihoodField::new(&map(&REFURNISHED));
    robot
}

#[test]
fn a_unique_place_is_sure_without_a_motion() {
    let mut robot = Robot::new(&HALL, &HALL, START);
    (0..10).for_each(|_| robot.step(0.0, 0.0));
    assert!(robot.is_sure(), "{:?}", robot.state);
}

#[test]
fn other_furniture_leaves_a_sure_pose_sure() {
    let mut robot = refurnished();
    let (mut sure, mut least) = (0, 1.0_f64);
    for step in 0..200 {
        robot.step(0.1, if step < 20 { 0.0 } else { -0.08 });
        sure += u32::from(robot.is_sure());
        least = least.min(robot.localizer.agreement());
    }
    assert!(
        least < robot.settings.limits.agreement,
        "{least} is no change that matters"
    );
    assert!(sure > 180, "{sure}: {:?}", robot.state);
}

#[test]
fn a_robot_that_is_carried_among_other_furniture_is_never_sure_of_the_old_place_for_long() {
    let mut robot = refurnished();
    (0..60).for_each(|_| robot.step(0.1, 0.08));
    assert!(robot.is_sure(), "{:?}", robot.state);
    robot.truth = Pose2D::new(24.0, 8.5, -2.0);
    let mut wrong = 0;
    for _ in 0..100 {
        robot.drive(0.1, 0.08);
        wrong += u32::from(robot.is_sure() && robot.error() > 0.5);
    }
    assert!(wrong < 8, "{wrong}");
}

#[test]
fn rooms_that_are_copies_are_told_apart_outside_only() {
    let mut robot = Robot::new(&TWINS, &TWINS, Pose2D::new(3.0, 9.0, 0.0));
    for _ in 0..300 {
        robot.step(0.05, 0.05);
        assert!(!robot.is_sure());
    }
    // Turned to the door, through it, and along the corridor.
    let to_door = Pose2D::new(5.0, 8.0, 0.0);
    let heading = libm::atan2(to_door.y - robot.truth.y, to_door.x - robot.truth.x);
    robot.step(0.0, normalize_angle(heading - robot.truth.theta));
    let way = robot.truth.distance_to(&to_door);
    (0..10).for_each(|_| robot.step(way / 10.0, 0.0));
    robot.step(
        0.0,
        normalize_angle(-core::f64::consts::FRAC_PI_2 - robot.truth.theta),
    );
    (0..40).for_each(|_| robot.step(0.1, 0.0));
    robot.step(0.0, core::f64::consts::FRAC_PI_2);
    (0..60).for_each(|_| robot.step(0.1, 0.0));
    assert!(robot.is_sure(), "{:?}", robot.state);
}

#[test]
fn a_map_of_another_building_is_not_believed_whatever_a_person_says() {
    for start in [START, Pose2D::new(20.0, 6.0, 1.0)] {
        let mut robot = Robot::new(&TWINS, &HALL, START);
        robot.localizer.start_at(&start, 0.3, 0.2);
        for _ in 0..300 {
            let motion = Pose2D::new(0.1, 0.0, 0.08);
            robot.truth = robot.truth.transform(&motion);
            robot.odometry = robot.odometry.transform(&motion);
            let beams = robot.beams();
            let state = robot.localizer.step(&robot.settings, &robot.odometry, &beams);
            assert_ne!(state, State::Sure);
            while let Some(state) = robot.localizer.search(&robot.settings) {
                assert_ne!(state, State::Sure);
            }
        }
    }
}

#[test]
fn a_search_goes_on_without_a_scan_and_as_fast_as_its_budget() {
    let calls = |search_step| {
        let mut robot = Robot::new(&HALL, &HALL, START);
        robot.settings.search_step = search_step;
        let beams = robot.beams();
        let state = robot.localizer.step(&robot.settings, &robot.odometry, &beams);
        assert_eq!(state, State::Searching(0.0));
        let mut calls = 0;
        while robot.localizer.search(&robot.settings).is_some() {
            calls += 1;
        }
        assert!(robot.localizer.particles() > 0);
        calls
    };
    assert_eq!(calls(usize::MAX), 1);
    assert!(calls(10_000) > 10);
}

/// A robot that is sure on a map that is right.
fn sure() -> Robot {
    let mut robot = Robot::new(&HALL, &HALL, START);
    (0..10).for_each(|_| robot.step(0.0, 0.0));
    assert!(robot.is_sure(), "{:?}", robot.state);
    robot
}

#[test]
fn a_robot_that_is_pushed_or_turned_where_it_stands_is_sure_of_its_new_pose() {
    for push in [
        Pose2D::new(0.5, 0.0, 0.0),
        Pose2D::new(-0.3, 0.4, 0.0),
        Pose2D::new(0.0, 0.0, 10_f64.to_radians()),
        Pose2D::new(0.0, 0.0, -10_f64.to_radians()),
    ] {
        let mut robot = sure();
        robot.truth = robot.truth.transform(&push);
        (0..120).for_each(|_| robot.drive(0.0, 0.0));
        let error = robot.error();
        assert!(
            robot.is_sure() && error < 0.15,
            "{push:?}: {:?}, {error}",
            robot.state
        );
    }
}

#[test]
fn a_search_is_not_of_the_scan_before_a_doubt() {
    let mut robot = Robot::new(&HALL, &HALL, START);
    robot.settings.search_step = 10_000;
    robot.step(0.0, 0.0);
    assert!(matches!(robot.state, State::Searching(_)));
    // Somebody carries it during a pause.
    robot.localizer.doubt();
    robot.truth = Pose2D::new(24.0, 8.5, -2.0);
    robot.step(0.0, 0.0);
    assert!(matches!(robot.state, State::Searching(_)), "{:?}", robot.state);
    while robot.localizer.search(&robot.settings).is_some() {}
    robot.step(0.0, 0.0);
    assert!(robot.is_sure(), "{:?}", robot.state);
}

#[test]
fn a_robot_that_is_carried_twice_while_it_is_searched_is_found() {
    let mut robot = sure();
    robot.settings.search_step = 10_000;
    for place in [Pose2D::new(24.0, 8.5, -2.0), Pose2D::new(8.0, 11.5, 1.0)] {
        robot.truth = place;
        (0..20).for_each(|_| robot.drive(0.0, 0.0));
        assert!(!robot.is_sure());
    }
    (0..400).for_each(|_| robot.step(0.0, 0.0));
    assert!(robot.is_sure(), "{:?}", robot.state);
}

#[test]
fn a_jump_of_the_odometry_during_a_search_leaves_what_is_found_right() {
    let mut robot = Robot::new(&HALL, &HALL, START);
    robot.settings.search_step = 10_000;
    (0..3).for_each(|_| robot.step(0.1, 0.0));
    let to = Pose2D::new(-30.0, 4.0, 2.0);
    robot.localizer.jump(&robot.odometry, &to);
    robot.odometry = to;
    (0..400).for_each(|_| robot.step(0.01, 0.0));
    assert!(robot.is_sure(), "{:?}", robot.state);
}

#[test]
fn what_was_never_sure_needs_more_agreement_than_what_was() {
    let mut robot = Robot::new(&HALL, &REFURNISHED, START);
    robot.localizer.start_at(&START, 0.1, 0.1);
    let (mut was_sure, mut least) = (false, 1.0_f64);
    for _ in 0..200 {
        robot.step(0.05, -0.08);
        let agreement = robot.localizer.agreement();
        was_sure |= agreement >= robot.settings.limits.sure_agreement;
        least = least.min(agreement);
        assert!(was_sure || !robot.is_sure(), "{agreement}");
    }
    assert!(least > robot.settings.limits.changed_agreement, "{least}");
}

#[test]
fn a_pause_among_other_furniture_is_no_loss_unless_the_robot_is_carried_meanwhile() {
    for carried in [false, true] {
        let mut robot = refurnished();
        (0..60).for_each(|_| robot.step(0.1, 0.08));
        assert!(robot.is_sure(), "{:?}", robot.state);
        let agreement = robot.localizer.agreement();
        assert!(agreement < robot.settings.limits.sure_agreement, "{agreement}");
        robot.localizer.doubt();
        if carried {
            robot.truth = Pose2D::new(24.0, 8.5, -2.0);
        }
        (0..100).for_each(|_| robot.step(0.0, 0.0));
        assert_eq!(robot.is_sure(), !carried, "{:?}", robot.state);
    }
}

#[test]
fn a_place_that_was_searched_around_a_click_is_confirmed_by_a_way() {
    let mut robot = Robot::new(&TWINS, &TWINS, Pose2D::new(3.0, 9.0, 0.0));
    robot.localizer.start_around((3.0, 9.0), 1.0);
    (0..30).for_each(|_| robot.step(0.0, 0.1));
    assert!(
        matches!(robot.state, State::Unsure(Doubt::Unconfirmed(_))),
        "{:?}",
        robot.state
    );
    (0..30).for_each(|_| robot.step(0.05, 0.05));
    assert!(robot.is_sure(), "{:?}", robot.state);
}

#[test]
fn more_equal_rooms_than_a_list_of_places_has_are_no_unique_place() {
    let room = [
        "#######", "#.....#", "#.##..#", "#.....#", "#.....#", "#....##", "#######",
    ];
    let rows: Vec<String> = room.iter().cycle().take(28).map(|part| part.repeat(11)).collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    for particles in [10, 2000] {
        let mut robot = Robot::new(&rows, &rows, Pose2D::new(3.0, 3.0, 0.3));
        robot.localizer = Localizer::new(LikelihoodField::new(&map(&rows)), particles, 7);
        robot.localizer.start_anywhere();
        for _ in 0..120 {
            robot.drive(0.02, 0.1);
            assert!(!robot.is_sure(), "{particles} particles");
        }
    }
}
