//! The exports of a camera and their times: the world's own time, a robot that enters and leaves, and
//! mistakes of configuration.

use core::time::Duration;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

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
    bench.awake().expect("its configuration is valid");
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
fn a_picture_shows_the_view_of_the_robot_at_the_time_of_the_world() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let mut camera = awake(&path, "carrier");
    robot.idle(1.0);
    camera.set_now(Duration::from_millis(1013));
    camera.iterate().expect("it takes a picture");
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
fn a_stereo_pair_on_the_head_has_a_disparity_and_turns_with_the_head() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let cameras = [0.1, -0.1].map(|y| {
        let mut bench = camera(&path, "carrier");
        bench.set("y", y);
        bench.awake().expect("its configuration is valid");
        bench
    });
    let turn_head = |robot: &mut Robot, pan: f64| {
        let command = PanTilt {
            pan,
            pan_velocity: 1.0,
            ..PanTilt::default()
        };
        robot.bench.command("head", &command);
        robot.idle(2.0);
    };
    let [mut left, mut right] = cameras;
    let mut pair = |robot: &Robot| {
        [&mut left, &mut right].map(|camera| {
            camera.set_now(robot.now);
            camera.iterate().expect("it takes a picture");
            red(image(camera).expect("the robot is there"))[0]
        })
    };
    robot.idle(0.1);
    let level = pair(&robot);
    assert!((level[0] - level[1] - 16.0).abs() < 0.5, "{level:?}");
    turn_head(&mut robot, 0.3);
    let turned = pair(&robot);
    assert!(
        turned[0] > level[0] + 40.0,
        "the ball is farther to the right: {level:?} {turned:?}"
    );
}

#[test]
fn the_camera_waits_for_the_robot_and_retracts_when_it_leaves() {
    let (_folder, path) = file(HALL);
    let mut camera = awake(&path, "carrier");
    camera.iterate().expect("it waits");
    assert!(image(&camera).is_none());
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.1);
    camera.iterate().expect("it takes a picture");
    assert!(image(&camera).is_some());
    drop(robot);
    camera.iterate().expect("it waits again");
    assert!(
        image(&camera).is_none(),
        "the picture of a closed world is retracted"
    );
}

#[test]
fn a_long_wait_for_the_robot_causes_one_warning() {
    let (_folder, path) = file(HALL);
    let mut camera = awake(&path, "carrier");
    let mut wait_until = |milliseconds| {
        camera.set_now(Duration::from_millis(milliseconds));
        camera.iterate().expect("it waits");
        let lines = camera.log().iter().map(|(_, text)| text.clone());
        lines.collect::<Vec<_>>()
    };
    assert!(wait_until(0).is_empty());
    assert!(wait_until(1_990).is_empty(), "there is no warning before 2 s");
    let warnings = wait_until(2_000);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    for expected in ["`carrier`", &path, "sim/robot"] {
        assert!(
            warnings[0].contains(expected),
            "`{expected}` is not in: {}",
            warnings[0]
        );
    }
    assert_eq!(wait_until(60_000), warnings, "there is one warning");
}

#[test]
fn another_spelling_of_a_path_is_the_same_world() {
    let (folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.1);
    let name = std::path::Path::new(&path).file_name().expect("it is a file");
    let other_spelling = folder
        .path()
        .join(".")
        .join("..")
        .join(folder.path().file_name().expect("it is a folder"));
    let other_spelling = other_spelling.join(name);
    let mut camera = awake(other_spelling.to_str().expect("its name is a text"), "carrier");
    camera.iterate().expect("it takes a picture");
    assert!(image(&camera).is_some());
}

#[test]
fn the_camera_opens_no_world_and_uses_the_time_of_the_open_one() {
    let (_folder, path) = file(HALL);
    let mut camera = awake(&path, "carrier");
    camera.set_now(Duration::from_secs(60));
    camera.iterate().expect("it waits");
    assert!(image(&camera).is_none());
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.5);
    camera.set_now(Duration::from_millis(530));
    camera.iterate().expect("it takes a picture");
    assert_eq!(camera.exported_at("image"), Some(Duration::from_millis(530)));
}

