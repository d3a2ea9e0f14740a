//! Tracks the people of a world by the laser of a TurtleBot 4 there, and compares them with the true ones.
//!
//! `cargo run --release -p jde-people --example walkers -- WORLD ROBOT [MINUTES [SEED]]`, for example with
//! `worlds/people.toml robot 20`. The robot turns to and fro on the spot, and its odometry errs. A person counts while
//! at least four beams end at the person within the range of the detector, from two seconds after the person came into
//! view. A switch is another number than before, after at most three seconds out of view. Times are processor time.

use std::error::Error;
use std::time::Duration;

use jde_people::{Person, Tracker, TrackerSettings};
use jde_sim::{Figure, LaserConfig, Outline, Pose2, RobotId, RobotModel, Twist2, World};
use jde_types::{LaserScan, Pose2D};
use rustix::time::{ClockId, clock_gettime};

/// From scan to scan, ns.
const PERIOD: u64 = 100_000_000;
/// How far a tracked person may be from the true one, m.
const NEAR: f64 = 0.5;
/// The hits that make a person visible.
const HITS: usize = 4;
/// How long a person must have been visible to count, and may be hidden to be the same, s.
const VISIBLE: f64 = 2.0;
const HIDDEN: f64 = 3.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, robot, rest @ ..] = arguments.as_slice() else {
        return Err("usage: walkers WORLD ROBOT [MINUTES [SEED]]".into());
    };
    let number = |index: usize, default: u64| rest.get(index).map_or(Ok(default), |text| text.parse());
    let (minutes, seed) = (number(0, 20)?, number(1, 1)?);
    let model = RobotModel::load("robots/turtlebot4.toml")?;
    let laser = &model.lasers.first().ok_or("the robot has no laser")?.config;
    let mut world = World::load(file, seed)?;
    let robot = world.add_robot(robot, model.config)?;
    let (mut tracker, settings) = (Tracker::default(), TrackerSettings::default());
    let mut score = Score::default();
    let mut times = Vec::new();
    // The frame of the odometry begins where the robot starts; here it is that of the world.
    let start = world.truth(robot).pose;
    for step in 1..=minutes * 600 {
        let turn = if step / 100 % 2 == 0 { 0.5 } else { -0.5 };
        world.command(robot, Twist2::new(0.0, turn))?;
        world.advance_to(step * PERIOD);
        let scan = scan(&world, robot, laser)?;
        let sensor = start.compose(world.odometry(robot).pose).compose(laser.mount);
        let begin = processor_time();
        tracker.step(&settings, (step * PERIOD) as f64 * 1e-9, &pose(sensor), &scan)?;
        times.push(processor_time() - begin);
        let truth = pose(world.truth(robot).pose.compose(laser.mount));
        // Where the persons are in the world, since the drift of the odometry is no error of theirs.
        let place = |person: Person| {
            let [x, y] = person.position;
            let place = truth.transform(&pose(sensor).localize(&Pose2D::new(x, y, 0.0)));
            Person {
                position: [place.x, place.y],
                ..person
            }
        };
        let tracked = tracker.persons().map(place).collect();
        score.add(&world, (&truth, &scan), settings.detector.range, tracked);
    }
    score.print();
    times.sort();
    let mean = times.iter().sum::<Duration>() / times.len() as u32;
    println!("a step: mean {mean:?}, longest {:?}", times[times.len() - 1]);
    Ok(())
}

fn scan(world: &World, robot: RobotId, laser: &LaserConfig) -> Result<LaserScan, Box<dyn Error>> {
    let mut scan = LaserScan {
        angle_min: laser.angle_min() as f32,
        angle_increment: laser.angle_increment() as f32,
        range_min: laser.range_min as f32,
        range_max: laser.range_max as f32,
        ..LaserScan::default()
    };
    scan.ranges.resize(laser.beams);
    scan.state_last_angle();
    world.laser(robot, laser, scan.ranges.as_mut_slice())?;
    Ok(scan)
}

fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// How well the people are tracked.
#[derive(Default)]
struct Score {
    walkers: Vec<Walker>,
    /// The sum of the squares of the errors of those who are visible, m², and their number.
    squares: f64,
    matched: usize,
    /// How often somebody is tracked where nobody is.
    wrong: usize,
}

impl Score {
    /// Compares what is tracked with a world, as a laser sees it.
    fn add(&mut self, world: &World, seen: (&Pose2D, &LaserScan), range: f64, mut tracked: Vec<Person>) {
        let (sensor, scan) = seen;
        let place = |x: f64, y: f64| {
            let place = sensor.transform(&Pose2D::new(x, y, 0.0));
            [place.x, place.y]
        };
        let hits: Vec<[f64; 2]> = scan.points().map(|point| place(point.x, point.y)).collect();
        let people = world
            .shapes()
            .filter_map(|shape| match (shape.figure, shape.outline) {
                (Figure::Person { .. }, Outline::Circle { center, radius }) => Some((center, radius)),
                _ => None,
            });
        for (index, (center, radius)) in people.enumerate() {
            if self.walkers.len() == index {
                self.walkers.push(Walker::default());
            }
            let walker = &mut self.walkers[index];
            let own = hits.iter().filter(|hit| away(**hit, center) < radius);
            let is_visible = own.count() >= HITS && away([sensor.x, sensor.y], center) < range;
            let distance = |person: &Person| away(person.position, center);
            // Who was matched stays matched; otherwise the nearest one is.
            let rank = |person: &Person| (Some(person.id) != walker.id, distance(person));
            let near = (0..tracked.len()).filter(|&index| distance(&tracked[index]) < NEAR);
            let found = near.min_by(|&a, &b| {
                let (a, b) = (rank(&tracked[a]), rank(&tracked[b]));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            let found = found.map(|index| tracked.remove(index));
            walker.see(is_visible, found.map(|person| person.id), PERIOD as f64 * 1e-9);
            if let Some(person) = found.filter(|_| is_visible) {
                self.squares += distance(&person).powi(2);
                self.matched += 1;
            }
        }
        self.wrong += tracked.iter().filter(|person| person.unseen == 0.0).count();
    }

    fn print(&self) {
        let sum = |part: fn(&Walker) -> usize| self.walkers.iter().map(part).sum::<usize>();
        let (counted, missed) = (sum(|walker| walker.counted), sum(|walker| walker.missed));
        let share = |part: usize| 100.0 * part as f64 / counted.max(1) as f64;
        println!("{} people, counted {counted} times", self.walkers.len());
        println!("switches: {}", sum(|walker| walker.switches));
        println!("missed: {missed} ({:.2} %)", share(missed));
        println!("where nobody is: {} ({:.2} %)", self.wrong, share(self.wrong));
        let error = (self.squares / self.matched.max(1) as f64).sqrt();
        println!("error, root mean square: {error:.3} m");
    }
}

/// What became of a person.
#[derive(Default)]
struct Walker {
    id: Option<u32>,
    visible: f64,
    hidden: f64,
    counted: usize,
    missed: usize,
    switches: usize,
}

impl Walker {
    fn see(&mut self, is_visible: bool, id: Option<u32>, time: f64) {
        if !is_visible {
            self.hidden += time;
            if self.hidden > HIDDEN {
                (self.id, self.visible) = (None, 0.0);
            }
            return;
        }
        self.hidden = 0.0;
        self.visible += time;
        if self.visible < VISIBLE {
            return;
        }
        self.counted += 1;
        self.missed += usize::from(id.is_none());
        if let Some(id) = id {
            self.switches += usize::from(self.id.is_some_and(|before| before != id));
            self.id = Some(id);
        }
    }
}

fn pose(pose: Pose2) -> Pose2D {
    Pose2D::new(pose.x, pose.y, pose.heading)
}

fn away(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
