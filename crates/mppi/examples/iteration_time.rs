//! Prints how long one iteration takes for 2000 trajectories of 56 steps, as nav2's controller samples.
//!
//! `cargo run --release -p jde-mppi --example iteration_time`

use std::time::Instant;

use jde_mppi::{Base, Clearance, Controller, Disc, Guide, Motion, Shape, Situation, Spread, Weights};

const CALLS: usize = 200;
const WIDTH: usize = 100;

fn main() {
    let shape = Shape {
        samples: 2000,
        steps: 56,
        step: 0.05,
    };
    let differential = Base {
        fast: 0.5,
        reverse: 0.0,
        sideways: 0.0,
        turn: 1.0,
        turning_radius: 0.0,
        acceleration: 0.5,
        turn_acceleration: 2.0,
    };
    let omnidirectional = Base {
        sideways: 0.5,
        ..differential
    };
    for (base, kind) in [
        (differential, "differential"),
        (omnidirectional, "omnidirectional"),
    ] {
        for discs in [1, 4] {
            println!("{kind}, {discs} discs: {:.2} ms", median(base, discs, shape));
        }
    }
}

/// The median time of an iteration before an obstacle, ms.
fn median(base: Base, discs: usize, shape: Shape) -> f64 {
    let mut clearance = Clearance::new(WIDTH, 0.05);
    let square =
        |cell: usize| ((cell % WIDTH).abs_diff(60).pow(2) + (cell / WIDTH).abs_diff(48).pow(2)) as u32;
    clearance.set_squares(&(0..WIDTH * WIDTH).map(square).collect::<Vec<_>>());
    let start = Motion {
        pose: [1.5, 2.5, 0.0],
        velocity: [0.4, 0.0, 0.0],
    };
    let mut guide = Guide::new();
    guide.follow(start.pose, (0..32).map(|at| (1.5 + 0.05 * at as f32, 2.5)));
    let place = |at: usize| Disc {
        x: 0.1 * at as f32,
        y: 0.0,
        radius: 0.2,
    };
    let situation = Situation {
        start,
        base,
        discs: &(0..discs).map(place).collect::<Vec<_>>(),
        clearance: &clearance,
        guide: &guide,
        margin: 0.05,
        near: 0.4,
        weights: Weights::default(),
    };
    let spread = Spread {
        deviation: [0.3, 0.2, 0.6],
        temperature: 0.1,
    };
    let mut controller = Controller::new(shape, 1);
    let mut times: Vec<f64> = (0..CALLS)
        .map(|_| {
            let begin = Instant::now();
            std::hint::black_box(controller.command(&situation, &spread, shape.step));
            begin.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CALLS / 2]
}
