//! Tests of colours, components, directions and places.

use core::f32::consts::TAU;
use std::thread;

use jde_types::{Image, Point, Pose, Text};
use proptest::prelude::*;

use crate::{Blobs, CameraModel, CameraMount, ColorRange, Hsv, Observation, Pixels};

#[track_caller]
fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} is not {expected} +- {tolerance}"
    );
}

fn limits(from_deg: f32, to_deg: f32) -> ColorRange {
    ColorRange {
        hue: [from_deg.to_radians(), to_deg.to_radians()],
        saturation: 0.5..=1.0,
        value: 0.25..=1.0,
    }
}

#[test]
fn a_colour_is_within_limits_of_hue_saturation_and_value() {
    let orange = limits(14.0, 36.0);
    assert!(orange.contains([240, 124, 24]));
    assert!(
        orange.contains([120, 62, 12]),
        "half the brightness has the same hue"
    );
    assert!(!orange.contains([60, 31, 6]), "too dark");
    assert!(!orange.contains([240, 190, 150]), "too pale");
    assert!(!orange.contains([242, 201, 32]), "yellow");
    assert!(!orange.contains([204, 41, 36]), "red");
}

#[test]
fn each_pure_colour_has_its_hue() {
    let colours = [
        ([255, 0, 0], 0.0),
        ([255, 255, 0], 60.0),
        ([0, 255, 0], 120.0),
        ([0, 255, 255], 180.0),
        ([0, 0, 255], 240.0),
        ([255, 0, 255], 300.0),
    ];
    for (color, hue) in colours {
        for (other, _) in colours {
            let range = limits(hue - 5.0, hue + 5.0);
            assert_eq!(range.contains(other), other == color, "{other:?} at {hue}");
        }
    }
}

#[test]
fn a_range_of_hues_can_contain_red() {
    let red = limits(350.0, 10.0);
    assert!(red.contains([204, 10, 36]) && red.contains([204, 36, 10]));
    assert!(!red.contains([10, 204, 36]) && !red.contains([204, 204, 10]));
}

#[test]
fn without_limits_all_colours_are_selected_and_grey_needs_no_hue() {
    let all = ColorRange {
        hue: [0.0, TAU],
        saturation: 0.0..=1.0,
        value: 0.0..=1.0,
    };
    for color in [[0, 0, 0], [255, 255, 255], [10, 200, 30], [200, 10, 12]] {
        assert!(all.contains(color), "{color:?}");
    }
    let white = ColorRange {
        saturation: 0.0..=0.1,
        value: 0.8..=1.0,
        ..limits(0.0, 1.0)
    };
    assert!(white.contains([250, 250, 250]));
    assert!(!white.contains([250, 150, 150]));
}

/// Number of pixels of the largest component in a drawing that is round enough.
fn largest(drawing: &[&str], roundness: f64) -> Option<usize> {
    let size = [drawing[0].len(), drawing.len()];
    let selected = |row: usize, column: usize| drawing[row].as_bytes()[column] == b'#';
    let mut blobs = Blobs::default();
    let (component, runs) = blobs.largest(size, selected, |component| component.roundness() >= roundness)?;
    let sum: usize = runs.map(|run| run.columns[1] - run.columns[0]).sum();
    assert_eq!(sum, component.count, "the runs contain all pixels");
    Some(component.count)
}

#[test]
fn pixels_that_touch_at_a_side_or_corner_are_one_component() {
    assert_eq!(largest(&["##..", "..##", "...."], 0.0), Some(4));
    assert_eq!(largest(&["..##", "##..", "...."], 0.0), Some(4));
    assert_eq!(largest(&["##.##", "....."], 0.0), Some(2));
    assert_eq!(largest(&["##.", "...", "###"], 0.0), Some(3));
    assert_eq!(largest(&["...", "..."], 0.0), None);
}

#[test]
fn branches_that_join_in_a_later_row_are_one_component() {
    let comb = ["#.#.#.#", "#.#.#.#", "#######", "......."];
    assert_eq!(largest(&comb, 0.0), Some(15));
    let spiral = ["#####", "....#", "###.#", "#...#", "#####"];
    assert_eq!(largest(&spiral, 0.0), Some(17));
}

/// Number of pixels of the largest component, found by visiting neighbours one by one.
fn largest_by_search(selected: &[bool], width: usize) -> usize {
    let height = selected.len() / width;
    let mut unvisited = selected.to_vec();
    let mut largest = 0;
    for start in 0..unvisited.len() {
        let (mut count, mut next) = (0, vec![start]);
        while let Some(pixel) = next.pop() {
            if !core::mem::take(&mut unvisited[pixel]) {
                continue;
            }
            count += 1;
            let (row, column) = (pixel / width, pixel % width);
            for row in row.saturating_sub(1)..=(row + 1).min(height - 1) {
                let columns = column.saturating_sub(1)..=(column + 1).min(width - 1);
                next.extend(columns.map(|column| row * width + column));
            }
        }
        largest = largest.max(count);
    }
    largest
}