#[test]
fn without_new_time_there_is_no_new_picture() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let mut camera = awake(&path, "carrier");
    robot.idle(0.5);
    camera.iterate().expect("it takes a picture");
    let before = bytes(&camera);
    let _other = Robot::awake(&path, "other");
    camera.iterate().expect("no time has passed since");
    assert!(bytes(&camera) == before, "the world has not changed");
    robot.idle(0.05);
    camera.iterate().expect("it takes a picture");
    assert!(bytes(&camera) != before);
}

#[test]
fn two_runs_take_the_same_pictures() {
    let run = || {
        let (_folder, path) = file(HALL);
        let mut robot = Robot::awake(&path, "carrier");
        let mut camera = awake(&path, "carrier");
        robot.drive(0.3, 0.1, 2.0);
        camera.iterate().expect("it takes a picture");
        bytes(&camera)
    };
    assert!(run() == run());
}

#[track_caller]
fn assert_refused(mut camera: Bench<Camera>, expected: &[&str]) {
    let problems = camera.inspect().expect("it inspects");
    let reason = match camera.awake() {
        Err(failure) => failure.reason,
        Ok(()) => camera.iterate().expect_err("it has no picture").reason,
    };
    for text in expected {
        assert!(reason.contains(text), "`{text}` is not in: {reason}");
    }
    let messages: Vec<_> = problems.iter().map(|problem| &*problem.words).collect();
    assert_eq!(messages, [reason], "an inspection reports the same");
}

#[test]
fn invalid_settings_are_refused_with_a_remedy() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.1);
    assert_refused(
        camera("", "carrier"),
        &["no world or no robot", "worlds/hall.toml"],
    );
    assert_refused(camera(&path, ""), &["no world or no robot", "robot = "]);
    assert_refused(camera(&path, "carier"), &["no robot `carier`", "`carrier`"]);
    let mut large = camera(&path, "carrier");
    large.set("width", 1280_u32);
    large.set("height", 720_u32);
    assert_refused(large, &["a picture of 1280 x 720", "921600"]);
    let mut large = depth_camera(&path);
    large.set("width", 640_u32);
    large.set("height", 480_u32);
    assert_refused(large, &["a depth image of 640 x 480", "1228800", "640 x 360"]);
    let mut empty = depth_camera(&path);
    empty.set("depth_max", 0.4);
    assert_refused(empty, &["depth range_max is 0.4"]);
}

fn depth_camera(world: &str) -> Bench<Camera> {
    let mut bench = camera(world, "carrier");
    bench.set("with_depth", Flag::new(true));
    bench
}

/// The depths of a camera, in metres.
fn depths(bench: &mut Bench<Camera>) -> Vec<f32> {
    bench.iterate().expect("it measures");
    let depth: &Image = bench.exported_in_place("depth").expect("the robot is there");
    let (places, rest) = depth.data.as_slice().as_chunks::<4>();
    assert!(rest.is_empty());
    places.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

#[test]
fn a_depth_image_has_the_geometry_and_the_time_of_the_picture() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.5);
    let mut camera = depth_camera(&path);
    camera.set("depth_max", 100.0);
    camera.set("depth_noise", 0.0);
    camera.awake().expect("its configuration is valid");
    let depths = depths(&mut camera);
    let depth: &Image = camera.exported_in_place("depth").expect("it has measured");
    assert_eq!((depth.width, depth.height, depth.step), (320, 240, 1280));
    assert_eq!(depth.encoding.as_str(), "32FC1");
    assert_eq!(depth.header, image(&camera).expect("it has a picture").header);
    assert_eq!(camera.exported_at("depth"), camera.exported_at("image"));
    assert_eq!(depths.len(), 320 * 240);
    // The wall is 6 m ahead of the robot's middle, and 5.95 m ahead of the head; the ball is 2 m away.
    assert!((depths[100 * 320 + 160] - 5.95).abs() < 1e-4);
    let [u, v] = red(image(&camera).expect("it has a picture"));
    let ball = depths[v as usize * 320 + u as usize];
    assert!((1.9..2.0).contains(&ball), "{ball}");
    drop(robot);
    camera.iterate().expect("it waits");
    assert!(camera.exported_in_place::<Image>("depth").is_none());
}

