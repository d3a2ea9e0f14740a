//! The processor time of a program that publishes a scan, a picture and a transform at 20 Hz.

use std::thread;

use anyhow::{Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::Rounds;

use super::{DIRECTLY, IDLE, addresses};
use crate::programs::{Program, Programs, SETTLING};

/// What a program publishes.
const TOPICS: [&str; 4] = ["scan", "image", "odom", "/tf"];
const TYPES: [&str; 4] = [
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/Image",
    "nav_msgs/msg/Odometry",
    "tf2_msgs/msg/TFMessage",
];

pub(crate) fn run(programs: &Programs) -> Result<Vec<Line>> {
    let application = format!(
        "name = \"sensors\"\n{IDLE}[schemas.sensors]\ntype = \"bench-000/sensors\"\n\
         [schemas.topics]\ntype = \"ros2/topics\"\n{}publish.scan = \"sensors.laser\"\n\
         publish.image = \"sensors.image\"\npublish.odom = \"sensors.odometry\"\n",
        addresses(programs, DIRECTLY)
    );
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..programs.seconds(1, 5).as_secs() {
        ours.push(share(programs, || programs.jde("sensors", &application))?);
        theirs.push(share(programs, || programs.python("sensors.py", &[]))?);
    }
    let (ours, theirs) = (Rounds::of(ours), Rounds::of(theirs));
    let line = Line::compared(
        "a laser, a picture of 900 kB and a transform at 20 Hz",
        Figure::Processor(ours.median()),
        "rclpy",
        Figure::Processor(theirs.median()),
        Goal::AtMost(0.5),
    );
    Ok(vec![line.paired(ours.ratio_to(&theirs))])
}

/// Returns the share of a processor that a program needs while all its topics have a subscriber, in percent.
fn share(programs: &Programs, start: impl FnOnce() -> Result<Program>) -> Result<f64> {
    let _router = programs.router()?;
    let mut arguments = vec!["count".to_owned()];
    for (topic, name) in TOPICS.iter().zip(TYPES) {
        arguments.extend([(*topic).to_owned(), name.to_owned()]);
    }
    let counting = programs.rclcpp(&arguments)?;
    let program = start()?;
    thread::sleep(SETTLING);
    let time = programs.seconds(3, 10);
    let before = program.processor_time()?;
    thread::sleep(time);
    let share = 100.0 * (program.processor_time()? - before) / time.as_secs_f64();
    // The middleware writes its messages between.
    let text = counting.end()?;
    let counts: Vec<u64> = text.lines().filter_map(|line| line.parse().ok()).collect();
    ensure!(counts.len() == TOPICS.len(), "the topics were not counted");
    // A twentieth may be missing, and what is sent before both know each other.
    let least = 19 * (time + SETTLING / 2).as_secs();
    ensure!(
        counts.iter().all(|count| *count >= least),
        "only {counts:?} messages of {TOPICS:?} in {time:?} from {}",
        program.name
    );
    Ok(share)
}
