//! The finder on painted pictures: the position of the ball, the objects that it rejects, and when it
//! retracts its export.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::Finder;
use crate::ball::Ball;
use crate::tests::{GREY, ORANGE, Painted, WIDE, near, paint, roomy, seconds};

const SIZE: [usize; 2] = [320, 240];

/// A finder without a pan-tilt head.
fn finder() -> Bench<Finder> {
    let mut bench = Bench::new();
    bench.set("field_of_view", WIDE);
    bench.set("radius", 0.1);
    bench.unbind("pan_tilt");
    bench
}

fn show(bench: &mut Bench<Finder>, balls: &[Painted]) -> Ball {
    bench.import("image", &*paint(SIZE, balls));
    bench.iterate().expect("it sees");
    bench.exported("ball").expect("it says what it sees")
}

#[test]
fn bearing_elevation_and_distance_are_those_of_the_ball_all_over_the_picture() {
    roomy(|| {
        for distance in [0.7, 1.0, 2.5] {
            for x in [-0.6, -0.3, 0.0, 0.4, 0.6] {
                for y in [-0.4, 0.0, 0.35] {
                    let length = f64::hypot(1.0, f64::hypot(x, y));
                    let middle = [x, y, 1.0].map(|axis| axis * distance / length);
                    let ball = show(&mut finder(), &[(middle, 0.1, ORANGE)]);
                    assert!(ball.seen.get());
                    near(ball.bearing, (-x).atan(), 0.005);
                    near(ball.elevation, -(y / 1_f64.hypot(x)).atan(), 0.005);
                    near(ball.distance, distance, 0.03 * distance);
                    near(ball.column, 160.0 + 160.0 * x, 0.7);
                    near(ball.row, 120.0 + 160.0 * y, 0.7);
                }
            }
        }
    });
}

#[test]
fn a_ball_of_twice_the_radius_is_twice_as_far() {
    roomy(|| {
        let mut bench = finder();
        let balls = [([0.0, 0.2, 1.0], 0.1, ORANGE)];
        let near_by = show(&mut bench, &balls).distance;
        bench.set("radius", 0.2);
        near(show(&mut bench, &balls).distance, 2.0 * near_by, 1e-9);
    });
}

#[test]
fn the_head_turns_what_the_camera_sees_into_the_frame_of_the_base() {
    roomy(|| {
        let mut bench = Bench::<Finder>::new();
        bench.set("field_of_view", WIDE);
        let look = PanTilt {
            pan: -0.8,
            tilt: 0.3,
            ..PanTilt::default()
        };
        bench.import("pan_tilt", &look);
        let ball = show(&mut bench, &[([0.0, 0.0, 1.0], 0.1, ORANGE)]);
        near(ball.bearing, -0.8, 0.003);
        near(ball.elevation, -0.3, 0.003);
        assert_eq!(ball.header.frame_id.as_str(), "base_link");
        // Without the position of the head, that of the ball is unknown.
        bench.retract("pan_tilt");
        bench.iterate().expect("it waits");
        assert_eq!(bench.exported::<Ball>("ball"), None);
    });
}

#[test]
fn of_several_balls_the_largest_counts_and_other_colours_do_not() {
    roomy(|| {
        let far = ([-1.0, 0.0, 3.0], 0.1, ORANGE);
        let close = ([0.4, 0.0, 1.0], 0.1, ORANGE);
        let blue = ([0.0, 0.0, 0.5], 0.1, [38, 92, 190]);
        let ball = show(&mut finder(), &[blue, far, close]);
        near(ball.bearing, (-0.4_f64).atan(), 0.01);
    });
}

#[test]
fn what_is_too_small_or_not_round_is_no_ball() {
    roomy(|| {
        let tiny = ([0.0, 0.0, 12.0], 0.1, ORANGE);
        assert!(!show(&mut finder(), &[tiny]).seen.get());
        let mut bench = finder();
        bench.set("pixels", 3_u32);
        assert!(show(&mut bench, &[tiny]).seen.get(), "the size is modulated");
        // Only a stripe at the edge of the ball is visible, which is long and thin.
        let cover = ([0.03, 0.0, 0.9], 0.1, GREY);
        let ball = ([0.0, 0.0, 1.0], 0.1, ORANGE);
        assert!(!show(&mut finder(), &[cover, ball]).seen.get());
        assert!(show(&mut finder(), &[ball]).seen.get());
    });
}

#[test]
fn half_a_ball_is_one_and_looks_farther_by_less_than_half() {
    roomy(|| {
        // The edge of a very large grey ball hides the right half.
        let cover = ([5.0, 0.0, 0.5], 5.0, GREY);
        let ball = show(&mut finder(), &[cover, ([0.0, 0.0, 1.0], 0.1, ORANGE)]);
        assert!(ball.seen.get());
        assert!((1.2..1.5).contains(&ball.distance), "{}", ball.distance);
    });
}

#[test]
fn a_lost_ball_is_where_it_was_and_the_time_is_counted() {
    roomy(|| {
        let mut bench = finder();
        bench.set_now(seconds(1.0));
        let never = show(&mut bench, &[]);
        assert_eq!(
            (never.seen.get(), never.unseen, never.is_known()),
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
        assert!(!show(&mut bench, &[]).is_known(), "it is not believed for long");
    });
}

#[test]
fn no_new_picture_is_no_news_and_no_picture_at_all_takes_it_back() {
    roomy(|| {
        let mut bench = finder();
        bench.set_now(seconds(1.0));
        show(&mut bench, &[([0.0, 0.0, 1.0], 0.1, ORANGE)]);
        bench.set_now(seconds(2.0));
        bench.iterate().expect("it waits");
        assert_eq!(bench.exported_at("ball"), Some(seconds(1.0)));
        bench.retract("image");
        bench.iterate().expect("it waits");
        assert_eq!(bench.exported::<Ball>("ball"), None);
    });
}

#[test]
fn blue_may_come_first_and_rows_may_be_longer_than_their_pixels() {
    roomy(|| {
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
        bench.iterate().expect("it sees");
        let ball: Ball = bench.exported("ball").expect("it says what it sees");
        near(ball.column, 208.0, 0.7);
    });
}

#[test]
fn a_picture_that_cannot_be_read_is_told_in_words() {
    roomy(|| {
        let refused = |image: &Image, words: &[&str]| {
            let mut bench = finder();
            bench.import("image", image);
            let reason = bench.iterate().expect_err("it cannot read that").reason;
            for word in words {
                assert!(reason.contains(word), "`{word}` is not in: {reason}");
            }
        };
        let mut image = paint(SIZE, &[]);
        image.encoding = Text::new("mono8");
        refused(&image, &["`image`", "mono8", "rgb8"]);
        image.encoding = Text::new("rgb8");
        image.height = 241;
        refused(&image, &["320 x 241", "960 bytes", "230400"]);
    });
}
