//! The simulator: the time of a laser's beam beside the library that casts rays, and the speed of the
//! demonstration.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, anyhow, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, interleave, see};
use jde_sim::{LaserConfig, Pose2, RobotConfig, World};
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry2d_f64::query::{Ray, RayCast};
use parry2d_f64::shape::{Polyline, Segment};
use serde::{Deserialize, Serialize};

use crate::product;
use crate::scope::Scope;

/// The number of walls in the world, each a segment.
const SEGMENTS: usize = 1000;
/// The side of the world, m.
const SIDE: f64 = 50.0;
/// The number of poses of the robot.
const PLACES: usize = 40;
/// The number of scans from one pose.
const SCANS: usize = 4;

pub(crate) fn laser(scope: &Scope) -> Result<Vec<Line>> {
    let walls = walls();
    let (mut world, robot) = world(&walls)?;
    let poses = poses(&mut world, robot);
    let (tree, polyline) = (Tree::of(&walls), polyline(&walls));
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
        let rays: Vec<Vec<Ray>> = poses.iter().map(|pose| rays(pose, &laser)).collect();
        let most = laser.range_max;
        let by_tree = |ray: &Ray| tree.cast(ray, most);
        let by_polyline = |ray: &Ray| polyline.cast_local_ray(ray, most, true);
        let (mut ranges, mut theirs, mut lines_of) = (vec![0.0; beams], vec![0.0; beams], vec![0.0; beams]);
        for (pose, rays) in poses.iter().zip(&rays) {
            world.place(robot, *pose)?;
            world.laser(robot, &laser, &mut ranges)?;
            cast(by_tree, rays, &mut theirs);
            check_ranges(&ranges, &theirs)?;
            cast(by_polyline, rays, &mut lines_of);
            check_ranges(&ranges, &lines_of)?;
        }
        // Each round visits all poses, so that both sides measure the same scans.
        let circuit = |times: u64, world: &mut World, robot, laser: &LaserConfig, ranges: &mut [f32]| {
            for pose in (0..times).flat_map(|_| &poses) {
                see(world.place(robot, *pose));
                (0..SCANS).for_each(|_| see(world.laser(robot, laser, ranges)));
            }
        };
        let mut twin = self::world(&walls)?;
        let mut with_noise = vec![0.0; beams];
        let [ours, noise, alone, polyline] = interleave(
            scope.effort(),
            [
                &mut |times| circuit(times, &mut world, robot, &laser, &mut ranges),
                &mut |times| circuit(times, &mut twin.0, twin.1, &noisy, &mut with_noise),
                &mut |times| {
                    for rays in (0..times).flat_map(|_| &rays) {
                        (0..SCANS).for_each(|_| cast(by_tree, rays, &mut theirs));
                    }
                },
                &mut |times| {
                    for rays in (0..times).flat_map(|_| &rays) {
                        (0..SCANS).for_each(|_| cast(by_polyline, rays, &mut lines_of));
                    }
                },
            ],
        );
        let a_ray = |rounds: &Rounds| Figure::Time(rounds.median() / (PLACES * SCANS * beams) as f64);
        let what = format!("a beam of {beams}, {SEGMENTS} segments");
        let beside = |what: &str, ours: &Rounds, (name, theirs): (&str, &Rounds), goal| {
            Line::beside(what, a_ray(ours), name, a_ray(theirs), goal).paired(ours.by(theirs))
        };
        let (shape, same_tree) = (
            ("parry2d, its Polyline", &polyline),
            ("parry2d, the same tree", &alone),
        );
        lines.push(beside(&what, &ours, shape, Goal::AtMost(1.1)));
        lines.push(beside(&what, &ours, same_tree, Goal::Reported));
        lines.push(beside(
            &format!("{what}, with noise"),
            &noise,
            shape,
            Goal::Reported,
        ));
        if let Some(python) = &scope.python {
            world.place(robot, poses[0])?;
            world.laser(robot, &laser, &mut ranges)?;
            let scan = ir_sim(scope, python, &walls, &laser, &poses[0], &ranges)?;
            let mut one = |times| (0..times).for_each(|_| see(world.laser(robot, &laser, &mut ranges)));
            let [ours] = interleave(scope.effort(), [&mut one]);
            lines.push(Line::beside(
                format!("{what}, from one place"),
                Figure::Time(ours.median() / beams as f64),
                "ir-sim",
                Figure::Time(scan / beams as f64),
                Goal::TimesFaster(1.0),
            ));
        }
    }
    Ok(lines)
}

