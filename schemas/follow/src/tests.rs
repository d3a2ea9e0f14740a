//! Whom it follows and how, with persons and poses as they are in a building, and what must not move the robot.

use jde_schema::bench::Bench;
use jde_schema::panel::{Button, Touch};
use jde_schema::types::{Padding, normalize_angle};

use super::*;

/// A robot that drives along the exported way, and persons.
struct Robot {
    bench: Bench<Person>,
    now: Duration,
    pose: Pose2D,
    persons: Vec<Tracked>,
    /// The frame of the persons.
    frame: &'static str,
}

/// A person at a place who walks ahead.
fn tracked(id: u32, x: f64, y: f64) -> Tracked {
    Tracked {
        id,
        padding: Padding::default(),
        position: Point2D { x, y },
        velocity: [0.6, 0.0],
        deviation: 0.1,
        confidence: 0.9,
        unseen: 0.0,
    }
}

impl Robot {
    fn new(persons: &[Tracked]) -> Self {
        let mut bench = Bench::new();
        bench.awake().expect("it awakes");
        Self {
            bench,
            now: Duration::ZERO,
            pose: Pose2D::ORIGIN,
            persons: persons.to_vec(),
            frame: "odom",
        }
    }

    /// Lets 0.1 s pass without authority. Returns whether it is READY.
    fn check(&mut self) -> bool {
        self.now += Duration::from_millis(100);
        self.bench.set_now(self.now);
        let persons = Persons {
            header: Header::new(self.now, self.frame),
            persons: self.persons.iter().copied().collect(),
        };
        self.bench.import("persons", &persons);
        self.check_pose()
    }

    /// The same without a scan: the persons are those of before.
    fn check_without_scan(&mut self) -> bool {
        self.now += Duration::from_millis(100);
        self.bench.set_now(self.now);
        self.check_pose()
    }

    fn check_pose(&mut self) -> bool {
        self.bench
            .import("pose", &Odometry::planar(self.now, self.pose, Twist::ZERO));
        self.bench.check().expect("the check succeeds").ready
    }

    /// Lets 0.1 s pass, in which the robot drives 0.08 m along the way. Returns whether it is READY.
    fn step(&mut self) -> bool {
        let ready = self.check();
        if ready {
            self.bench.iterate().expect("the iteration succeeds");
            assert_eq!(self.bench.awake_children(), ["drive"]);
        }
        let mut left = 0.08;
        for point in self.way().into_iter().skip(1) {
            let away = self.pose.distance_to(&point);
            let share = (left / away.max(1e-9)).min(1.0);
            let (dx, dy) = (point.x - self.pose.x, point.y - self.pose.y);
            let turn = normalize_angle(dy.atan2(dx) - self.pose.theta).clamp(-0.5, 0.5);
            self.pose = Pose2D::new(
                self.pose.x + share * dx,
                self.pose.y + share * dy,
                self.pose.theta + turn,
            );
            left -= share * away;
        }
        ready
    }

    /// Lets the first person walk to a place at 0.6 m/s.
    fn walk(&mut self, x: f64, y: f64) {
        loop {
            let Point2D { x: from, y: aside } = self.persons[0].position;
            let away = (x - from).hypot(y - aside);
            if away < 1e-6 {
                return;
            }
            let share = (0.06 / away).min(1.0);
            self.persons[0].velocity = [0.6 * (x - from) / away, 0.6 * (y - aside) / away];
            self.persons[0].position = Point2D {
                x: from + share * (x - from),
                y: aside + share * (y - aside),
            };
            self.step();
        }
    }

    fn steps(&mut self, seconds: u32) {
        for _ in 0..10 * seconds {
            self.step();
        }
    }

    /// The way that it exports.
    fn way(&self) -> Vec<Pose2D> {
        let path: Option<Path> = self.bench.exported("path");
        let poses = path.iter().flat_map(|path| path.poses.iter());
        poses.map(|stamped| stamped.pose.into()).collect()
    }

    fn mission(&self) -> Mission {
        self.bench.exported("mission").expect("a mission")
    }

    #[track_caller]
    fn says(&self, words: &str) {
        let note = self.mission().note;
        assert!(note.as_str().contains(words), "{:?} for {words}", note.as_str());
    }

    /// The distance to the first person, m.
    fn away(&self) -> f64 {
        let Point2D { x, y } = self.persons[0].position;
        self.pose.distance_to(&Pose2D::new(x, y, 0.0))
    }
}

