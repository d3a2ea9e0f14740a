//! Where a robot among tags is said to be, and what makes it say nothing.

use core::f64::consts::PI;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{Point, Pose, Quaternion, TagDetection, TagDetections};

use super::{MISFITS, TagPlace, TagPlaces, Tags};

/// Three tags on the right wall of a room of 5 x 4 m.
const PLACES: [Pose2D; 3] = [
    Pose2D::new(5.0, 0.8, PI),
    Pose2D::new(5.0, 2.0, PI),
    Pose2D::new(5.0, 3.2, PI),
];

const START: Pose2D = Pose2D::new(2.5, 1.0, 0.0);

/// A robot that drives in a circle, whose odometry counts and turns 1 % too much.
struct Room {
    bench: Bench<Tags>,
    truth: Pose2D,
    odometry: Pose2D,
    turn_rate: f64,
    /// Added to the place of a tag before the camera, m.
    error: f64,
    /// The turn that the odometry counts for each metre and that is none, rad/m.
    drift: f64,
    /// Whether the camera repeats what it saw last.
    is_frozen: bool,
    seen: TagDetections,
    step: u32,
}

impl Room {
    fn new() -> Self {
        let mut bench = Bench::new();
        let tags = (0..).zip(PLACES).map(|(id, pose)| TagPlace { id, pose });
        bench.set("places", TagPlaces { tags: tags.collect() });
        Self {
            bench,
            truth: START,
            odometry: Pose2D::ORIGIN,
            turn_rate: 0.0,
            error: 0.0,
            drift: 0.0,
            is_frozen: false,
            seen: TagDetections::default(),
            step: 0,
        }
    }

    /// Returns a number of mean 0 and deviation of about 1 that looks random.
    fn noise(&self, stream: u32) -> f64 {
        let sum: f64 = (0..12)
            .map(|part| {
                let bits = (self.step * 97 + stream * 31 + part).wrapping_mul(0x9e37_79b9);
                let bits = (bits ^ bits >> 15).wrapping_mul(0x85eb_ca6b);
                f64::from(bits ^ bits >> 13) / f64::from(u32::MAX)
            })
            .sum();
        sum - 6.0
    }

    /// Moves, shows the tags before it if `sees`, and iterates.
    fn step(&mut self, sees: bool) {
        self.step += 1;
        let now = Duration::from_millis(50 * u64::from(self.step));
        self.bench.set_now(now);
        self.truth = self.truth.transform(&Pose2D::new(0.02, 0.0, 0.02));
        self.odometry = self
            .odometry
            .transform(&Pose2D::new(0.02 * 1.01, 0.0, 0.02 * (1.01 + self.drift)));
        let mut odometry = Odometry {
            header: Header::new(now, "odom"),
            ..Odometry::default()
        };
        odometry.pose.pose = self.odometry.into();
        odometry.twist.twist.angular.z = self.turn_rate;
        self.bench.import("odometry", &odometry);
        if sees {
            if !self.is_frozen {
                let tags = (0..).zip(PLACES).filter_map(|(id, place)| self.tag(id, &place));
                self.seen.tags = tags.collect();
            }
            self.bench.import("tags", &self.seen);
        }
        self.bench.iterate().expect("the iteration succeeds");
    }

    /// Returns a tag as a camera that sees 35 degrees to either side sees it, with errors.
    fn tag(&self, id: u32, place: &Pose2D) -> Option<TagDetection> {
        let seen = self.truth.localize(place);
        let range = seen.x.hypot(seen.y);
        let bearing = seen.y.atan2(seen.x);
        if bearing.abs() > 0.6 {
            return None;
        }
        let noisy = range + 0.01 * range * range * self.noise(id);
        let bearing = bearing + 0.005 * self.noise(10 + id);
        let facing = seen.theta + 0.04 * range * range * self.noise(20 + id);
        let z = [facing.sin(), 0.0, -facing.cos()];
        Some(TagDetection {
            id,
            pose: Pose {
                position: Point {
                    x: -noisy * bearing.sin(),
                    y: 0.0,
                    z: noisy * bearing.cos() + self.error,
                },
                orientation: Quaternion::from_axes([[z[2], 0.0, -z[0]], [0.0, 1.0, 0.0], z]),
            },
            ambiguity: 0.3,
            ..TagDetection::default()
        })
    }

