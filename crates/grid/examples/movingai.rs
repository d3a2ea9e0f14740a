//! Measures the planners on a map and its scenarios of MovingAI's benchmarks (Sturtevant, "Benchmarks for
//! grid-based pathfinding", 2012): the share of optimal lengths, the lengths beside them, and the times.
//!
//! `cargo run --release -p jde-grid --example movingai -- MAP SCENARIOS [EVERY]`

use std::error::Error;
use std::time::{Duration, Instant};

use jde_grid::{Angles, Cell, Costmap, Geometry, Inflation, Occupancy, OccupancyGrid, Prices, Unknown, plan};

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
    let costs = read_map(&std::fs::read_to_string(map)?)?;
    let scenarios: Vec<Scenario> = std::fs::read_to_string(scenarios)?
        .lines()
        .filter_map(read_scenario)
        .step_by(every)
        .collect();
    let prices = Prices::new(0.0, Unknown::Closed);
    for angles in [Angles::Eight, Angles::Any] {
        let mut sums = Sums::default();
        for scenario in &scenarios {
            let begin = Instant::now();
            let way = plan(&costs, &prices, angles, scenario.start, scenario.goal);
            let time = begin.elapsed();
            sums.time += time;
            sums.longest = sums.longest.max(time);
            match way {
                Ok(way) => {
                    // The files have eight decimals.
                    sums.optimal += usize::from((way.length() - scenario.optimal).abs() < 1e-6);
                    sums.ratio += (way.length() / scenario.optimal.max(1e-9)).min(10.0);
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
            sums.time.as_secs_f64() * 1e3 / all as f64,
            sums.longest.as_secs_f64() * 1e3,
        );
    }
    Ok(())
}

/// Reads a map: `.`, `G` and `S` are open, all else is closed. Rows run from top to bottom, which changes no
/// length.
fn read_map(text: &str) -> Result<Costmap, Box<dyn Error>> {
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
    let inflation = Inflation {
        inscribed: 0.0,
        circumscribed: 0.0,
        reach: 0.0,
        decay: 0.0,
    };
    Ok(Costmap::new(&grid, &inflation)?)
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
