//! The rows of the table, in its order. Each measures one claim, which `docs/figures/ros2.md` explains.

mod arbiter;
mod many;
mod nodes;
mod processor;
mod transfer;
mod wifi;

use anyhow::Result;
use jde_measure::figure::Line;

use crate::programs::Programs;

/// A row: one claim, in one or more lines.
pub(crate) struct Row {
    /// The name for `--row`.
    pub(crate) name: &'static str,
    /// What it measures.
    pub(crate) title: &'static str,
    pub(crate) run: fn(&Programs) -> Result<Vec<Line>>,
}

/// The beginning of an application that only publishes.
const IDLE: &str =
    "roots = [\"idle\"]\nawake = [\"topics\"]\n[schemas.idle]\ntype = \"bench-000/act\"\nperiod = \"1s\"\n";

/// What a driver without addresses has, but with the router of this run: it connects to other nodes directly.
const DIRECTLY: &str = "listen = \"tcp/127.0.0.1:0\"\n";
/// All messages pass through the router.
const BY_ROUTER: &str = "";

/// The addresses of a driver.
fn addresses(programs: &Programs, listen: &str) -> String {
    format!("connect = \"tcp/127.0.0.1:{}\"\n{listen}", programs.port)
}

pub(crate) const ROWS: &[Row] = &[
    row("transfer", "a message from one program to another", transfer::run),
    row("rate", "messages as fast as they pass", transfer::rate),
    row("processor", "processor time of a driver at 20 Hz", processor::run),
    row("topics", "a hundred topics at 50 Hz", many::run),
    row("restart", "the router ends and starts again", many::restart),
    row("nodes", "two hundred other nodes", nodes::run),
    row("arbiter", "from a source's velocity to the robot's", arbiter::run),
    row("wifi", "a network that loses a fifth of all packets", wifi::run),
];

const fn row(name: &'static str, title: &'static str, run: fn(&Programs) -> Result<Vec<Line>>) -> Row {
    Row { name, title, run }
}
