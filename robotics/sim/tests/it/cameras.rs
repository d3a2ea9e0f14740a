//! Pictures: positions by the pinhole formula, hidden surfaces, and equal bytes for equal worlds.

use jde_sim::{
    CameraConfig, CameraMount, Edits, HeadCommand, Pose2, RobotConfig, RobotId, Twist2, World, WorldError,
};
use proptest::prelude::*;

const SECOND: u64 = 1_000_000_000;

/// Creates a robot at the origin that faces along x.
fn world_with(things: &str) -> (World, RobotId) {
    let mut world = World::parse(
        &format!("floor = 'gray'\nsky = '#0000ff'\n{things}\n[robots.r]\nstart = {{ x = 0, y = 0 }}"),
        "cameras.toml",
        0,
    )
    .unwrap();
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

struct Picture {
    width: usize,
    bytes: Vec<u8>,
}

fn take_picture(world: &World, robot: RobotId, camera: &CameraConfig) -> Picture {
    let mut bytes = vec![0; camera.bytes()];
    world.picture(robot, camera, &mut bytes).unwrap();
    Picture {
        width: camera.width,
        bytes,
    }
}

impl Picture {
    fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let first = 3 * (row * self.width + column);
        self.bytes[first..first + 3].try_into().unwrap()
    }

    /// Returns the centroid and the number of the pixels of a hue.
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
        // FNV-1a
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

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// The formula is independent of the renderer: it uses sines and cosines to rotate the point into the
    /// frame of the head.
    #[test]
    fn a_ball_is_at_the_pixel_of_the_pinhole_formula(
        x in 2.0..5.0f64, y in -1.0..1.0f64, heading in -0.3..0.3f64, pan in -0.2..0.2f64, tilt in -0.15..0.3f64,
    ) {
        let (mut world, robot) = world_with(&format!("balls = [{{ center = [{x}, {y}], radius = 0.06, color = '#ff0000' }}]"));
        world.place(robot, Pose2::new(0.0, 0.0, heading)).unwrap();
        turn_head(&mut world, robot, pan, tilt);
        let camera = CameraConfig { field_of_view: 70f64.to_radians(), ..CameraConfig::default() };
        let (found, count) = take_picture(&world, robot, &camera).blob(red);

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
    fn every_camera_at_every_pose_draws_the_same_picture_twice(
        (x, y, heading) in (0.6..11.4f64, 0.6..7.4f64, -4.0..4.0f64),
        (pan, tilt) in (-2.0..2.0f64, -2.0..2.0f64),
        (width, height, view) in (1..90usize, 1..70usize, 0.02..3.0f64),
        z in -1.0..3.0f64,
    ) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../worlds/hall.toml");
        let mut world = World::load(path, 1).unwrap();
        let robot = world.add_robot("pioneer", RobotConfig::default()).unwrap();
        if world.place(robot, Pose2::new(x, y, heading)).is_err() { return Ok(()) }
        turn_head(&mut world, robot, pan, tilt);
        let camera = CameraConfig { width, height, field_of_view: view, place: [0.1, 0.0, z], ..CameraConfig::default() };
        let mut bytes = vec![1; camera.bytes()];
        world.picture(robot, &camera, &mut bytes).unwrap();
        let mut again = vec![2; camera.bytes()];
        world.picture(robot, &camera, &mut again).unwrap();
        prop_assert_eq!(bytes, again, "every byte is written, and the pictures are equal");
    }
}

#[test]
fn near_things_hide_far_ones_in_any_order() {
    for (near, far) in [("#ff0000", "#00ff00"), ("#00ff00", "#ff0000")] {
        let (world, robot) = world_with(&format!(
            "boxes = [{{ center = [4, 0], size = [0.5, 0.5], color = '{far}', height = 1 }},
                      {{ center = [2, 0], size = [0.5, 0.5], color = '{near}', height = 1 }}]"
        ));
        let middle = take_picture(&world, robot, &camera()).pixel(160, 120);
        assert_eq!(red(middle), near == "#ff0000", "{middle:?}");
        assert_eq!(green(middle), near == "#00ff00", "{middle:?}");
    }
    let (world, robot) = world_with(
        "walls = [{ points = [[3, -1], [3, 1]], color = '#00ff00', height = 1 }]
         balls = [{ center = [2, 0], radius = 0.3, color = '#ff0000' }, { center = [4, 0.0], radius = 0.45, color = '#ff0000' }]",
    );
    let picture = take_picture(&world, robot, &camera());
    assert!(
        red(picture.pixel(160, 130)) && green(picture.pixel(200, 120)),
        "the wall hides the ball behind it"
    );
}

