//! The simulator: what a beam of a laser costs beside the library that casts its rays, and how fast the demonstration goes.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, anyhow};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, interleave, see};
use jde_sim::{LaserConfig, Pose2, RobotConfig, World};
use parry2d_f64::math::Vector;
use parry2d_f64::query::{Ray, RayCast};
use parry2d_f64::shape::Polyline;
use serde::{Deserialize, Serialize};

use crate::product;
use crate::scope::Scope;

/// Walls of the world, each a segment.
const SEGMENTS: usize = 1000;
/// Side of the world, m.
const SIDE: f64 = 50.0;
/// Where the robot stands in it.
const AT: [f64; 2] = [25.3, 24.7];
/// Rays a second that parry2d casts at such a world on a machine of the same kind.
const GIVEN: f64 = 2.6e6;

pub(crate) fn laser(scope: &Scope) -> Result<Vec<Line>> {
    let walls = walls();
    let (world, robot) = world(&walls)?;
    let parry = polyline(&walls);
    let mut lines = Vec::new();
    for (beams, degrees) in [(180, 180.0f64), (360, 360.0)] {
        let laser = LaserConfig {
            beams,
            field_of_view: degrees.to_radians(),
            mount: Pose2::default(),
            sigma: 0.0,
            ..LaserConfig::default()
        };
        let noisy = LaserConfig {
            sigma: LaserConfig::default().sigma,
            ..laser.clone()
        };
        let rays: Vec<Ray> = (0..beams)
            .map(|beam| {
                let (sin, cos) = laser.angle(beam).sin_cos();
                Ray::new(Vector::new(AT[0], AT[1]), Vector::new(cos, sin))
            })
            .collect();
        let (mut ranges, mut with_noise, mut theirs) = (vec![0.0; beams], vec![0.0; beams], vec![0.0; beams]);
        let [ours, noise, alone] = interleave(
            scope.effort(),
            [
                &mut |times| (0..times).for_each(|_| see(world.laser(robot, &laser, &mut ranges))),
                &mut |times| (0..times).for_each(|_| see(world.laser(robot, &noisy, &mut with_noise))),
                &mut |times| {
                    for _ in 0..times {
                        for (range, ray) in theirs.iter_mut().zip(black_box(&rays)) {
                            let hit = parry.cast_local_ray(ray, laser.range_max, true);
                            *range = hit.map_or(f32::INFINITY, |hit| hit as f32);
                        }
                        black_box(&theirs);
                    }
                },
            ],
        );
        same(&ranges, &theirs)?;
        let a_ray = |rounds: &Rounds| Figure::Time(rounds.median() / beams as f64);
        let what = format!("a beam of {beams}, {SEGMENTS} segments");
        lines.push(
            Line::beside(&what, a_ray(&ours), "parry2d", a_ray(&alone), Goal::AtMost(1.1))
                .paired(ours.by(&alone)),
        );
        lines.push(Line::given(
            &what,
            a_ray(&ours),
            "parry2d",
            Figure::Time(1e9 / GIVEN),
            Goal::AtMost(1.1),
        ));
        if let Some(python) = &scope.python {
            let scan = ir_sim(scope, python, &walls, &laser)?;
            lines.push(Line::beside(
                &what,
                a_ray(&ours),
                "ir-sim",
                Figure::Time(scan / beams as f64),
                Goal::TimesFaster(1.0),
            ));
        }
        lines.push(
            Line::beside(
                format!("{what}, with noise"),
                a_ray(&noise),
                "parry2d",
                a_ray(&alone),
                Goal::Told,
            )
            .paired(noise.by(&alone)),
        );
    }
    Ok(lines)
}

/// Both see the same, or nothing was compared.
fn same(ours: &[f32], theirs: &[f32]) -> Result<()> {
    let differs = |(ours, theirs): (&f32, &f32)| ours != theirs && (ours - theirs).abs() > 1e-3;
    match ours.iter().zip(theirs).position(differs) {
        Some(beam) => Err(anyhow!(
            "beam {beam} measures {} and parry2d {}",
            ours[beam],
            theirs[beam]
        )),
        None => Ok(()),
    }
}

