//! Maps a laser log, and compares the poses of its scans with relations between them (Kuemmerle et al., "On measuring the
//! accuracy of SLAM algorithms", 2009): the mean error of each relation in position and heading.
//!
//! `cargo run --release -p jde-slam --example relations -- GRAPH [ODOMETRY] [--map FILE] [--laser X] [--seed N]
//! [--rawlog FILE | --poses FILE]`
//!
//! GRAPH has a line `VERTEX2 id x y theta` for each pose, `ROBOTLASER1` with the ranges for its scan, from right to left, and
//! `EDGE2 from to dx dy dtheta` for each relation, after `#SEQUENTIAL` and after `#LOOP`. ODOMETRY has a line
//! `ODO dx dy dtheta` for each motion in the frame of the base and `SCAN` with ranges for each scan; those of its scans that
//! are in GRAPH too have relations. Without ODOMETRY, it is made of the poses of GRAPH with noise: 10 % of the way, 10 % of
//! turns, and 5 degrees/m, five seeds or the one of `--seed`. The map is written as PGM; X is where the laser is on the base, m.
//! Times are processor time.
//!
//! For other programs, `--rawlog` writes the scans and the odometry in the form of MRPT instead of mapping them, and `--poses`
//! compares the poses of a file instead, which has a line `scan x y theta ..` for each of them.

mod rawlog;

use std::collections::HashMap;
use std::error::Error;
use std::time::Duration;

use jde_slam::{Guess, MapDrawing, Scan, Settings, Slam, State, Surface};
use jde_types::{LaserScan, Pose2D, normalize_angle};
use rustix::time::{ClockId, clock_gettime};

/// The most beams of a scan.
const BEAMS: usize = 360;
/// What is farther away is left out, m.
const REACH: f64 = 20.0;
/// Standard deviations of the odometry that is made: m/m, rad/rad and rad/m.
const NOISE: (f64, f64, f64) = (0.1, 0.1, 0.087);
const SEEDS: u64 = 5;
/// How often the work behind the scans goes on between two of them: they are about a second apart, and a schema iterates more
/// often than this.
const BEHIND: usize = 10;

const USAGE: &str = "GRAPH [ODOMETRY] [--map FILE] [--laser X] [--seed N] [--rawlog FILE | --poses FILE]";

type Failure = Box<dyn Error>;

struct Relation {
    from: usize,
    to: usize,
    pose: Pose2D,
    is_loop: bool,
}

/// A scan, the pose of the odometry, and the number of the vertex.
struct Record {
    scan: LaserScan,
    odometry: Pose2D,
    vertex: Option<usize>,
}

struct Log {
    vertices: Vec<(Pose2D, LaserScan)>,
    relations: Vec<Relation>,
}

fn main() -> Result<(), Failure> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut option = |name: &str| {
        let at = arguments.iter().position(|word| word == name)?;
        arguments.remove(at);
        (at < arguments.len()).then(|| arguments.remove(at))
    };
    let (map, rawlog, poses) = (option("--map"), option("--rawlog"), option("--poses"));
    let laser = option("--laser").map_or(Ok(0.0), |number| number.parse())?;
    let seeds = match option("--seed").map(|number| number.parse()).transpose()? {
        Some(seed) => seed..seed + 1,
        None => 0..SEEDS,
    };
    let (graph, odometry) = match arguments.as_slice() {
        [graph] => (graph, None),
        [graph, odometry] => (graph, Some(odometry)),
        _ => return Err(format!("usage: relations {USAGE}").into()),
    };
    let log = read_graph(&std::fs::read_to_string(graph)?)?;
    if let Some(file) = poses {
        let poses = read_poses(&std::fs::read_to_string(file)?)?;
        compare(&log, |vertex| poses.get(&vertex).copied());
        return Ok(());
    }
    let runs = match odometry {
        Some(odometry) => vec![read_odometry(&std::fs::read_to_string(odometry)?, &log)?],
        None => seeds.map(|seed| disturbed(&log, seed)).collect(),
    };
    if let Some(file) = rawlog {
        return match runs.as_slice() {
            [records] => Ok(std::fs::write(file, rawlog::rawlog(records, laser))?),
            _ => Err("--rawlog needs --seed".into()),
        };
    }
    pairs(&log);
    for records in runs {
        run(&log, &records, laser, map.as_deref())?;
    }
    Ok(())
}

fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

fn run(log: &Log, records: &[Record], x: f64, map: Option<&str>) -> Result<(), Failure> {
    let settings = Settings {
        way_by_way: 0.15,
        turn_by_turn: 0.2,
        turn_by_way: 0.1,
        ..Settings::default()
    };
    let mut slam = Slam::new(Pose2D::ORIGIN);
    let mut anchors = HashMap::new();
    let (mut differ, mut steps, mut times) = (0, Vec::new(), Vec::new());
    for record in records {
        let begin = processor_time();
        let scan = Scan::new(&record.scan, |_| Pose2D::new(x, 0.0, 0.0), BEAMS, REACH);
        let state = slam.step(&settings, &record.odometry, &scan);
        steps.push(processor_time() - begin);
        differ += usize::from(!matches!(state, State::Fits(_)));
        if let (Some(vertex), Some(anchor)) = (record.vertex, slam.anchor(&record.odometry)) {
            anchors.insert(vertex, anchor);
        }
        for _ in 0..BEHIND {
            let begin = processor_time();
            slam.advance(&settings);
            times.push(processor_time() - begin);
        }
    }
    while !slam.graph().is_settled() {
        slam.advance(&settings);
    }
    steps.sort_unstable();
    times.sort_unstable();
    let sum = |times: &[Duration]| times.iter().sum::<Duration>();
    let loops: Vec<_> = slam.graph().loops().collect();
    println!(
        "{} scans, {} keyframes, {} edges that close loops, {} of them doubted; {differ} scans did not fit",
        records.len(),
        slam.scans().len(),
        loops.len(),
        loops.iter().filter(|edge| slam.graph().is_doubted(edge)).count(),
    );
    println!(
        "  a step: {:?} on average, {:?} at most; behind it: {:?} for each scan, {:?} at most at a time; {:?} in all",
        sum(&steps) / steps.len().max(1) as u32,
        steps.last().copied().unwrap_or_default(),
        sum(&times) / records.len().max(1) as u32,
        times.last().copied().unwrap_or_default(),
        sum(&steps) + sum(&times),
    );
    compare(log, |vertex| {
        anchors.get(&vertex).map(|anchor| slam.place(anchor))
    });
    map.map_or(Ok(()), |file| write_map(&slam, file))
}

/// Prints how far the poses of the scans are from the relations between them.
fn compare(log: &Log, place: impl Fn(usize) -> Option<Pose2D>) {
    for (kind, of) in [("successive", Some(false)), ("loops", Some(true)), ("all", None)] {
        let errors: Vec<(f64, f64)> = (log.relations.iter())
            .filter(|relation| of.is_none_or(|of| relation.is_loop == of))
            .filter_map(|relation| {
                let between = place(relation.from)?.localize(&place(relation.to)?);
                Some((
                    between.distance_to(&relation.pose),
                    normalize_angle(between.theta - relation.pose.theta)
                        .abs()
                        .to_degrees(),
                ))
            })
            .collect();
        let of = |pick: fn(&(f64, f64)) -> f64| {
            let values: Vec<f64> = errors.iter().map(pick).collect();
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let squares = values
                .iter()
                .map(|value| (value - mean) * (value - mean))
                .sum::<f64>();
            let most = values.iter().copied().fold(0.0, f64::max);
            (mean, (squares / values.len().max(1) as f64).sqrt(), most)
        };
        let (way, turn) = (of(|error| error.0), of(|error| error.1));
        println!(
            "  {} {kind}: {:.4} +- {:.4} m, most {:.3}; {:.3} +- {:.3} degrees, most {:.2}",
            errors.len(),
            way.0,
            way.1,
            way.2,
            turn.0,
            turn.1,
            turn.2
        );
    }
}

