//! The schema on painted pictures: the areas that it finds, where they are, and how its panel calibrates.

use core::f64::consts::FRAC_PI_2;
use core::time::Duration;
use std::panic::resume_unwind;
use std::thread;

use jde_schema::bench::Bench;
use jde_schema::panel::Touch;
use jde_schema::prelude::*;
use jde_schema::types::{ColorBlob, ColorBlobs};

use crate::{Approach, Color, Colors};

const GREY: [u8; 3] = [120, 122, 118];
const ORANGE: [u8; 3] = [240, 124, 24];
const BLUE: [u8; 3] = [20, 40, 220];

/// A rectangle to paint: left, top, width and height in px, and a colour.
type Rectangle = ([usize; 4], [u8; 3]);

/// A picture of 160 x 120 pixels.
fn paint(rectangles: &[Rectangle]) -> Box<Image> {
    let mut image = Box::new(Image::default());
    (image.width, image.height, image.step) = (160, 120, 480);
    image.encoding = Text::new("rgb8");
    let data = image.data.resize(480 * 120);
    data.chunks_mut(3).for_each(|pixel| pixel.copy_from_slice(&GREY));
    for ([left, top, width, height], color) in rectangles {
        for row in *top..top + height {
            for pixel in data[480 * row + 3 * left..][..3 * width].chunks_mut(3) {
                pixel.copy_from_slice(color);
            }
        }
    }
    image
}

/// A schema without a pan-tilt head, whose camera is 0.5 m above the floor and has a focal length of 80 px.
fn see() -> Bench<Color> {
    let mut bench = Bench::new();
    bench.set("field_of_view", FRAC_PI_2);
    bench.set("height", 0.5);
    bench.unbind("pan_tilt");
    bench.unbind("camera_info");
    bench
}

fn show(bench: &mut Bench<Color>, rectangles: &[Rectangle]) -> ColorBlobs {
    bench.import("image", &*paint(rectangles));
    bench.iterate().expect("the iteration succeeds");
    bench.exported("blobs").expect("the areas are exported")
}

/// Runs a test on a thread with a stack large enough for pictures of nearly a megabyte each.
fn with_large_stack(test: impl FnOnce() + Send + 'static) {
    let thread = thread::Builder::new().stack_size(64 << 20).spawn(test);
    if let Err(panic) = thread.expect("the thread starts").join() {
        resume_unwind(panic);
    }
}

#[test]
fn areas_are_found_the_largest_first_with_their_places() {
    with_large_stack(|| {
        let seen = show(
            &mut see(),
            &[
                ([70, 80, 20, 20], ORANGE),
                ([10, 10, 30, 20], ORANGE),
                ([0, 119, 1, 1], ORANGE),
            ],
        );
        assert_eq!((seen.blobs.len(), seen.left_out), (2, 0), "one pixel is noise");
        let [above, below] = [seen.blobs[0], seen.blobs[1]];
        assert_eq!(
            (above.count, above.left, above.top, above.width, above.height),
            (600, 10, 10, 30, 20)
        );
        assert!(!above.on_floor.get(), "it is above the horizon");
        assert!(above.bearing > 0.0 && above.elevation > 0.0);
        assert_eq!(below.count, 400);
        // Its lowest row is 40 px below the middle, so it meets the floor at 80 / 40 times the height.
        assert!(below.on_floor.get());
        assert!((below.x - 1.0).abs() < 0.01 && below.y.abs() < 0.01, "{below:?}");
    });
}

#[test]
fn an_area_that_continues_below_the_picture_has_no_place() {
    with_large_stack(|| {
        let inside = show(&mut see(), &[([70, 80, 20, 39], ORANGE)]);
        assert!(inside.blobs[0].on_floor.get());
        let cut = show(&mut see(), &[([70, 80, 20, 40], ORANGE)]);
        assert!(
            !cut.blobs[0].on_floor.get(),
            "it is nearer than the lowest row shows"
        );
    });
}

#[test]
fn a_head_that_turns_turns_the_places_with_it() {
    with_large_stack(|| {
        let mut bench = Bench::<Color>::new();
        bench.unbind("camera_info");
        bench.set("field_of_view", FRAC_PI_2);
        bench.set("height", 0.5);
        let picture = [([70, 50, 20, 10], ORANGE)];
        bench.import("image", &*paint(&picture));
        bench.iterate().expect("the iteration succeeds");
        let none: Option<ColorBlobs> = bench.exported("blobs");
        assert_eq!(none, None, "the direction of the head is unknown");
        let head = PanTilt {
            pan: FRAC_PI_2,
            tilt: FRAC_PI_2 / 2.0,
            ..PanTilt::default()
        };
        bench.import("pan_tilt", &head);
        let blob = show(&mut bench, &picture).blobs[0];
        assert!((blob.bearing - FRAC_PI_2).abs() < 0.01, "{blob:?}");
        assert!(blob.x.abs() < 0.01 && (blob.y - 0.5).abs() < 0.01, "{blob:?}");
    });
}

