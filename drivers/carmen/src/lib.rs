//! Plays a CARMEN text log as the sensors of a robot, with the log's own time. Commands are exported for
//! display and have no effect, because the drive was recorded earlier. A replay shows how schemas would have
//! decided, not how the robot would have moved.

mod log;

use core::time::Duration;
use std::path::Path;

use jde_schema::prelude::*;
use jde_schema::types::{Body, Mount};

use log::{LogError, LogFile as Recording, Scan};

/// Most bytes of a log, unpacked: an hour of 361 beams, 37 times a second.
const MAX_BYTES: u64 = 256 << 20;
/// The name of the laser's frame.
const LASER: &str = "laser";

/// A robot that repeats the drive of a log.
///
/// It reads the scans of one laser (`FLASER`, `ROBOTLASER1`, else `RAWLASER1` or those of the rear) and the `ODOM`
/// lines, plain or gzip, and names all others. The scans are in the frame of the laser, and `body` states where the
/// laser is on the robot. If the clocks of a log are not usable, it is played at the rate of `interval`. The mission
/// is done when the log ends.
#[derive(Describe)]
#[schema(driver, period = "20ms", budget = "20ms")]
pub struct Log {
    /// The log file.
    #[modulation(default = "", unit = "file", fixed)]
    path: Modulation<Text<1024>>,
    /// Ranges from this one on count as beams without a return.
    #[modulation(default = 80.0, unit = "m", min = 0.1, fixed)]
    laser_range: Modulation<f64>,
    /// Least time between scans in a log without a usable clock.
    #[modulation(default = 0.2, unit = "s", min = 0.001, max = 3600.0, fixed)]
    interval: Modulation<f64>,
    /// Speeds of the base, which have no effect.
    #[command(neutral = Twist::ZERO, validity = "1s")]
    velocity: Command<Twist>,
    /// The command in force, for display and recording.
    #[export]
    wanted: Export<Twist>,
    /// The scan of the laser, in its own frame.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// The robot's pose in the log. Between two that are far apart, it is interpolated.
    #[export(validity = "1s")]
    odometry: Export<Odometry>,
    /// Where the laser is on the robot.
    #[export(lasting)]
    body: Export<Body>,
    /// Scans played, and their total.
    #[export(lasting)]
    mission: Export<Mission>,
    recording: Option<Recording>,
    next: usize,
    scans: u32,
}

impl Schema for Log {
    fn awake(&mut self, cx: &Context) -> Result {
        if let Some(recording) = &self.recording {
            self.body.write(cx, body(cx.now(), recording));
            return Ok(());
        }
        let recording = self.recording(cx)?;
        for note in recording.notes() {
            warn!(cx, "{note}");
        }
        info!(
            cx,
            "{} scans over {:.1} s",
            recording.scans(),
            recording.duration().as_secs_f64()
        );
        self.body.write(cx, body(cx.now(), &recording));
        self.recording = Some(recording);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.wanted.write(cx, *self.velocity.get(cx).value());
        let Some(recording) = self.recording.take() else {
            return Err("it has no log".into());
        };
        while let Some(record) = recording
            .records()
            .get(self.next)
            .filter(|record| record.time <= cx.now())
        {
            self.next += 1;
            self.odometry.write_at(
                cx,
                Odometry::planar(record.time, record.pose, Twist::ZERO),
                record.time,
            );
            if let Some(scan) = &record.scan {
                self.scans += 1;
                self.publish(cx, record.time, scan, recording.no_return())?;
            }
        }
        if let Some(pose) = recording.pose_between(self.next, cx.now()) {
            let odometry = Odometry::planar(cx.now(), pose, Twist::ZERO);
            self.odometry.write_at(cx, odometry, cx.now());
        }
        let ended = self.next == recording.records().len();
        let mission = Mission {
            state: if ended { Mission::DONE } else { Mission::RUNNING },
            reached: self.scans,
            total: recording.scans() as u32,
            note: Text::new("scans played"),
            ..Mission::default()
        };
        self.mission.write(cx, mission);
        self.recording = Some(recording);
        Ok(())
    }
}

impl Inspect for Log {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.path, self.recording(cx));
    }
}

impl Log {
    fn recording(&self, cx: &Context) -> Result<Recording> {
        let path = self.path.get(cx);
        if path.is_empty() {
            return Err(
                "it has no log; give it one: path = \"drive.log.gz\", or --set NAME.path=drive.log.gz".into(),
            );
        }
        let interval = Duration::from_secs_f64(self.interval.get(cx));
        let path = path.as_str();
        let (bytes, damage) =
            jde_files::read_undamaged(Path::new(path), MAX_BYTES).map_err(|error| LogError::Io {
                path: path.to_owned(),
                error,
            })?;
        Ok(Recording::of(&bytes, damage, path, interval)?)
    }

    fn publish(&mut self, cx: &Context, time: Duration, scan: &Scan, no_return: Option<f32>) -> Result {
        let max_range = (self.laser_range.get(cx) as f32)
            .min(scan.reach)
            .min(no_return.unwrap_or(f32::INFINITY));
        let mut laser = self.laser.loan(cx);
        laser.header = Header::new(time, LASER);
        laser.angle_min = scan.angle_min as f32;
        laser.angle_increment = scan.angle_increment as f32;
        laser.time_increment = 0.0;
        laser.scan_time = 0.0;
        laser.range_min = 0.0;
        laser.range_max = max_range;
        laser.intensities.clear();
        laser.ranges.clear();
        laser.ranges.extend_from_slice(&scan.ranges)?;
        for range in laser
            .ranges
            .as_mut_slice()
            .iter_mut()
            .filter(|range| **range >= max_range)
        {
            *range = f32::INFINITY;
        }
        laser.state_last_angle();
        laser.publish_at(time);
        Ok(())
    }
}

/// Returns where the laser is; the outline of the robot is not known.
fn body(now: Duration, recording: &Recording) -> Body {
    let laser = Mount {
        frame: Text::new(LASER),
        pose: recording.mount(),
    };
    Body {
        header: Header::new(now, "base_link"),
        lasers: [laser].into_iter().collect(),
        ..Body::default()
    }
}

jde_schema::export!("carmen", "Plays a CARMEN log as laser and odometry.", [Log]);

#[cfg(test)]
mod tests;
