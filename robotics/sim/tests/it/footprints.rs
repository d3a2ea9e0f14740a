//! Robots with polygons as bodies: contacts while they drive and turn, and what others see of them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use jde_sim::{CameraConfig, Footprint, LaserConfig, Pose2, RobotConfig, RobotId, Twist2, World, WorldError};
use proptest::prelude::*;

/// A corridor of 1 m along x, with a post, a carton and another robot.
const CORRIDOR: &str = "
    walls   = [{ name = 'wall', points = [[0, 0], [8, 0], [8, 1], [0, 1]], closed = true }]
    circles = [{ name = 'post', center = [5, 0.9], radius = 0.05 }]
    robots  = { r = { start = { x = 1, y = 0.5 } }, other = { start = { x = 3, y = 0.5 } } }";

/// 0.8 m long and 0.4 m wide, around its middle.
const CORNERS: [[f64; 2]; 4] = [[0.4, 0.2], [-0.4, 0.2], [-0.4, -0.2], [0.4, -0.2]];

fn long() -> RobotConfig {
    RobotConfig {
        footprint: Footprint::polygon(&CORNERS).unwrap(),
        linear_acceleration: 1e9,
        linear_deceleration: 1e9,
        angular_acceleration: 1e9,
        angular_deceleration: 1e9,
        ..RobotConfig::default()
    }
}

fn corridor() -> (World, RobotId) {
    let mut world = World::parse(CORRIDOR, "corridor.toml", 7).unwrap();
    let robot = world.add_robot("r", long()).unwrap();
    (world, robot)
}

fn run(world: &mut World, seconds: f64) {
    world.advance_to(world.now() + (seconds * 1e9).round() as u64);
}

#[track_caller]
fn near(actual: f64, expected: f64) {
    assert!((actual - expected).abs() < 1e-6, "{actual} is not {expected}");
}

#[test]
fn the_clearance_is_that_of_the_outline() {
    let (mut world, robot) = corridor();
    near(world.truth(robot).clearance, 0.3);
    world.place(robot, Pose2::new(7.0, 0.5, FRAC_PI_2)).unwrap();
    near(world.truth(robot).clearance, 0.1);
}

#[test]
fn a_polygon_stops_with_its_front_at_a_wall() {
    let (mut world, robot) = corridor();
    world.command(robot, Twist2::new(-0.5, 0.0)).unwrap();
    run(&mut world, 3.0);
    let truth = world.truth(robot);
    near(truth.pose.x, 0.4);
    assert!(
        truth.stalled && truth.contact && truth.collisions == 1,
        "{truth:?}"
    );
    assert!(world.bumpers(robot).rear.contains(&true) && !world.bumpers(robot).front.contains(&true));
}

#[test]
fn a_polygon_cannot_turn_where_its_corners_have_no_room() {
    let text = CORRIDOR
        .replace("[8, 1], [0, 1]", "[8, 0.85], [0, 0.85]")
        .replace("post', center = [5, 0.9]", "post', center = [5, 0.7]");
    let mut world = World::parse(&text.replace("y = 0.5", "y = 0.425"), "narrow.toml", 7).unwrap();
    let robot = world.add_robot("r", long()).unwrap();
    world.command(robot, Twist2::new(0.0, 0.5)).unwrap();
    run(&mut world, 10.0);
    let truth = world.truth(robot);
    // The diagonal is 0.894 m and the corridor 0.85 m: the corner meets the wall at asin(0.425/0.447) less
    // the angle of the corner.
    let expected = (0.425 / 0.2f64.hypot(0.4)).asin() - 0.5f64.atan();
    near(truth.pose.heading, expected);
    assert!(
        truth.stalled && truth.collisions == 1 && truth.twist == Twist2::default(),
        "{truth:?}"
    );
    let odometry = world.odometry(robot).pose.heading;
    assert!(
        (odometry - expected).abs() < 0.01,
        "the wheels stop with the robot: {odometry}"
    );
    world.command(robot, Twist2::new(0.0, -0.5)).unwrap();
    run(&mut world, 0.5);
    assert!(
        world.truth(robot).pose.heading < expected - 0.2,
        "it can turn back"
    );
}

#[test]
fn a_laser_of_another_robot_measures_the_outline() {
    let (mut world, robot) = corridor();
    let other = world.add_robot("other", RobotConfig::default()).unwrap();
    let laser = LaserConfig {
        mount: Pose2::default(),
        sigma: 0.0,
        beams: 4,
        ..LaserConfig::default()
    };
    let mut ranges = [0.0; 4];
    world
        .place(other, Pose2::new(3.0, 0.5, std::f64::consts::PI))
        .unwrap();
    world.laser(other, &laser, &mut ranges).unwrap();
    near(f64::from(ranges[2]), 1.6);
    world.place(robot, Pose2::new(1.0, 0.5, FRAC_PI_4)).unwrap();
    world.laser(other, &laser, &mut ranges).unwrap();
    // The beam along the middle of the corridor meets the side of the turned robot.
    near(f64::from(ranges[2]), 2.0 - 0.2 / FRAC_PI_4.sin());
}

#[test]
fn two_polygons_touch_and_both_count_it() {
    let (mut world, robot) = corridor();
    let other = world.add_robot("other", long()).unwrap();
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    run(&mut world, 4.0);
    near(world.truth(robot).pose.x, 2.2);
    assert_eq!(
        (world.truth(robot).collisions, world.truth(other).collisions),
        (1, 1)
    );
    assert!(world.bumpers(other).rear.contains(&true));
}

