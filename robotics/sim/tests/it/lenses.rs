//! Lenses: where a distorted picture shows a thing, by the formula of the plumb bob, and the noise of pixels.

use jde_sim::{CameraConfig, CameraMount, DepthConfig, Lens, RobotConfig, RobotId, World};
use proptest::prelude::*;

/// A robot at the origin, and a red ball at a place.
fn ball([x, y, z]: [f64; 3], seed: u64) -> (World, RobotId) {
    // A ball lies on the floor: the camera's height makes the angle.
    assert!(z < 0.0);
    let text = format!(
        "floor = 'gray'\nsky = 'blue'\nballs = [{{ center = [{x}, {y}], radius = 0.05, color = '#ff0000' }}]\n\
         robots.r.start = {{ x = 0, y = 0 }}"
    );
    let mut world = World::parse(&text, "lens.toml", seed).unwrap();
    let config = RobotConfig {
        footprint: jde_sim::Footprint::Circle { radius: 0.05 },
        ..RobotConfig::default()
    };
    let robot = world.add_robot("r", config).unwrap();
    (world, robot)
}

fn camera(lens: Lens, z: f64) -> CameraConfig {
    CameraConfig {
        width: 320,
        height: 240,
        field_of_view: 60f64.to_radians(),
        mount: CameraMount::Body,
        place: [0.0, 0.0, 0.05 - z],
        lens,
        ..CameraConfig::default()
    }
}

/// Returns the middle of the red pixels, and their number.
fn red(world: &World, robot: RobotId, camera: &CameraConfig) -> ([f64; 2], f64) {
    let mut picture = vec![0; camera.bytes()];
    world.picture(robot, camera, &mut picture).unwrap();
    let (pixels, _) = picture.as_chunks::<3>();
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for (index, [r, g, b]) in pixels.iter().enumerate() {
        if *r > 60 && *g < r / 2 && *b < r / 2 {
            sum[0] += (index % camera.width) as f64 + 0.5;
            sum[1] += (index / camera.width) as f64 + 0.5;
            count += 1.0;
        }
    }
    (sum.map(|sum| sum / count), count)
}

/// The distortion of Brown's model.
fn distorted(lens: &Lens, x: f64, y: f64) -> [f64; 2] {
    let [k1, k2, p1, p2, k3] = lens.distortion;
    let r2 = x * x + y * y;
    let radial = 1.0 + k1 * r2 + k2 * r2.powi(2) + k3 * r2.powi(3);
    [
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn a_lens_shows_a_thing_where_the_formula_says(
        k1 in -0.15..0.2f64,
        k2 in -0.02..0.05f64,
        p1 in -0.003..0.003f64,
        p2 in -0.003..0.003f64,
        principal in [-15.0..15.0f64, -15.0..15.0f64],
        x in -0.4..0.4f64,
        y in 0.05..0.3f64,
    ) {
        let lens = Lens { principal, distortion: [k1, k2, p1, p2, 0.0] };
        // The ball is 2 m ahead.
        let (world, robot) = ball([2.0, -2.0 * x, -2.0 * y], 0);
        let camera = camera(lens, -2.0 * y);
        let ([u, v], count) = red(&world, robot, &camera);
        let [x, y] = distorted(&lens, x, y);
        let focal = camera.focal_length();
        let expected = [160.0 + principal[0] + focal * x, 120.0 + principal[1] + focal * y];
        prop_assert!(count > 0.0);
        prop_assert!((u - expected[0]).abs() < 0.7 && (v - expected[1]).abs() < 0.7, "{} {} {:?}", u, v, expected);
    }
}

#[test]
fn depths_are_those_of_the_points_that_a_lens_shows() {
    let (world, robot) = ball([2.0, -0.6, -0.4], 1);
    let lens = Lens {
        distortion: [-0.2, 0.02, 0.0, 0.0, 0.0],
        ..Lens::default()
    };
    let camera = camera(lens, -0.4);
    let ([u, v], _) = red(&world, robot, &camera);
    let (mut picture, mut depths) = (vec![0; camera.bytes()], vec![0.0; camera.pixels()]);
    let depth = DepthConfig {
        sigma: 0.0,
        ..DepthConfig::default()
    };
    world
        .picture_with_depths(robot, (&camera, &depth), &mut picture, &mut depths)
        .unwrap();
    let found = depths[v as usize * camera.width + u as usize];
    assert!((found - 1.95).abs() < 0.02, "{found}");
}

#[test]
fn a_lens_that_folds_its_picture_is_refused() {
    for (k1, is_valid) in [(-1.5, false), (-0.2, true), (0.5, true), (f64::NAN, false)] {
        let lens = Lens {
            distortion: [k1, 0.0, 0.0, 0.0, 0.0],
            ..Lens::default()
        };
        let checked = camera(lens, -0.5).check();
        assert_eq!(checked.is_ok(), is_valid, "{k1}: {checked:?}");
        assert!(is_valid || checked.is_err_and(|error| error.to_string().contains("camera k1")));
    }
}

#[test]
fn the_noise_of_a_picture_has_its_deviation_and_is_that_of_its_seed() {
    let take = |seed: u64, noise: f64, stream: u16| {
        let (world, robot) = ball([2.0, 0.0, -0.5], seed);
        let camera = CameraConfig {
            noise,
            stream,
            ..camera(Lens::default(), -0.5)
        };
        let mut picture = vec![0; camera.bytes()];
        world.picture(robot, &camera, &mut picture).unwrap();
        picture
    };
    let (plain, noisy) = (take(1, 0.0, 0), take(1, 4.0, 0));
    let errors = plain
        .iter()
        .zip(&noisy)
        .map(|(plain, noisy)| f64::from(*noisy) - f64::from(*plain));
    let (mut sum, mut squares, count) = (0.0, 0.0, plain.len() as f64);
    for error in errors {
        sum += error;
        squares += error * error;
    }
    assert!((sum / count).abs() < 0.1, "{}", sum / count);
    assert!(
        ((squares / count).sqrt() - 4.0).abs() < 0.2,
        "{}",
        (squares / count).sqrt()
    );
    assert_eq!(noisy, take(1, 4.0, 0));
    assert!(noisy != take(2, 4.0, 0) && noisy != take(1, 4.0, 1));
}