fn write_map(slam: &Slam, file: &str) -> Result<(), Failure> {
    let mut drawing = MapDrawing::new(slam, 0.05, 1.0)?;
    while !drawing.advance(slam, 100) {}
    let side = drawing.geometry().width();
    let mut cells = vec![0; drawing.geometry().cells()];
    drawing.write_ros(&mut cells);
    let shade = |cell: &i8| match cell {
        100 => 0,
        0 => 254,
        _ => 205,
    };
    let mut image = format!("P5 {side} {side} 255\n").into_bytes();
    for row in cells.chunks(side as usize).rev() {
        image.extend(row.iter().map(shade));
    }
    std::fs::write(file, image)?;
    Ok(())
}

/// How far the relations are from matches of their two scans alone that begin there, and these from matches the other way
/// round: the error of the relations, and that of matches. Of scans that overlap by 60 % and say where they are to 1 cm.
fn pairs(log: &Log) {
    let scan = |vertex: usize| Scan::new(&log.vertices[vertex].1, |_| Pose2D::ORIGIN, BEAMS, REACH);
    let fit = |from: &Scan, to: &Scan, pose: &Pose2D| {
        let guess = Guess {
            pose: *pose,
            information: [[0.0; 3]; 3],
        };
        Surface::new([(Pose2D::ORIGIN, from)], 0).refine(to.points(), pose, &guess)
    };
    for is_loop in [false, true] {
        let errors: Vec<(f64, f64)> = (log.relations.iter())
            .filter(|relation| relation.is_loop == is_loop)
            .filter_map(|relation| {
                let (from, to) = (scan(relation.from), scan(relation.to));
                let there = fit(&from, &to, &relation.pose)?;
                let back = fit(&to, &from, &there.pose.localize(&Pose2D::ORIGIN))?;
                let least = there.information[0][0].min(there.information[1][1]);
                let error = there.pose.distance_to(&relation.pose);
                let around = there.pose.transform(&back.pose).distance_to(&Pose2D::ORIGIN);
                (there.share > 0.6 && least > 1e4).then_some((error, around))
            })
            .collect();
        let mean = |pick: fn(&(f64, f64)) -> f64| errors.iter().map(pick).sum::<f64>() / errors.len() as f64;
        println!(
            "{} pairs of {}: {:.4} m from the relation, {:.4} m there and back",
            errors.len(),
            if is_loop { "loops" } else { "successive scans" },
            mean(|error| error.0),
            mean(|error| error.1)
        );
    }
}

/// The records of a graph with an odometry that errs.
fn disturbed(log: &Log, seed: u64) -> Vec<Record> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut normal = move || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let mut odometry = Pose2D::ORIGIN;
    let mut last = log.vertices.first().map_or(Pose2D::ORIGIN, |(pose, _)| *pose);
    let mut records = Vec::new();
    for (vertex, (pose, scan)) in log.vertices.iter().enumerate() {
        let motion = last.localize(pose);
        let (way, turn) = (motion.x.hypot(motion.y), motion.theta.abs());
        let (way_error, turn_error) = (NOISE.0 * way, NOISE.1 * turn + NOISE.2 * way);
        odometry = odometry.transform(&Pose2D::new(
            motion.x + way_error * normal(),
            motion.y + way_error * normal(),
            motion.theta + turn_error * normal(),
        ));
        last = *pose;
        records.push(Record {
            scan: *scan,
            odometry,
            vertex: Some(vertex),
        });
    }
    records
}