/// Short walls all over the place, none of them over the robot: the same in every run.
fn walls() -> Vec<[[f64; 2]; 2]> {
    let mut state = 1u64;
    let mut random = move || {
        // Numerical Recipes' generator, of which the upper bits are good enough to spread walls.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut walls = Vec::new();
    while walls.len() < SEGMENTS {
        let (x, y, angle) = (random() * SIDE, random() * SIDE, random() * std::f64::consts::TAU);
        let (sin, cos) = angle.sin_cos();
        let far = |[x, y]: [f64; 2]| (x - AT[0]).hypot(y - AT[1]) > 1.5;
        let wall = [[x, y], [x + cos, y + sin]];
        if wall.into_iter().all(far) {
            walls.push(wall);
        }
    }
    walls
}

fn world(walls: &[[[f64; 2]; 2]]) -> Result<(World, jde_sim::RobotId)> {
    let mut text = format!(
        "robots = {{ pioneer = {{ start = {{ x = {}, y = {} }} }} }}\n",
        AT[0], AT[1]
    );
    for [from, to] in walls {
        let _ = writeln!(text, "[[walls]]\npoints = [{from:?}, {to:?}]");
    }
    let mut world = World::parse(&text, "bench.toml", 1)?;
    let robot = world.add_robot("pioneer", RobotConfig::default())?;
    Ok((world, robot))
}

/// The walls as parry keeps many segments: in one shape with a tree over them.
fn polyline(walls: &[[[f64; 2]; 2]]) -> Polyline {
    let points = walls
        .iter()
        .flatten()
        .map(|point| Vector::new(point[0], point[1]));
    let indices = (0..walls.len() as u32).map(|wall| [2 * wall, 2 * wall + 1]);
    Polyline::new(points.collect(), Some(indices.collect()))
}

/// What ir-sim is asked.
#[derive(Serialize)]
struct Asked<'a> {
    walls: &'a [[[f64; 2]; 2]],
    at: [f64; 2],
    beams: usize,
    degrees: f64,
    range: f64,
    seconds: f64,
}

/// What it answers.
#[derive(Deserialize)]
struct Scanned {
    scan_ns: f64,
}

/// What a scan takes ir-sim, ns.
fn ir_sim(scope: &Scope, python: &Path, walls: &[[[f64; 2]; 2]], laser: &LaserConfig) -> Result<f64> {
    let asked = Asked {
        walls,
        at: AT,
        beams: laser.beams,
        degrees: laser.field_of_view.to_degrees(),
        range: laser.range_max,
        seconds: scope.either(0.5, 3.0),
    };
    let mut command = Command::new(python);
    command.arg(scope.root.join("benches/peers/ir_sim.py"));
    let said = product::tell(&mut command, &serde_json::to_string(&asked)?)?;
    Ok(serde_json::from_str::<Scanned>(&said)?.scan_ns)
}

/// What `jde demo --json` ends with, as far as it is used here.
#[derive(Deserialize)]
struct Summary {
    sim_seconds: f64,
    wall_seconds: f64,
}

pub(crate) fn demo(scope: &Scope) -> Result<Vec<Line>> {
    let folder = tempfile::tempdir()?;
    let mut speeds = Vec::new();
    for _ in 0..scope.either(1, 5) {
        let mut command = product::jde(scope, folder.path());
        command
            .args(["demo", "--lockstep", "--json", "--seed", "1", "--out"])
            .arg(folder.path());
        let said = product::read(&mut command)?;
        let last = said.lines().last().context("`jde demo` says nothing")?;
        let summary: Summary = serde_json::from_str(last)?;
        speeds.push(summary.sim_seconds / summary.wall_seconds);
    }
    Ok(vec![Line::alone(
        "demonstration in lockstep, picture and decisions included",
        Figure::Speed(Rounds::of(speeds).median()),
        Goal::Least(Figure::Speed(500.0)),
    )])
}
