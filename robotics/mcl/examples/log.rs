//! Localizes a robot in a laser log with raw odometry, on a map of other scans of the same building: how far the pose is
//! from the true one, how often the robot is found anywhere, and what happens when it is carried away.
//!
//! `cargo run --release -p jde-mcl --example log -- ODOMETRY GRAPH [beam]`
//!
//! ODOMETRY has a line `ODO dx dy dtheta` for each motion in the frame of the base and `SCAN` with ranges for each scan.
//! GRAPH has a line `VERTEX2 id x y theta` for each optimized pose, and `ROBOTLASER1` with the ranges for its scan, from
//! right to left. Scans that are in both have a true pose. They are left out of the map. Times are processor time.

use std::collections::HashMap;
use std::error::Error;
use std::time::Duration;

use jde_grid::{OccupancyGrid, Ray, RollingGrid};
use jde_mcl::{Beams, LikelihoodField, Localizer, Model, MotionNoise, Sensor, Settings, State};
use jde_types::{LaserScan, Pose2D, normalize_angle};
use rustix::time::{ClockId, clock_gettime};

/// Ranges from here on are no returns, m.
const NO_RETURN: f32 = 29.0;
const PARTICLES: usize = 2000;
const BEAMS: usize = 60;
const SEEDS: u64 = 20;
/// The places from which it is searched.
const STARTS: usize = 100;

struct Record {
    scan: LaserScan,
    odometry: Pose2D,
    truth: Option<Pose2D>,
}

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [odometry, graph, model @ ..] = arguments.as_slice() else {
        return Err("usage: log ODOMETRY GRAPH [beam]".into());
    };
    let model = if model.is_empty() {
        Model::LikelihoodField
    } else {
        Model::Beam
    };
    let vertices = read_graph(&std::fs::read_to_string(graph)?)?;
    let (records, used) = read_odometry(&std::fs::read_to_string(odometry)?, &vertices)?;
    let known: Vec<usize> = (0..records.len())
        .filter(|&at| records[at].truth.is_some())
        .collect();
    if known.len() < STARTS {
        return Err(format!(
            "{} scans of {odometry} are in {graph}: {STARTS} are needed",
            known.len()
        )
        .into());
    }
    let map = map(vertices
        .iter()
        .zip(&used)
        .filter(|(_, used)| !**used)
        .map(|(vertex, _)| vertex))?;
    println!(
        "{} scans, {} with a true pose; a map of {} other scans",
        records.len(),
        known.len(),
        vertices.len() - used.iter().filter(|used| **used).count()
    );
    let field = LikelihoodField::new(&map);
    let settings = settings(model);
    track(&records, &field, &settings, known[0]);
    find(&records, &field, &settings, &known);
    kidnap(&records, &field, &settings, &known)
}

/// The odometry of the log errs by 3 degrees and 7 cm from scan to scan.
fn settings(model: Model) -> Settings {
    Settings {
        motion: MotionNoise {
            turn_by_turn: 0.2,
            turn_by_way: 0.1,
            way_by_way: 0.15,
            way_by_turn: 0.05,
        },
        sensor: Sensor {
            model,
            ..Sensor::default()
        },
        search_step: usize::MAX,
        ..Settings::default()
    }
}

fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// A drive through the records from `first` on, one step each.
struct Drive<'a> {
    localizer: Localizer,
    beams: Beams,
    records: &'a [Record],
    at: usize,
    /// What the robot's odometry says, when it has been carried away.
    carried: Pose2D,
    times: Vec<Duration>,
}

impl<'a> Drive<'a> {
    fn new(records: &'a [Record], field: &LikelihoodField, first: usize, seed: u64) -> Self {
        Self {
            localizer: Localizer::new(field.clone(), PARTICLES, seed),
            beams: Beams::new(BEAMS),
            records,
            at: first,
            carried: Pose2D::ORIGIN,
            times: Vec::new(),
        }
    }

    /// Takes the next record. Returns what is known and the error, m and rad.
    fn step(&mut self, settings: &Settings) -> Option<(State, Option<(f64, f64)>)> {
        let record = self.records.get(self.at)?;
        self.at += 1;
        let odometry = self.carried.transform(&record.odometry);
        let begin = processor_time();
        let seen = self.beams.update(&record.scan, |_| Pose2D::ORIGIN);
        let state = match seen {
            Ok(()) => self.localizer.step(settings, &odometry, &self.beams),
            Err(_) => State::Unsure(jde_mcl::Doubt::Unseen),
        };
        let state = self.localizer.search(settings).unwrap_or(state);
        self.times.push(processor_time() - begin);
        let pose = self.localizer.pose(&odometry);
        let error = record.truth.zip(pose).map(|(truth, pose)| {
            (
                pose.distance_to(&truth),
                normalize_angle(pose.theta - truth.theta).abs(),
            )
        });
        Some((state, error))
    }

    /// The robot is at another record now, and its odometry noticed nothing.
    fn carry(&mut self, to: usize) {
        let odometry = self.carried.transform(&self.records[self.at - 1].odometry);
        self.at = to;
        let back = self.records[to].odometry.localize(&Pose2D::ORIGIN);
        self.carried = odometry.transform(&back);
    }
}