#[test]
fn it_keeps_its_distance_behind_a_person_and_stands_with_one_who_stands() {
    let mut robot = Robot::new(&[tracked(4, 2.0, 0.0)]);
    assert!(robot.step());
    robot.says("follows person 4");
    robot.walk(8.0, 0.0);
    assert!((1.0..2.0).contains(&robot.away()), "{} m away", robot.away());
    robot.persons[0].velocity = [0.0; 2];
    robot.steps(5);
    robot.says("stands near person 4");
    assert!((1.0..1.6).contains(&robot.away()), "{} m away", robot.away());
    assert!(robot.way().is_empty());
}

#[test]
fn it_goes_where_the_person_went_and_not_straight() {
    let mut robot = Robot::new(&[tracked(1, 1.5, 0.0)]);
    robot.walk(4.0, 0.0);
    robot.walk(4.0, 4.0);
    robot.walk(1.0, 4.0);
    robot.walk(-2.0, 4.0);
    assert!((1.0..2.0).contains(&robot.away()), "{} m away", robot.away());
    // The corner at 4, 4 was not cut: the robot is on the last leg, behind the person.
    assert!((robot.pose.y - 4.0).abs() < 0.2, "{:?}", robot.pose);
}

#[test]
fn its_child_is_as_fast_as_the_person_and_faster_who_is_far_behind() {
    let mut robot = Robot::new(&[tracked(1, 1.3, 0.0)]);
    robot.step();
    let fast = |robot: &Robot| robot.bench.modulated::<f64>("drive", "vx_max").expect("a speed");
    assert!((fast(&robot) - 0.68).abs() < 0.01, "{}", fast(&robot));
    robot.persons[0].position.x = 2.0;
    robot.step();
    assert_eq!(fast(&robot), 1.0);
}

#[test]
fn it_chooses_the_nearest_ahead_or_the_one_with_the_number() {
    let around = [
        tracked(1, -1.0, 0.0),
        tracked(2, 3.0, 0.5),
        tracked(3, 2.0, 0.0),
        tracked(5, 9.0, 0.0),
    ];
    let mut robot = Robot::new(&around);
    robot.step();
    robot.says("person 3");
    robot.bench.set("id", 1_u32);
    robot.step();
    robot.says("person 1");
    robot.bench.set("id", 8_u32);
    assert!(!robot.step(), "there is no such person");
    robot.says("nobody");
    assert!(robot.way().is_empty());
    let mut robot = Robot::new(&[around[0], around[3]]);
    assert!(!robot.step(), "behind it, or too far away");
    robot.says("nobody to follow");
}

#[test]
fn a_click_chooses_a_person() {
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0), tracked(2, -2.0, 1.0)]);
    robot.step();
    let click = |robot: &mut Robot, at: [f64; 3]| {
        let button = Button::Primary;
        let taken = robot.bench.touch("around", Touch::Clicked { at, button });
        taken.expect("it is taken");
        robot.step();
    };
    click(&mut robot, [5.0, 5.0, 0.0]);
    robot.says("person 1");
    click(&mut robot, [-1.8, 1.2, 0.0]);
    robot.says("person 2");
    let panel = robot.bench.draw().expect("the panel is drawn");
    assert!(panel.texts()[0].contains("person 2"));
}

#[test]
fn a_lost_person_is_searched_where_the_trail_ends_and_beyond() {
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0)]);
    robot.walk(5.0, 0.0);
    robot.persons.clear();
    robot.steps(2);
    robot.says("searches person 1");
    let end = robot.way().pop().expect("a way");
    assert!((end.x - 6.5).abs() < 0.1 && end.y.abs() < 0.1, "{end:?}");
    robot.steps(10);
    assert!((robot.pose.x - 6.5).abs() < 0.2, "{:?}", robot.pose);
    // Somebody new there is taken for the person; somebody far away, or who was there before, is not.
    robot.persons = vec![tracked(2, 20.0, 0.0)];
    robot.step();
    robot.says("searches person 1");
    let mut other = tracked(3, 6.0, -1.5);
    other.velocity = [-0.6, 0.0];
    robot.persons = vec![other];
    robot.step();
    // Who fits better comes into view a moment later.
    robot.persons.push(tracked(4, 8.5, 1.0));
    robot.steps(1);
    robot.says("follows person 4");
}

#[test]
fn a_person_who_came_nearer_is_searched_at_the_last_place_before_the_guess_beyond() {
    let mut robot = Robot::new(&[tracked(1, 3.5, 1.0)]);
    robot.persons[0].velocity[0] = -0.6;
    robot.step();
    robot.persons.clear();
    robot.steps(1);
    let places: Vec<_> = robot.way().iter().skip(1).map(|at| (at.x, at.y)).collect();
    assert_eq!(places, [(3.5, 1.0), (2.0, 1.0)]);
    robot.steps(10);
    assert!((robot.pose.x - 2.0).abs() < 0.2, "{:?}", robot.pose);
}