#[test]
fn of_many_areas_the_smallest_are_left_out() {
    with_large_stack(|| {
        let mut bench = see();
        bench.set("pixels", 1_u32);
        let dots: Vec<Rectangle> = (0..40).map(|n| ([3 * n, 3, 1 + n / 39, 2], ORANGE)).collect();
        let seen = show(&mut bench, &dots);
        assert_eq!((seen.blobs.len(), seen.left_out), (32, 8));
        assert_eq!(seen.blobs[0].count, 4, "the last is the largest");
        assert!(seen.blobs.iter().all(|blob| blob.count > 0 && blob.column > 0.0));
    });
}

#[test]
fn pictures_that_end_retract_the_areas_and_others_are_refused() {
    with_large_stack(|| {
        let mut bench = see();
        show(&mut bench, &[]);
        bench.retract("image");
        bench.set_now(Duration::from_secs(1));
        bench.iterate().expect("the iteration succeeds");
        let seen: Option<ColorBlobs> = bench.exported("blobs");
        assert_eq!(seen, None);

        let mut grey = paint(&[]);
        grey.encoding = Text::new("mono8");
        bench.import("image", &*grey);
        let error = bench.iterate().expect_err("it is not in colour");
        assert!(error.to_string().contains("import `image`"), "{error}");
    });
}

fn click(bench: &mut Bench<Color>, at: [f64; 2]) {
    let touch = Touch::Clicked {
        at: [at[0], at[1], 0.0],
        button: jde_schema::panel::Button::Primary,
    };
    bench.touch("picture", touch).expect("the gesture is handled");
}

#[test]
fn a_click_sets_the_range_of_the_chosen_colour_and_the_panel_shows_the_line() {
    with_large_stack(|| {
        let mut bench = see();
        let picture = [([10, 10, 30, 20], BLUE), ([70, 80, 20, 20], ORANGE)];
        assert_eq!(show(&mut bench, &picture).blobs.len(), 1);
        click(&mut bench, [20.0, 15.0]);
        let seen = show(&mut bench, &picture);
        assert_eq!(
            (seen.blobs.len(), seen.blobs[0].left),
            (1, 10),
            "blue instead of orange"
        );
        let panel = bench.draw().expect("it draws");
        assert!(format!("{panel:?}").contains("colors = { ranges = ["));

        bench.touch("extend", Touch::Toggled(true)).unwrap();
        click(&mut bench, [80.0, 90.0]);
        assert_eq!(show(&mut bench, &picture).blobs.len(), 2, "both colours");
        click(&mut bench, [1e9, -1e9]);
        click(&mut bench, [0.0, 119.0]);
        assert_eq!(
            show(&mut bench, &picture).blobs.len(),
            2,
            "neither the place outside nor grey counts"
        );
        bench.touch("reset", Touch::Pressed).unwrap();
        assert_eq!(show(&mut bench, &picture).blobs[0].left, 70, "orange again");
    });
}

/// An area of a colour at a place on the floor.
fn standing(color: u32, x: f64, y: f64) -> ColorBlob {
    ColorBlob {
        color,
        x,
        y,
        on_floor: Flag::TRUE,
        ..ColorBlob::default()
    }
}

fn blobs(blobs: &[ColorBlob]) -> ColorBlobs {
    ColorBlobs {
        blobs: blobs.iter().copied().collect(),
        ..ColorBlobs::default()
    }
}

#[test]
fn approach_drives_to_the_nearest_of_its_colour_and_stops_at_its_distance() {
    let mut bench = Bench::<Approach>::new();
    assert!(!bench.check().unwrap().ready, "nothing is seen");
    let floating = ColorBlob {
        on_floor: Flag::FALSE,
        ..standing(0, 0.1, 0.0)
    };
    bench.import("blobs", &blobs(&[standing(1, 1.0, 0.0), floating]));
    assert!(
        !bench.check().unwrap().ready,
        "another colour, and one in the air"
    );
    bench.import("blobs", &blobs(&[standing(0, 3.0, 0.0), standing(0, 1.0, 1.0)]));
    assert!(bench.check().unwrap().ready);
    bench.iterate().unwrap();
    let twist: Twist = bench.commanded("base").expect("it commands");
    assert!(twist.linear.x > 0.0 && twist.linear.x <= 0.3, "{twist:?}");
    assert_eq!(twist.angular.z, 0.6, "toward the left, at the limit");
    let at = |bench: &mut Bench<Approach>, distance| {
        bench.import("blobs", &blobs(&[standing(0, distance, 0.0)]));
        bench.check().unwrap().ready
    };
    assert_eq!(
        [0.79, 0.81, 0.75, 0.69, 0.75].map(|distance| at(&mut bench, distance)),
        [true, true, true, false, false],
        "with hysteresis"
    );
    assert!(at(&mut bench, 2.0));
    bench.set_now(Duration::from_millis(600));
    assert!(!bench.check().unwrap().ready, "the picture is too old");
}

#[test]
fn the_line_for_the_application_states_every_limit() {
    assert_eq!(
        Colors::orange().to_string(),
        r#"colors = { ranges = [["orange", "14 deg", "36 deg", 0.75, 1.00, 0.25, 1.00]] }"#
    );
}