/// Checks that both sides measure the same ranges; otherwise the comparison would be worthless.
fn check_ranges(ours: &[f32], theirs: &[f32]) -> Result<()> {
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

/// Returns a generator of numbers from 0 to 1 that are the same in every run: Knuth's MMIX. Its upper bits
/// are random enough for this purpose.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Checks that most beams measure the same; otherwise the comparison would be worthless. ir-sim spreads its
/// beams over the closed field of view: in a full circle the last beam equals the first, and those between
/// deviate slightly from jde's. Therefore a beam may miss a wall that its counterpart meets.
fn check_most_ranges(ours: &[f32], theirs: &[f32], most: f32) -> Result<()> {
    ensure!(
        ours.len() == theirs.len(),
        "ir-sim has {} beams of {}",
        theirs.len(),
        ours.len()
    );
    let near = |(ours, theirs): &(&f32, &f32)| (ours.min(most) - theirs.min(most)).abs() < 0.2;
    let same = ours.iter().zip(theirs).filter(near).count();
    ensure!(
        same * 10 >= ours.len() * 8,
        "only {same} of {} beams of ir-sim measure what ours do",
        ours.len()
    );
    Ok(())
}

/// Short walls at random places, none of them close to the robot's start.
fn walls() -> Vec<[[f64; 2]; 2]> {
    let mut random = random();
    let mut walls = Vec::new();
    while walls.len() < SEGMENTS {
        let (x, y, angle) = (random() * SIDE, random() * SIDE, random() * std::f64::consts::TAU);
        let (sin, cos) = angle.sin_cos();
        let far = |[x, y]: [f64; 2]| (x - SIDE / 2.0).hypot(y - SIDE / 2.0) > 1.5;
        let wall = [[x, y], [x + cos, y + sin]];
        if wall.into_iter().all(far) {
            walls.push(wall);
        }
    }
    walls
}

/// Poses in the middle of the world in which the robot touches no wall. The first faces along the x axis.
fn poses(world: &mut World, robot: jde_sim::RobotId) -> Vec<Pose2> {
    let mut random = random();
    let mut poses = vec![Pose2::new(SIDE / 2.0, SIDE / 2.0, 0.0)];
    while poses.len() < PLACES {
        let inside = |share: f64| 10.0 + share * (SIDE - 20.0);
        let (x, y) = (inside(random()), inside(random()));
        let pose = Pose2::new(x, y, random() * std::f64::consts::TAU);
        if world.place(robot, pose).is_ok() {
            poses.push(pose);
        }
    }
    poses
}

/// Returns the beams of a laser from a pose.
fn rays(pose: &Pose2, laser: &LaserConfig) -> Vec<Ray> {
    let beams = (0..laser.beams).map(|beam| {
        let (sin, cos) = (pose.heading + laser.angle(beam)).sin_cos();
        Ray::new(Vector::new(pose.x, pose.y), Vector::new(cos, sin))
    });
    beams.collect()
}

fn world(walls: &[[[f64; 2]; 2]]) -> Result<(World, jde_sim::RobotId)> {
    let middle = SIDE / 2.0;
    let mut text = format!("robots = {{ pioneer = {{ start = {{ x = {middle}, y = {middle} }} }} }}\n");
    for [from, to] in walls {
        let _ = writeln!(text, "[[walls]]\npoints = [{from:?}, {to:?}]");
    }
    let mut world = World::parse(&text, "bench.toml", 1)?;
    let robot = world.add_robot("pioneer", RobotConfig::default())?;
    Ok((world, robot))
}

/// Casts prepared rays, so that of parry only the casting is measured.
fn cast(by: impl Fn(&Ray) -> Option<f64>, rays: &[Ray], ranges: &mut [f32]) {
    for (range, ray) in ranges.iter_mut().zip(black_box(rays)) {
        *range = by(ray).map_or(f32::INFINITY, |hit| hit as f32);
    }
    black_box(ranges);
}

/// The walls in a tree of the kind that parry uses for casting rays. The simulator uses the same kind.
struct Tree {
    segments: Vec<Segment>,
    boxes: Bvh,
}

impl Tree {
    fn of(walls: &[[[f64; 2]; 2]]) -> Self {
        let segments: Vec<Segment> = walls
            .iter()
            .map(|wall| {
                let [from, to] = wall.map(|point| Vector::new(point[0], point[1]));
                Segment::new(from, to)
            })
            .collect();
        let leaves = segments.iter().map(Segment::local_aabb).enumerate();
        let boxes = Bvh::from_iter(BvhBuildStrategy::Ploc, leaves);
        Self { segments, boxes }
    }

    fn cast(&self, ray: &Ray, most: f64) -> Option<f64> {
        let segment = |index: u32, best| self.segments[index as usize].cast_local_ray(ray, best, true);
        self.boxes.cast_ray(ray, most, segment).map(|(_, hit)| hit)
    }
}

/// The walls in parry's shape for many segments, which has its own tree.
fn polyline(walls: &[[[f64; 2]; 2]]) -> Polyline {
    let points = walls
        .iter()
        .flatten()
        .map(|point| Vector::new(point[0], point[1]));
    let indices = (0..walls.len() as u32).map(|wall| [2 * wall, 2 * wall + 1]);
    Polyline::new(points.collect(), Some(indices.collect()))
}

/// The input of the ir-sim program.
#[derive(Serialize)]
struct ScanRequest<'a> {
    walls: &'a [[[f64; 2]; 2]],
    at: [f64; 2],
    beams: usize,
    degrees: f64,
    range: f64,
    seconds: f64,
}

