//! The schema on drawn pictures: what it finds, where that is, and what it refuses.

use core::f64::consts::FRAC_PI_2;
use core::time::Duration;
use std::panic::resume_unwind;
use std::thread;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{CameraInfo, TagDetections};
use jde_tags::Family;
use jde_vision::CameraModel;

use crate::Tags;

/// Pixels of a cell.
const CELL: usize = 6;
/// Columns and rows of a picture.
const SIZE: [usize; 2] = [160, 120];

/// A picture in which some tags of the family are drawn, each with its left and upper edge in px.
fn draw(encoding: &str, tags: &[(u32, [usize; 2])]) -> Box<Image> {
    let mut image = Box::new(Image::default());
    let channels = if encoding == "mono8" { 1 } else { 3 };
    let step = channels * SIZE[0];
    (image.width, image.height, image.step) = (SIZE[0] as u32, SIZE[1] as u32, step as u32);
    image.encoding = Text::new(encoding);
    image.header = Header::new(Duration::from_millis(20), "camera");
    let data = image.data.resize(step * SIZE[1]);
    data.fill(180);
    for (id, [left, top]) in tags {
        let cells = Family::Tag16h5.cells(*id).expect("the tag exists");
        for (number, white) in cells.into_iter().enumerate() {
            let [column, row] = [left + CELL * (number % 8), top + CELL * (number / 8)];
            for line in row..row + CELL {
                let pixels = &mut data[line * step + channels * column..][..channels * CELL];
                pixels.fill(if white { 250 } else { 10 });
            }
        }
    }
    image
}

/// A schema whose camera has a focal length of 80 px, for tags of 16 cm.
fn tags() -> Bench<Tags> {
    let mut bench = calibrated();
    bench.unbind("camera_info");
    bench
}

/// The same, whose camera states its calibration.
fn calibrated() -> Bench<Tags> {
    let mut bench = Bench::new();
    bench.set("field_of_view", FRAC_PI_2);
    bench.set("family", crate::Family::Tag16h5);
    bench
}

fn show(bench: &mut Bench<Tags>, image: &Image) -> TagDetections {
    bench.import("image", image);
    bench.iterate().expect("the iteration succeeds");
    bench.exported("tags").expect("the tags are exported")
}

/// Runs a test on a thread with a stack large enough for pictures of nearly a megabyte each.
fn with_large_stack(test: impl FnOnce() + Send + 'static) {
    let thread = thread::Builder::new().stack_size(64 << 20).spawn(test);
    if let Err(panic) = thread.expect("the thread starts").join() {
        resume_unwind(panic);
    }
}

#[test]
fn a_tag_is_found_with_its_pose_in_every_encoding() {
    with_large_stack(|| {
        // A border of 36 px is 16 cm wide at 80 / 36 of that distance.
        let distance = 0.16 * 80.0 / 36.0;
        for encoding in ["rgb8", "bgr8", "mono8"] {
            let seen = show(&mut tags(), &draw(encoding, &[(7, [56, 36])]));
            assert_eq!((seen.tags.len(), seen.left_out), (1, 0), "{encoding}");
            assert_eq!(seen.header, Header::new(Duration::from_millis(20), "camera"));
            let tag = seen.tags[0];
            assert_eq!((tag.family.as_str(), tag.id, tag.hamming), ("tag16h5", 7, 0));
            let expected = [62.0, 78.0, 98.0, 78.0, 98.0, 42.0, 62.0, 42.0];
            let pairs = tag.corners.iter().zip(expected);
            assert!(
                pairs.clone().all(|(found, is)| (found - is).abs() < 0.3),
                "{:?}",
                tag.corners
            );
            let position = tag.pose.position;
            assert!((position.z - distance).abs() < 0.01, "{position:?}");
            assert!(position.x.abs() < 0.01 && position.y.abs() < 0.01, "{position:?}");
            assert!(tag.pose.orientation.w > 0.95, "{:?}", tag.pose.orientation);
        }
    });
}

#[test]
fn tags_come_by_number_and_faint_ones_not_at_all() {
    with_large_stack(|| {
        let picture = draw("mono8", &[(9, [8, 8]), (3, [90, 40])]);
        let mut bench = tags();
        let ids = |seen: &TagDetections| seen.tags.iter().map(|tag| tag.id).collect::<Vec<_>>();
        assert_eq!(ids(&show(&mut bench, &picture)), [3, 9]);
        bench.set("margin", 400.0);
        assert_eq!(ids(&show(&mut bench, &picture)), [0_u32; 0]);
        bench.set("margin", 20.0);
        bench.set("family", crate::Family::Tag36h11);
        assert_eq!(ids(&show(&mut bench, &picture)), [0_u32; 0], "another family");
    });
}