#[test]
fn it_comes_near_a_person_who_is_found_again_aside_of_the_trail() {
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0)]);
    robot.walk(3.0, 0.0);
    robot.persons.clear();
    robot.steps(1);
    robot.persons = vec![tracked(2, 3.0, 1.6)];
    robot.persons[0].velocity = [0.0; 2];
    robot.steps(5);
    robot.says("stands near person 2");
}

#[test]
fn a_bystander_is_not_taken_for_the_person() {
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0), tracked(2, 3.0, 0.5)]);
    robot.walk(3.0, 0.0);
    robot.persons.remove(0);
    robot.steps(3);
    robot.says("searches person 1");
}

#[test]
fn it_gives_up_in_words_and_is_no_longer_ready() {
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0)]);
    robot.bench.set("patience", 4.0);
    robot.walk(3.0, 0.0);
    robot.persons.clear();
    robot.steps(5);
    assert!(!robot.step());
    assert_eq!(robot.mission().state, Mission::FAILED);
    robot.says("gave up");
    assert!(robot.way().is_empty());
    // Who comes later is somebody else, until it sleeps.
    robot.persons = vec![tracked(2, robot.pose.x + 2.0, 0.0)];
    assert!(!robot.step());
    robot.bench.sleep().expect("it sleeps");
    robot.bench.awake().expect("it awakes");
    assert!(robot.step());
}

#[test]
fn the_mission_is_done_after_it_stood_near_the_person() {
    let mut robot = Robot::new(&[tracked(1, 1.3, 0.0)]);
    robot.bench.set("arrival", 2.0);
    robot.persons[0].velocity = [0.0; 2];
    robot.steps(1);
    assert_eq!(robot.mission().state, Mission::RUNNING);
    robot.steps(2);
    assert_eq!(
        (robot.mission().state, robot.mission().reached),
        (Mission::DONE, 1)
    );
}

#[test]
fn it_neither_gives_up_nor_arrives_while_another_drives() {
    let mut robot = Robot::new(&[tracked(1, 1.3, 0.0)]);
    robot.bench.set("arrival", 2.0);
    robot.bench.set("patience", 4.0);
    robot.persons[0].velocity = [0.0; 2];
    robot.step();
    for _ in 0..50 {
        assert!(robot.check());
    }
    assert_eq!(robot.mission().state, Mission::RUNNING);
    robot.persons.clear();
    for _ in 0..60 {
        assert!(robot.check());
    }
    robot.says("searches person 1");
    robot.steps(3);
    assert!(robot.step());
    robot.steps(2);
    robot.says("gave up");
}

#[test]
fn a_pose_that_jumps_leaves_no_old_way() {
    for jumped in [Pose2D::new(30.0, -20.0, 0.0), Pose2D::new(0.0, 0.0, 2.0)] {
        let mut robot = Robot::new(&[tracked(1, 3.0, 0.0)]);
        robot.step();
        robot.pose = jumped;
        robot.persons.clear();
        assert!(!robot.step());
        robot.says("nobody to follow");
        assert!(robot.way().is_empty());
        // It begins anew with who is ahead there.
        let ahead = robot.pose.transform(&Pose2D::new(2.0, 0.0, 0.0));
        robot.persons = vec![tracked(2, ahead.x, ahead.y)];
        assert!(robot.step());
        robot.says("follows person 2");
    }
}

#[test]
fn persons_from_before_a_jump_are_not_followed() {
    for id in [0_u32, 1] {
        let mut robot = Robot::new(&[tracked(1, 2.0, 0.0)]);
        robot.bench.set("id", id);
        robot.step();
        robot.walk(8.0, 0.0);
        // The pose begins anew. Until the next scan the persons are those of before.
        robot.persons = vec![tracked(1, 3.0, 0.0)];
        robot.pose = Pose2D::ORIGIN;
        assert!(!robot.check());
        robot.says("nobody to follow");
        assert!(!robot.check_without_scan());
        assert!(robot.way().is_empty());
        assert!(robot.step(), "those are new");
        robot.says("follows person 1");
    }
}

