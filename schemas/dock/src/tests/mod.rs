//! The schema on a bench: a base that moves as it is commanded, and a camera that sees the tag exactly or with errors, or a
//! laser that sees a reflector in its place.

mod effort;

use core::f64::consts::PI;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{Point, Pose, PoseStamped, Quaternion, TagDetection, TagDetections};

use crate::Dock;

/// The tag in the frame of the odometry: it faces back along x.
const TAG: Pose2D = Pose2D::new(5.0, 2.0, PI);
const PERIOD: Duration = Duration::from_millis(50);

struct Drive {
    bench: Bench<Dock>,
    base: Pose2D,
    now: Duration,
    /// How far a pose of the tag is turned, rad, with alternating signs.
    error: f64,
    sees: bool,
    ambiguity: f64,
    /// Where the other tag is, number 8.
    other: Option<Pose2D>,
    has_odometry: bool,
    /// Whether the camera repeats its last picture.
    is_frozen: bool,
    picture: TagDetections,
    /// Whether the mark is a reflector.
    is_reflector: bool,
    /// Where the reflector is.
    reflector: Pose2D,
    /// The origin of the odometry.
    origin: Pose2D,
    /// The speed and the turn rate below which the base stands, m/s and rad/s.
    dead_band: (f64, f64),
}

impl Drive {
    fn from(x: f64, y: f64, theta: f64) -> Self {
        let mut bench = Bench::new();
        bench.set("id", 7_u32);
        bench.unbind("reflector");
        Self {
            bench,
            base: Pose2D::new(x, y, theta),
            now: Duration::from_secs(1),
            error: 0.0,
            sees: true,
            ambiguity: 0.1,
            other: None,
            has_odometry: true,
            is_frozen: false,
            picture: TagDetections::default(),
            is_reflector: false,
            reflector: TAG,
            origin: Pose2D::ORIGIN,
            dead_band: (0.0, 0.0),
        }
    }

    /// A base whose laser, 10 cm behind its middle and turned to the left, sees a reflector.
    fn to_reflector(x: f64, y: f64, theta: f64) -> Self {
        let mut drive = Self::from(x, y, theta);
        drive.bench = Bench::new();
        drive.bench.unbind("tags");
        drive.bench.set("ahead", -0.1);
        drive.bench.set("yaw", 0.5);
        drive.is_reflector = true;
        drive
    }

    /// Shows the pose and the tag, checks, and moves the base as commanded if the schema is READY. Returns whether it is.
    fn step(&mut self) -> bool {
        self.now += PERIOD;
        self.bench.set_now(self.now);
        if self.has_odometry {
            let pose = self.origin.localize(&self.base);
            self.bench.import("pose", &odometry(self.now, pose));
        } else {
            self.bench.retract("pose");
        }
        if self.sees && self.is_reflector {
            let laser = self.base.transform(&Pose2D::new(-0.1, 0.0, 0.5));
            let seen = PoseStamped {
                header: Header::new(self.now, "laser"),
                pose: laser.localize(&self.reflector).into(),
            };
            self.bench.import("reflector", &seen);
        } else if self.sees {
            self.error = -self.error;
            let seen = [(7, Some(TAG)), (8, self.other)].into_iter();
            let seen = seen.filter_map(|(id, tag)| Some(self.detection(id, &self.base.localize(&tag?))));
            if !self.is_frozen {
                self.picture.tags = seen.collect();
            }
            self.picture.header = Header::new(self.now, "camera");
            self.bench.import("tags", &self.picture);
        }
        let ready = self.bench.check().expect("it checks").ready;
        if ready {
            self.bench.iterate().expect("it iterates");
            let twist: Twist = self.bench.commanded("base").expect("it commands");
            let moves = twist.linear.x.abs() >= self.dead_band.0 || twist.angular.z.abs() >= self.dead_band.1;
            let time = if moves { 0.05 } else { 0.0 };
            let (way, turn) = (twist.linear.x * time, twist.angular.z * time);
            self.base = self.base.transform(&Pose2D::new(way, 0.0, turn));
        }
        ready
    }