/// The output of the ir-sim program.
#[derive(Deserialize)]
struct ScanResult {
    scan_ns: f64,
    /// Beams without an echo have the greatest range.
    ranges: Vec<f32>,
}

/// Returns the time of one scan of ir-sim from a pose, ns. Checks it against the given ranges.
fn ir_sim(
    scope: &Scope,
    python: &Path,
    walls: &[[[f64; 2]; 2]],
    laser: &LaserConfig,
    at: &Pose2,
    ours: &[f32],
) -> Result<f64> {
    let request = ScanRequest {
        walls,
        at: [at.x, at.y],
        beams: laser.beams,
        degrees: laser.field_of_view.to_degrees(),
        range: laser.range_max,
        seconds: scope.either(0.5, 3.0),
    };
    let mut command = Command::new(python);
    command.arg(scope.root.join("benches/peers/ir_sim.py"));
    let output = product::run_with_input(&mut command, &serde_json::to_string(&request)?)?;
    let scanned: ScanResult = serde_json::from_str(&output)?;
    check_most_ranges(ours, &scanned.ranges, laser.range_max as f32)?;
    Ok(scanned.scan_ns)
}

/// The fields of the summary of `jde demo --json` that this row uses.
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
        let output = product::read(&mut command)?;
        let last = output.lines().last().context("`jde demo` printed nothing")?;
        let summary: Summary = serde_json::from_str(last)?;
        speeds.push(summary.sim_seconds / summary.wall_seconds);
    }
    Ok(vec![Line::alone(
        "demonstration in lockstep, picture and decisions included",
        Figure::Speed(Rounds::of(speeds).median()),
        Goal::Least(Figure::Speed(500.0)),
    )])
}