    fn pose(&mut self) -> Option<Pose2D> {
        let pose: Option<Odometry> = self.bench.exported("pose");
        pose.map(|pose| pose.pose2d())
    }

    /// Returns where it believes to be, sure or not.
    fn estimated(&self) -> Pose2D {
        let estimate = self.bench.schema().estimate;
        estimate.expect("it saw a tag").pose
    }

    fn state(&mut self) -> String {
        let state: Text<160> = self.bench.exported("state").expect("it says how sure it is");
        state.as_str().to_owned()
    }
}

#[test]
fn with_tags_at_one_wall_in_four_the_pose_errs_by_less_than_5_cm() {
    for drift in [0.0, 0.08, -0.08] {
        let mut room = Room::new();
        room.drift = drift;
        let (mut sum, mut count, mut worst) = (0.0, 0.0, 0.0_f64);
        for step in 0..2000 {
            room.step(true);
            let Some(pose) = room.pose() else { continue };
            worst = worst.max(pose.distance_to(&room.truth));
            // After the first turn.
            if step > 320 {
                sum += pose.distance_to(&room.truth).powi(2);
                count += 1.0;
            }
        }
        assert!(count > 1600.0, "it is sure nearly always: {count}");
        let error = f64::sqrt(sum / count);
        assert!(error < 0.05 && worst < 0.3, "{error} m, {worst} m with {drift}");
        let lost = START.transform(&room.odometry).distance_to(&room.truth);
        assert!(lost > 0.3, "the odometry alone is lost: {lost} m");
    }
}

#[test]
fn the_pose_is_sure_after_a_tag_and_no_longer_far_from_one() {
    let mut room = Room::new();
    room.step(false);
    assert_eq!(room.pose(), None);
    assert_eq!(room.state(), "no tag was seen yet");
    (0..20).for_each(|_| room.step(true));
    assert!(room.state().starts_with("sure to 0.0"), "{}", room.state());
    let correction: PoseStamped = room.bench.exported("correction").expect("it is sure");
    let corrected = Pose2D::from(correction.pose).transform(&room.odometry);
    let pose = room.pose().expect("it is sure");
    assert!(
        corrected.distance_to(&pose) < 1e-6,
        "{corrected:?} is not {pose:?}"
    );
    assert!((0..4000).any(|_| {
        room.step(false);
        room.pose().is_none()
    }));
    assert!(room.state().starts_with("not sure"), "{}", room.state());
}

#[test]
fn a_robot_that_is_carried_away_is_found_and_one_false_tag_moves_nothing() {
    let mut room = Room::new();
    (0..20).for_each(|_| room.step(true));
    let before = room.pose().expect("it is sure");
    room.truth = Pose2D::new(3.5, 2.5, 0.2);
    room.step(true);
    let after = room.pose().expect("it is sure");
    assert!(
        before.distance_to(&after) < 0.05,
        "a sighting that does not fit is left out"
    );
    (0..20).for_each(|_| room.step(true));
    let found = room.pose().expect("it is sure");
    assert!(
        found.distance_to(&room.truth) < 0.2,
        "{found:?} is not {:?}",
        room.truth
    );
}

