//! The finder on painted pictures: the position of the ball, the objects that it rejects, and when it
//! retracts its export.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::Finder;
use crate::ball::Ball;
use crate::tests::{FIELD_OF_VIEW, GREY, ORANGE, PaintedBall, assert_near, paint, seconds, with_large_stack};

const SIZE: [usize; 2] = [320, 240];

/// A finder without a pan-tilt head.
fn finder() -> Bench<Finder> {
    let mut bench = Bench::new();
    bench.set("field_of_view", FIELD_OF_VIEW);
    bench.set("radius", 0.1);
    bench.unbind("pan_tilt");
    bench.unbind("camera_info");
    bench
}

fn show(bench: &mut Bench<Finder>, balls: &[PaintedBall]) -> Ball {
    bench.import("image", &*paint(SIZE, balls));
    bench.iterate().expect("the iteration succeeds");
    bench.exported("ball").expect("the ball is exported")
}

#[test]
fn bearing_elevation_and_distance_are_correct_in_the_whole_image() {
    with_large_stack(|| {
        for distance in [0.7, 1.0, 2.5] {
            for x in [-0.6, -0.3, 0.0, 0.4, 0.6] {
                for y in [-0.4, 0.0, 0.35] {
                    let length = f64::hypot(1.0, f64::hypot(x, y));
                    let middle = [x, y, 1.0].map(|axis| axis * distance / length);
                    let ball = show(&mut finder(), &[(middle, 0.1, ORANGE)]);
                    assert!(ball.seen.get());
                    assert_near(ball.bearing, (-x).atan(), 0.005);
                    assert_near(ball.elevation, -(y / 1_f64.hypot(x)).atan(), 0.005);
                    assert_near(ball.distance, distance, 0.03 * distance);
                    assert_near(ball.column, 160.0 + 160.0 * x, 0.7);
                    assert_near(ball.row, 120.0 + 160.0 * y, 0.7);
                }
            }
        }
    });
}

#[test]
fn distance_is_proportional_to_the_radius() {
    with_large_stack(|| {
        let mut bench = finder();
        let balls = [([0.0, 0.2, 1.0], 0.1, ORANGE)];
        let distance = show(&mut bench, &balls).distance;
        bench.set("radius", 0.2);
        assert_near(show(&mut bench, &balls).distance, 2.0 * distance, 1e-9);
    });
}

#[test]
fn angles_are_converted_to_the_frame_of_the_base() {
    with_large_stack(|| {
        let mut bench = Bench::<Finder>::new();
        bench.unbind("camera_info");
        bench.set("field_of_view", FIELD_OF_VIEW);
        let head = PanTilt {
            pan: -0.8,
            tilt: 0.3,
            ..PanTilt::default()
        };
        bench.import("pan_tilt", &head);
        let ball = show(&mut bench, &[([0.0, 0.0, 1.0], 0.1, ORANGE)]);
        assert_near(ball.bearing, -0.8, 0.003);
        assert_near(ball.elevation, -0.3, 0.003);
        assert_eq!(ball.header.frame_id.as_str(), "base_link");
        // Without the position of the head, that of the ball is unknown.
        bench.retract("pan_tilt");
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(bench.exported::<Ball>("ball"), None);
    });
}

#[test]
fn the_largest_ball_of_the_colour_is_selected() {
    with_large_stack(|| {
        let far = ([-1.0, 0.0, 3.0], 0.1, ORANGE);
        let close = ([0.4, 0.0, 1.0], 0.1, ORANGE);
        let blue = ([0.0, 0.0, 0.5], 0.1, [38, 92, 190]);
        let ball = show(&mut finder(), &[blue, far, close]);
        assert_near(ball.bearing, (-0.4_f64).atan(), 0.01);
    });
}

