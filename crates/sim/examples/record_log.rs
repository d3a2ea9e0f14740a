//! Drives a robot through a simulated building and writes what it measures as a CARMEN log: how `apps/logs/hall.log` was made.
//!
//! ```text
//! cargo run -p jde-sim --example record_log > apps/logs/hall.log
//! ```
//!
//! The same every time; it steers by where the robot truly is and stops for nothing that moves.

use std::fmt::Write;
use std::path::Path;

use jde_sim::{LaserConfig, OdometryOrigin, Pose2, RobotConfig, Twist2, World};

/// Out of the lab, along the corridor, into the office.
const ROUTE: [[f64; 2]; 3] = [[3.55, 7.1], [9.55, 7.1], [9.55, 3.5]];
/// Time between scans: a log of a hundred scans is enough to look at.
const STEP_NS: u64 = 400_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::load(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../worlds/office.toml"),
        7,
    )?;
    let config = RobotConfig {
        odometry_origin: OdometryOrigin::StartPose,
        ..RobotConfig::default()
    };
    let robot = world.add_robot("pioneer", config)?;
    let laser = LaserConfig::default();
    let mut ranges = vec![0.0; laser.beams];
    let mut log =
        String::from("# A drive through a simulated office, made by the example record_log of jde-sim.\n");
    for target in ROUTE {
        loop {
            world.laser(robot, &laser, &mut ranges)?;
            let (truth, odometry) = (world.truth(robot).pose, world.odometry(robot).pose);
            flaser(
                &mut log,
                &ranges,
                laser.range_max,
                truth,
                odometry,
                world.now() as f64 / 1e9,
            )?;
            let (dx, dy) = (target[0] - truth.x, target[1] - truth.y);
            if dx.hypot(dy) < 0.3 {
                break;
            }
            let error = jde_sim::wrap_angle(dy.atan2(dx) - truth.heading);
            let ahead = if error.abs() < 0.5 { 0.4 } else { 0.0 };
            world.command(robot, Twist2::new(ahead, error.clamp(-0.8, 0.8)))?;
            world.advance_to(world.now() + STEP_NS);
        }
    }
    print!("{log}");
    Ok(())
}

/// `FLASER n ranges x y theta odom_x odom_y odom_theta ipc_timestamp host logger_timestamp`.
fn flaser(
    log: &mut String,
    ranges: &[f32],
    range_max: f64,
    pose: Pose2,
    odometry: Pose2,
    time: f64,
) -> std::fmt::Result {
    write!(log, "FLASER {}", ranges.len())?;
    for range in ranges {
        // CARMEN writes the greatest number of the device where a beam met nothing.
        write!(
            log,
            " {:.2}",
            if range.is_finite() {
                f64::from(*range)
            } else {
                10.0 * range_max
            }
        )?;
    }
    for Pose2 { x, y, heading } in [pose, odometry] {
        write!(log, " {x:.3} {y:.3} {heading:.4}")?;
    }
    writeln!(log, " {time:.3} jde {time:.3}")
}