#[test]
fn a_sleep_and_pictures_that_end_retract_the_tags_and_others_are_refused() {
    with_large_stack(|| {
        let mut bench = tags();
        show(&mut bench, &draw("rgb8", &[(1, [40, 40])]));
        bench.sleep().expect("it sleeps");
        let seen: Option<TagDetections> = bench.exported("tags");
        assert_eq!(seen, None);
        bench.awake().expect("it awakes");
        show(&mut bench, &draw("rgb8", &[(1, [40, 40])]));
        bench.retract("image");
        bench.iterate().expect("the iteration succeeds");
        let seen: Option<TagDetections> = bench.exported("tags");
        assert_eq!(seen, None);

        let mut bayer = draw("mono8", &[]);
        bayer.encoding = Text::new("bayer_rggb8");
        bench.import("image", &*bayer);
        assert!(
            bench
                .iterate()
                .expect_err("it has no colours")
                .to_string()
                .contains("bayer_rggb8")
        );
    });
}

#[test]
fn the_panel_shows_the_picture_and_the_tags() {
    with_large_stack(|| {
        let mut bench = tags();
        let panel = |bench: &mut Bench<Tags>| format!("{:?}", bench.draw().expect("it draws"));
        assert!(panel(&mut bench).contains("No picture"));
        show(&mut bench, &draw("rgb8", &[(7, [56, 36])]));
        let shown = panel(&mut bench);
        assert!(shown.contains("\"7\"") && shown.contains("\"0.36\""), "{shown}");
    });
}

/// The calibration of a wide lens for pictures of [`SIZE`].
fn wide_lens() -> CameraInfo {
    let mut d = Seq::new();
    d.extend_from_slice(&[-0.28, 0.06, 0.001, -0.001, 0.0])
        .expect("they fit");
    CameraInfo {
        d,
        ..CameraInfo::pinhole(SIZE.map(|pixels| pixels as u32), 67_f64.to_radians())
    }
}

/// A picture through that lens of tag 7 of 16 cm, which faces the camera with its middle at `place`, m.
fn draw_through_lens(info: &CameraInfo, [x, y, z]: [f64; 3]) -> Box<Image> {
    let camera = CameraModel::calibrated(info, SIZE, false).expect("the calibration is right");
    let cells = Family::Tag16h5.cells(7).expect("the tag exists");
    let mut image = draw("mono8", &[]);
    let pixels = image.data.resize(SIZE[0] * SIZE[1]);
    for (number, pixel) in pixels.iter_mut().enumerate() {
        let mut sum = 0;
        for part in 0..16 {
            let place = [number % SIZE[0] * 4 + part % 4, number / SIZE[0] * 4 + part / 4];
            let ray = camera
                .ray(place.map(|quarter| (quarter as f64 + 0.5) / 4.0))
                .expect("the lens shows it");
            let [column, row] = [z * ray[0] - x, z * ray[1] - y].map(|away| 4.0 + away * 6.0 / 0.16);
            let inside = (0.0..8.0).contains(&column) && (0.0..8.0).contains(&row);
            sum += match inside.then(|| cells[row as usize * 8 + column as usize]) {
                Some(true) => 250,
                Some(false) => 10,
                None => 180,
            };
        }
        *pixel = (sum / 16) as u8;
    }
    image
}

#[test]
fn a_calibrated_lens_gives_the_place_and_a_field_of_view_alone_does_not() {
    with_large_stack(|| {
        let place = [0.2, -0.13, 0.55];
        let info = wide_lens();
        let picture = draw_through_lens(&info, place);
        let error = |bench: &mut Bench<Tags>| {
            let position = show(bench, &picture).tags[0].pose.position;
            [
                position.x - place[0],
                position.y - place[1],
                position.z - place[2],
            ]
            .map(f64::abs)
            .into_iter()
            .fold(0.0, f64::max)
        };
        let mut bench = tags();
        bench.set("field_of_view", 67_f64.to_radians());
        let pinhole = error(&mut bench);
        assert!(pinhole > 0.02, "{pinhole}");
        let mut bench = calibrated();
        bench.import("camera_info", &info);
        let calibrated = error(&mut bench);
        assert!(calibrated < 0.005, "{calibrated}");
    });
}

#[test]
fn a_camera_whose_calibration_is_unknown_or_of_others_shows_no_tags() {
    with_large_stack(|| {
        let picture = draw("mono8", &[(7, [56, 36])]);
        let mut bench = calibrated();
        bench.import("camera_info", &CameraInfo::pinhole([160, 120], FRAC_PI_2));
        assert_eq!(show(&mut bench, &picture).tags.len(), 1);
        bench.retract("camera_info");
        bench.iterate().expect("it waits");
        let seen: Option<TagDetections> = bench.exported("tags");
        assert_eq!(seen, None);
        bench.import("camera_info", &CameraInfo::pinhole([320, 240], FRAC_PI_2));
        let error = bench
            .iterate()
            .expect_err("the pictures are of another size")
            .to_string();
        assert!(error.contains("these have 160 x 120"), "{error}");
    });
}