#[test]
fn small_or_elongated_components_are_rejected() {
    with_large_stack(|| {
        let tiny = ([0.0, 0.0, 12.0], 0.1, ORANGE);
        assert!(!show(&mut finder(), &[tiny]).seen.get());
        let mut bench = finder();
        bench.set("pixels", 3_u32);
        assert!(
            show(&mut bench, &[tiny]).seen.get(),
            "the minimum size is modulated"
        );
        // Only a stripe at the edge of the ball is visible, which is long and thin.
        let cover = ([0.03, 0.0, 0.9], 0.1, GREY);
        let ball = ([0.0, 0.0, 1.0], 0.1, ORANGE);
        assert!(!show(&mut finder(), &[cover, ball]).seen.get());
        assert!(show(&mut finder(), &[ball]).seen.get());
    });
}

#[test]
fn half_a_ball_is_found_at_less_than_one_and_a_half_times_the_distance() {
    with_large_stack(|| {
        // The edge of a very large grey ball hides the right half.
        let cover = ([5.0, 0.0, 0.5], 5.0, GREY);
        let ball = show(&mut finder(), &[cover, ([0.0, 0.0, 1.0], 0.1, ORANGE)]);
        assert!(ball.seen.get());
        assert!((1.2..1.5).contains(&ball.distance), "{}", ball.distance);
    });
}

#[test]
fn a_lost_ball_keeps_its_position_and_the_time_is_counted() {
    with_large_stack(|| {
        let mut bench = finder();
        bench.set_now(seconds(1.0));
        let before = show(&mut bench, &[]);
        assert_eq!(
            (before.seen.get(), before.unseen, before.is_known()),
            (false, 0.0, false)
        );
        bench.set_now(seconds(2.0));
        assert_eq!(show(&mut bench, &[]).unseen, 1.0);

        bench.set_now(seconds(3.0));
        let ball = show(&mut bench, &[([-0.5, 0.0, 1.0], 0.1, ORANGE)]);
        assert_eq!((ball.unseen, ball.is_known()), (0.0, true));
        assert_eq!(bench.exported_at("ball"), Some(seconds(3.0)));

        bench.set_now(seconds(3.25));
        let lost = show(&mut bench, &[]);
        assert_eq!((lost.unseen, lost.count, lost.is_known()), (0.25, 0, true));
        assert_eq!((lost.bearing, lost.distance), (ball.bearing, ball.distance));
        bench.set_now(seconds(3.5));
        assert!(
            !show(&mut bench, &[]).is_known(),
            "the position is known for a short time only"
        );
    });
}

#[test]
fn without_a_new_image_nothing_is_published_and_without_any_it_is_retracted() {
    with_large_stack(|| {
        let mut bench = finder();
        bench.set_now(seconds(1.0));
        show(&mut bench, &[([0.0, 0.0, 1.0], 0.1, ORANGE)]);
        bench.set_now(seconds(2.0));
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(bench.exported_at("ball"), Some(seconds(1.0)));
        bench.retract("image");
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(bench.exported::<Ball>("ball"), None);
    });
}

#[test]
fn bgr_images_and_padded_rows_are_supported() {
    with_large_stack(|| {
        let mut image = paint(SIZE, &[([0.3, 0.0, 1.0], 0.1, ORANGE)]);
        for pixel in image.data.as_mut_slice().as_chunks_mut::<3>().0 {
            pixel.reverse();
        }
        // Fewer columns than each row holds: the right edge of the picture is missing, so the ball is nearer
        // to the middle.
        image.encoding = Text::new("bgr8");
        image.width = 300;
        let mut bench = finder();
        bench.import("image", &*image);
        bench.iterate().expect("the iteration succeeds");
        let ball: Ball = bench.exported("ball").expect("the ball is exported");
        assert_near(ball.column, 208.0, 0.7);
    });
}

#[test]
fn an_unsupported_image_is_an_error() {
    with_large_stack(|| {
        let assert_rejected = |image: &Image, expected: &[&str]| {
            let mut bench = finder();
            bench.import("image", image);
            let reason = bench.iterate().expect_err("the image is rejected").reason;
            for text in expected {
                assert!(reason.contains(text), "`{text}` is not in: {reason}");
            }
        };
        let mut image = paint(SIZE, &[]);
        image.encoding = Text::new("mono8");
        assert_rejected(&image, &["`image`", "mono8", "rgb8"]);
        image.encoding = Text::new("rgb8");
        image.step = 959;
        assert_rejected(&image, &["320 x 240", "959 bytes"]);
    });
}
