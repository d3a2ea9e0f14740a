//! Prints how long one collision check among 720 points takes, in the open and beside a wall.
//!
//! `cargo run --release -p jde-motion --example stopping_time`

use std::hint::black_box;
use std::time::Instant;

use jde_motion::{BaseDynamics, Maneuver, Outline};
use jde_types::{Footprint, Point2D, Seq, Twist};

const CALLS: u32 = 20_000;

fn main() {
    let corners = [(0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)].map(|(x, y)| Point2D { x, y });
    let rectangle = Footprint {
        radius: 0.0,
        points: Seq::from_slice(&corners).expect("four points fit"),
    };
    let maneuver = Maneuver {
        velocity: Twist::planar(0.5, 0.3),
        lead: Twist::ZERO,
        wait: 0.0,
        command: Twist::planar(0.5, 0.3),
        hold: 0.2,
        dynamics: BaseDynamics {
            acceleration: 0.5,
            deceleration: 0.5,
            turn_acceleration: 2.0,
            turn_deceleration: 2.0,
            lag: 0.0,
        },
    };
    for (shape, footprint) in [("circle", Footprint::circle(0.25)), ("rectangle", rectangle)] {
        let outline = Outline::try_from(&footprint).expect("a valid footprint");
        for (place, distance) in [("2 m from walls", 2.0), ("0.3 m from a wall", 0.3)] {
            let points = corridor(distance);
            let start = Instant::now();
            for _ in 0..CALLS {
                black_box(maneuver.stopping(&outline, black_box(&points), 0.02));
            }
            let micros = start.elapsed().as_secs_f64() * 1e6 / f64::from(CALLS);
            println!("{shape}, {place}: {micros:.2} µs");
        }
    }
}

/// A wall to the right at `distance` m, and a box of 4 m around the rest.
fn corridor(distance: f64) -> Vec<Point2D> {
    (0..720)
        .map(|beam| (f64::from(beam) * 0.5).to_radians().sin_cos())
        .map(|(sin, cos)| {
            let side = if sin < 0.0 {
                distance / -sin
            } else {
                4.0 / sin.max(1e-9)
            };
            let range = side.min(4.0 / cos.abs().max(1e-9));
            Point2D {
                x: range * cos,
                y: range * sin,
            }
        })
        .collect()
}
