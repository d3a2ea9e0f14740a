//! Two hundred nodes of another program: how long until a program that starts among them has its first message, and what
//! their discovery costs one that runs already.

use std::thread;

use anyhow::{Context as _, Result};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::Rounds;

use super::{DIRECTLY, addresses};
use crate::arrivals::{Arrivals, now};
use crate::programs::{Program, Programs, SETTLING};

const NODES: &str = "200";

pub(crate) fn run(programs: &Programs) -> Result<Vec<Line>> {
    let application = format!(
        "name = \"nodes\"\nroots = [\"heard\"]\n[schemas.topics]\ntype = \"ros2/topics\"\n\
         {}subscribe.tick = \"tick\"\n\
         [schemas.heard]\ntype = \"bench-000/listen\"\nimports = {{ input = \"topics.tick\" }}\n",
        addresses(programs, DIRECTLY)
    );
    let ours = || programs.jde("nodes", &application);
    let theirs = || programs.rclcpp(&["listen", "tick"].map(str::to_owned));
    let mut firsts = [Vec::new(), Vec::new()];
    let mut costs = [Vec::new(), Vec::new()];
    for _ in 0..programs.seconds(1, 5).as_secs() {
        firsts[0].push(first(programs, &ours, true)?);
        firsts[1].push(first(programs, &theirs, false)?);
        costs[0].push(cost(programs, &ours)?);
        costs[1].push(cost(programs, &theirs)?);
    }
    let line = |what: &str, sides: [Vec<f64>; 2], goal| {
        let [ours, theirs] = sides.map(Rounds::of);
        Line::compared(
            what,
            Figure::Time(ours.median()),
            "rclcpp",
            Figure::Time(theirs.median()),
            goal,
        )
        .paired(ours.ratio_to(&theirs))
    };
    Ok(vec![
        line(
            "from the start among 200 nodes to the first message",
            firsts,
            Goal::AtMost(1.1),
        ),
        line("200 nodes appear: processor time", costs, Goal::AtMost(1.1)),
    ])
}

/// Returns the time from the start of a program among the nodes to its first message, ns.
fn first(programs: &Programs, start: &dyn Fn() -> Result<Program>, is_jde: bool) -> Result<f64> {
    let _router = programs.router()?;
    let _nodes = programs.rclcpp(&["nodes", NODES].map(str::to_owned))?;
    let talk = programs.rclcpp(&["talk", "tick", "64", "5", "0"].map(str::to_owned))?;
    thread::sleep(SETTLING);
    let started = now();
    let program = start()?;
    thread::sleep(2 * SETTLING);
    let text = if is_jde {
        program.terminate()?;
        programs.recorded("nodes", "heard")?
    } else {
        program.end()?
    };
    talk.end()?;
    let arrivals = Arrivals::read(&text).of(if is_jde { "heard" } else { "tick" }, (started, u64::MAX));
    let first = arrivals.iter().map(|arrival| arrival.arrived).min();
    Ok((first.context("no message arrived")? - started) as f64)
}

/// Returns the processor time of a program while the nodes appear, ns.
fn cost(programs: &Programs, start: &dyn Fn() -> Result<Program>) -> Result<f64> {
    let _router = programs.router()?;
    let program = start()?;
    thread::sleep(SETTLING);
    let before = program.processor_time()?;
    let _nodes = programs.rclcpp(&["nodes", NODES].map(str::to_owned))?;
    thread::sleep(SETTLING);
    Ok((program.processor_time()? - before) * 1e9)
}
