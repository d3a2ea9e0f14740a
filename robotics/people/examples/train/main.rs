//! Trains the model of legs on simulated scans, and measures it on recorded ones.
//!
//! `cargo run --release -p jde-people --example train > coefficients` prints `src/coefficients.rs` and, on the standard
//! error, how it does on other simulated scans and what each feature contributes.
//!
//! `cargo run --release -p jde-people --example train -- FILE...` measures it on recordings: each alone, by the model of
//! simulated scans and by one of all other recordings. A recording has a line for each scan: the angle of the first
//! beam, the angle from beam to beam, rad, the number of beams and their ranges, m, the number of legs and for each x
//! and y in the frame of the laser, m. In a recording without any legs all segments are others; of one with legs, only
//! these count.

mod boosting;
mod recordings;
mod scenes;

use std::error::Error;

use boosting::{Example, boost};
use jde_people::{DetectorSettings, FEATURES, Features, Stump, confidence};

const ROUNDS: usize = 60;
const SCANS: usize = 3000;

fn main() -> Result<(), Box<dyn Error>> {
    let settings = DetectorSettings::default();
    let mut random = fastrand::Rng::with_seed(1);
    let mut simulated = Vec::new();
    scenes::simulate(SCANS, &settings, &mut random, &mut simulated);
    let stumps = boost(&simulated, ROUNDS);
    let files: Vec<String> = std::env::args().skip(1).collect();
    if files.is_empty() {
        let mut others = Vec::new();
        scenes::simulate(SCANS / 3, &settings, &mut random, &mut others);
        eprintln!("other simulated scans: {}", Score::of(&stumps, &others));
        explain(&stumps);
        print(&stumps);
        return Ok(());
    }
    recordings::measure(&files, &settings, &stumps)
}

/// How often a model is right.
#[derive(Clone, Copy, Default)]
struct Score {
    legs: usize,
    others: usize,
    found: usize,
    wrong: usize,
}

impl Score {
    fn of(stumps: &[Stump], examples: &[Example]) -> Self {
        let mut score = Self::default();
        for example in examples {
            let is_found = confidence(stumps, &example.features) >= 0.5;
            score.legs += usize::from(example.is_leg);
            score.others += usize::from(!example.is_leg);
            score.found += usize::from(example.is_leg && is_found);
            score.wrong += usize::from(!example.is_leg && is_found);
        }
        score
    }

    fn add(&mut self, other: &Self) {
        self.legs += other.legs;
        self.others += other.others;
        self.found += other.found;
        self.wrong += other.wrong;
    }
}

impl std::fmt::Display for Score {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            legs,
            others,
            found,
            wrong,
        } = *self;
        let [right, false_alarms] =
            [(found, legs), (wrong, others)].map(|(part, whole)| part as f64 / whole.max(1) as f64);
        write!(
            f,
            "F1 {:.3}, with as many others as legs {:.3}; {found} of {legs} legs ({:.1} %), {wrong} of {others} others ({:.1} %)",
            2.0 * found as f64 / (legs + found + wrong).max(1) as f64,
            2.0 * right / (1.0 + right + false_alarms),
            100.0 * right,
            100.0 * false_alarms
        )
    }
}

/// Prints how much the stumps of each feature can add to the logarithm of the odds.
fn explain(stumps: &[Stump]) {
    for feature in 0..FEATURES {
        let own = stumps.iter().filter(|stump| stump.feature == feature);
        let most: f64 = own.map(|stump| (stump.above - stump.below).abs()).sum();
        eprintln!("{most:6.2}  {}", Features::NAMES[feature]);
    }
}

fn print(stumps: &[Stump]) {
    println!("//! What the example `train` prints: the model of legs in simulated scans.\n");
    println!("use crate::model::Stump;\n");
    println!("/// By feature, threshold, and what each side adds.");
    println!("pub(crate) const STUMPS: [Stump; {}] = [", stumps.len());
    for Stump {
        feature,
        threshold,
        below,
        above,
    } in stumps
    {
        println!("    stump({feature}, {threshold:.4}, {below:.4}, {above:.4}),");
    }
    println!("];\n");
    println!("const fn stump(feature: usize, threshold: f64, below: f64, above: f64) -> Stump {{");
    println!(
        "    Stump {{\n        feature,\n        threshold,\n        below,\n        above,\n    }}\n}}"
    );
}