#[test]
fn two_runs_measure_the_same_depths_with_noise() {
    let run = |noise: f64| {
        let (_folder, path) = file(HALL);
        let mut robot = Robot::awake(&path, "carrier");
        robot.idle(0.5);
        let mut camera = depth_camera(&path);
        camera.set("depth_noise", noise);
        camera.awake().expect("its configuration is valid");
        depths(&mut camera)
    };
    let first = run(0.001);
    assert!(first == run(0.001));
    assert!(first != run(0.0));
}

#[test]
fn a_camera_without_depth_exports_none() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    robot.idle(0.5);
    let mut camera = awake(&path, "carrier");
    camera.iterate().expect("it takes a picture");
    assert!(image(&camera).is_some());
    assert!(camera.exported_in_place::<Image>("depth").is_none());
}

#[test]
fn a_camera_states_its_lens() {
    let (_folder, path) = file(HALL);
    let _robot = Robot::awake(&path, "carrier");
    let mut bench = camera(&path, "carrier");
    for (key, value) in [
        ("principal_x", 5.0),
        ("principal_y", -3.0),
        ("k1", -0.02),
        ("p2", 0.001),
        ("noise", 2.0),
    ] {
        bench.set(key, value);
    }
    bench.awake().expect("its configuration is valid");
    bench.iterate().expect("it takes a picture");
    let info: CameraInfo = bench.exported("camera_info").expect("a picture");
    assert_eq!((info.k[2], info.k[5]), (159.5 + 5.0, 119.5 - 3.0));
    assert_eq!((info.p[2], info.p[6]), (info.k[2], info.k[5]));
    assert_eq!(info.d.as_slice(), [-0.02, 0.0, 0.0, 0.001, 0.0]);
    assert_eq!(info.distortion_model.as_str(), "plumb_bob");
    let ([u, v], focal) = (red(image(&bench).expect("a picture")), info.k[0]);
    // The ball is 2 m ahead of the head, 0.25 m lower.
    let (x, y) = (0.0, 0.25 / 2.0);
    let r2 = x * x + y * y;
    let expected = [
        info.k[2] + 0.5 + focal * (0.001 * r2),
        info.k[5] + 0.5 + focal * y * (1.0 - 0.02 * r2),
    ];
    assert!(
        (u - expected[0]).abs() < 1.0 && (v - expected[1]).abs() < 1.0,
        "{u} {v} {expected:?}"
    );
}

#[test]
fn a_lens_that_folds_its_picture_is_a_problem_of_the_camera() {
    let (_folder, path) = file(HALL);
    let mut bench = camera(&path, "carrier");
    bench.set("k1", -2.0);
    let error = bench.awake().expect_err("it folds").to_string();
    assert!(error.contains("camera k1"), "{error}");
}

#[test]
fn a_late_picture_states_when_it_was_taken() {
    let (_folder, path) = file(HALL);
    let mut robot = Robot::awake(&path, "carrier");
    let (mut prompt, mut late) = (camera(&path, "carrier"), camera(&path, "carrier"));
    late.set("latency", 0.12);
    for bench in [&mut prompt, &mut late] {
        bench.awake().expect("its configuration is valid");
    }
    let mut pictures = Vec::new();
    for _ in 0..20 {
        robot.bench.command("velocity", &Twist::planar(0.0, 0.3));
        robot.idle(0.05);
        for bench in [&mut prompt, &mut late] {
            bench.set_now(robot.now);
            bench.iterate().expect("it takes a picture");
        }
        pictures.push((prompt.exported_at("image"), bytes(&prompt)));
        if let Some(measured) = late.exported_at("image") {
            assert!(robot.now - measured >= Duration::from_millis(120), "{measured:?}");
            assert!(pictures.contains(&(Some(measured), bytes(&late))));
            assert_eq!(late.exported_at("camera_info"), Some(measured));
        }
    }
    assert!(late.exported_at("image").is_some());
}