    /// Returns a tag, at a pose in the frame of the base, as the camera sees it.
    fn detection(&self, id: u32, seen: &Pose2D) -> TagDetection {
        let out = seen.theta + self.error;
        // The axes of the tag in the frame of the camera, which is x to the right, y down and z ahead.
        let z = [out.sin(), 0.0, -out.cos()];
        TagDetection {
            id,
            pose: Pose {
                position: Point {
                    x: -seen.y,
                    y: 0.0,
                    z: seen.x,
                },
                orientation: Quaternion::from_axes([[z[2], 0.0, -z[0]], [0.0, 1.0, 0.0], z]),
            },
            ambiguity: self.ambiguity,
            ..TagDetection::default()
        }
    }

    /// Steps until it is not READY any more, at most two minutes.
    fn run(&mut self) {
        assert!(
            (0..2400).any(|_| !self.step()),
            "it does not end: {:?}",
            self.base
        );
    }

    fn mission(&mut self) -> Mission {
        self.bench.exported("docking").expect("the mission is exported")
    }
}

fn odometry(now: Duration, pose: Pose2D) -> Odometry {
    let mut odometry = Odometry {
        header: Header::new(now, "odom"),
        ..Odometry::default()
    };
    odometry.pose.pose = pose.into();
    odometry
}

#[test]
fn it_docks_from_every_side_and_leaves_again() {
    let starts = [
        (3.0, 2.0, 0.0),
        (2.5, 2.8, -0.4),
        (3.5, 1.2, 0.5),
        (4.2, 2.5, -0.7),
        (4.3, 2.0, 1.0),
        (4.45, 1.9, 0.0),
        (4.7, 2.0, 0.0),
    ];
    for ((x, y, theta), error) in starts.into_iter().flat_map(|start| [(start, 0.0), (start, 0.05)]) {
        let mut drive = Drive::from(x, y, theta);
        drive.error = error;
        drive.run();
        let Pose2D {
            x: at,
            y: beside,
            theta: heading,
        } = drive.base;
        let shown = format!("from {x}, {y} with {error}: {:?}", drive.base);
        assert!((at - 4.5).abs() < 0.01, "{shown}");
        assert!((beside - 2.0).abs() < 0.02, "{shown}");
        assert!(heading.abs() < 1_f64.to_radians(), "{shown}");
        assert_eq!(drive.mission().state, Mission::DONE);

        drive.bench.set("leave", Flag::TRUE);
        drive.run();
        assert!((3.4..=3.5).contains(&drive.base.x), "off again: {:?}", drive.base);
        assert_eq!(drive.mission().note.as_str(), "off the tag");
    }
}

#[test]
fn without_the_tag_it_is_not_ready_and_what_it_saw_lasts_for_its_patience() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    drive.sees = false;
    assert!(!drive.step(), "nothing was seen yet");
    assert_eq!(drive.mission().note.as_str(), "waiting for tag 7");
    drive.sees = true;
    assert!(drive.step());
    drive.sees = false;
    drive.bench.set("patience", 1.0);
    let steps = (0..100).take_while(|_| drive.step()).count();
    assert_eq!(steps, 20, "a second");
    assert_eq!(drive.mission().state, Mission::FAILED);
}

#[test]
fn it_docks_at_a_reflector_and_leaves_again() {
    for (x, y, theta) in [(3.0, 2.0, 0.0), (3.5, 1.2, 0.5), (4.7, 2.0, 0.0)] {
        let mut drive = Drive::to_reflector(x, y, theta);
        drive.bench.awake().expect("it awakes");
        drive.step();
        assert!(drive.mission().note.as_str().starts_with("driving"));
        drive.run();
        let shown = format!("from {x}, {y}: {:?}", drive.base);
        assert!((drive.base.x - 4.5).abs() < 0.01, "{shown}");
        assert!((drive.base.y - 2.0).abs() < 0.02, "{shown}");
        assert!(drive.base.theta.abs() < 1_f64.to_radians(), "{shown}");
        drive.bench.set("leave", Flag::TRUE);
        drive.run();
        assert_eq!(drive.mission().note.as_str(), "off the reflector");
    }
}

#[test]
fn without_a_reflector_it_says_what_is_said_of_the_scans() {
    let mut drive = Drive::to_reflector(3.0, 2.0, 0.0);
    drive.sees = false;
    let words = "the laser measures no intensities";
    drive.bench.import("state", &Text::<160>::new(words));
    assert!(!drive.step());
    assert_eq!(drive.mission().note.as_str(), words);
    assert_eq!(drive.mission().state, Mission::RUNNING);
    drive.sees = true;
    drive.bench.set("patience", 1.0);
    assert!(drive.step());
    drive.sees = false;
    let words = "no reflector of 3 strips among 2 bright ones and 0 other things";
    drive.bench.retract("reflector");
    drive.bench.import("state", &Text::<160>::new(words));
    drive.run();
    assert_eq!(drive.mission().note.as_str(), words);
    assert_eq!(drive.mission().state, Mission::FAILED);
}