#[test]
fn an_odometry_that_jumps_or_is_not_finite_and_unknown_tags_give_no_pose() {
    let mut room = Room::new();
    (0..20).for_each(|_| room.step(true));
    room.odometry.x += 3.0;
    room.step(false);
    assert_eq!(room.pose(), None, "it jumped");
    (0..5).for_each(|_| room.step(true));
    assert!(room.pose().is_some(), "and is known again by a tag");
    room.bench.set(
        "places",
        TagPlaces {
            tags: core::iter::once(TagPlace {
                id: 9,
                pose: PLACES[0],
            })
            .collect(),
        },
    );
    room.odometry.x += 3.0;
    (0..5).for_each(|_| room.step(true));
    assert_eq!(room.pose(), None, "no tag that it knows");
}

#[test]
fn a_sleep_leaves_no_pose() {
    let mut room = Room::new();
    (0..20).for_each(|_| room.step(true));
    room.bench.sleep().expect("it sleeps");
    assert_eq!(room.pose(), None);
    assert_eq!(room.bench.exported::<PoseStamped>("correction"), None);
    room.bench.awake().expect("it awakes");
    // The tags come again, and are those of the last picture.
    room.bench.import("tags", &room.seen);
    room.step += 10;
    room.step(false);
    assert_eq!(room.state(), "no tag was seen yet");
}

#[test]
fn pictures_that_come_late_are_named() {
    let mut room = Room::new();
    for _ in 0..3 {
        let tags = (0..).zip(PLACES).filter_map(|(id, place)| room.tag(id, &place));
        room.seen.tags = tags.collect();
        room.bench.import("tags", &room.seen);
        room.step += 23;
        room.step(false);
        assert_eq!(room.state(), "no tag was seen yet: the pictures are 1.2 s old");
    }
}

#[test]
fn numbers_that_are_not_finite_give_no_pose_and_change_none() {
    let mut room = Room::new();
    for error in [f64::NAN, f64::INFINITY, 1e200] {
        room.error = error;
        room.step(true);
        assert_eq!(room.pose(), None, "the only tag is {error} m away");
    }
    room.error = 0.0;
    (0..20).for_each(|_| room.step(true));
    room.turn_rate = f64::NAN;
    room.step(true);
    assert_eq!(room.pose(), None);
    assert_eq!(room.state(), "there is no odometry");
    room.turn_rate = 0.0;
    for error in [f64::NAN, 1e200, 0.0] {
        room.error = error;
        (0..MISFITS + 1).for_each(|_| room.step(true));
        let pose = room.pose().expect("it is sure");
        assert!(pose.distance_to(&room.truth) < 0.2, "{pose:?} after {error}");
    }
}

#[test]
fn a_camera_that_repeats_its_last_picture_says_nothing() {
    let mut room = Room::new();
    // Round once, until tags are before it again.
    (0..330).for_each(|_| room.step(true));
    assert!(room.seen.tags.len() > 1, "{:?}", room.seen.tags.len());
    room.is_frozen = true;
    for _ in 0..2000 {
        room.step(true);
        let away = room.pose().map(|pose| pose.distance_to(&room.truth));
        assert!(away.is_none_or(|away| away < 0.3), "{away:?} m: {}", room.state());
    }
    assert_eq!(room.pose(), None, "{}", room.state());
    room.is_frozen = false;
    (0..330).for_each(|_| room.step(true));
    let pose = room.pose().expect("it is sure again");
    assert!(
        pose.distance_to(&room.truth) < 0.2,
        "{pose:?} is not {:?}",
        room.truth
    );
}

#[test]
fn what_was_learned_about_the_wheels_outlasts_a_jump_of_the_odometry() {
    let mut room = Room::new();
    room.drift = 0.08;
    (0..330).for_each(|_| room.step(true));
    let mut other = Room::new();
    (other.drift, other.truth) = (room.drift, room.truth);
    room.odometry.x += 3.0;
    // Some pictures, and 2 m without.
    let [known, new] = [&mut room, &mut other].map(|room| {
        (0..5).for_each(|_| room.step(true));
        (0..100).for_each(|_| room.step(false));
        room.estimated().distance_to(&room.truth)
    });
    assert!(known < 0.06 && new > 0.1, "{known} m, {new} m");
}
