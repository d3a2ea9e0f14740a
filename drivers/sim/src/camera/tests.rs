//! The exports of a camera and their times: the world's own time, a robot that enters and leaves, and
//! mistakes of configuration.

use core::time::Duration;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::Camera;
use crate::tests::{Robot, file};

/// A hall with a red ball 2 m ahead of the robot's head.
const HALL: &str = r##"
walls = [{ name = "hall", points = [[0, 0], [8, 0], [8, 6], [0, 6]], closed = true }]
balls = [{ center = [4.05, 3], radius = 0.1, color = "#ff0000" }]

[robots.carrier]
start = { x = 2, y = 3, heading_deg = 0 }

[robots.other]
start = { x = 5, y = 3.6, heading_deg = 0 }
"##;

fn camera(world: &str, robot: &str) -> Bench<Camera> {
    let mut bench = Bench::new();
    bench.set("world", Text::<1024>::new(world));
    bench.set("robot", Text::<60>::new(robot));
    bench.set("field_of_view", core::f64::consts::FRAC_PI_2);
    bench
}

fn awake(world: &str, robot: &str) -> Bench<Camera> {
    let mut bench = camera(world, robot);
    bench.awake().expect("its numbers are sound");
    bench
}

fn image(bench: &Bench<Camera>) -> Option<&Image> {
    bench.exported_in_place("image")
}

/// The bytes of the picture, for comparison.
fn bytes(bench: &Bench<Camera>) -> Vec<u8> {
    image(bench).expect("the robot is there").data.as_slice().to_vec()
}

/// The middle of all red pixels.
fn red(image: &Image) -> [f64; 2] {
    let (pixels, _) = image.data.as_slice().as_chunks::<3>();
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for (index, [r, g, b]) in pixels.iter().enumerate() {
        if *r > 60 && *g < r / 2 && *b < r / 2 {
            sum[0] += (index % image.width as usize) as f64 + 0.5;
            sum[1] += (index / image.width as usize) as f64 + 0.5;
            count += 1.0;
        }
    }
    sum.map(|sum| sum / count)
}

#[test]
fn it_shows_what_the_robot_has_before_it_at_the_worlds_time() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let mut camera = awake(&path, "carrier");
    robot.idle(1.0);
    camera.set_now(Duration::from_millis(1013));
    camera.iterate().expect("it sees");
    let image = image(&camera).expect("the robot is there");
    assert_eq!((image.width, image.height, image.step), (320, 240, 960));
    assert_eq!(
        (image.encoding.as_str(), image.header.frame_id.as_str()),
        ("rgb8", "camera")
    );
    assert_eq!(image.data.len(), 320 * 240 * 3);
    // The world advances in whole steps.
    let time = Duration::from_millis(1010);
    assert_eq!(camera.exported_at("image"), Some(time));
    assert_eq!(Duration::from(image.header.stamp), time);
    // 2 m ahead, 0.25 m below the camera; the focal length is 160 pixels.
    let [u, v] = red(image);
    assert!((u - 160.0).abs() < 0.6 && (v - 140.0).abs() < 0.6, "{u} {v}");
}

#[test]
fn a_pair_on_the_head_sees_the_disparity_and_turns_with_it() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let eyes = [0.1, -0.1].map(|y| {
        let mut bench = camera(&path, "carrier");
        bench.set("y", y);
        bench.awake().expect("its numbers are sound");
        bench
    });
    let look = |robot: &mut Robot, pan: f64| {
        let command = PanTilt {
            pan,
            pan_velocity: 1.0,
            ..PanTilt::default()
        };
        robot.bench.command("head", &command);
        robot.idle(2.0);
    };
    let [mut left, mut right] = eyes;
    let mut pair = |robot: &Robot| {
        [&mut left, &mut right].map(|eye| {
            eye.set_now(robot.now);
            eye.iterate().expect("it sees");
            red(image(eye).expect("the robot is there"))[0]
        })
    };
    robot.idle(0.1);
    let level = pair(&robot);
    assert!((level[0] - level[1] - 16.0).abs() < 0.5, "{level:?}");
    look(&mut robot, 0.3);
    let turned = pair(&robot);
    assert!(
        turned[0] > level[0] + 40.0,
        "the ball is farther to the right: {level:?} {turned:?}"
    );
}