#[test]
fn another_reflector_is_not_followed_before_a_sleep() {
    let mut drive = Drive::to_reflector(3.0, 2.0, 0.0);
    (0..20).for_each(|_| assert!(drive.step()));
    drive.bench.set("patience", 1.0);
    drive.reflector.y -= 0.9;
    drive.run();
    let mission = drive.mission();
    assert_eq!(
        mission.note.as_str(),
        "another reflector, 0.9 m beside it, is in sight"
    );
    assert_eq!(mission.state, Mission::FAILED);
    assert!((drive.base.y - 2.0).abs() < 0.01, "{:?}", drive.base);
    drive.bench.sleep().expect("it sleeps");
    drive.bench.awake().expect("it awakes");
    drive.run();
    assert!((drive.base.y - 1.1).abs() < 0.02, "{:?}", drive.base);
}

#[test]
fn after_a_long_way_the_place_of_the_reflector_is_new() {
    let mut drive = Drive::to_reflector(4.0, 2.0, 0.0);
    (0..20).for_each(|_| assert!(drive.step()));
    drive.bench.set("patience", 0.5);
    drive.sees = false;
    drive.bench.retract("reflector");
    // Around the room and back, while the odometry drifts by 1.2 m.
    for step in 0..120 {
        let way = if step < 60 { -0.05 } else { 0.05 };
        drive.base = drive.base.transform(&Pose2D::new(way, 0.0, 0.0));
        drive.origin.y += 0.01;
        drive.step();
    }
    drive.sees = true;
    drive.run();
    assert_eq!(drive.mission().state, Mission::DONE);
}

#[test]
fn it_needs_one_kind_of_mark() {
    let mut both = Bench::<Dock>::new();
    let is_refused = |bench: &mut Bench<Dock>| {
        let problems = bench.inspect().unwrap();
        assert_eq!(bench.awake().is_err(), !problems.is_empty(), "{problems:?}");
        !problems.is_empty()
    };
    assert!(is_refused(&mut both));
    both.unbind("tags");
    assert!(!is_refused(&mut both));
    both.unbind("reflector");
    assert!(is_refused(&mut both));
}

#[test]
fn another_tag_is_no_dock() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    drive.bench.set("id", 9_u32);
    assert!(!drive.step());
    assert_eq!(drive.mission().note.as_str(), "waiting for tag 9, it sees 7");
}

#[test]
fn what_it_knows_of_a_tag_does_not_count_for_another() {
    let mut drive = Drive::from(4.0, 2.0, 0.0);
    drive.run();
    drive.bench.set("id", 8_u32);
    assert!(!drive.step(), "it did not see tag 8");
    assert_eq!(drive.mission().note.as_str(), "waiting for tag 8, it sees 7");
    drive.other = Some(Pose2D::new(5.0, 2.5, PI));
    drive.run();
    assert!((drive.base.y - 2.5).abs() < 0.02, "{:?}", drive.base);
}

#[test]
fn a_picture_from_before_a_sleep_says_nothing() {
    let mut drive = Drive::from(4.0, 2.0, 0.0);
    drive.run();
    drive.bench.sleep().expect("it sleeps");
    drive.base = Pose2D::new(1.0, 1.0, 1.0);
    drive.bench.awake().expect("it awakes");
    drive.sees = false;
    // The tags come again, and are those of the last picture.
    drive.bench.import("tags", &drive.picture);
    drive.now += Duration::from_millis(500);
    assert!(!drive.step(), "{}", drive.mission().note);
    assert_eq!(drive.mission().state, Mission::RUNNING, "it waits for a sight");
}

#[test]
fn pictures_that_come_late_are_named() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    drive.sees = false;
    let seen = drive.detection(7, &drive.base.localize(&TAG));
    drive.picture.tags = core::iter::once(seen).collect();
    for _ in 0..3 {
        drive.bench.set_now(drive.now);
        drive.bench.import("tags", &drive.picture);
        drive.now += Duration::from_millis(1200);
        assert!(!drive.step());
        assert_eq!(drive.mission().note.as_str(), "tag 7: the pictures are 1.2 s old");
    }
}

