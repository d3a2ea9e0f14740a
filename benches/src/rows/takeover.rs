//! From the publication of a sensor's value to the first command of the winner that it makes, between threads in real time.

use std::time::Duration;

use anyhow::{Result, ensure};

use crate::figure::{Figure, Goal, Line};
use crate::pairs::{Rounds, quantile};
use crate::scope::Scope;
use crate::{bare, live};

/// How often the sensor has a value, and the bare thread rings. Every other value is a takeover.
const PERIOD: Duration = Duration::from_millis(20);

const APPLICATION: &str = r#"
    roots = ["brake", "cruise"]
    [schemas.robot]
    type = "pace/robot"
    [schemas.brake]
    type = "pace/brake"
    imports = { seen = "robot.seen" }
    actuators = { base = "robot.velocity" }
    [schemas.cruise]
    type = "pace/cruise"
    actuators = { base = "robot.velocity" }
"#;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let time = Duration::from_secs(scope.either(1, 6));
    let (mut ours, mut bare) = (Vec::new(), Vec::new());
    for _ in 0..scope.either(2, 11) {
        ours.push(after_start(
            live::run(APPLICATION, time)?.notes.concat(),
            2 * PERIOD,
        )?);
        // As many of either, so that the last of a hundred is the same one.
        bare.push(after_start(
            bare::hand_over(PERIOD, live::START + time / 2),
            PERIOD,
        )?);
    }
    let line = |what: &str, share: f64, most: f64| {
        let of =
            |runs: &[Vec<f64>]| Rounds::of(runs.iter().map(|run| quantile(run.clone(), share)).collect());
        let (ours, bare) = (of(&ours), of(&bare));
        Line::beside(
            format!("takeover, {what}"),
            Figure::Time(ours.median()),
            "futex between two threads",
            Figure::Time(bare.median()),
            Goal::AtMost(most),
        )
        .paired(ours.by(&bare))
    };
    Ok(vec![line("median", 0.5, 2.0), line("p99", 0.99, 3.0)])
}

/// What came once all were there and the system had found a processor for each.
fn after_start(took: Vec<u64>, every: Duration) -> Result<Vec<f64>> {
    let first = live::START.as_nanos().div_ceil(every.as_nanos()) as usize;
    let took: Vec<f64> = took.into_iter().skip(first).map(|time| time as f64).collect();
    ensure!(!took.is_empty(), "nobody took over");
    Ok(took)
}
