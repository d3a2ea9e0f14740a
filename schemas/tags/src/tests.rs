//! The schema on drawn pictures: what it finds, where that is, and what it refuses.

use core::f64::consts::FRAC_PI_2;
use core::time::Duration;
use std::panic::resume_unwind;
use std::thread;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::TagDetections;
use jde_tags::Family;

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