#[test]
fn components_in_noise_equal_those_of_a_search_by_neighbours() {
    let mut random = 88_172_645_463_325_252_u64;
    let mut blobs = Blobs::default();
    for percent in (5..100).step_by(5) {
        for (width, height) in [(1, 40), (40, 1), (37, 23), (64, 48)] {
            let selected: Vec<bool> = (0..width * height)
                .map(|_| {
                    random ^= random << 13;
                    random ^= random >> 7;
                    random ^= random << 17;
                    random % 100 < percent
                })
                .collect();
            let found = blobs.largest(
                [width, height],
                |row, column| selected[row * width + column],
                |_| true,
            );
            let found = found.map(|(component, runs)| {
                let pixels: usize = runs.map(|run| run.columns[1] - run.columns[0]).sum();
                assert_eq!(pixels, component.count, "the runs contain all pixels");
                pixels
            });
            assert_eq!(
                found.unwrap_or(0),
                largest_by_search(&selected, width),
                "{percent} % of {width} x {height}"
            );
        }
    }
}

#[test]
fn the_last_column_does_not_touch_the_next_row() {
    assert_eq!(largest(&["...#", "#...", "...."], 0.0), Some(1));
}

#[test]
fn elongated_or_hollow_components_are_not_round() {
    let square = ["....", ".##.", ".##.", "...."];
    assert_eq!(largest(&square, 0.9), Some(4));
    assert_eq!(largest(&["########", "........"], 0.4), None);
    let ring = ["######", "#....#", "#....#", "#....#", "#....#", "######"];
    assert_eq!(largest(&ring, 0.8), None);
    assert_eq!(
        largest(&["########", "........", "##......", "##......"], 0.9),
        Some(4),
        "the round component, though the other is larger"
    );
}

#[test]
fn left_and_up_are_positive_and_the_angles_of_the_head_are_added() {
    let angles = |direction: [f64; 3], pan: f64, tilt: f64| {
        let observation = Observation {
            direction,
            solid_angle: 1.0,
        };
        observation.angles(pan, tilt)
    };
    let check = |[bearing, elevation]: [f64; 2], expected: [f64; 2]| {
        assert_near(bearing, expected[0], 1e-9);
        assert_near(elevation, expected[1], 1e-9);
    };
    check(angles([0.0, 0.0, 1.0], 0.0, 0.0), [0.0, 0.0]);
    check(angles([-1.0, 0.0, 1.0], 0.0, 0.0), [45_f64.to_radians(), 0.0]);
    check(angles([0.0, 1.0, 1.0], 0.0, 0.0), [0.0, -45_f64.to_radians()]);
    check(angles([0.0, 0.0, 1.0], 0.7, 0.3), [0.7, -0.3]);
    check(angles([0.0, 1.0, 1.0], -0.7, -45_f64.to_radians()), [-0.7, 0.0]);
    // When the camera looks down, an object to the side has a greater bearing than its column suggests.
    let [bearing, _] = angles([-1.0, 0.0, 1.0], 0.0, 60_f64.to_radians());
    assert_near(bearing, 2_f64.atan(), 1e-9);
}

#[test]
fn a_pixel_has_hue_saturation_and_value() {
    let color = Hsv::of([0, 128, 0]);
    assert!((color.hue.unwrap() - TAU / 3.0).abs() < 1e-6);
    assert_eq!((color.saturation, color.value), (1.0, 128.0 / 255.0));
    assert_eq!(Hsv::of([9, 9, 9]).hue, None);
    assert_eq!(ColorRange::around(&[[9, 9, 9]]), None);
    assert_eq!(ColorRange::around(&[]), None);
}

/// A small image in an encoding, with this many bytes.
fn image(encoding: &str, [width, height, step]: [u32; 3], bytes: usize) -> Box<Image> {
    let mut image = Box::new(Image::default());
    (image.width, image.height, image.step) = (width, height, step);
    image.encoding = Text::new(encoding);
    image.data.resize(bytes);
    image
}

/// Runs a test on a thread with a stack large enough for images of nearly a megabyte each.
fn with_large_stack(test: fn()) {
    let thread = thread::Builder::new().stack_size(64 << 20).spawn(test);
    thread
        .expect("the thread starts")
        .join()
        .expect("the test passes");
}

#[test]
fn pixels_are_read_in_both_orders_and_past_padded_rows() {
    with_large_stack(|| {
        for (encoding, expected) in [("rgb8", [1, 2, 3]), ("bgr8", [3, 2, 1])] {
            let mut image = image(encoding, [2, 2, 8], 16);
            image.data.as_mut_slice()[11..14].copy_from_slice(&[1, 2, 3]);
            let pixels = Pixels::of(&image).unwrap();
            assert_eq!(pixels.size(), [2, 2]);
            assert_eq!(pixels.at(1, 1), expected);
        }
    });
}

