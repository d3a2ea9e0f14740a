//! Writes an experiment: a TurtleBot drives to random goals in the office, each with a seed of its own. A goal is a
//! place to which a disc of 0.3 m can move from the start.
//!
//! `cargo run -p jde-sim --example goals -- 1000 > target/goals.toml` writes a thousand drives, always the same, which
//! `jde experiment target/goals.toml` runs.

use std::collections::{BTreeSet, VecDeque};
use std::error::Error;

use jde_sim::{Footprint, Pose2, RobotConfig, World};

/// The radius of the disc, in metres: the robot has 0.17 m.
const RADIUS: f64 = 0.3;
/// The distance of the places that are tried, in metres.
const STEP: f64 = 0.1;
/// The least distance of a goal from the start, in metres: the robot is not there already.
const NEAREST: f64 = 1.0;
/// The start, as in `apps/navigate.toml`.
const START: [f64; 2] = [3.55, 1.6];

const EXPERIMENT: &str = r#"name        = "goals"
doc         = "The robot reaches random goals in an unknown building without touching anything."
application = "../apps/navigate.toml"
for         = "400s"

[must."no collision"]
never = "collisions > 0"

[must."no schema faults or misses its deadlines"]
never = "faults > 0 or overruns > 0"

[measure]
time       = "time"
distance   = "distance"
nearest    = "clearance"
spl        = "spl"
smoothness = "smoothness"
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let goals: u64 = std::env::args().nth(1).ok_or("goals NUMBER")?.parse()?;
    let places = reachable(World::load("worlds/office.toml", 1)?)?;
    println!("{EXPERIMENT}");
    for seed in 1..=goals {
        let [x, y] = places[(mixed(seed) % places.len() as u64) as usize];
        println!("[[cases]]\nname = \"{seed}: {x:.2}, {y:.2}\"\nseed = {seed}");
        println!("set  = {{ \"navigate.route\" = {{ poses = [[{x:.2}, {y:.2}, 0]] }} }}");
    }
    Ok(())
}

/// Returns the places to which the disc can move from the start.
fn reachable(mut world: World) -> Result<Vec<[f64; 2]>, Box<dyn Error>> {
    let config = RobotConfig {
        footprint: Footprint::Circle { radius: RADIUS },
        ..RobotConfig::default()
    };
    let place = |(column, row): (i32, i32)| {
        [
            START[0] + STEP * f64::from(column),
            START[1] + STEP * f64::from(row),
        ]
    };
    let disc = world.add_robot_at("disc", Pose2::new(START[0], START[1], 0.0), config)?;
    let mut seen = BTreeSet::from([(0, 0)]);
    let mut next = VecDeque::from([(0, 0)]);
    let mut places = Vec::new();
    while let Some((column, row)) = next.pop_front() {
        let [x, y] = place((column, row));
        if world.place(disc, Pose2::new(x, y, 0.0)).is_err() {
            continue;
        }
        if (x - START[0]).hypot(y - START[1]) >= NEAREST {
            places.push([x, y]);
        }
        let around = [
            (column + 1, row),
            (column - 1, row),
            (column, row + 1),
            (column, row - 1),
        ];
        next.extend(around.into_iter().filter(|cell| seen.insert(*cell)));
    }
    Ok(places)
}

/// Returns a number without order from a seed: SplitMix64 (Steele, Lea, Flood 2014).
fn mixed(seed: u64) -> u64 {
    let mut mixed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