#[test]
fn directions_that_are_ambiguous_count_little() {
    let mut drive = Drive::from(3.0, 2.3, -0.1);
    drive.step();
    (drive.ambiguity, drive.error) = (0.95, 0.5);
    (0..9).for_each(|_| assert!(drive.step()));
    (drive.ambiguity, drive.error) = (0.1, 0.0);
    drive.run();
    assert!((drive.base.y - 2.0).abs() < 0.02, "{:?}", drive.base);
    assert!(drive.base.theta.abs() < 1_f64.to_radians(), "{:?}", drive.base);
}

#[test]
fn a_base_that_is_moved_off_the_place_docks_again() {
    let mut drive = Drive::from(4.0, 2.0, 0.0);
    drive.run();
    drive.base.x -= 0.03;
    assert!(!drive.step(), "within the margin");
    drive.base.x -= 0.05;
    assert!(drive.step());
    drive.run();
    assert!((drive.base.x - 4.5).abs() < 0.01, "{:?}", drive.base);
}

#[test]
fn a_base_that_is_turned_at_the_place_turns_back() {
    let mut drive = Drive::from(4.0, 2.0, 0.0);
    drive.run();
    drive.base.theta += 1.5_f64.to_radians();
    assert!(!drive.step(), "by less than 2 degrees");
    drive.base.theta += 1.0;
    assert!(drive.step());
    drive.run();
    assert!(drive.base.theta.abs() < 1_f64.to_radians(), "{:?}", drive.base);
}

#[test]
fn a_camera_that_repeats_its_last_picture_leads_nowhere() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    (0..20).for_each(|_| assert!(drive.step()));
    drive.is_frozen = true;
    drive.bench.set("patience", 3.0);
    drive.run();
    assert!(drive.base.x < 4.0, "{:?}", drive.base);
    assert_eq!(drive.mission().note.as_str(), "the tag is not in sight");
    drive.is_frozen = false;
    drive.run();
    assert!((drive.base.x - 4.5).abs() < 0.01, "{:?}", drive.base);
}

#[test]
fn a_jump_of_the_odometry_is_not_followed() {
    for origin in [Pose2D::new(0.4, 0.0, 0.0), Pose2D::new(0.0, 0.0, 2.0)] {
        let mut drive = Drive::from(3.0, 2.0, 0.0);
        (0..100).for_each(|_| assert!(drive.step()));
        drive.origin = origin;
        drive.sees = false;
        assert!(!drive.step(), "it does not know where the tag is");
        assert_eq!(drive.mission().state, Mission::RUNNING);
        drive.sees = true;
        drive.run();
        assert!((drive.base.x - 4.5).abs() < 0.01, "{:?}", drive.base);
        assert_eq!(drive.mission().state, Mission::DONE);
    }
}

#[test]
fn without_odometry_it_waits_for_it() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    assert!(drive.step());
    drive.has_odometry = false;
    assert!(!drive.step());
    let mission = drive.mission();
    assert_eq!(mission.note.as_str(), "waiting for the odometry");
    assert_eq!(mission.state, Mission::RUNNING);
    drive.has_odometry = true;
    assert!(drive.step());
}

#[test]
fn numbers_that_are_not_finite_move_nothing() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    drive.error = f64::NAN;
    assert!(!drive.step(), "a tag of no direction");
    drive.error = 0.0;
    assert!(drive.step());
    for broken in 0..3 {
        drive.now += PERIOD;
        drive.bench.set_now(drive.now);
        let mut pose = odometry(drive.now, drive.base);
        match broken {
            0 => pose.pose.pose.position.x = f64::NAN,
            1 => pose.pose.pose.orientation.w = f64::NAN,
            _ => pose.twist.twist.angular.z = f64::INFINITY,
        }
        drive.bench.import("pose", &pose);
        assert!(!drive.bench.check().expect("it checks").ready, "{broken}");
        assert_eq!(drive.mission().note.as_str(), "waiting for the odometry");
    }
    drive.run();
    assert!((drive.base.x - 4.5).abs() < 0.01, "{:?}", drive.base);
}

#[test]
fn the_panel_shows_what_it_knows() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    let shown = |drive: &mut Drive| format!("{:?}", drive.bench.draw().expect("it draws"));
    assert!(shown(&mut drive).contains("waiting for tag 7"));
    drive.step();
    assert!(shown(&mut drive).contains("distance to go"));
}
