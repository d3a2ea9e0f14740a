//! Measures the planners on a map and its scenarios of MovingAI's benchmarks (Sturtevant, "Benchmarks for
//! grid-based pathfinding", 2012): the share of optimal lengths, the lengths beside them, the times, and the
//! repair of a field.
//!
//! `cargo run --release -p jde-grid --example movingai -- MAP SCENARIOS [EVERY]`

use std::error::Error;
use std::time::{Duration, Instant};

use jde_grid::{
    Angles, Cell, Costmap, Field, Geometry, Inflation, Occupancy, OccupancyGrid, Prices, Unknown, plan,
};

/// A robot without extent, as in the benchmarks.
const POINT: Inflation = Inflation::circle(0.0);

/// One line of a file of scenarios.
struct Scenario {
    start: Cell,
    goal: Cell,
    /// The length of the best way along eight directions.
    optimal: f64,
}

/// What a planner needed for all scenarios.
#[derive(Default)]
struct Sums {
    optimal: usize,
    missing: usize,
    ratio: f64,
    time: Duration,
    longest: Duration,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [map, scenarios, rest @ ..] = arguments.as_slice() else {
        return Err("usage: movingai MAP SCENARIOS [EVERY]".into());
    };
    let every: usize = rest.first().map_or(Ok(1), |every| every.parse())?;
    let grid = read_map(&std::fs::read_to_string(map)?)?;
    let scenarios: Vec<Scenario> = std::fs::read_to_string(scenarios)?
        .lines()
        .filter_map(read_scenario)
        .step_by(every)
        .collect();
    let costs = Costmap::new(&grid, &POINT)?;
    for angles in [Angles::Eight, Angles::Any] {
        measure_planner(&costs, &scenarios, angles);
    }
    measure_field(grid, &scenarios)
}

fn prices() -> Prices {
    Prices::new(0.0, Unknown::Closed)
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn measure_planner(costs: &Costmap, scenarios: &[Scenario], angles: Angles) {
    let mut sums = Sums::default();
    for scenario in scenarios {
        let begin = Instant::now();
        let way = plan(costs, &prices(), angles, scenario.start, scenario.goal);
        let time = begin.elapsed();
        sums.time += time;
        sums.longest = sums.longest.max(time);
        match way {
            Ok(way) => {
                // The files have eight decimals.
                sums.optimal += usize::from((way.length() - scenario.optimal).abs() < 1e-6);
                sums.ratio += way.length() / scenario.optimal.max(1e-9);
            }
            Err(_) => sums.missing += 1,
        }
    }
    let all = scenarios.len();
    println!(
        "{angles:?}: {} of {all} have the length of the file, {} no way, mean ratio {:.4}, mean {:.2} ms, longest {:.1} ms",
        sums.optimal,
        sums.missing,
        sums.ratio / all as f64,
        milliseconds(sums.time) / all as f64,
        milliseconds(sums.longest),
    );
}

/// Measures the field of the last scenario's goal: in full, and after a wall of a hundred cells appears
/// across each way, from a tenth of it to nine tenths.
fn measure_field(mut grid: OccupancyGrid, scenarios: &[Scenario]) -> Result<(), Box<dyn Error>> {
    let Scenario { start, goal, optimal } = scenarios.last().ok_or("there are no scenarios")?;
    let mut costs = Costmap::new(&grid, &POINT)?;
    let begin = Instant::now();
    let mut field = Field::new(&costs, &prices(), *goal)?;
    field.settle();
    let full = milliseconds(begin.elapsed());
    let all = field.propagated();
    let begin = Instant::now();
    let way = field.route(*start)?;
    let descent = milliseconds(begin.elapsed());
    println!(
        "field: in full {full:.1} ms, {all} cells; a way of {:.1} cells for {optimal:.1} {descent:.2} ms",
        way.length()
    );
    for tenth in 1..10 {
        let (x, y) = way.points[way.points.len() * tenth / 10];
        let (left, below) = ((x as u32).saturating_sub(5), (y as u32).saturating_sub(5));
        let block = (0..100).map(|at| Cell::new(left + at % 10, below + at / 10));
        let block: Vec<Cell> = block.filter(|&cell| grid.get(cell) == Occupancy::Free).collect();
        let mut repair = |state, from: Cell| -> Result<_, Box<dyn Error>> {
            for &cell in &block {
                grid.set(cell, state);
            }
            let changed = costs.update(&grid, &block);
            let (begin, before) = (Instant::now(), field.propagated());
            field.update(&costs, &changed);
            let _ = field.route(from)?;
            let (way, cells) = (milliseconds(begin.elapsed()), field.propagated() - before);
            field.settle();
            Ok((
                way,
                cells,
                milliseconds(begin.elapsed()),
                field.propagated() - before,
            ))
        };
        // Where a robot would be that sees the block 60 cells ahead.
        let near = way.points[(way.points.len() * tenth / 10).saturating_sub(120)];
        let near = Cell::new(near.0 as u32, near.1 as u32);
        let (appears, disappears) = (repair(Occupancy::Occupied, near)?, repair(Occupancy::Free, near)?);
        println!(
            "  block at {tenth}/10: appears {:.1} ms ({} cells) for the way, {:.1} ms ({} cells) everywhere; disappears {:.1} ms, {:.1} ms",
            appears.0, appears.1, appears.2, appears.3, disappears.0, disappears.2
        );
    }
    Ok(())
}

/// Reads a map: `.`, `G` and `S` are open, all else is closed. Rows run from top to bottom, which changes no
/// length.
fn read_map(text: &str) -> Result<OccupancyGrid, Box<dyn Error>> {
    let rows: Vec<&str> = text.lines().skip_while(|line| *line != "map").skip(1).collect();
    let width = rows.first().ok_or("the map has no rows")?.len();
    let geometry = Geometry::new(width as u32, rows.len() as u32, 1.0, (0.0, 0.0, 0.0))?;
    let mut grid = OccupancyGrid::filled(geometry, Occupancy::Occupied);
    for (y, row) in rows.iter().enumerate() {
        for (x, _) in row
            .bytes()
            .enumerate()
            .filter(|(_, symbol)| b".GS".contains(symbol))
        {
            grid.set(Cell::new(x as u32, y as u32), Occupancy::Free);
        }
    }
    Ok(grid)
}

/// Reads a line: bucket, map, width, height, start x, start y, goal x, goal y, length.
fn read_scenario(line: &str) -> Option<Scenario> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    let [_, _, _, _, sx, sy, gx, gy, optimal] = fields[..] else {
        return None;
    };
    Some(Scenario {
        start: Cell::new(sx.parse().ok()?, sy.parse().ok()?),
        goal: Cell::new(gx.parse().ok()?, gy.parse().ok()?),
        optimal: optimal.parse().ok()?,
    })
}
