//! Compares the gradient field with the navigation function of nav2 on a ROS map: the times of full plans, what the
//! ways cost by navfn's own costs, and the repair of the field after a change of a hundred cells.
//!
//! ```sh
//! cargo run --release -p jde-grid --example navfn -- MAP.yaml COSTS.pgm PAIRS.txt
//! g++ -O3 -DNDEBUG -I NAV2/nav2_navfn_planner/include -I STUBS robotics/grid/examples/navfn.cc \
//!     NAV2/nav2_navfn_planner/src/navfn.cpp -o navfn && ./navfn COSTS.pgm PAIRS.txt RESULTS.txt
//! cargo run --release -p jde-grid --example navfn -- MAP.yaml COSTS.pgm PAIRS.txt RESULTS.txt
//! ```
//!
//! The first command writes the costs, as nav2's default parameters inflate the map, and a hundred pairs as its
//! benchmark draws them: `start_x start_y goal_x goal_y`, one pair a line, in columns and rows. The second plans;
//! the head of `navfn.cc` names the two stub headers. Its results have for each pair a line
//! `milliseconds x y x y ...`, in columns and rows with fractions; without points there was no way. All times are
//! processor time.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use jde_grid::costmap::UNKNOWN;
use jde_grid::{Cell, Costmap, Field, Geometry, Inflation, Occupancy, OccupancyGrid, Point, Prices, Unknown};
use jde_map_file::MapFile;
use rustix::time::{ClockId, clock_gettime};

/// The default parameters of nav2's global costmap.
const INFLATION: Inflation = Inflation {
    inscribed: 0.22,
    circumscribed: 0.22,
    reach: 0.7,
    decay: 3.0,
};
/// navfn's cost of a cell without a cost, and by how much one of the costmap raises it.
const NEUTRAL: f64 = 50.0;
const FACTOR: f64 = 0.8;
/// How nav2's benchmark draws pairs: their number, their distance to the edge of the map in cells and to each other
/// in metres, and the costs that both ends stay below.
const PAIRS: usize = 100;
const MARGIN: u32 = 100;
const LEAST_DISTANCE: f64 = 3.0;
const MAX_COST: u8 = 210;

type Result<T> = core::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [map, costs_file, pairs_file, results @ ..] = arguments.as_slice() else {
        return Err("usage: navfn MAP.yaml COSTS.pgm PAIRS.txt [RESULTS.txt]".into());
    };
    let mut grid = read_map(map.as_ref())?;
    let costs = Costmap::new(&grid, &INFLATION)?;
    let Some(results) = results.first() else {
        write_costs(&costs, costs_file)?;
        return write_pairs(&costs, pairs_file);
    };
    let pairs = read_pairs(&std::fs::read_to_string(pairs_file)?)?;
    let theirs = read_results(&std::fs::read_to_string(results)?)?;
    if pairs.len() != theirs.len() {
        return Err(format!("{} pairs and {} results", pairs.len(), theirs.len()).into());
    }
    compare_plans(&costs, &pairs, &theirs)?;
    measure_repairs(&mut grid, costs, &pairs)
}

/// navfn's costs as prices: 1 to 1 + 0.8 · 252 / 50 for a cell.
fn prices() -> Prices {
    Prices::new(FACTOR * 252.0 / NEUTRAL, Unknown::Closed)
}