#[test]
fn a_jump_revives_no_mission_that_has_ended() {
    let mut arrived = Robot::new(&[tracked(1, 1.3, 0.0)]);
    arrived.bench.set("arrival", 2.0);
    arrived.persons[0].velocity = [0.0; 2];
    arrived.steps(3);
    let mut lost = Robot::new(&[tracked(1, 2.0, 0.0)]);
    lost.bench.set("patience", 4.0);
    lost.step();
    lost.persons.clear();
    lost.steps(6);
    for (mut robot, state) in [(arrived, Mission::DONE), (lost, Mission::FAILED)] {
        assert_eq!(robot.mission().state, state);
        robot.pose = Pose2D::new(30.0, -20.0, 0.0);
        robot.persons = vec![tracked(2, 33.0, -20.0)];
        robot.steps(1);
        assert_eq!(robot.mission().state, state);
        assert!(robot.way().is_empty());
    }
}

#[test]
fn somebody_elsewhere_with_the_number_of_the_lost_person_is_somebody_else() {
    // The schema that tracks the persons has been restarted, and counts from 1 again.
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0)]);
    robot.walk(3.0, 0.0);
    robot.persons.clear();
    robot.steps(2);
    robot.persons = vec![tracked(1, -6.0, 3.0)];
    robot.steps(1);
    robot.says("searches person 1");
    robot.persons = vec![tracked(1, 6.0, 0.0)];
    robot.step();
    robot.says("follows person 1");
}

#[test]
fn a_person_who_hurries_on_out_of_sight_is_the_same() {
    let mut robot = Robot::new(&[tracked(1, 2.0, 0.0)]);
    robot.persons[0].velocity[0] = 1.6;
    robot.step();
    let mut hidden = robot.persons.clone();
    robot.persons.clear();
    robot.steps(2);
    hidden[0].position.x += 2.1 * 1.6;
    robot.persons = hidden;
    robot.step();
    robot.says("follows person 1");
}

#[test]
fn persons_in_another_frame_or_at_no_place_lead_nowhere() {
    let mut robot = Robot::new(&[tracked(1, 3.0, 0.0)]);
    robot.frame = "map";
    assert!(!robot.step());
    robot.says("another frame");
    robot.frame = "odom";
    assert!(robot.step());
    robot.frame = "map";
    robot.step();
    assert!(robot.way().is_empty());
    let mut robot = Robot::new(&[tracked(1, f64::NAN, 0.0), tracked(2, 3.0, 0.0)]);
    robot.step();
    robot.says("follows person 2");
    robot.persons[1].velocity[0] = f64::INFINITY;
    robot.steps(1);
    robot.says("searches person 2");
    assert!(
        robot
            .way()
            .iter()
            .all(|point| point.x.is_finite() && point.y.is_finite())
    );
}

#[test]
fn persons_who_are_old_are_not_seen() {
    let mut robot = Robot::new(&[tracked(1, 3.0, 0.0)]);
    robot.step();
    for _ in 0..15 {
        robot.check_without_scan();
    }
    robot.says("searches person 1");
}

#[test]
fn the_way_has_the_frame_and_the_time_of_the_pose_without_persons() {
    let mut robot = Robot::new(&[tracked(1, 3.0, 0.0)]);
    robot.step();
    robot.bench.retract("persons");
    robot.bench.check().expect("the check succeeds");
    let path: Path = robot.bench.exported("path").expect("a way");
    assert_eq!(path.header, Header::new(robot.now, "odom"));
}

#[test]
fn what_cannot_be_used_leaves_no_way() {
    type Spoil = fn(&mut Robot);
    let spoiled: [(&str, Spoil); 4] = [
        ("no pose", |robot| robot.bench.retract("pose")),
        ("a pose that is not finite", |robot| {
            let nowhere = Pose2D::new(0.0, f64::NAN, 0.0);
            robot
                .bench
                .import("pose", &Odometry::planar(robot.now, nowhere, Twist::ZERO));
        }),
        ("a heading that is not finite", |robot| {
            let nowhere = Pose2D::new(0.0, 0.0, f64::INFINITY);
            robot
                .bench
                .import("pose", &Odometry::planar(robot.now, nowhere, Twist::ZERO));
        }),
        ("no persons for longer than the patience", |robot| {
            robot.bench.retract("persons");
            robot.now += Duration::from_secs(30);
            robot.bench.set_now(robot.now);
        }),
    ];
    for (what, spoil) in spoiled {
        let mut robot = Robot::new(&[tracked(1, 3.0, 0.0)]);
        robot.step();
        assert!(!robot.way().is_empty());
        spoil(&mut robot);
        robot.bench.check().expect("the check succeeds");
        assert!(robot.way().is_empty(), "{what}");
    }
}
