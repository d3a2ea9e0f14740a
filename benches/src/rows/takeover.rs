//! From the publication of a sensor's value to the first command of the winner that it makes, between threads in real time.

use std::time::Duration;

use anyhow::{Result, ensure};

use crate::figure::{Figure, Goal, Line};
use crate::pairs::{Rounds, quantile};
use crate::scope::Scope;
use crate::{bare, live};

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
    let time = Duration::from_secs(scope.either(1, 3));
    let (mut ours, mut bare) = (Vec::new(), Vec::new());
    for _ in 0..scope.either(2, 11) {
        let took = live::run(APPLICATION, time)?.notes.concat();
        ensure!(!took.is_empty(), "nobody took over");
        ours.push(numbers(took));
        bare.push(numbers(bare::hand_over(PERIOD, time)));
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

fn numbers(times: Vec<u64>) -> Vec<f64> {
    times.into_iter().map(|time| time as f64).collect()
}
