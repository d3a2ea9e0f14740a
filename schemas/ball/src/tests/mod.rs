//! Shared helpers: pictures of balls computed by geometry alone, and balls as the finder publishes them.

mod base;
mod finder;
mod follower;
mod hall;
mod head;

use core::time::Duration;
use std::panic::resume_unwind;
use std::thread;

use jde_schema::prelude::*;

use crate::ball::Ball;

/// A field of view whose half has the tangent 1: the focal length is half of the width.
pub(crate) const FIELD_OF_VIEW: f64 = core::f64::consts::FRAC_PI_2;
pub(crate) const ORANGE: [u8; 3] = [240, 124, 24];
pub(crate) const GREY: [u8; 3] = [128, 126, 120];

/// A ball to paint: its middle in the frame of the camera (right, down, into the picture), its radius, m, its
/// colour.
pub(crate) type PaintedBall = ([f64; 3], f64, [u8; 3]);

/// Paints balls before a grey background with the field of view `FIELD_OF_VIEW`. Earlier balls cover later
/// ones.
pub(crate) fn paint([width, height]: [usize; 2], balls: &[PaintedBall]) -> Box<Image> {
    let mut image = Box::new(Image::default());
    (image.width, image.height, image.step) = (width as u32, height as u32, 3 * width as u32);
    image.encoding = Text::new("rgb8");
    let data = image.data.resize(3 * width * height);
    let focal = width as f64 / 2.0;
    for row in 0..height {
        for column in 0..width {
            let ray = [
                (column as f64 + 0.5 - focal) / focal,
                (row as f64 + 0.5 - height as f64 / 2.0) / focal,
                1.0,
            ];
            let ball = balls
                .iter()
                .find(|(middle, radius, _)| hits(ray, *middle, *radius));
            let index = 3 * (row * width + column);
            data[index..index + 3].copy_from_slice(&ball.map_or(GREY, |(_, _, color)| *color));
        }
    }
    image
}

/// Whether a ray from the camera passes a point within `radius`.
fn hits(ray: [f64; 3], middle: [f64; 3], radius: f64) -> bool {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = dot(ray, middle);
    along > 0.0 && dot(middle, middle) - along * along / dot(ray, ray) <= radius * radius
}

/// A ball on the horizon that is seen.
pub(crate) fn seen(bearing: f64, distance: f64) -> Ball {
    Ball {
        seen: Flag::TRUE,
        bearing,
        distance,
        ..Ball::default()
    }
}

/// The same ball, not seen for this time, s.
pub(crate) fn unseen(bearing: f64, distance: f64, unseen_for: f64) -> Ball {
    Ball {
        seen: Flag::FALSE,
        unseen: unseen_for,
        ..seen(bearing, distance)
    }
}

pub(crate) fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

#[track_caller]
pub(crate) fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} is not {expected} +- {tolerance}"
    );
}

/// Runs a test on a thread with a stack large enough for pictures of nearly a megabyte each.
pub(crate) fn with_large_stack(test: impl FnOnce() + Send + 'static) {
    let thread = thread::Builder::new().stack_size(64 << 20).spawn(test);
    if let Err(panic) = thread.expect("the thread starts").join() {
        resume_unwind(panic);
    }
}
