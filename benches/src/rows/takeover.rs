//! The time from a sensor's publication to the first command of the new winner, between threads in real time.

use std::time::Duration;

use anyhow::{Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, quantile};

use crate::scope::Scope;
use crate::{bare, live};

/// The period of the sensor's values and of the bare wake-ups. Every other value of the sensor causes a
/// takeover.
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
        ours.push(numbers(live::run(APPLICATION, time)?.notes.concat()));
        // Half the time gives the same number of samples, so that the p99 has the same rank on both sides.
        bare.push(numbers(bare::hand_over(PERIOD, live::START + time / 2)));
    }
    ensure!(!ours.concat().is_empty(), "there was no takeover");
    let line = |what: &str, share: f64, from: Duration, goal| {
        let of = |runs: &[Vec<f64>], every: Duration| {
            let first = from.as_nanos().div_ceil(every.as_nanos()) as usize;
            let late = |run: &Vec<f64>| run.get(first..).unwrap_or_default().to_vec();
            Rounds::of(runs.iter().map(|run| quantile(late(run), share)).collect())
        };
        let (ours, bare) = (of(&ours, 2 * PERIOD), of(&bare, PERIOD));
        Line::beside(
            format!("takeover, {what}"),
            Figure::Time(ours.median()),
            "futex between two threads",
            Figure::Time(bare.median()),
            goal,
        )
        .paired(ours.by(&bare))
    };
    // By then the system has placed each thread on a processor.
    let then = live::START;
    Ok(vec![
        line("median", 0.5, then, Goal::AtMost(2.0)),
        line("p99", 0.99, then, Goal::AtMost(3.0)),
        line("p99 with the first 0.2 s", 0.99, Duration::ZERO, Goal::Reported),
    ])
}

fn numbers(times: Vec<u64>) -> Vec<f64> {
    times.into_iter().map(|time| time as f64).collect()
}