#[test]
fn a_polygon_is_placed_only_where_it_fits() {
    let (mut world, robot) = corridor();
    world.place(robot, Pose2::new(2.0, 0.25, 0.0)).unwrap();
    let error = world.place(robot, Pose2::new(2.0, 0.25, 0.6)).unwrap_err();
    assert!(matches!(error, WorldError::PlaceBlocked { .. }), "{error}");
    world.place(robot, Pose2::new(2.0, 0.15, 0.0)).unwrap_err();
    let crossing = world
        .place(robot, Pose2::new(7.9, 0.5, 0.0))
        .unwrap_err()
        .to_string();
    assert!(crossing.contains("0.300 m"), "{crossing}");
}

#[test]
fn a_picture_shows_the_body_of_a_polygon() {
    let (mut world, robot) = corridor();
    let other = world.add_robot("other", RobotConfig::default()).unwrap();
    let camera = CameraConfig::default();
    let (mut with, mut without) = (vec![0; camera.bytes()], vec![0; camera.bytes()]);
    world.picture(robot, &camera, &mut without).unwrap();
    world.place(other, Pose2::new(1.7, 0.5, 0.0)).unwrap();
    world.remove_robot(robot);
    let again = world.add_robot("r", long()).unwrap();
    world.picture(again, &camera, &mut with).unwrap();
    assert_ne!(with, without);
    let red = |picture: &[u8]| picture.chunks(3).filter(|c| c[0] / 2 > c[1].max(c[2])).count();
    world.remove_robot(other);
    let other = world
        .add_robot_at("other", Pose2::new(2.5, 0.5, std::f64::consts::PI), long())
        .unwrap();
    world.picture(again, &camera, &mut with).unwrap();
    assert!(red(&with) > 500, "{}", red(&with));
    let _ = other;
}

#[test]
fn outlines_that_are_no_convex_polygons_around_the_centre_are_refused() {
    let star: Vec<[f64; 2]> = (0..5)
        .map(|corner| (f64::from(corner * 2) * std::f64::consts::TAU / 5.0).sin_cos())
        .map(|(y, x)| [x, y])
        .collect();
    let cases: [(&[[f64; 2]], &str); 7] = [
        (&[[0.0, 0.0], [1.0, 0.0]], "has 2 corners"),
        (
            &[[1.0, -1.0], [2.0, -1.0], [2.0, 1.0], [1.0, 1.0]],
            "contain (0, 0)",
        ),
        (
            &[[1.0, -1.0], [1.0, 1.0], [0.1, 0.0], [-1.0, 1.0], [-1.0, -1.0]],
            "convex",
        ),
        (&star, "convex"),
        (&[[1.0, f64::NAN], [1.0, 1.0], [-1.0, 0.0]], "finite"),
        (&[[50.0, -1.0], [50.0, 1.0], [-1.0, 0.0]], "at most 10 m"),
        (
            &[[1.0, -0.001], [1.0, 0.001], [-1.0, 0.001], [-1.0, -0.001]],
            "m wide",
        ),
    ];
    for (corners, part) in cases {
        let error = Footprint::polygon(corners).unwrap_err().to_string();
        assert!(error.contains(part), "{corners:?}: {error}");
    }
    let reversed: Vec<[f64; 2]> = CORNERS.into_iter().rev().collect();
    assert!(Footprint::polygon(&reversed).is_ok());
}

/// What the distance between a polygon and a wall may err by, m: the algorithm approaches it step by step.
const ROUNDING: f64 = 1e-7;

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn polygons_never_overlap_anything(commands in proptest::collection::vec((-1.0..1.0f64, -2.0..2.0f64, -1.0..1.0f64), 1..30)) {
        let (mut world, robot) = corridor();
        let other = world.add_robot("other", RobotConfig { footprint: Footprint::polygon(&[[0.3, 0.0], [-0.2, 0.25], [-0.2, -0.25]]).unwrap(), ..long() }).unwrap();
        for (v, w, other_v) in commands {
            world.command(robot, Twist2::new(v, w)).unwrap();
            world.command(other, Twist2::new(other_v, -w)).unwrap();
            for _ in 0..40 {
                run(&mut world, 0.01);
                for id in [robot, other] {
                    let truth = world.truth(id);
                    prop_assert!(truth.min_clearance >= 0.0, "{:?}", truth);
                }
                let pose = world.truth(robot).pose;
                for [x, y] in CORNERS {
                    let corner = pose.compose(Pose2::new(x, y, 0.0));
                    prop_assert!((-ROUNDING..=8.0 + ROUNDING).contains(&corner.x) && (-ROUNDING..=1.0 + ROUNDING).contains(&corner.y), "{:?}", corner);
                }
            }
        }
    }

    #[test]
    fn no_corners_panic(corners in proptest::collection::vec([-12.0..12.0f64, -12.0..12.0f64], 0..9)) {
        if let Ok(footprint) = Footprint::polygon(&corners) {
            let [low, high] = footprint.extent();
            prop_assert!(low[0] < 0.0 && low[1] < 0.0 && high[0] > 0.0 && high[1] > 0.0);
            prop_assert!(footprint.radius() <= 10.0);
        }
    }
}