/// From the true pose of the first scan that has one, to the end.
fn track(records: &[Record], field: &LikelihoodField, settings: &Settings, first: usize) {
    let (mut lost, mut unsure, mut steps, mut particles) = (0, 0, 0, 0);
    let (mut squares, mut turns, mut count, mut worst) = (0.0, 0.0, 0.0, 0.0_f64);
    let mut times = Vec::new();
    for seed in 0..SEEDS {
        let mut drive = Drive::new(records, field, first, seed);
        if let Some(truth) = records[first].truth {
            drive.localizer.start_at(&truth, 0.1, 0.1);
        }
        let mut farthest = 0.0_f64;
        let mut of_seed = (0.0, 0.0);
        while let Some((state, error)) = drive.step(settings) {
            steps += 1;
            particles += drive.localizer.particles();
            unsure += usize::from(state != State::Sure);
            if let Some((away, turned)) = error {
                squares += away * away;
                turns += turned * turned;
                count += 1.0;
                of_seed = (of_seed.0 + away * away, of_seed.1 + 1.0);
                farthest = farthest.max(away);
            }
        }
        lost += usize::from(farthest > 1.0);
        worst = worst.max(farthest);
        times.append(&mut drive.times);
        println!(
            "  seed {seed}: {:.3} m, worst {farthest:.2} m",
            f64::sqrt(of_seed.0 / of_seed.1)
        );
    }
    times.sort_unstable();
    println!(
        "tracking, {SEEDS} seeds: {lost} lost; rmse {:.3} m and {:.2} degrees, worst {worst:.2} m; not sure at {unsure} of {steps} \
         steps; {} particles on average; {:?} a step on average, {:?} at most",
        f64::sqrt(squares / count),
        f64::sqrt(turns / count).to_degrees(),
        particles / steps,
        times.iter().sum::<Duration>() / times.len() as u32,
        times.last().copied().unwrap_or_default()
    );
}

/// From a hundred places without a pose, until it is sure.
fn find(records: &[Record], field: &LikelihoodField, settings: &Settings, known: &[usize]) {
    let (mut found, mut wrong, mut scans, mut longest) = (0, 0, Vec::new(), Duration::ZERO);
    for number in 0..STARTS {
        let first = known[number * known.len() / STARTS];
        let mut drive = Drive::new(records, field, first, number as u64);
        drive.localizer.start_anywhere();
        let mut sure_since = None;
        // The first true pose of a scan at which it is sure.
        while let Some((state, error)) = drive.step(settings) {
            let is_sure = state == State::Sure;
            if is_sure {
                sure_since.get_or_insert(drive.at - first);
            }
            if let (true, Some((away, _))) = (is_sure, error) {
                if away < 0.5 {
                    found += 1;
                    scans.extend(sure_since);
                } else {
                    wrong += 1;
                    println!("  wrong: from scan {first}, sure after {sure_since:?} scans, {away:.2} m away");
                }
                break;
            }
        }
        longest = longest.max(drive.times.iter().max().copied().unwrap_or_default());
    }
    scans.sort_unstable();
    println!(
        "found anywhere: {found} of {STARTS}, wrong {wrong}; sure after {} scans at the median, {} at most; longest step {longest:?}",
        scans.get(scans.len() / 2).unwrap_or(&0),
        scans.last().unwrap_or(&0)
    );
}

/// Carried 50 times to a place at least 10 m away, until it is sure there.
fn kidnap(
    records: &[Record],
    field: &LikelihoodField,
    settings: &Settings,
    known: &[usize],
) -> Result<(), Failure> {
    let (mut found, mut wrong, mut silent, mut wrong_steps) = (0, 0, Vec::new(), 0);
    for number in 0..50 {
        let mut random = fastrand::Rng::with_seed(number);
        let mut pick = || known[random.usize(..known.len() * 9 / 10)];
        let pairs = (0..10_000).map(|_| (pick(), pick()));
        let is_far = |&(first, to): &(usize, usize)| {
            let truths = records[first].truth.zip(records[to].truth);
            truths.is_some_and(|(from, to)| from.distance_to(&to) > 10.0)
        };
        let pair = { pairs }.find(is_far);
        let (first, to) = pair.ok_or("no two scans are 10 m from each other")?;
        let mut drive = Drive::new(records, field, first, number);
        if let Some(truth) = records[first].truth {
            drive.localizer.start_at(&truth, 0.1, 0.1);
        }
        for _ in 0..20 {
            drive.step(settings);
        }
        drive.carry(to);
        let (mut lost, mut steps) = (false, 0);
        while let Some((state, error)) = drive.step(settings) {
            steps += 1;
            lost |= state != State::Sure;
            wrong_steps += usize::from(state == State::Sure && !lost);
            if let (State::Sure, Some((away, _)), true) = (state, error, lost) {
                if away < 0.5 {
                    found += 1;
                    silent.push(steps);
                } else {
                    wrong += 1;
                    println!("  wrong: carried to {to}, {steps} scans, {away:.2} m away");
                }
                break;
            }
        }
    }
    silent.sort_unstable();
    println!(
        "carried away: {found} of 50 found again, wrong {wrong}; sure at the old place for {:.1} scans on average; found after {} \
         scans at the median, {} at most",
        f64::from(wrong_steps as u32) / 50.0,
        silent.get(silent.len() / 2).unwrap_or(&0),
        silent.last().unwrap_or(&0)
    );
    Ok(())
}