fn compare_plans(costs: &Costmap, pairs: &[[Cell; 2]], theirs: &[(f64, Vec<Point>)]) -> Result<()> {
    let (mut our_times, mut their_times, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let mut only_one = 0;
    for (&[start, goal], (time, path)) in pairs.iter().zip(theirs) {
        let begin = processor_time();
        let route = Field::new(costs, &prices(), goal)?.route(start);
        our_times.push(processor_time() - begin);
        their_times.push(*time);
        match route {
            Ok(route) if !path.is_empty() => ratios.push(cost(costs, &route.points) / cost(costs, path)),
            Ok(_) => only_one += 1,
            Err(_) => only_one += usize::from(!path.is_empty()),
        }
    }
    let all = pairs.len();
    println!(
        "{all} pairs, {} with both ways, {only_one} with one",
        ratios.len()
    );
    let (ours, their) = (median(&mut our_times), median(&mut their_times));
    println!(
        "full plan: ours {ours:.1} ms, navfn {their:.1} ms in the median; {:.1} and {:.1} ms at most",
        our_times[all - 1],
        their_times[all - 1]
    );
    let middle = median(&mut ratios);
    println!(
        "cost of our way by navfn's costs, theirs = 1: median {middle:.4}, {:.4} to {:.4}",
        ratios[0],
        ratios[ratios.len() - 1]
    );
    Ok(())
}

/// Measures the repair of the field of each pair's goal when a block of 10 × 10 cells appears on the way, 3 m
/// ahead of a robot that has gone half of it.
fn measure_repairs(grid: &mut OccupancyGrid, mut costs: Costmap, pairs: &[[Cell; 2]]) -> Result<()> {
    let (mut shares, mut times) = (Vec::new(), Vec::new());
    for &[start, goal] in pairs {
        let begin = processor_time();
        let mut field = Field::new(&costs, &prices(), goal)?;
        let Ok(route) = field.route(start) else { continue };
        let full = processor_time() - begin;
        let at = |place: usize| {
            let (x, y) = route.points[place.min(route.points.len() - 1)];
            Cell::new(x as u32, y as u32)
        };
        // Points are half a cell apart.
        let (robot, middle) = (at(route.points.len() / 2), at(route.points.len() / 2 + 120));
        let corner = (middle.x.saturating_sub(5), middle.y.saturating_sub(5));
        let block = (0..100).map(|at| Cell::new(corner.0 + at % 10, corner.1 + at / 10));
        let block: Vec<Cell> = block
            .filter(|&cell| grid.get(cell) == Occupancy::Free && cell != goal)
            .collect();
        for state in [Occupancy::Occupied, Occupancy::Free] {
            for &cell in &block {
                grid.set(cell, state);
            }
            let changed = costs.update(grid, &block);
            let begin = processor_time();
            field.update(&costs, &changed);
            // Whether a way is left does not matter here.
            let _ = field.route(robot);
            let time = processor_time() - begin;
            times.push(time);
            shares.push(time / full);
        }
    }
    let (time, share) = (median(&mut times), median(&mut shares));
    let last = shares.len() - 1;
    println!(
        "repair after 100 cells: median {time:.2} ms, {:.2} % of the full plan, 95 % of them up to {:.1} %, at most {:.1} %",
        100.0 * share,
        100.0 * shares[last * 95 / 100],
        100.0 * shares[last]
    );
    Ok(())
}

/// The cost of a way by navfn's costs of the cells that it passes.
fn cost(costs: &Costmap, points: &[Point]) -> f64 {
    let of = |cell: Cell| NEUTRAL + FACTOR * f64::from(costs.get(cell));
    let of_line = |pair: &[Point]| {
        let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
        // In parts of a tenth of a cell.
        let length = (bx - ax).hypot(by - ay);
        let parts = (10.0 * length).ceil().max(1.0) as u32;
        let sum: f64 = (0..parts)
            .map(|part| (f64::from(part) + 0.5) / f64::from(parts))
            .map(|share| {
                of(Cell::new(
                    (ax + share * (bx - ax)) as u32,
                    (ay + share * (by - ay)) as u32,
                ))
            })
            .sum();
        length * sum / f64::from(parts)
    };
    points.windows(2).map(of_line).sum()
}

/// The processor time of this process, ms: other programs affect it little.
fn processor_time() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 / 1e6
}

/// Sorts the values, and returns the middle one.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn read_map(path: &Path) -> Result<OccupancyGrid> {
    let map = MapFile::load(path)?;
    let [x, y, yaw] = map.origin;
    let geometry = Geometry::new(map.width as u32, map.height as u32, map.resolution, (x, y, yaw))?;
    let mut grid = OccupancyGrid::filled(geometry, Occupancy::Free);
    for (index, cell) in map.cells.iter().enumerate() {
        grid.set(geometry.cell(index), Occupancy::from_ros(cell.to_ros()));
    }
    Ok(grid)
}

fn write_costs(costs: &Costmap, file: &str) -> Result<()> {
    let geometry = costs.geometry();
    let mut bytes = format!("P5 {} {} 255\n", geometry.width(), geometry.height()).into_bytes();
    bytes.extend_from_slice(costs.costs());
    Ok(std::fs::write(file, bytes)?)
}

fn write_pairs(costs: &Costmap, file: &str) -> Result<()> {
    let geometry = costs.geometry();
    let mut random = fastrand::Rng::with_seed(33);
    let mut draw = |far_from: Option<Cell>| loop {
        let cell = Cell::new(
            random.u32(MARGIN..geometry.width() - MARGIN),
            random.u32(MARGIN..geometry.height() - MARGIN),
        );
        let is_far = far_from.is_none_or(|from| from.distance(cell) * geometry.resolution() > LEAST_DISTANCE);
        if is_far && costs.get(cell) < MAX_COST && costs.get(cell) != UNKNOWN {
            return cell;
        }
    };
    let mut text = String::new();
    for _ in 0..PAIRS {
        let start = draw(None);
        let goal = draw(Some(start));
        writeln!(text, "{} {} {} {}", start.x, start.y, goal.x, goal.y)?;
    }
    Ok(std::fs::write(file, text)?)
}

fn read_pairs(text: &str) -> Result<Vec<[Cell; 2]>> {
    let pair = |line: &str| {
        let numbers: Vec<u32> = line
            .split_whitespace()
            .map(str::parse)
            .collect::<core::result::Result<_, _>>()?;
        let [sx, sy, gx, gy] = numbers[..] else {
            return Err(format!("not a pair: {line}").into());
        };
        Ok([Cell::new(sx, sy), Cell::new(gx, gy)])
    };
    text.lines().map(pair).collect()
}

/// Reads the time and the way of each line.
fn read_results(text: &str) -> Result<Vec<(f64, Vec<Point>)>> {
    let result = |line: &str| {
        let numbers: Vec<f64> = line
            .split_whitespace()
            .map(str::parse)
            .collect::<core::result::Result<_, _>>()?;
        let [time, coordinates @ ..] = numbers.as_slice() else {
            return Err("an empty line".into());
        };
        let points = coordinates.chunks_exact(2).map(|point| (point[0], point[1]));
        Ok((*time, points.collect()))
    };
    text.lines().map(result).collect()
}