fn scan(first: f64, increment: f64, ranges: &[f32], no_return: f32) -> Result<LaserScan, Failure> {
    let mut scan = LaserScan {
        angle_min: first as f32,
        angle_increment: increment as f32,
        range_min: 0.1,
        range_max: no_return,
        ..LaserScan::default()
    };
    let finite = |&range: &f32| if range < no_return { range } else { f32::NAN };
    for range in ranges.iter().map(finite) {
        scan.ranges.push(range).map_err(|_| "too many beams")?;
    }
    scan.state_last_angle();
    Ok(scan)
}

fn numbers(line: &str) -> Result<Vec<f64>, Failure> {
    line.split_whitespace()
        .map(|word| word.parse().map_err(Failure::from))
        .collect()
}

fn read_graph(text: &str) -> Result<Log, Failure> {
    let mut log = Log {
        vertices: Vec::new(),
        relations: Vec::new(),
    };
    let (mut pose, mut is_loop) = (Pose2D::ORIGIN, false);
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("VERTEX2 ") {
            let values = numbers(rest)?;
            pose = Pose2D::new(values[1], values[2], values[3]);
        } else if let Some(rest) = line.strip_prefix("ROBOTLASER1 ") {
            // Eight parameters: kind, first angle, field of view, increment, greatest range, accuracy, mode, count.
            let words: Vec<&str> = rest.split_whitespace().collect();
            let number = |at: usize| words.get(at).ok_or("a scan without ranges");
            let count: usize = number(7)?.parse()?;
            let ranges: Result<Vec<f32>, _> = (words.iter().skip(8).take(count))
                .map(|word| word.parse())
                .collect();
            let scan = scan(number(1)?.parse()?, number(3)?.parse()?, &ranges?, 50.0)?;
            log.vertices.push((pose, scan));
        } else if let Some(rest) = line.strip_prefix("EDGE2 ") {
            let values = numbers(rest)?;
            log.relations.push(Relation {
                from: values[0] as usize,
                to: values[1] as usize,
                pose: Pose2D::new(values[2], values[3], values[4]),
                is_loop,
            });
        } else if line.starts_with("#LOOP") {
            is_loop = true;
        }
    }
    Ok(log)
}

fn read_poses(text: &str) -> Result<HashMap<usize, Pose2D>, Failure> {
    let pose = |line| match numbers(line)?.as_slice() {
        [scan, x, y, theta, ..] => Ok((*scan as usize, Pose2D::new(*x, *y, *theta))),
        _ => Err(format!("not a pose: {line}").into()),
    };
    text.lines().map(pose).collect()
}

fn read_odometry(text: &str, log: &Log) -> Result<Vec<Record>, Failure> {
    let key = |ranges: &[f32]| -> Vec<i32> {
        let rounded = |range: &f32| {
            if *range < 29.0 {
                (range * 100.0).round() as i32
            } else {
                -1
            }
        };
        ranges.iter().map(rounded).collect()
    };
    let by_scan: HashMap<Vec<i32>, usize> = (log.vertices.iter().enumerate())
        .map(|(at, (_, scan))| (key(&scan.ranges), at))
        .collect();
    let (mut odometry, mut records) = (Pose2D::ORIGIN, Vec::new());
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("ODO ") {
            let values = numbers(rest)?;
            odometry = odometry.transform(&Pose2D::new(values[0], values[1], values[2]));
        } else if let Some(rest) = line.strip_prefix("SCAN ") {
            // Time, field of view, greatest range, number, and two words.
            let ranges: Result<Vec<f32>, _> = rest.split_whitespace().skip(6).map(str::parse).collect();
            let scan = scan(
                -core::f64::consts::FRAC_PI_2,
                core::f64::consts::PI / 180.0,
                &ranges?,
                29.0,
            )?;
            let vertex = by_scan.get(&key(&scan.ranges)).copied();
            records.push(Record {
                scan,
                odometry,
                vertex,
            });
        }
    }
    let known = records.iter().filter(|record| record.vertex.is_some()).count();
    println!("{} scans, {known} of them in the graph", records.len());
    Ok(records)
}
