//! Pictures: positions by the pinhole formula, hidden surfaces, and the same bytes for the same world.

use jde_sim::{
    CameraConfig, CameraMount, HeadCommand, Pose2, RobotConfig, RobotId, Twist2, World, WorldError,
};
use proptest::prelude::*;

const SECOND: u64 = 1_000_000_000;

/// Creates a robot at the origin that faces along x.
fn place(things: &str) -> (World, RobotId) {
    let mut world = World::parse(
        &format!("floor = 'gray'\nsky = '#0000ff'\n{things}\n[robots.r]\nstart = {{ x = 0, y = 0 }}"),
        "cameras.toml",
        0,
    )
    .unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

/// Returns a camera on the body, 0.4 m above the floor, with a quarter turn of view: the focal length is half
/// the width.
fn camera() -> CameraConfig {
    CameraConfig {
        field_of_view: 90f64.to_radians(),
        mount: CameraMount::Body,
        place: [0.0, 0.0, 0.4],
        ..CameraConfig::default()
    }
}

struct Picture {
    width: usize,
    bytes: Vec<u8>,
}

fn take(world: &World, robot: RobotId, camera: &CameraConfig) -> Picture {
    let mut bytes = vec![0; camera.bytes()];
    world.picture(robot, camera, &mut bytes).unwrap();
    Picture {
        width: camera.width,
        bytes,
    }
}

impl Picture {
    fn at(&self, column: usize, row: usize) -> [u8; 3] {
        let first = 3 * (row * self.width + column);
        self.bytes[first..first + 3].try_into().unwrap()
    }

    /// Returns the centroid of all pixels of a hue, and their number.
    fn blob(&self, hue: fn([u8; 3]) -> bool) -> ([f64; 2], usize) {
        let (pixels, _) = self.bytes.as_chunks::<3>();
        let of_hue = pixels.iter().enumerate().filter(|(_, pixel)| hue(**pixel));
        let (mut sum, mut count) = ([0.0; 2], 0);
        for (index, _) in of_hue {
            sum[0] += (index % self.width) as f64 + 0.5;
            sum[1] += (index / self.width) as f64 + 0.5;
            count += 1;
        }
        (sum.map(|sum| sum / count as f64), count)
    }

    fn hash(&self) -> u64 {
        // FNV-1a: small, and the same everywhere.
        self.bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
        })
    }
}

fn red([r, g, b]: [u8; 3]) -> bool {
    r > 60 && g < r / 2 && b < r / 2
}

fn green([r, g, b]: [u8; 3]) -> bool {
    g > 60 && r < g / 2 && b < g / 2
}

fn look(world: &mut World, robot: RobotId, pan: f64, tilt: f64) {
    let command = HeadCommand {
        pan,
        tilt,
        pan_speed: 10.0,
        tilt_speed: 10.0,
    };
    world.command_head(robot, command).unwrap();
    world.advance_to(world.now() + 5 * SECOND);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// The formula is independent of the renderer: it rotates the point into the frame of the head by sines
    /// and cosines.
    #[test]
    fn a_ball_is_on_the_pixel_that_the_pinhole_formula_says(
        x in 2.0..5.0f64, y in -1.0..1.0f64, heading in -0.3..0.3f64, pan in -0.2..0.2f64, tilt in -0.15..0.3f64,
    ) {
        let (mut world, robot) = place(&format!("balls = [{{ center = [{x}, {y}], radius = 0.06, color = '#ff0000' }}]"));
        world.place(robot, Pose2::new(0.0, 0.0, heading)).unwrap();
        look(&mut world, robot, pan, tilt);
        let camera = CameraConfig { field_of_view: 70f64.to_radians(), ..CameraConfig::default() };
        let (found, count) = take(&world, robot, &camera).blob(red);

        let [mount_x, _, mount_z] = RobotConfig::default().head.mount;
        let (dx, dy) = (x - mount_x * heading.cos(), y - mount_x * heading.sin());
        let bearing = dy.atan2(dx) - heading - pan;
        let level = dx.hypot(dy);
        let (ahead, left, up) = (level * bearing.cos(), level * bearing.sin(), 0.06 - mount_z);
        let (depth, rise) = (ahead * tilt.cos() - up * tilt.sin(), ahead * tilt.sin() + up * tilt.cos());
        let focal = 160.0 / 35f64.to_radians().tan();
        let expected = [160.0 - focal * left / depth, 120.0 - focal * rise / depth];
        prop_assume!((10.0..310.0).contains(&expected[0]) && (10.0..230.0).contains(&expected[1]));
        let size = std::f64::consts::PI * (focal * 0.06 / depth).powi(2);
        prop_assert!((found[0] - expected[0]).abs() < 0.8 && (found[1] - expected[1]).abs() < 0.8, "{:?} {:?}", found, expected);
        prop_assert!((count as f64 / size - 1.0).abs() < 0.35, "{} pixels of {}", count, size);
    }

    #[test]
    fn any_camera_anywhere_makes_a_picture(
        (x, y, heading) in (0.6..11.4f64, 0.6..7.4f64, -4.0..4.0f64),
        (pan, tilt) in (-2.0..2.0f64, -2.0..2.0f64),
        (width, height, view) in (1..90usize, 1..70usize, 0.02..3.0f64),
        z in -1.0..3.0f64,
    ) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../worlds/hall.toml");
        let mut world = World::load(path, 1).unwrap();
        let robot = world.add_robot("pioneer", RobotConfig::default()).unwrap();
        if world.place(robot, Pose2::new(x, y, heading)).is_err() { return Ok(()) }
        look(&mut world, robot, pan, tilt);
        let camera = CameraConfig { width, height, field_of_view: view, place: [0.1, 0.0, z], ..CameraConfig::default() };
        let mut bytes = vec![1; camera.bytes()];
        world.picture(robot, &camera, &mut bytes).unwrap();
        let mut again = vec![2; camera.bytes()];
        world.picture(robot, &camera, &mut again).unwrap();
        prop_assert_eq!(bytes, again, "every byte is written, and always the same");
    }
}

