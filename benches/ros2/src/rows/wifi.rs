//! Commands to a robot over a network that loses a fifth of all packets, and then all of them for a time: how old they are, when
//! the robot notices, and when it has commands again. Beside a program of rclcpp on the same robot.

use std::thread;
use std::time::Duration;

use anyhow::{Context as _, Result};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::quantile;

use crate::arrivals::{Arrival, Arrivals, now};
use crate::programs::{Programs, SETTLING};

/// The network namespace of the robot, and its address.
const ROBOT: &str = "jde-bench-robot";
const ADDRESS: &str = "10.77.63.2";
/// The loss in percent.
const LOSS: &str = "20";
/// The time without a network.
const OUTAGE: Duration = Duration::from_secs(5);

pub(crate) fn run(programs: &Programs) -> Result<Vec<Line>> {
    let mut network = programs.python("lossy.py", &[ROBOT, "0"])?;
    let (robot, base) = (programs.inside(ROBOT), programs.at(ADDRESS));
    let _router = robot.router()?;
    let application = format!(
        "name = \"wifi\"\nroots = [\"heard\"]\n[schemas.topics]\ntype = \"ros2/topics\"\nconnect = \"tcp/127.0.0.1:{}\"\n\
         subscribe.command = {{ as = \"command\", stale = \"500ms\" }}\n\
         [schemas.heard]\ntype = \"bench-000/listen\"\nimports = {{ input = \"topics.command\" }}\n",
        programs.port
    );
    let jde = robot.jde("wifi", &application)?;
    let listen = robot.rclcpp(&["listen", "command"].map(str::to_owned))?;
    let talk = base.rclcpp(&["talk", "command", "64", "50", "0"].map(str::to_owned))?;
    thread::sleep(SETTLING);
    network.write(LOSS)?;
    let from = now();
    thread::sleep(programs.seconds(6, 60));
    let to = now();
    network.write("100")?;
    let cut = now();
    thread::sleep(OUTAGE);
    network.write(LOSS)?;
    let back = now();
    thread::sleep(Duration::from_secs(20));
    talk.end()?;
    jde.terminate()?;
    let theirs = Arrivals::read(&listen.end()?).of("command", (0, u64::MAX));
    let ours = Arrivals::read(&programs.recorded("wifi", "heard")?).of("heard", (0, u64::MAX));
    network.end()?;
    let line = |what: String, figure: &dyn Fn(&[Arrival]) -> Result<f64>, goal| -> Result<Line> {
        let (ours, theirs) = (figure(&ours)?, figure(&theirs)?);
        Ok(Line::compared(
            what,
            Figure::Time(ours),
            "rclcpp",
            Figure::Time(theirs),
            goal,
        ))
    };
    let age = |share: f64| {
        move |arrivals: &[Arrival]| {
            let sent = arrivals
                .iter()
                .filter(|arrival| (from..to).contains(&arrival.sent));
            let ages: Vec<f64> = sent.map(Arrival::age).collect();
            anyhow::ensure!(!ages.is_empty(), "no command arrived");
            Ok(quantile(ages, share))
        }
    };
    let returned = |arrivals: &[Arrival]| {
        let mut after = arrivals
            .iter()
            .filter(|arrival| arrival.sent > 0 && arrival.arrived > back);
        let first = after.next().context("no command arrived after the outage")?;
        Ok((first.arrived - back) as f64)
    };
    // A value that is retracted is recorded as one that was never sent.
    let mut retracted = ours
        .iter()
        .filter(|arrival| arrival.sent == 0 && arrival.arrived > cut);
    let retracted = retracted.next().context("the robot did not notice the outage")?;
    let last = ours
        .iter()
        .rfind(|arrival| arrival.sent > 0 && arrival.arrived < retracted.arrived);
    let last = last.context("no command arrived before the outage")?;
    Ok(vec![
        line(
            format!("{LOSS} % of the packets are lost: age of commands, median"),
            &age(0.5),
            Goal::ReportOnly,
        )?,
        line(
            format!("{LOSS} % of the packets are lost: age of commands, p99"),
            &age(0.99),
            Goal::ReportOnly,
        )?,
        Line::new(
            "no network: from the last command until there is none",
            Figure::Time((retracted.arrived - last.arrived) as f64),
            Goal::Below(Figure::millis(550.0)),
        ),
        line(
            format!(
                "no network for {} s: from its return to the next command",
                OUTAGE.as_secs()
            ),
            &returned,
            Goal::ReportOnly,
        )?,
    ])
}