#[test]
fn an_image_that_is_shorter_than_it_states_or_has_another_encoding_is_refused() {
    with_large_stack(|| {
        for (encoding, size, bytes, part) in [
            ("mono8", [2, 2, 2], 4, "\"mono8\""),
            ("rgb8", [2, 2, 6], 11, "11 bytes"),
            ("rgb8", [2, 2, 5], 12, "rows of 5 bytes"),
            ("rgb8", [1, u32::MAX, u32::MAX], 12, "4294967295 pixels"),
        ] {
            let error = Pixels::of(&image(encoding, size, bytes)).expect_err("it is refused");
            assert!(error.to_string().contains(part), "{error}");
        }
        assert_eq!(Pixels::of(&image("rgb8", [0, 0, 0], 0)).unwrap().size(), [0, 0]);
    });
}

#[test]
fn a_camera_that_looks_down_sees_the_floor_where_the_ray_meets_it() {
    let camera = CameraModel::new([200, 100], 90_f64.to_radians());
    let mount = |pan: f64, tilt: f64| CameraMount {
        position: [0.1, 0.0, 0.5],
        pan: pan.to_radians(),
        tilt: tilt.to_radians(),
    };
    let middle = camera.ray([100.0, 50.0]).unwrap();
    let check = |found: Option<[f64; 2]>, [x, y]: [f64; 2]| {
        let found = found.expect("the ray meets the floor");
        assert_near(found[0], x, 1e-9);
        assert_near(found[1], y, 1e-9);
    };
    check(mount(0.0, 45.0).floor(middle), [0.6, 0.0]);
    check(mount(90.0, 45.0).floor(middle), [0.1, 0.5]);
    // One step to the right of the picture is to the right of the robot.
    check(
        mount(0.0, 90.0).floor(camera.ray([200.0, 50.0]).unwrap()),
        [0.1, -0.5],
    );
    assert_eq!(mount(0.0, 0.0).floor(middle), None, "the horizon");
    assert_eq!(mount(0.0, -10.0).floor(middle), None, "the sky");
    let sunk = CameraMount {
        position: [0.0, 0.0, -0.1],
        ..mount(0.0, 45.0)
    };
    assert_eq!(sunk.floor(middle), None);
    assert_eq!(camera.pixel([0.0, 0.0, -1.0]), None, "behind the camera");
    assert_eq!(camera.pixel([0.0; 3]), None, "no direction");
}

proptest! {
    #[test]
    fn a_range_around_samples_contains_them(
        pixels in prop::collection::vec((0u8..40, 200u8.., 0u8..90), 1..9).prop_map(|pixels| {
            pixels.into_iter().map(|(a, b, c)| [b, a, c]).collect::<Vec<_>>()
        }),
    ) {
        let range = ColorRange::around(&pixels).unwrap();
        for pixel in pixels {
            prop_assert!(range.contains(pixel), "{pixel:?} is not in {range:?}");
        }
        prop_assert!(!range.contains([0, 255, 0]), "green is far from red");
    }

    #[test]
    fn every_pixel_below_the_horizon_is_found_again_from_its_point_on_the_floor(
        place in [0.0..320.0, 0.0..240.0],
        view in 0.3..2.5,
        position in [-1.0..1.0, -1.0..1.0, 0.05..2.0],
        (pan, tilt) in (-3.0..3.0, -1.5..1.5),
    ) {
        let camera = CameraModel::new([320, 240], view);
        let mount = CameraMount { position, pan, tilt };
        let ray = camera.ray(place).unwrap();
        let (back, length) = (mount.to_camera(mount.to_base(ray)), |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]));
        for (axis, expected) in back.into_iter().zip(ray) {
            prop_assert!((axis - expected).abs() < 1e-9);
        }
        prop_assert!((length(mount.to_base(ray)) - length(ray)).abs() < 1e-9);
        if let Some([x, y]) = mount.floor(ray).filter(|point| point.iter().all(|axis| axis.abs() < 1e3)) {
            let found = camera.pixel(mount.direction_of([x, y, 0.0])).expect("it is in front");
            prop_assert!((found[0] - place[0]).hypot(found[1] - place[1]) < 1e-3, "{found:?}");
        }
    }
}

#[test]
fn a_tag_on_a_wall_faces_the_robot_before_it() {
    let mount = CameraMount {
        position: [0.1, 0.0, 0.5],
        pan: core::f64::consts::FRAC_PI_2,
        tilt: 0.0,
    };
    // Two metres to the left of the camera, read straight ahead.
    let pose = Pose {
        position: Point {
            x: 0.0,
            y: -0.3,
            z: 2.0,
        },
        ..Pose::default()
    };
    let facing = mount.facing(&pose);
    assert_near(facing.x, 0.1, 1e-9);
    assert_near(facing.y, 2.0, 1e-9);
    assert_near(facing.theta, -core::f64::consts::FRAC_PI_2, 1e-9);
}
