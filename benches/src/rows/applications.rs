//! What people run: the processor time of shipped applications in lockstep, as a share of one processor at the robot's time.

use anyhow::{Context as _, Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::Rounds;
use serde::Deserialize;

use crate::product;
use crate::scope::Scope;

/// The applications, and whether they need a route because they have no targets of their own.
const APPLICATIONS: &[(&str, bool)] = &[
    ("wander", false),
    ("patrol", false),
    ("navigate", true),
    ("localize", true),
    ("vacuum", false),
    ("barn", false),
    ("explore", false),
    ("guide", false),
    ("follow-person", false),
];

/// From one end of the office to the other and back.
const ROUTE: &str = "navigate.route={poses=[[16.75, 11.15, 0], [3.55, 2.6, 0]]}";

/// The fields of the summary of `jde run --json` that are used here.
#[derive(Deserialize)]
struct Summary {
    outcome: String,
    sim_seconds: f64,
    decisions_sha256: String,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    APPLICATIONS
        .iter()
        .map(|&(name, needs_route)| {
            let share = share(scope, name, needs_route).with_context(|| format!("`{name}`"))?;
            Ok(Line::new(
                format!("`{name}` in lockstep, at the robot's time"),
                Figure::Processor(share),
                Goal::ReportOnly,
            ))
        })
        .collect()
}

/// Processor time for each second of the robot, the start of all processes included, in percent.
fn share(scope: &Scope, name: &str, needs_route: bool) -> Result<f64> {
    let folder = tempfile::tempdir()?;
    let (mut shares, mut decisions) = (Vec::new(), Vec::new());
    for _ in 0..scope.either(1, 3) {
        let mut command = product::jde(scope, folder.path());
        command.args(["run", name, "--lockstep", "--json", "--for", "120s"]);
        if needs_route {
            command.args(["--set", ROUTE]);
        }
        let before = product::children_processor_time()?;
        let output = command.output()?;
        let processor = product::children_processor_time()? - before;
        // The status is 1 when the time is up before the mission is done, which is no fault here.
        let summary = String::from_utf8(output.stdout)?;
        let errors = || String::from_utf8_lossy(&output.stderr).into_owned();
        let last = summary.lines().last().with_context(errors)?;
        let summary: Summary = serde_json::from_str(last)?;
        ensure!(
            output.status.success() || summary.outcome == "time-up",
            "{}",
            errors()
        );
        shares.push(100.0 * processor / summary.sim_seconds);
        decisions.push(summary.decisions_sha256);
    }
    decisions.dedup();
    ensure!(decisions.len() == 1, "two runs decided differently");
    Ok(Rounds::of(shares).median())
}