#[test]
fn the_edges_of_a_box_are_at_the_expected_pixels() {
    let (world, robot) =
        world_with("boxes = [{ center = [2.5, 0], size = [1, 1], color = '#ff0000', height = 0.9 }]");
    let picture = take_picture(&world, robot, &camera());
    // The front is 2 m away: 0.5 m to each side and up are 40 pixels, and 0.4 m down are 32.
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
        assert_eq!(red(picture.pixel(column, row)), inside, "{column} {row}");
    }
}

#[test]
fn a_level_camera_shows_the_sky_above_the_horizon_and_the_floor_below() {
    let (world, robot) = world_with("");
    let picture = take_picture(&world, robot, &camera());
    let blue = |[r, g, b]: [u8; 3]| b > 100 && r == 0 && g == 0;
    assert!(blue(picture.pixel(160, 119)) && blue(picture.pixel(5, 3)));
    assert!(!blue(picture.pixel(160, 120)) && !blue(picture.pixel(5, 236)));
    assert!(
        picture.pixel(160, 100)[2] > picture.pixel(160, 0)[2],
        "the sky is darker above"
    );
}

#[test]
fn a_camera_shows_only_floor_when_tilted_down_and_only_sky_when_tilted_up() {
    let (mut world, robot) = world_with("");
    let camera = CameraConfig {
        field_of_view: 40f64.to_radians(),
        ..CameraConfig::default()
    };
    let sky = |picture: &Picture| picture.blob(|pixel| pixel[0] == 0).1;
    turn_head(&mut world, robot, 0.0, 30f64.to_radians());
    assert_eq!(sky(&take_picture(&world, robot, &camera)), 0);
    turn_head(&mut world, robot, 0.0, -30f64.to_radians());
    assert_eq!(sky(&take_picture(&world, robot, &camera)), 320 * 240);
}

#[test]
fn the_lines_of_the_floor_are_one_metre_apart() {
    let (world, robot) = world_with("");
    let picture = take_picture(&world, robot, &camera());
    // The line x = 1 is 0.4 m below the camera and 1 m ahead: 64 pixels below the middle.
    let (line, plain) = (picture.pixel(200, 184), picture.pixel(200, 200));
    assert!(plain[0] > line[0] + 10, "{line:?} {plain:?}");
}

#[test]
fn a_face_toward_the_light_is_brighter() {
    let (world, robot) = world_with(
        "light = { from_deg = 90, height_deg = 20 }
         boxes = [{ center = [3, 1.4], size = [1, 1], angle_deg = 45, color = '#ff0000', height = 2 }]",
    );
    let picture = take_picture(&world, robot, &camera());
    // The corner at (2.29, 1.4) is between the left face and the right one, which faces away from the light.
    let (left, right) = (picture.pixel(54, 110), picture.pixel(72, 110));
    assert!(
        red(left) && red(right) && left[0] > right[0] + 30,
        "{left:?} {right:?}"
    );
}

#[test]
fn a_camera_on_the_head_turns_with_it_and_one_on_the_body_does_not() {
    let (mut world, robot) = world_with("balls = [{ center = [0, 3], radius = 0.3, color = '#ff0000' }]");
    let (body, head) = (
        camera(),
        CameraConfig {
            place: [0.0; 3],
            mount: CameraMount::Head,
            ..camera()
        },
    );
    turn_head(&mut world, robot, 90f64.to_radians(), 0.0);
    assert!(take_picture(&world, robot, &head).blob(red).1 > 100);
    assert_eq!(take_picture(&world, robot, &body).blob(red).1, 0);
    let left = CameraConfig {
        yaw: 90f64.to_radians(),
        ..body
    };
    assert!(take_picture(&world, robot, &left).blob(red).1 > 100);
}

#[test]
fn two_cameras_side_by_side_have_the_disparity_of_a_stereo_pair() {
    let (world, robot) = world_with("balls = [{ center = [2.05, 0], radius = 0.1, color = '#ff0000' }]");
    let camera_at = |y: f64| CameraConfig {
        place: [0.0, y, 0.0],
        mount: CameraMount::Head,
        ..camera()
    };
    let [left, right] = [0.1, -0.1].map(|y| take_picture(&world, robot, &camera_at(y)).blob(red).0);
    // Baseline times focal length by depth: 0.2 m, 160 pixels, 2 m.
    assert!(
        (left[0] - right[0] - 16.0).abs() < 0.5 && (left[1] - right[1]).abs() < 0.1,
        "{left:?} {right:?}"
    );
}

