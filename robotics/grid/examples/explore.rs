//! Times for which an ideal robot explores a map, to compare those of real drives with: it drives at full speed along the shortest
//! way, turns on the spot at the start of each, and has a laser without errors at every step.
//!
//! ```sh
//! cargo run -p jde-sim --example map -- worlds/office.toml target/office 0.1
//! cargo run -p jde-grid --example explore -- target/office.yaml 3.55 1.6
//! ```
//!
//! The first line is "nearest frontier with perfect knowledge": ways lead over the whole map, and a frontier counts only if there is
//! floor behind it. The others know what they have seen, and choose by the length of the way less a gain for each metre of the
//! frontier.

use std::error::Error;
use std::path::Path;

use jde_grid::{
    Cell, Costmap, Field, Geometry, Inflation, Occupancy, OccupancyGrid, Prices, Unknown, frontiers,
    nearest_open, walk,
};

/// The robot: its radius with a margin, m, speed and turn rate of `drive/path`, m/s and rad/s.
const RADIUS: f64 = 0.25;
const SPEED: f64 = 0.4;
const TURN: f64 = 0.87;
/// The laser: its range, m, and the beams all around.
const RANGE: f64 = 12.0;
const BEAMS: u32 = 720;
/// The least length of a frontier, m.
const MIN_FRONTIER_SIZE: f64 = 0.5;
/// How near the last target a frontier must be to be the same, m.
const SAME_FRONTIER_DISTANCE: f64 = 0.5;
/// How near its target a robot turns to the next one, m.
const REACHED: f64 = 0.3;
const GAINS: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0];

/// A cell of a frontier, and the way there.
type Aim = (Cell, Vec<Cell>);

struct Drive<'a> {
    truth: &'a OccupancyGrid,
    known: OccupancyGrid,
    robot: Cell,
    heading: f64,
    time: f64,
    way: f64,
    targets: u32,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, x, y] = arguments.as_slice() else {
        return Err("explore MAP X Y".into());
    };
    let map = jde_map_file::MapFile::load(Path::new(file))?;
    let [left, low, heading] = map.origin;
    let geometry = Geometry::new(
        map.width as u32,
        map.height as u32,
        map.resolution,
        (left, low, heading),
    )?;
    let mut truth = OccupancyGrid::filled(geometry, Occupancy::Unknown);
    for (index, cell) in map.cells.iter().enumerate() {
        truth.set(geometry.cell(index), Occupancy::from_ros(cell.to_ros()));
    }
    let start = geometry
        .cell_at((x.parse()?, y.parse()?))
        .ok_or("the start is outside")?;
    println!("perfect knowledge: {}", explore(&truth, start, None)?);
    for gain in GAINS {
        println!(
            "gain {gain:3.1}:          {}",
            explore(&truth, start, Some(gain))?
        );
    }
    Ok(())
}

/// Returns what it took to explore, by the nearest frontier with perfect knowledge or with a gain.
fn explore(truth: &OccupancyGrid, start: Cell, gain: Option<f64>) -> Result<String, Box<dyn Error>> {
    let mut drive = Drive {
        truth,
        known: OccupancyGrid::filled(*truth.geometry(), Occupancy::Unknown),
        robot: start,
        heading: 0.0,
        time: 0.0,
        way: 0.0,
        targets: 0,
    };
    drive.observe();
    // A target is given up if nothing new is seen on the way to it.
    let mut given_up = Vec::new();
    while let Some((target, way)) = drive.choose(gain, &given_up)? {
        drive.targets += 1;
        if !drive.follow(&way, target) {
            given_up.push(target);
        }
    }
    let Drive {
        time, way, targets, ..
    } = drive;
    Ok(format!(
        "{time:6.1} s, {way:6.1} m, {targets} targets, {} given up",
        given_up.len()
    ))
}

