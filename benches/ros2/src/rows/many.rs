//! A hundred topics at 50 Hz: what is lost, and what is lost while the router ends and starts again.

use std::thread;
use std::time::Duration;

use anyhow::{Context as _, Result};
use jde_measure::figure::{Figure, Goal, Line};

use super::{BY_ROUTER, DIRECTLY, IDLE, addresses};
use crate::arrivals::{Arrivals, lost, now};
use crate::programs::{Program, Programs, SETTLING};

const TOPICS: usize = 100;
/// The time without a router.
const OUTAGE: Duration = Duration::from_secs(3);

/// What arrived in a time, and the processor time of the program that sent it.
struct Sent {
    all: Arrivals,
    within: (u64, u64),
    processor: f64,
    /// When the router was there again.
    restarted: u64,
}

/// Nothing is lost.
pub(crate) fn run(programs: &Programs) -> Result<Vec<Line>> {
    let time = programs.seconds(6, 60);
    let ours = send(programs, || jde(programs, DIRECTLY), time, false)?;
    let theirs = send(programs, || rclcpp(programs), time, false)?;
    let what = format!("{TOPICS} topics at 50 Hz for {} s", time.as_secs());
    let share = |sent: &Sent| Figure::Processor(100.0 * sent.processor / time.as_secs_f64());
    Ok(vec![
        Line::compared(
            format!("{what}: messages lost"),
            Figure::Count(ours.lost()? as f64),
            "rclcpp",
            Figure::Count(theirs.lost()? as f64),
            Goal::Below(Figure::Count(0.0)),
        ),
        Line::compared(
            format!("{what}: processor time"),
            share(&ours),
            "rclcpp",
            share(&theirs),
            Goal::ReportOnly,
        ),
    ])
}

/// The router is killed, and started again 3 s later.
pub(crate) fn restart(programs: &Programs) -> Result<Vec<Line>> {
    let time = Duration::from_secs(8);
    let theirs = send(programs, || rclcpp(programs), time, true)?;
    let mut lines = Vec::new();
    for (what, listen) in [("by the router", BY_ROUTER), ("directly", DIRECTLY)] {
        let ours = send(programs, || jde(programs, listen), time, true)?;
        lines.push(Line::compared(
            format!("no router for 3 s, {what}: messages lost of each topic"),
            Figure::Count(ours.lost()? as f64 / TOPICS as f64),
            "rclcpp",
            Figure::Count(theirs.lost()? as f64 / TOPICS as f64),
            Goal::ReportOnly,
        ));
        lines.push(Line::compared(
            format!("no router for 3 s, {what}: from its start until all topics pass"),
            Figure::Time(ours.back()?),
            "rclcpp",
            Figure::Time(theirs.back()?),
            Goal::Below(Figure::Time(5e9)),
        ));
    }
    Ok(lines)
}

/// The application whose driver publishes.
fn jde(programs: &Programs, listen: &str) -> Result<Program> {
    let publish: String = topics()
        .map(|topic| format!("publish.{topic} = \"talk.out\"\n"))
        .collect();
    let application = format!(
        "name = \"many\"\n{IDLE}[schemas.talk]\ntype = \"bench-000/talk\"\nevery = 0.02\n\
         [schemas.topics]\ntype = \"ros2/topics\"\n{}{publish}",
        addresses(programs, listen)
    );
    programs.jde("many", &application)
}

/// The program of rclcpp that publishes.
fn rclcpp(programs: &Programs) -> Result<Program> {
    let mut arguments = vec!["talk".to_owned()];
    arguments.extend(topics().flat_map(|topic| [topic, "64".to_owned(), "20".to_owned(), "0".to_owned()]));
    programs.rclcpp(&arguments)
}

fn topics() -> impl Iterator<Item = String> {
    (0..TOPICS).map(|number| format!("t{number}"))
}

/// Lets a program send for a time, in the middle of which the router may be away.
fn send(
    programs: &Programs,
    start: impl FnOnce() -> Result<Program>,
    time: Duration,
    outage: bool,
) -> Result<Sent> {
    let mut router = programs.router()?;
    let listen = programs.rclcpp(
        &["listen".to_owned()]
            .into_iter()
            .chain(topics())
            .collect::<Vec<_>>(),
    )?;
    let program = start()?;
    thread::sleep(SETTLING);
    let (from, before) = (now(), program.processor_time()?);
    let mut restarted = from;
    if outage {
        thread::sleep(Duration::from_secs(2));
        drop(router);
        thread::sleep(OUTAGE);
        router = programs.router()?;
        restarted = now();
    }
    thread::sleep(time);
    let (to, processor) = (now(), program.processor_time()? - before);
    thread::sleep(SETTLING / 4);
    let text = listen.end()?;
    drop(router);
    Ok(Sent {
        all: Arrivals::read(&text),
        within: (from, to),
        processor,
        restarted,
    })
}

impl Sent {
    /// The messages of all topics that were lost.
    fn lost(&self) -> Result<u64> {
        let mut sum = 0;
        for topic in topics() {
            let arrivals = self.all.of(&topic, self.within);
            anyhow::ensure!(!arrivals.is_empty(), "no message of `{topic}` arrived");
            sum += lost(&arrivals);
        }
        Ok(sum)
    }

    /// The time from the start of the router until the last topic passed, ns.
    fn back(&self) -> Result<f64> {
        let mut longest = 0;
        for topic in topics() {
            let all = self.all.of(&topic, (self.restarted, self.within.1));
            let first = all.iter().map(|arrival| arrival.arrived).min();
            let first = first.with_context(|| format!("no message of `{topic}` arrived afterwards"))?;
            longest = longest.max(first - self.restarted);
        }
        Ok(longest as f64)
    }
}