#[test]
fn a_camera_shows_people_and_other_robots_but_not_its_own() {
    let mut world = World::parse(
        "people = [{ way = [[3, 1], [3, -1]], speed = 0.1, color = '#00ff00' }]
         robots = { r = { start = { x = 0, y = 0 } }, s = { start = { x = 2, y = -1 } } }",
        "cameras.toml",
        0,
    )
    .unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(take_picture(&world, robot, &camera()).blob(red).1, 0);
    world.add_robot("s", RobotConfig::default()).unwrap();
    let picture = take_picture(&world, robot, &camera());
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
fn a_person_who_raises_a_colour_shows_it_on_every_side_until_it_is_lowered() {
    for way in [
        "[[3, 0], [3, -1]]",
        "[[3, 0], [3, 1]]",
        "[[3, 0], [4, 0]]",
        "[[3, 0], [2, 0]]",
    ] {
        let people = format!("people = [{{ name = 'anna', way = {way}, speed = 0, signal = '#00ff00' }}]");
        let (mut world, robot) = world_with(&people);
        let mut count = |text: &str| {
            for edit in Edits::parse(text).unwrap().edits {
                world.edit(robot, &edit).unwrap();
            }
            take_picture(&world, robot, &camera()).blob(green).1
        };
        assert_eq!(count(""), 0);
        assert!(count("{ raise = 'anna' }") > 100, "{way}");
        assert_eq!(count("{ lower = 'anna' }"), 0);
    }
}

#[test]
fn all_people_of_a_name_raise_their_colour() {
    let anna = |way| format!("{{ name = 'anna', way = {way}, speed = 0, signal = '#00ff00' }}");
    let (behind, ahead) = (anna("[[-3, 0], [-4, 0]]"), anna("[[3, 0], [2, 0]]"));
    let (mut world, robot) = world_with(&format!("people = [{behind}, {ahead}]"));
    for edit in Edits::parse("{ raise = 'anna' }").unwrap().edits {
        world.edit(robot, &edit).unwrap();
    }
    assert!(take_picture(&world, robot, &camera()).blob(green).1 > 100);
}

#[test]
fn a_picture_shows_a_ball_at_its_new_position_after_a_push() {
    let (mut world, robot) =
        world_with("balls = [{ center = [0.6, 0.1], radius = 0.11, color = '#ff0000' }]");
    let (before, count) = take_picture(&world, robot, &camera()).blob(red);
    assert!(count > 1000 && before[0] < 150.0, "{before:?} {count}");
    world.command(robot, Twist2::new(0.6, 0.0)).unwrap();
    world.advance_to(3 * SECOND);
    assert_eq!(
        take_picture(&world, robot, &camera()).blob(red).1,
        0,
        "the ball rolls out of the picture"
    );
}

#[test]
fn invalid_values_of_a_camera_are_reported() {
    let (world, robot) = world_with("");
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
    for (invalid, part) in [
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
        let error = world.picture(robot, &invalid, &mut []).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

/// Everything that changes pictures changes the hash. Inspect a picture before you update the hash.
#[test]
fn a_picture_is_the_same_on_any_machine() {
    let (mut world, robot) = world_with(
        "walls = [{ points = [[4, -3], [4, 3]], color = 'beige' }]
         boxes = [{ center = [2.5, 0.9], size = [0.5, 0.5], angle_deg = 30 }]
         circles = [{ center = [3, -1], radius = 0.2 }]
         people = [{ way = [[3, 0.3], [3, -1.5]], speed = 0.5 }]
         balls = [{ center = [1.5, -0.3], radius = 0.11, color = 'orange' }]",
    );
    turn_head(&mut world, robot, 0.05, 0.1);
    let camera = CameraConfig {
        width: 64,
        height: 48,
        field_of_view: 1.2,
        ..CameraConfig::default()
    };
    let picture = take_picture(&world, robot, &camera);
    assert_eq!(picture.hash(), 0x21f5_c11e_8077_cf2f, "{:#x}", picture.hash());
}
