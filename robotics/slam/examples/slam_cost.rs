//! What an iteration of a graph costs, and what it takes to continue a map: processor time by the size of a building.
//!
//! `cargo run --release -p jde-slam --example slam_cost`

use std::error::Error;
use std::time::Duration;

use jde_grid::{Cell, Geometry, Occupancy, OccupancyGrid};
use jde_slam::{Continuation, Edge, Graph, Relation};
use jde_types::Pose2D;
use rustix::time::{ClockId, clock_gettime};

/// Keyframes in a row of a graph, each linked with the one before it and, by a loop, with the one beside it.
const ROW: usize = 64;
/// The side of a hall, m, and how far apart its pillars are, in cells of 5 cm.
const HALLS: [f64; 3] = [15.0, 30.0, 60.0];
const PILLARS: u32 = 60;

fn main() -> Result<(), Box<dyn Error>> {
    for keyframes in [1000, 2000, 4000] {
        iterate(keyframes);
    }
    for side in HALLS {
        read(side)?;
    }
    Ok(())
}

fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Iterates a graph once whose edges contradict each other by some centimetres.
fn iterate(keyframes: usize) {
    let mut random = fastrand::Rng::with_seed(1);
    let mut error = |size: f64| size * (2.0 * random.f64() - 1.0);
    let mut graph = Graph::default();
    let place = |at: usize| Pose2D::new(0.5 * (at % ROW) as f64, 0.5 * (at / ROW) as f64, 0.0);
    for to in 0..keyframes {
        graph.add_pose(place(to));
        let beside = (to % ROW > 0).then(|| to - 1);
        for from in beside.into_iter().chain(to.checked_sub(ROW)) {
            let step = Pose2D::new(error(0.02), error(0.02), error(0.01));
            graph.add_edge(Edge {
                from,
                to,
                pose: place(from).localize(&place(to)).transform(&step),
                information: [[1e4, 0.0, 0.0], [0.0, 1e4, 0.0], [0.0, 0.0, 1e5]],
                relation: if from + ROW == to {
                    Relation::Loop
                } else {
                    Relation::Successive
                },
            });
        }
    }
    let (mut parts, mut all, mut most) = (0, Duration::ZERO, Duration::ZERO);
    // An iteration ends when it moves the keyframes.
    loop {
        let before = processor_time();
        let moved = graph.iterate();
        let took = processor_time().saturating_sub(before);
        (parts, all, most) = (parts + 1, all + took, most.max(took));
        if moved || graph.is_settled() {
            break;
        }
    }
    println!("{keyframes} keyframes: an iteration takes {all:.1?} in {parts} parts, {most:.1?} at most");
}

/// Reads the map of a hall with pillars.
fn read(side: f64) -> Result<(), Box<dyn Error>> {
    let cells = (side / 0.05) as u32;
    let geometry = Geometry::new(cells, cells, 0.05, (0.0, 0.0, 0.0))?;
    let mut map = OccupancyGrid::filled(geometry, Occupancy::Free);
    for at in 0..geometry.cells() {
        let cell = geometry.cell(at);
        let is_wall = cell.x.min(cell.y) == 0 || cell.x.max(cell.y) == cells - 1;
        if is_wall || (cell.x % PILLARS < 10 && cell.y % PILLARS < 10) {
            map.set(Cell::new(cell.x, cell.y), Occupancy::Occupied);
        }
    }
    let before = processor_time();
    let mut continuation =
        Continuation::new(map, &Pose2D::new(1.5, 1.5, 0.0)).ok_or("there are no free cells there")?;
    let begun = processor_time().saturating_sub(before);
    let mut most = Duration::ZERO;
    loop {
        let before = processor_time();
        let slam = continuation.advance(1);
        most = most.max(processor_time().saturating_sub(before));
        if slam.is_some() {
            break;
        }
    }
    let all = processor_time().saturating_sub(before);
    println!(
        "a hall of {side} m × {side} m: {} keyframes in {all:.1?}, of which {begun:.1?} at first; {most:.1?} at most for one",
        continuation.keyframes()
    );
    Ok(())
}
