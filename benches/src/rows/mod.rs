//! The rows of the table, in its order. Each measures one claim, which `docs/figures/performance.md` explains.

mod applications;
mod authority;
mod build;
mod contended;
mod control;
mod experiment;
mod iteration;
mod jitter;
mod link;
mod recording;
mod scale;
mod selection;
mod senses;
mod simulator;
mod startup;
mod stop;
mod takeover;
mod variables;

pub(crate) use self::link::{LISTEN, listen};

use anyhow::Result;
use jde_measure::figure::Line;

use crate::scope::Scope;

/// A row: one claim, in one or more lines.
pub(crate) struct Row {
    /// The name for `--row`.
    pub(crate) name: &'static str,
    /// What it measures.
    pub(crate) title: &'static str,
    /// Whether it takes many minutes and therefore runs only when it is named.
    pub(crate) long: bool,
    pub(crate) run: fn(&Scope) -> Result<Vec<Line>>,
}

pub(crate) const ROWS: &[Row] = &[
    row("read", "reading a small variable", variables::read),
    row(
        "image",
        "a picture in place, from publish to read",
        variables::image,
    ),
    row(
        "contended",
        "one writer and three readers at once",
        contended::run,
    ),
    row(
        "authority",
        "commands and the authority over them",
        authority::run,
    ),
    row("selection", "one selection with its record", selection::run),
    row(
        "iteration",
        "one iteration of a loaded schema in lockstep",
        iteration::run,
    ),
    row(
        "takeover",
        "from a sensor's value to the new winner's first command",
        takeover::run,
    ),
    row(
        "stop",
        "from a scan with an obstacle to a driver that stands",
        stop::run,
    ),
    row("jitter", "how late periods begin", jitter::run),
    row(
        "thousand",
        "a thousand awake schemas in real time",
        scale::thousand,
    ),
    row(
        "ten-thousand",
        "ten thousand awake schemas in lockstep",
        scale::ten_thousand,
    ),
    row("laser", "laser beams of the simulator", simulator::laser),
    row("demo", "the demonstration in lockstep", simulator::demo),
    row(
        "applications",
        "the shipped applications in lockstep",
        applications::run,
    ),
    row(
        "control",
        "an iteration of a controller, a guard's judgement",
        control::run,
    ),
    row("experiment", "many drives, judged and measured", experiment::run),
    row("senses", "what other sensors and the world cost", senses::run),
    row("recording", "recording the demonstration", recording::run),
    row("link", "a value from one process to another", link::run),
    row("startup", "starting, reloading, loading", startup::run),
    Row {
        long: true,
        ..row(
            "build",
            "both commands of the README, from a fresh clone",
            build::run,
        )
    },
];

const fn row(name: &'static str, title: &'static str, run: fn(&Scope) -> Result<Vec<Line>>) -> Row {
    Row {
        name,
        title,
        long: false,
        run,
    }
}
