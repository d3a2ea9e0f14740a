//! Who waves, and who is followed.

use super::*;

#[test]
fn it_follows_who_waves_until_the_next_wave() {
    let mut test = Test::mapped();
    test.mission_at("followed", Mission::RUNNING, "", Pose2D::new(2.0, 2.0, 0.0));
    test.persons(&[(3, 2.0, 2.0), (4, 2.0, -0.1)]);
    test.wave(Some(0.9), 1);
    test.wave(None, 2);
    assert_eq!(test.bench.modulated("follow", "id"), Some(3_u32));
    test.bench.set_child("follow", State::Winner);
    let (child, reason) = test.choice(&["follow", "patrol"]);
    assert_eq!(
        (child.as_deref(), reason.as_str()),
        (Some("follow"), "person 3 waves")
    );
    test.wave(Some(0.9), 1);
    test.wave(None, 10);
    assert_eq!(
        test.awake(),
        ["follow", "patrol"],
        "the robot has turned meanwhile"
    );
    test.wave(Some(0.9), 1);
    assert_eq!(test.awake(), ["patrol"]);
    test.wave(None, 10);
    test.wave(Some(-2.0), 1);
    assert_eq!(test.awake(), ["patrol"], "nobody is there");
    test.persons(&[(4, -1.0, -2.0)]);
    test.wave(Some(-2.0), 1);
    assert_eq!(
        test.bench.modulated("follow", "id"),
        Some(4_u32),
        "now somebody is"
    );
    test.mission("followed", Mission::FAILED, "gave up");
    test.step();
    assert_eq!(test.awake(), ["patrol"]);
}

#[test]
fn a_person_who_is_gone_is_not_followed() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 0.0)]);
    test.wave(Some(0.0), 1);
    test.bench.set_child("follow", State::Checking);
    test.wave(None, 8);
    assert_eq!(test.awake(), ["follow", "patrol"]);
    test.wave(None, 3);
    assert_eq!(test.awake(), ["patrol"]);
}

#[test]
fn a_person_is_not_gone_for_the_time_in_which_the_robot_does_not_look() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 0.0)]);
    test.wave(Some(0.0), 1);
    test.charge(0.1);
    test.at_dock();
    test.mission("docked", Mission::DONE, "docked");
    test.wave(None, 60);
    test.charge(1.0);
    test.step();
    assert_eq!(test.awake(), ["follow", "patrol"], "it has charged");
    test.steps(45);
    assert_eq!(test.awake(), ["follow", "patrol"]);
    test.now += Duration::from_secs(60);
    test.bench.set_now(test.now);
    test.bench.awake().expect("it awakes");
    test.steps(45);
    assert_eq!(test.awake(), ["follow", "patrol"], "it slept");
    test.steps(10);
    assert_eq!(test.awake(), ["patrol"]);
}

#[test]
fn the_wave_of_somebody_else_ends_no_following() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 2.0), (4, 2.0, -2.0)]);
    test.wave(Some(0.78), 1);
    test.bench.set_child("follow", State::Winner);
    test.wave(None, 10);
    // The schema that follows has lost person 3, and found the same one again as person 5.
    test.persons(&[(5, 2.0, 2.0), (4, 2.0, -2.0)]);
    test.mission_at("followed", Mission::RUNNING, "", Pose2D::new(2.0, 1.9, 0.0));
    test.wave(Some(-0.78), 2);
    assert_eq!(test.awake(), ["follow", "patrol"]);
    assert_eq!(test.bench.modulated("follow", "id"), Some(3_u32));
    test.waves(&[-0.78, 0.78], 1);
    assert_eq!(test.awake(), ["patrol"]);
    test.mission("followed", Mission::DONE, "");
    test.wave(None, 10);
    test.waves(&[2.0, -0.78], 1);
    assert_eq!(
        test.bench.modulated("follow", "id"),
        Some(4_u32),
        "nobody is at the largest"
    );
}

#[test]
fn the_wave_of_somebody_else_ends_no_following_of_a_person_who_is_lost() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 2.0), (4, 2.0, -2.0)]);
    test.wave(Some(0.78), 1);
    test.bench.set_child("follow", State::Winner);
    test.wave(None, 10);
    test.persons(&[(4, 2.0, -2.0)]);
    test.mission_at("followed", Mission::RUNNING, "", Pose2D::new(2.0, 2.0, 0.0));
    test.wave(Some(-0.78), 1);
    assert_eq!(test.awake(), ["follow", "patrol"]);
}

#[test]
fn who_waved_is_sought_where_the_robot_looked_when_the_picture_was_taken() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 0.0), (4, 2.0, 1.0)]);
    test.bench.import(
        "blobs",
        &ColorBlobs {
            blobs: [ColorBlob::default()].into_iter().collect(),
            ..ColorBlobs::default()
        },
    );
    test.bench.set_now(test.now + Duration::from_millis(200));
    test.odometry.pose.pose = Pose2D::new(0.0, 0.0, 0.4).into();
    test.odometry.twist.twist = Twist::planar(0.0, 2.0);
    test.step();
    assert_eq!(test.bench.modulated("follow", "id"), Some(3_u32));
}

#[test]
fn a_picture_that_is_too_old_to_say_who_waved_is_refused_in_words() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 0.0)]);
    let blobs = ColorBlobs {
        blobs: [ColorBlob::default()].into_iter().collect(),
        ..ColorBlobs::default()
    };
    test.bench.import("blobs", &blobs);
    test.now += Duration::from_secs(2);
    test.steps(2);
    assert_eq!(test.awake(), ["patrol"]);
    assert!(test.has_logged("cannot tell who waves: the pictures are 2.2 s old"));
}

#[test]
fn a_colour_that_is_no_number_is_no_wave() {
    let mut test = Test::mapped();
    test.persons(&[(3, f64::NAN, 0.0), (4, 2.0, 0.0)]);
    test.wave(Some(f64::NAN), 1);
    assert_eq!(test.awake(), ["patrol"]);
}