impl Drive<'_> {
    /// Chooses a frontier, and returns a cell of it and the way there.
    fn choose(&self, gain: Option<f64>, given_up: &[Cell]) -> Result<Option<Aim>, Box<dyn Error>> {
        let resolution = self.truth.geometry().resolution();
        let known = if gain.is_some() { &self.known } else { self.truth };
        let costs = Costmap::new(known, &Inflation::circle(RADIUS))?;
        let prices = Prices::new(0.0, Unknown::Closed);
        let start = nearest_open(&costs, &prices, self.robot, 5.0).ok_or("the robot is in an obstacle")?;
        let mut field = Field::new(&costs, &prices, start)?;
        field.settle();
        let mut best: Option<(f64, Cell)> = None;
        for mut cells in frontiers(&self.known) {
            cells.retain(|&cell| {
                let is_given_up = given_up
                    .iter()
                    .any(|&past| cell.distance(past) * resolution <= 1.0);
                field.price(cell).is_some() && !is_given_up && (gain.is_some() || self.has_floor_behind(cell))
            });
            let size = cells.len() as f64 * resolution;
            if size < MIN_FRONTIER_SIZE {
                continue;
            }
            let mean = |pick: fn(&Cell) -> u32| {
                cells.iter().map(|cell| f64::from(pick(cell))).sum::<f64>() / cells.len() as f64
            };
            let middle = Cell::new(mean(|cell| cell.x) as u32, mean(|cell| cell.y) as u32);
            let by = |cell: &&Cell| {
                if gain.is_some() {
                    cell.distance(middle)
                } else {
                    field.price(**cell).unwrap_or(f64::INFINITY)
                }
            };
            let target = cells.iter().min_by(|a, b| by(a).total_cmp(&by(b))).copied();
            let Some((target, price)) = target.and_then(|cell| Some((cell, field.price(cell)?))) else {
                continue;
            };
            let cost = price * resolution - gain.unwrap_or(0.0) * size;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, target));
            }
        }
        let Some((_, target)) = best else { return Ok(None) };
        let mut way: Vec<Cell> = field
            .route(target)?
            .points
            .iter()
            .map(|&(x, y)| Cell::new(x as u32, y as u32))
            .collect();
        way.reverse();
        way.dedup();
        Ok(Some((target, way)))
    }

    /// Whether an unknown cell beside it is floor.
    fn has_floor_behind(&self, cell: Cell) -> bool {
        [(1, 0), (0, 1), (-1, 0), (0, -1)].iter().any(|&(x, y)| {
            cell.offset(x, y).is_some_and(|next| {
                self.known.get(next) == Occupancy::Unknown && self.truth.get(next) == Occupancy::Free
            })
        })
    }

    /// Drives along a way until the frontier at its end is seen. Returns whether anything new was seen.
    fn follow(&mut self, way: &[Cell], target: Cell) -> bool {
        let resolution = self.truth.geometry().resolution();
        let mut has_seen = false;
        if let Some(ahead) = way.get(way.len().min(6) - 1) {
            let to = (f64::from(ahead.y) - f64::from(self.robot.y))
                .atan2(f64::from(ahead.x) - f64::from(self.robot.x));
            let turn = (to - self.heading).sin().atan2((to - self.heading).cos());
            self.time += turn.abs() / TURN;
            self.heading = to;
        }
        for &next in way {
            let step = self.robot.distance(next) * resolution;
            if step > 0.0 {
                self.heading = (f64::from(next.y) - f64::from(self.robot.y))
                    .atan2(f64::from(next.x) - f64::from(self.robot.x));
            }
            self.way += step;
            self.time += step / SPEED;
            self.robot = next;
            if self.observe() {
                has_seen = true;
                let is_open = |cell: Cell| {
                    cell.distance(target) * resolution <= SAME_FRONTIER_DISTANCE
                        && self.known.get(cell) == Occupancy::Free
                };
                if !frontiers(&self.known).into_iter().flatten().any(is_open) {
                    break;
                }
            }
            if next.distance(target) * resolution <= REACHED {
                break;
            }
        }
        has_seen
    }

    /// Adds what the laser sees to the known map. Returns whether anything is new.
    fn observe(&mut self) -> bool {
        let geometry = *self.truth.geometry();
        let (x, y) = geometry.center(self.robot);
        let mut is_new = false;
        for beam in 0..BEAMS {
            let angle = f64::from(beam) / f64::from(BEAMS) * core::f64::consts::TAU;
            let end = |range: f64| geometry.cell_at((x + range * angle.cos(), y + range * angle.sin()));
            // A beam that leaves the map is shortened.
            let mut ranges = core::iter::successors(Some(RANGE), |range| Some(range - geometry.resolution()));
            let Some(last) = ranges.find_map(end) else {
                continue;
            };
            walk(self.robot, last, |cell, _| {
                let state = match self.truth.get(cell) {
                    Occupancy::Free => Occupancy::Free,
                    Occupancy::Occupied | Occupancy::Unknown => Occupancy::Occupied,
                };
                is_new |= self.known.set(cell, state);
                state == Occupancy::Free
            });
        }
        is_new
    }
}
