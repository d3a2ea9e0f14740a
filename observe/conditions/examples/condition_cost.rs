//! Measures what expressions cost: a new value of each input, and the evaluation. It runs in the release
//! profile: `cargo run --release -p jde-conditions --example condition_cost`.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use jde_conditions::{BadCondition, Expression, Names};
use jde_types::{Flag, LaserScan, Seq, Text, Truth, Value};

const EXPRESSIONS: [&str; 6] = [
    "pioneer.truth.collisions > 0",
    "collisions > 0",
    "vff.won and clearance < 0.2",
    "math.least(pioneer.laser.ranges) < 0.3",
    "pioneer.laser.ranges.exists(r, r < 0.3)",
    // Not over numbers: CEL's interpreter evaluates it.
    "pioneer.name.data == 'pioneer'",
];
const ROUND_COUNT: usize = 20;

fn main() -> Result<(), BadCondition> {
    let types = [
        ("pioneer.truth", Truth::describe()),
        ("pioneer.laser", LaserScan::describe()),
        ("pioneer.name", Text::<16>::describe()),
    ];
    let types = types.map(|(name, value_type)| (name.to_owned(), Arc::new(value_type)));
    let names = Names {
        schemas: vec!["vff".to_owned()],
        groups: Vec::new(),
        variables: BTreeMap::from(types),
        seed: None,
    };
    let scan = LaserScan {
        ranges: Seq::from_slice(&[1.0; 180]).unwrap_or_default(),
        ..LaserScan::default()
    };
    let (truth, name, won) = (Truth::default(), Text::<16>::truncated("pioneer"), Flag::TRUE);
    for text in EXPRESSIONS {
        let mut expression = Expression::condition(text, &names)?;
        let values: Vec<_> = expression
            .inputs()
            .map(|input| match input {
                "pioneer.truth" => truth.as_bytes(),
                "pioneer.laser" => scan.as_bytes(),
                "pioneer.name" => name.as_bytes(),
                "vff.won" => won.as_bytes(),
                _ => 1.0_f64.as_bytes(),
            })
            .collect();
        // The least of several rounds is the cost without interruptions.
        let mut least = f64::INFINITY;
        for round in 0..ROUND_COUNT {
            let count = 1000;
            let start = Instant::now();
            let mut truths = 0;
            for _ in 0..count {
                for (place, value) in values.iter().enumerate() {
                    expression.set(place, Some(value));
                }
                truths += usize::from(std::hint::black_box(&expression).is_true());
            }
            let took = start.elapsed().as_nanos() as f64 / f64::from(count);
            assert!(truths == 0 || truths == 1000, "round {round} differs");
            least = least.min(took);
        }
        println!("{least:>8.0} ns  {text}");
    }
    Ok(())
}
