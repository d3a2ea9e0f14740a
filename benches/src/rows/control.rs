//! An iteration of sampled control before an obstacle, as many trajectories and steps as nav2's controller has.

use anyhow::Result;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{consume, interleave};
use jde_mppi::{Base, Clearance, Controller, Disc, Guide, Motion, Shape, Situation, Spread, Weights};

use crate::scope::Scope;

/// Trajectories and steps of 50 ms: what nav2 states for its controller, at 50 Hz.
const SHAPE: Shape = Shape {
    samples: 2000,
    steps: 56,
    step: 0.05,
};
/// The side of the area, in cells of 5 cm.
const WIDTH: usize = 100;
const DIFFERENTIAL: Base = Base {
    fast: 0.5,
    reverse: 0.0,
    sideways: 0.0,
    turn: 1.0,
    turning_radius: 0.0,
    acceleration: 0.5,
    turn_acceleration: 2.0,
};

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let omnidirectional = Base {
        sideways: 0.5,
        ..DIFFERENTIAL
    };
    let line = |name: &str, base, discs| {
        Line::new(
            format!("{} trajectories of {} steps, {name}", SHAPE.samples, SHAPE.steps),
            Figure::Time(median(scope, base, discs)),
            Goal::Below(Figure::millis(11.6)),
        )
    };
    Ok(vec![
        line("differential, a disc", DIFFERENTIAL, 1),
        line("omnidirectional, four discs", omnidirectional, 4),
    ])
}

/// The median time of an iteration, ns.
fn median(scope: &Scope, base: Base, discs: usize) -> f64 {
    let mut clearance = Clearance::new(WIDTH, 0.05);
    let square = |cell: usize| {
        let (column, row) = (cell % WIDTH, cell / WIDTH);
        (column.abs_diff(60).pow(2) + row.abs_diff(48).pow(2)) as u32
    };
    clearance.set_squares(&(0..WIDTH * WIDTH).map(square).collect::<Vec<_>>());
    let start = Motion {
        pose: [1.5, 2.5, 0.0],
        velocity: [0.4, 0.0, 0.0],
    };
    let mut guide = Guide::new();
    guide.follow(start.pose, (0..40).map(|at| (1.5 + 0.04 * at as f32, 2.5)));
    let disc = |at: usize| Disc {
        x: 0.1 * at as f32,
        y: 0.0,
        radius: 0.2,
    };
    let situation = Situation {
        start,
        base,
        discs: &(0..discs).map(disc).collect::<Vec<_>>(),
        clearance: &clearance,
        guide: &guide,
        margin: 0.05,
        near: 0.4,
        weights: Weights::default(),
    };
    let spread = Spread {
        deviation: [0.3, 0.3, 0.6],
        temperature: 0.1,
    };
    let mut controller = Controller::new(SHAPE, 1);
    let mut iterate = |times: u64| {
        (0..times).for_each(|_| consume(controller.command(&situation, &spread, SHAPE.step)));
    };
    let [rounds] = interleave(scope.effort(), [&mut iterate]);
    rounds.median()
}