#[test]
fn it_waits_for_the_robot_and_retracts_when_it_is_gone() {
    let (_folder, path) = file(HALL);
    let mut camera = awake(&path, "carrier");
    camera.iterate().expect("it waits");
    assert!(image(&camera).is_none());
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.1);
    camera.iterate().expect("it sees");
    assert!(image(&camera).is_some());
    drop(robot);
    camera.iterate().expect("it waits again");
    assert!(image(&camera).is_none(), "nobody is to see a world that is gone");
}

#[test]
fn it_says_once_for_whom_it_waits_so_long() {
    let (_folder, path) = file(HALL);
    let mut camera = awake(&path, "carrier");
    let mut wait_until = |milliseconds| {
        camera.set_now(Duration::from_millis(milliseconds));
        camera.iterate().expect("it waits");
        let said = camera.log().iter().map(|(_, text)| text.clone());
        said.collect::<Vec<_>>()
    };
    assert!(wait_until(0).is_empty());
    assert!(wait_until(1_990).is_empty(), "robots may take their time");
    let said = wait_until(2_000);
    assert_eq!(said.len(), 1, "{said:?}");
    for words in ["`carrier`", &path, "sim/pioneer"] {
        assert!(said[0].contains(words), "`{words}` is not in: {}", said[0]);
    }
    assert_eq!(wait_until(60_000), said, "once is enough");
}

#[test]
fn a_path_written_in_another_way_is_the_same_world() {
    let (folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.1);
    let name = std::path::Path::new(&path).file_name().expect("it is a file");
    let around = folder
        .path()
        .join(".")
        .join("..")
        .join(folder.path().file_name().expect("it is a folder"));
    let around = around.join(name);
    let mut camera = awake(around.to_str().expect("its name is a text"), "carrier");
    camera.iterate().expect("it sees");
    assert!(image(&camera).is_some());
}

#[test]
fn it_opens_no_world_and_sees_the_one_there_is_at_its_own_time() {
    let (_folder, path) = file(HALL);
    let mut camera = awake(&path, "carrier");
    camera.set_now(Duration::from_secs(60));
    camera.iterate().expect("it waits");
    assert!(image(&camera).is_none());
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.5);
    camera.set_now(Duration::from_millis(530));
    camera.iterate().expect("it sees");
    assert_eq!(camera.exported_at("image"), Some(Duration::from_millis(530)));
}

#[test]
fn without_new_time_there_is_no_new_picture() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let mut camera = awake(&path, "carrier");
    robot.idle(0.5);
    camera.iterate().expect("it sees");
    let before = bytes(&camera);
    let _other = Robot::awake(&path, "other");
    camera.iterate().expect("no time has passed since");
    assert!(bytes(&camera) == before, "it still stands");
    robot.idle(0.05);
    camera.iterate().expect("it sees the other come");
    assert!(bytes(&camera) != before);
}

#[test]
fn two_runs_see_the_same_bytes() {
    let run = || {
        let (_folder, path) = file(HALL);
        let mut robot = Robot::awake(&path, "carrier");
        let mut camera = awake(&path, "carrier");
        robot.drive(0.3, 0.1, 2.0);
        camera.iterate().expect("it sees");
        bytes(&camera)
    };
    assert!(run() == run());
}

#[track_caller]
fn refused(mut camera: Bench<Camera>, words: &[&str]) {
    let found = camera.inspect().expect("it inspects");
    let reason = match camera.awake() {
        Err(failure) => failure.reason,
        Ok(()) => camera.iterate().expect_err("it has no picture").reason,
    };
    for word in words {
        assert!(reason.contains(word), "`{word}` is not in: {reason}");
    }
    let said: Vec<_> = found.iter().map(|problem| &*problem.words).collect();
    assert_eq!(said, [reason], "an inspection says the same");
}

#[test]
fn what_a_person_must_mend_is_said() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.1);
    refused(
        camera("", "carrier"),
        &["no world or no robot", "worlds/hall.toml"],
    );
    refused(camera(&path, ""), &["no world or no robot", "robot = "]);
    refused(camera(&path, "carier"), &["no robot `carier`", "`carrier`"]);
    let mut large = camera(&path, "carrier");
    large.set("width", 1280_u32);
    large.set("height", 720_u32);
    refused(large, &["1280 x 720", "921600"]);
}