/// A map with cells of 5 cm.
fn map<'a>(
    vertices: impl Iterator<Item = &'a (Pose2D, LaserScan)> + Clone,
) -> Result<OccupancyGrid, Failure> {
    let places = vertices.clone().map(|(pose, _)| pose);
    let bound = |pick: fn(&Pose2D) -> f64| {
        let (low, high) = places
            .clone()
            .map(pick)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
        (f64::midpoint(low, high), high - low)
    };
    let ((x, wide), (y, high)) = (bound(|pose| pose.x), bound(|pose| pose.y));
    let side = (2.0 * wide.max(high) / 0.05) as u32;
    let mut grid = RollingGrid::new(side, 0.05)?;
    grid.follow((x, y))?;
    for (pose, scan) in vertices {
        let rays = scan.rays(pose).map(|(end, hit)| Ray {
            end: (end.x, end.y),
            hit,
        });
        grid.observe((pose.x, pose.y), rays, Duration::ZERO);
    }
    let mut data = vec![0; grid.geometry().cells()];
    grid.write_ros(Duration::ZERO, Duration::MAX, &mut data);
    Ok(OccupancyGrid::from_ros(*grid.geometry(), &data)?)
}

fn scan(ranges: &[f32]) -> Result<LaserScan, Failure> {
    let mut scan = LaserScan {
        angle_min: -core::f32::consts::FRAC_PI_2,
        angle_increment: core::f32::consts::PI / 180.0,
        range_min: 0.1,
        range_max: NO_RETURN,
        ..LaserScan::default()
    };
    let finite = |&range: &f32| if range < NO_RETURN { range } else { f32::NAN };
    for range in ranges.iter().map(finite) {
        scan.ranges.push(range).map_err(|_| "too many beams")?;
    }
    scan.state_last_angle();
    Ok(scan)
}

/// The first numbers of a line.
fn numbers<const COUNT: usize>(line: &str) -> Result<[f64; COUNT], Failure> {
    let words = line.split_whitespace().take(COUNT);
    let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
    let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| format!("`{line}` does not begin with {COUNT} numbers").into())
}

/// The optimized poses and their scans.
fn read_graph(text: &str) -> Result<Vec<(Pose2D, LaserScan)>, Failure> {
    let mut pose = Pose2D::ORIGIN;
    let mut vertices = Vec::new();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("VERTEX2 ") {
            let [_, x, y, theta] = numbers(rest)?;
            pose = Pose2D::new(x, y, theta);
        } else if let Some(rest) = line.strip_prefix("ROBOTLASER1 ") {
            // Eight parameters, of which the last is the number of ranges.
            let words: Vec<&str> = rest.split_whitespace().collect();
            let count: usize = words.get(7).ok_or("a scan without ranges")?.parse()?;
            let ranges: Result<Vec<f32>, _> = words
                .iter()
                .skip(8)
                .take(count)
                .map(|word| word.parse())
                .collect();
            let ranges = ranges?;
            vertices.push((pose, scan(&ranges)?));
        }
    }
    Ok(vertices)
}

/// The records, and which vertices have the same scan as one of them.
fn read_odometry(text: &str, vertices: &[(Pose2D, LaserScan)]) -> Result<(Vec<Record>, Vec<bool>), Failure> {
    let key = |scan: &LaserScan| -> Vec<i32> {
        scan.ranges
            .iter()
            .map(|range| (range * 100.0).round() as i32)
            .collect()
    };
    let by_scan: HashMap<Vec<i32>, usize> = vertices
        .iter()
        .enumerate()
        .map(|(at, (_, scan))| (key(scan), at))
        .collect();
    let (mut odometry, mut records, mut used) = (Pose2D::ORIGIN, Vec::new(), vec![false; vertices.len()]);
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("ODO ") {
            let [x, y, theta] = numbers(rest)?;
            odometry = odometry.transform(&Pose2D::new(x, y, theta));
        } else if let Some(rest) = line.strip_prefix("SCAN ") {
            // Time, field of view, greatest range, number, and two words.
            let ranges: Result<Vec<f32>, _> = rest.split_whitespace().skip(6).map(str::parse).collect();
            let scan = scan(&ranges?)?;
            let vertex = by_scan.get(&key(&scan)).copied();
            if let Some(vertex) = vertex {
                used[vertex] = true;
            }
            records.push(Record {
                scan,
                odometry,
                truth: vertex.map(|vertex| vertices[vertex].0),
            });
        }
    }
    Ok((records, used))
}