#[test]
fn the_nearer_hides_the_farther_whatever_the_order() {
    for (near, far) in [("#ff0000", "#00ff00"), ("#00ff00", "#ff0000")] {
        let (world, robot) = place(&format!(
            "boxes = [{{ center = [4, 0], size = [0.5, 0.5], color = '{far}', height = 1 }},
                      {{ center = [2, 0], size = [0.5, 0.5], color = '{near}', height = 1 }}]"
        ));
        let middle = take(&world, robot, &camera()).at(160, 120);
        assert_eq!(red(middle), near == "#ff0000", "{middle:?}");
        assert_eq!(green(middle), near == "#00ff00", "{middle:?}");
    }
    let (world, robot) = place(
        "walls = [{ points = [[3, -1], [3, 1]], color = '#00ff00', height = 1 }]
         balls = [{ center = [2, 0], radius = 0.3, color = '#ff0000' }, { center = [4, 0.0], radius = 0.45, color = '#ff0000' }]",
    );
    let picture = take(&world, robot, &camera());
    assert!(
        red(picture.at(160, 130)) && green(picture.at(200, 120)),
        "the ball behind the wall is not seen"
    );
}

#[test]
fn edges_of_a_box_are_where_they_are_seen_from() {
    let (world, robot) =
        place("boxes = [{ center = [2.5, 0], size = [1, 1], color = '#ff0000', height = 0.9 }]");
    let picture = take(&world, robot, &camera());
    // Its front is 2 m away: half a metre to each side is 40 pixels, 0.5 m up 40, 0.4 m down 32.
    for (column, row, inside) in [
        (121, 120, true),
        (119, 120, false),
        (198, 120, true),
        (200, 120, false),
        (160, 81, true),
        (160, 79, false),
        (160, 151, true),
        (160, 153, false),
    ] {
        assert_eq!(red(picture.at(column, row)), inside, "{column} {row}");
    }
}

#[test]
fn level_it_sees_sky_above_the_horizon_and_floor_below() {
    let (world, robot) = place("");
    let picture = take(&world, robot, &camera());
    let blue = |[r, g, b]: [u8; 3]| b > 100 && r == 0 && g == 0;
    assert!(blue(picture.at(160, 119)) && blue(picture.at(5, 3)));
    assert!(!blue(picture.at(160, 120)) && !blue(picture.at(5, 236)));
    assert!(
        picture.at(160, 100)[2] > picture.at(160, 0)[2],
        "the sky is darker above"
    );
}

#[test]
fn tilted_down_it_sees_the_floor_alone_and_up_the_sky_alone() {
    let (mut world, robot) = place("");
    let camera = CameraConfig {
        field_of_view: 40f64.to_radians(),
        ..CameraConfig::default()
    };
    let sky = |picture: &Picture| picture.blob(|pixel| pixel[0] == 0).1;
    look(&mut world, robot, 0.0, 30f64.to_radians());
    assert_eq!(sky(&take(&world, robot, &camera)), 0);
    look(&mut world, robot, 0.0, -30f64.to_radians());
    assert_eq!(sky(&take(&world, robot, &camera)), 320 * 240);
}

#[test]
fn the_grid_of_the_floor_is_one_of_metres() {
    let (world, robot) = place("");
    let picture = take(&world, robot, &camera());
    // The line x = 1 is 0.4 m below the eye and 1 m ahead: 64 pixels below the middle. Beside it is plain
    // floor.
    let (line, plain) = (picture.at(200, 184), picture.at(200, 200));
    assert!(plain[0] > line[0] + 10, "{line:?} {plain:?}");
}

#[test]
fn a_face_is_brighter_toward_the_light() {
    let (world, robot) = place(
        "light = { from_deg = 90, height_deg = 20 }
         boxes = [{ center = [3, 1.4], size = [1, 1], angle_deg = 45, color = '#ff0000', height = 2 }]",
    );
    let picture = take(&world, robot, &camera());
    // Its corner at (2.29, 1.4) separates the face on the right, which looks away from the light, from the
    // one on the left.
    let (left, right) = (picture.at(54, 110), picture.at(72, 110));
    assert!(
        red(left) && red(right) && left[0] > right[0] + 30,
        "{left:?} {right:?}"
    );
}

