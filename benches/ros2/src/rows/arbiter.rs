//! The time from a source's velocity to the robot's, beside `twist_mux`, in turns.

use anyhow::{Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, median};

use super::{DIRECTLY, addresses};
use crate::programs::{Programs, SETTLING};

/// The parameters of `twist_mux`: one source.
const MUX: &str = "/**:\n  ros__parameters:\n    use_stamped: false\n    topics:\n      navigation:\n        \
                   topic: mux/source\n        timeout: 0.5\n        priority: 10\n";

pub(crate) fn run(programs: &Programs) -> Result<Vec<Line>> {
    let parameters = programs.folder.path().join("mux.yaml");
    std::fs::write(&parameters, MUX)?;
    let _router = programs.router()?;
    let arguments = [
        "--ros-args",
        "--params-file",
        &parameters.display().to_string(),
        "-r",
        "cmd_vel_out:=mux/robot",
    ];
    let _mux = programs.node("twist_mux", &arguments.map(str::to_owned))?;
    let _jde = programs.jde("jde", &application(programs))?;
    std::thread::sleep(SETTLING);
    let mut rounds = [Vec::new(), Vec::new()];
    for _ in 0..programs.seconds(2, 10).as_secs() {
        for (rounds, side) in rounds.iter_mut().zip(["jde", "mux"]) {
            rounds.push(round(programs, side)?);
        }
    }
    let [ours, theirs] = rounds.map(Rounds::of);
    let line = Line::compared(
        "a velocity through an arbiter",
        Figure::Time(ours.median()),
        "twist_mux",
        Figure::Time(theirs.median()),
        Goal::AtMost(1.1),
    );
    Ok(vec![line.paired(ours.ratio_to(&theirs))])
}

/// An application like `apps/ros2-arbiter.toml`, with topics of its own.
fn application(programs: &Programs) -> String {
    let addresses = addresses(programs, DIRECTLY);
    format!(
        "name = \"jde\"\nroots = [\"navigation\"]\n[schemas.robot]\ntype = \"ros2/base\"\n\
         velocity_topic = \"jde/robot\"\n{addresses}[schemas.navigation]\ntype = \"ros2/follow\"\n\
         topic = \"jde/source\"\nactuators = {{ base = \"robot.velocity\" }}\n{addresses}"
    )
}

/// Returns the median time of some velocities, ns.
fn round(programs: &Programs, side: &str) -> Result<f64> {
    const COUNT: usize = 60;
    let arguments = [
        "drive",
        &format!("{side}/source"),
        &format!("{side}/robot"),
        &COUNT.to_string(),
    ];
    let text = programs.rclcpp(&arguments.map(str::to_owned))?.output()?;
    // The middleware writes its messages between.
    let times: Vec<f64> = text.lines().filter_map(|line| line.parse().ok()).collect();
    ensure!(
        times.len() > COUNT / 2,
        "{side} let {} of {COUNT} velocities pass",
        times.len()
    );
    Ok(median(times))
}
