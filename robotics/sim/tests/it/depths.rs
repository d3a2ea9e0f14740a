//! Depths: the distance along the optical axis by plane geometry, the pixels of the picture, and the noise.

use jde_sim::{
    CameraConfig, CameraMount, DepthConfig, HeadCommand, LaserConfig, LineSensorConfig, RobotConfig, RobotId,
    SonarConfig, World, WorldError,
};
use proptest::prelude::*;

const SECOND: u64 = 1_000_000_000;

/// Creates a robot at the origin that faces along x.
fn world_with(things: &str, seed: u64) -> (World, RobotId) {
    let text = format!("{things}\n[robots.r]\nstart = {{ x = 0, y = 0 }}");
    let mut world = World::parse(&text, "depths.toml", seed).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

/// Returns a camera on the body, 0.4 m above the floor, with a field of view of 90 degrees: the focal length
/// is half the width.
fn camera() -> CameraConfig {
    CameraConfig {
        field_of_view: 90f64.to_radians(),
        mount: CameraMount::Body,
        place: [0.0, 0.0, 0.4],
        ..CameraConfig::default()
    }
}

/// Returns a sensor without noise that measures any depth.
fn exact() -> DepthConfig {
    DepthConfig {
        range_min: 0.0,
        range_max: 1e3,
        sigma: 0.0,
        ..DepthConfig::default()
    }
}

fn measure(world: &World, robot: RobotId, camera: &CameraConfig, depth: &DepthConfig) -> Vec<f32> {
    let (mut picture, mut depths) = (vec![0; camera.bytes()], vec![f32::NAN; camera.pixels()]);
    world
        .picture_with_depths(robot, (camera, depth), &mut picture, &mut depths)
        .unwrap();
    depths
}

fn turn_head(world: &mut World, robot: RobotId, pan: f64, tilt: f64) {
    let command = HeadCommand {
        pan,
        tilt,
        pan_speed: 10.0,
        tilt_speed: 10.0,
    };
    world.command_head(robot, command).unwrap();
    world.advance_to(world.now() + 5 * SECOND);
}

/// Returns the part to the left and the part down of a pixel's ray, for one metre ahead.
fn slopes(camera: &CameraConfig, index: usize) -> [f64; 2] {
    let (u, v) = (
        (index % camera.width) as f64 + 0.5,
        (index / camera.width) as f64 + 0.5,
    );
    let focal = camera.focal_length();
    [
        (camera.width as f64 / 2.0 - u) / focal,
        (v - camera.height as f64 / 2.0) / focal,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// The formula is independent of the renderer: it intersects the ray of a pixel with two planes.
    #[test]
    fn every_pixel_of_a_wall_and_the_floor_has_its_depth(
        distance in 0.6..4.5f64, pan in -0.6..0.6f64, tilt in -0.5..0.5f64,
    ) {
        let (mut world, robot) = world_with(
            &format!("walls = [{{ points = [[{distance}, -50], [{distance}, 50]], height = 3 }}]"), 0);
        turn_head(&mut world, robot, pan, tilt);
        let camera = CameraConfig { width: 64, height: 48, mount: CameraMount::Head, place: [0.0; 3], ..camera() };
        let depths = measure(&world, robot, &camera, &exact());
        let [mount_x, _, height] = RobotConfig::default().head.mount;
        for (index, depth) in depths.into_iter().enumerate() {
            let [left, down] = slopes(&camera, index);
            // The head tilts about its left axis, which pans about the upright axis.
            let (level, rise) = (tilt.cos() - down * tilt.sin(), -tilt.sin() - down * tilt.cos());
            let ahead = pan.cos() * level - pan.sin() * left;
            let wall = if ahead > 0.0 { (distance - mount_x) / ahead } else { f64::INFINITY };
            let floor = if rise < 0.0 { height / -rise } else { f64::INFINITY };
            let top = height + wall * rise;
            let wall = if top < 3.0 { wall } else { f64::INFINITY };
            let expected = wall.min(floor);
            // The pixels of an edge and of the horizon may be either side of it.
            if (wall / floor - 1.0).abs() < 1e-3 || (top - 3.0).abs() < 1e-2 || expected > 900.0 { continue }
            prop_assert!((f64::from(depth) / expected - 1.0).abs() < 1e-4, "pixel {}: {} for {}", index, depth, expected);
        }
    }
}

#[test]
fn a_ball_has_the_depth_of_its_near_side() {
    let (world, robot) = world_with("balls = [{ center = [2, 0], radius = 0.4 }]", 0);
    let depths = measure(&world, robot, &camera(), &exact());
    let mut pixels = 0;
    for (index, depth) in depths.iter().enumerate() {
        let [left, down] = slopes(&camera(), index);
        // The first point of `t * (1, left, -down)` that is 0.4 m from (2, 0, 0).
        let square = 1.0 + left * left + down * down;
        let discriminant = 4.0 - square * (4.0 - 0.16);
        if discriminant > 1e-3 {
            let expected = (2.0 - discriminant.sqrt()) / square;
            assert!(
                (f64::from(*depth) - expected).abs() < 1e-5,
                "{depth} for {expected}"
            );
            pixels += 1;
        }
    }
    assert!(pixels > 3000, "{pixels} pixels of the ball");
    // The ball stands on the floor, so that its middle is at the height of the camera.
    assert!((depths[120 * 320 + 160] - 1.6).abs() < 1e-4);
}

#[test]
fn a_tag_has_the_depth_of_its_wall() {
    let wall = "walls = [{ points = [[2, -3], [2, 3]] }]";
    let tag = "[[tags]]\nid = 5\nplace = [2, 0, 0.4]\nfacing_deg = 180";
    let [bare, tagged] = [wall.to_owned(), format!("{wall}\n{tag}")].map(|things| {
        let (world, robot) = world_with(&things, 0);
        measure(&world, robot, &camera(), &exact())
    });
    for (bare, tagged) in bare.into_iter().zip(tagged) {
        assert!((bare - tagged).abs() < 1e-5, "{tagged} for {bare}");
    }
}

#[test]
fn a_picture_with_depths_has_the_same_colours_and_edges() {
    let (world, robot) = world_with(
        "sky = '#0000ff'
         boxes = [{ center = [2.5, 0], size = [1, 1], color = '#ff0000', height = 0.9 }]",
        0,
    );
    let camera = camera();
    let mut alone = vec![0; camera.bytes()];
    world.picture(robot, &camera, &mut alone).unwrap();
    let (mut picture, mut depths) = (vec![1; camera.bytes()], vec![0.0; camera.pixels()]);
    world
        .picture_with_depths(robot, (&camera, &exact()), &mut picture, &mut depths)
        .unwrap();
    assert!(picture == alone);
    let (pixels, _) = picture.as_chunks::<3>();
    for (index, ([r, g, b], depth)) in pixels.iter().zip(depths).enumerate() {
        let floor = 0.4 / slopes(&camera, index)[1];
        let is_front = (depth - 2.0).abs() < 1e-4;
        assert_eq!(*r > 60 && *g < r / 2 && *b < r / 2, is_front, "{index}: {depth}");
        let is_sky = *r == 0 && *b > 100;
        assert_eq!(is_sky, depth == f32::INFINITY, "{index}: {depth}");
        if !is_front && !is_sky {
            assert!(
                (f64::from(depth) / floor - 1.0).abs() < 1e-5,
                "{index}: {depth} for {floor}"
            );
        }
    }
}

#[test]
fn depths_outside_the_range_are_infinite() {
    let (world, robot) = world_with("walls = [{ points = [[2, -9], [2, 9]], height = 3 }]", 0);
    let middle = |range_min, range_max| {
        let depth = DepthConfig {
            range_min,
            range_max,
            ..exact()
        };
        measure(&world, robot, &camera(), &depth)[120 * 320 + 160]
    };
    assert!((middle(1.9, 2.1) - 2.0).abs() < 1e-6);
    assert_eq!(middle(2.1, 5.0), f32::NEG_INFINITY);
    assert_eq!(middle(0.5, 1.9), f32::INFINITY);
    let above = CameraConfig {
        place: [0.0, 0.0, 4.0],
        ..camera()
    };
    assert_eq!(measure(&world, robot, &above, &exact())[0], f32::INFINITY, "sky");
}

#[test]
fn an_eye_in_or_below_the_floor_measures_none() {
    let (world, robot) = world_with("", 0);
    for z in [0.0, -0.5] {
        let camera = CameraConfig {
            place: [0.0, 0.0, z],
            ..camera()
        };
        let depths = measure(&world, robot, &camera, &exact());
        assert!(depths.iter().all(|depth| *depth == f32::INFINITY), "{z}");
    }
}

/// The errors of the pixels of a wall that faces the camera, in metres.
fn errors(world: &World, robot: RobotId, distance: f64, stream: u16) -> Vec<f64> {
    let depth = DepthConfig {
        range_max: 100.0,
        stream,
        ..DepthConfig::default()
    };
    let depths = measure(world, robot, &camera(), &depth);
    // The upper half of the picture is above the horizon.
    let wall = depths[..320 * 120].iter();
    wall.map(|depth| f64::from(*depth) - distance).collect()
}

#[test]
fn the_noise_is_normal_and_grows_with_the_square_of_the_depth() {
    for distance in [1.0, 2.0, 4.0] {
        let wall = format!("walls = [{{ points = [[{distance}, -90], [{distance}, 90]], height = 50 }}]");
        let (world, robot) = world_with(&wall, 3);
        let errors = errors(&world, robot, distance, 0);
        let count = errors.len() as f64;
        let sigma = 0.001425 * distance * distance;
        let mean = errors.iter().sum::<f64>() / count;
        let square = errors.iter().map(|error| error * error).sum::<f64>() / count;
        // Five standard deviations of the two estimates, and the rounding of a depth.
        assert!(
            mean.abs() < 5.0 * sigma / count.sqrt() + 1e-5,
            "{mean} at {distance} m"
        );
        assert!(
            (square.sqrt() / sigma - 1.0).abs() < 5.0 / (2.0 * count).sqrt(),
            "{} for {sigma}",
            square.sqrt()
        );
        let inside = errors.iter().filter(|error| error.abs() < sigma).count() as f64 / count;
        assert!(
            (inside - 0.6827).abs() < 5.0 * (0.2166 / count).sqrt(),
            "{inside}"
        );
        let product = errors.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / count;
        assert!(
            product.abs() < 5.0 * sigma * sigma / count.sqrt(),
            "neighbours are independent"
        );
    }
}

#[test]
fn the_noise_depends_on_the_seed_the_stream_and_the_time_only() {
    let wall = "walls = [{ points = [[2, -90], [2, 90]], height = 50 }]";
    let (mut world, robot) = world_with(wall, 3);
    let first = errors(&world, robot, 2.0, 0);
    assert!(
        first == errors(&world, robot, 2.0, 0),
        "it is a function of the time"
    );
    assert!(first != errors(&world, robot, 2.0, 1));
    let (other, other_robot) = world_with(wall, 4);
    assert!(first != errors(&other, other_robot, 2.0, 0));
    world.advance_to(SECOND);
    assert!(first != errors(&world, robot, 2.0, 0));
}

#[test]
fn measuring_depths_changes_no_other_sensor() {
    let history = |with_depths: bool| {
        let (mut world, robot) = world_with("walls = [{ points = [[2, -9], [2, 9]] }]", 5);
        let line = LineSensorConfig {
            mounts: vec![[0.1, 0.0]],
            spot: 0.01,
            sigma: 0.05,
            stream: 0,
        };
        let mut readings = Vec::new();
        for tick in 1..20 {
            world.advance_to(tick * SECOND / 20);
            if with_depths {
                measure(&world, robot, &camera(), &DepthConfig::default());
            }
            let (mut ranges, mut echoes, mut brightness) = (vec![0.0; 180], vec![0.0; 16], vec![0.0]);
            world.laser(robot, &LaserConfig::default(), &mut ranges).unwrap();
            world.sonars(robot, &SonarConfig::default(), &mut echoes).unwrap();
            world.line_sensor(robot, &line, &mut brightness).unwrap();
            readings.extend([ranges, echoes, brightness].concat());
        }
        readings
    };
    assert!(history(false) == history(true));
}

#[test]
fn invalid_values_of_a_depth_sensor_are_reported() {
    let (world, robot) = world_with("", 0);
    let measure = |depth: &DepthConfig, depths: &mut [f32]| {
        let mut picture = vec![0; camera().bytes()];
        world
            .picture_with_depths(robot, (&camera(), depth), &mut picture, depths)
            .unwrap_err()
    };
    let error = measure(&DepthConfig::default(), &mut [0.0; 5]);
    assert!(
        matches!(
            error,
            WorldError::BadBuffer {
                sensor: "depths",
                given: 5,
                expected: 76_800
            }
        ),
        "{error:?}"
    );
    for (invalid, part) in [
        (
            DepthConfig {
                range_min: -0.1,
                ..exact()
            },
            "depth range_min is -0.1: expected 0 m or more",
        ),
        (
            DepthConfig {
                range_min: 2.0,
                range_max: 2.0,
                ..exact()
            },
            "depth range_max is 2: expected more than range_min",
        ),
        (
            DepthConfig {
                sigma: f64::NAN,
                ..exact()
            },
            "depth sigma",
        ),
    ] {
        let error = measure(&invalid, &mut []).to_string();
        assert!(error.contains(part), "{error}");
    }
}