#[test]
fn a_camera_of_the_head_turns_with_it_and_one_of_the_body_does_not() {
    let (mut world, robot) = place("balls = [{ center = [0, 3], radius = 0.3, color = '#ff0000' }]");
    let (body, head) = (
        camera(),
        CameraConfig {
            place: [0.0; 3],
            mount: CameraMount::Head,
            ..camera()
        },
    );
    look(&mut world, robot, 90f64.to_radians(), 0.0);
    assert!(take(&world, robot, &head).blob(red).1 > 100);
    assert_eq!(take(&world, robot, &body).blob(red).1, 0);
    let left = CameraConfig {
        yaw: 90f64.to_radians(),
        ..body
    };
    assert!(take(&world, robot, &left).blob(red).1 > 100);
}

#[test]
fn two_cameras_beside_each_other_see_the_disparity_of_a_stereo_pair() {
    let (world, robot) = place("balls = [{ center = [2.05, 0], radius = 0.1, color = '#ff0000' }]");
    let eye = |y: f64| CameraConfig {
        place: [0.0, y, 0.0],
        mount: CameraMount::Head,
        ..camera()
    };
    let [left, right] = [0.1, -0.1].map(|y| take(&world, robot, &eye(y)).blob(red).0);
    // Baseline times focal length by depth: 0.2 m, 160 pixels, 2 m.
    assert!(
        (left[0] - right[0] - 16.0).abs() < 0.5 && (left[1] - right[1]).abs() < 0.1,
        "{left:?} {right:?}"
    );
}

#[test]
fn people_and_robots_are_seen_and_the_own_body_is_not() {
    let mut world = World::parse(
        "people = [{ way = [[3, 1], [3, -1]], speed = 0.1, color = '#00ff00' }]
         robots = { r = { start = { x = 0, y = 0 } }, s = { start = { x = 2, y = -1 } } }",
        "cameras.toml",
        0,
    )
    .unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(take(&world, robot, &camera()).blob(red).1, 0);
    world.add_robot("s", RobotConfig::default()).unwrap();
    let picture = take(&world, robot, &camera());
    let ((person, cloth), (other, shell)) = (picture.blob(green), picture.blob(red));
    assert!(
        cloth > 200 && person[0] < 120.0 && person[1] < 120.0,
        "{person:?} {cloth}"
    );
    assert!(
        shell > 300 && other[0] > 220.0 && other[1] > 130.0,
        "{other:?} {shell}"
    );
}

#[test]
fn a_ball_that_was_pushed_aside_is_seen_no_more_where_it_was() {
    let (mut world, robot) = place("balls = [{ center = [0.6, 0.1], radius = 0.11, color = '#ff0000' }]");
    let (before, count) = take(&world, robot, &camera()).blob(red);
    assert!(count > 1000 && before[0] < 150.0, "{before:?} {count}");
    world.command(robot, Twist2::new(0.6, 0.0)).unwrap();
    world.advance_to(3 * SECOND);
    assert_eq!(
        take(&world, robot, &camera()).blob(red).1,
        0,
        "met off its middle, it rolls out of the picture"
    );
}

#[test]
fn numbers_that_cannot_work_are_named() {
    let (world, robot) = place("");
    let error = world.picture(robot, &camera(), &mut [0; 5]).unwrap_err();
    assert!(
        matches!(
            error,
            WorldError::BadBuffer {
                expected: 230_400,
                ..
            }
        ),
        "{error:?}"
    );
    for (bad, word) in [
        (CameraConfig { width: 0, ..camera() }, "width"),
        (
            CameraConfig {
                field_of_view: 3.11,
                ..camera()
            },
            "field_of_view is 3.11: expected 0.01 to 3.1 rad",
        ),
        (
            CameraConfig {
                place: [0.0, f64::NAN, 0.0],
                ..camera()
            },
            "place.y",
        ),
    ] {
        let error = world.picture(robot, &bad, &mut []).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// The hash changes with everything that changes a picture. Then look at a picture, and update the hash.
#[test]
fn a_picture_is_the_same_on_any_machine() {
    let (mut world, robot) = place(
        "walls = [{ points = [[4, -3], [4, 3]], color = 'beige' }]
         boxes = [{ center = [2.5, 0.9], size = [0.5, 0.5], angle_deg = 30 }]
         circles = [{ center = [3, -1], radius = 0.2 }]
         people = [{ way = [[3, 0.3], [3, -1.5]], speed = 0.5 }]
         balls = [{ center = [1.5, -0.3], radius = 0.11, color = 'orange' }]",
    );
    look(&mut world, robot, 0.05, 0.1);
    let camera = CameraConfig {
        width: 64,
        height: 48,
        field_of_view: 1.2,
        ..CameraConfig::default()
    };
    let picture = take(&world, robot, &camera);
    assert_eq!(picture.hash(), 0x21f5_c11e_8077_cf2f, "{:#x}", picture.hash());
}
