//! What drives and what judges it: an iteration of sampled control before an obstacle, with as many trajectories
//! and steps as nav2's controller has, a turn of regulated pure pursuit, and the judgement of a guard.

use std::time::Duration;

use anyhow::{Result, anyhow, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{consume, interleave};
use jde_mppi::{Base, Clearance, Controller, Disc, Guide, Motion, Shape, Situation, Spread, Weights};
use jde_paths::{BEAMS, Periods, SPEED, surroundings};
use jde_schema::types::Twist;

use crate::loaded;
use crate::schemas::PLUGIN;
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
    lag: 0.0,
};

/// A base that follows a path through a corridor.
const PURSUIT: &str = r#"
    roots = ["follow"]
    [schemas.follow]
    type = "drive/path"
    period = "1ms"
    imports = { laser = "corridor.laser", pose = "corridor.pose", path = "corridor.path" }
    actuators = { base = "corridor.velocity" }
    [schemas.corridor]
    type = "pace/corridor"
"#;

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
        Line::new(
            format!("`drive/path`, a check and an iteration, {BEAMS} beams"),
            Figure::Time(pursuit(scope)?),
            Goal::Below(Figure::millis(1.0)),
        ),
        Line::new(
            format!("`guard/footprint` judges a command by {BEAMS} points"),
            Figure::Time(judgement(scope)?),
            Goal::ReportOnly,
        ),
    ])
}

/// The median time of a turn of regulated pure pursuit, ns.
fn pursuit(scope: &Scope) -> Result<f64> {
    let mut plugins = loaded::plugins(&scope.built);
    plugins.link(&PLUGIN)?;
    let mut periods = Periods::of(PURSUIT, &plugins)?;
    let [rounds] = interleave(scope.effort(), [&mut |times| periods.pass(times)]);
    let speed = periods.value("corridor.speed")?;
    ensure!(speed > Some(0.0), "the base is commanded {speed:?} m/s");
    Ok(rounds.median())
}

/// The median time of a judgement, ns.
fn judgement(scope: &Scope) -> Result<f64> {
    let (around, command) = (surroundings(), Twist::planar(SPEED, 0.0));
    let judge = || around.judge(Duration::from_millis(25), &command);
    judge().map_err(|reason| anyhow!("the command is refused: {reason}"))?;
    let [rounds] = interleave(
        scope.effort(),
        [&mut |times| (0..times).for_each(|_| consume(judge()))],
    );
    Ok(rounds.median())
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
        lead: [0.0; 3],
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
