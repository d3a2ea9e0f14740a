//! Writes a drive as a CARMEN log, as measured by the laser and the wheels: out of the lab of the office,
//! along the corridor and into the next room. It follows fixed way-points, and waits for things in its way;
//! it avoids nothing.
//!
//! ```text
//! cargo run -p jde-sim --example record_log > apps/logs/hall.log
//! ```
//!
//! The command writes the same bytes every time: `FLASER n r0 .. rn-1 x y theta odom_x odom_y odom_theta time
//! host time`, twice a second.

use std::fmt::Write as _;
use std::io::Write as _;

use jde_sim::{LaserConfig, OdometryOrigin, Pose2, RobotConfig, Twist2, World, wrap_angle};

const WORLD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../worlds/office.toml");
const WAY: [[f64; 2]; 3] = [[3.55, 7.1], [9.55, 7.1], [9.55, 3.2]];
/// Time between commands, ns.
const TICK: u64 = 100_000_000;
/// Time between lines of the log, ns.
const LINE: u64 = 5 * TICK;
/// The reading of a SICK laser for a beam without a return, m.
const NOTHING: f32 = 81.83;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::load(WORLD, 2007)?;
    let config = RobotConfig {
        odometry_origin: OdometryOrigin::StartPose,
        ..RobotConfig::default()
    };
    let robot = world.add_robot("pioneer", config)?;
    let laser = LaserConfig::default();
    let mut ranges = vec![0.0; laser.beams];
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "# A drive of `cargo run -p jde-sim --example record_log` in worlds/office.toml"
    )?;
    let mut now = 0;
    for [x, y] in WAY {
        loop {
            world.advance_to(now);
            world.laser(robot, &laser, &mut ranges)?;
            let pose = world.odometry(robot).pose;
            if now % LINE == 0 {
                writeln!(out, "{}", line(&ranges, pose, now))?;
            }
            now += TICK;
            let (ahead, aside) = (x - pose.x, y - pose.y);
            if ahead.hypot(aside) < 0.2 {
                break;
            }
            let error = wrap_angle(aside.atan2(ahead) - pose.heading);
            world.command(robot, toward(error, is_free(&laser, &ranges)))?;
        }
    }
    Ok(())
}

/// Returns the command: straight ahead, a turn on the spot, or a wait.
fn toward(error: f64, free: bool) -> Twist2 {
    if error.abs() > 0.3 {
        Twist2::new(0.0, 0.6_f64.copysign(error))
    } else if free {
        Twist2::new(0.4, error)
    } else {
        Twist2::default()
    }
}

fn is_free(laser: &LaserConfig, ranges: &[f32]) -> bool {
    ranges.iter().enumerate().all(|(beam, range)| {
        let (sin, cos) = laser.angle(beam).sin_cos();
        let range = f64::from(*range);
        range * cos > 0.8 || (range * sin).abs() > 0.35
    })
}

fn line(ranges: &[f32], pose: Pose2, now: u64) -> String {
    let mut line = format!("FLASER {}", ranges.len());
    for range in ranges {
        let range = if range.is_finite() { *range } else { NOTHING };
        write!(line, " {range:.2}").expect("a String takes all");
    }
    let Pose2 { x, y, heading } = pose;
    // A time of 0 would mean that there is none.
    let time = 1.0 + now as f64 * 1e-9;
    for _ in 0..2 {
        write!(line, " {x:.4} {y:.4} {heading:.4}").expect("a String takes all");
    }
    format!("{line} {time:.3} hall {time:.3}")
}
