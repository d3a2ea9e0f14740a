//! Schemas that are compared with programs of ROS 2. Times are of the wall clock, ns.

use std::fmt::Write as _;
use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

use jde_schema::prelude::*;

use crate::TIMES_FILE;

/// The beams of a scan of [`Sensors`].
const BEAMS: usize = 720;
/// The greatest number of arrivals that are recorded.
const MAX_ARRIVALS: usize = 1 << 18;

/// Exports pictures whose first bytes are the time and a number.
#[derive(Describe)]
#[schema(driver, period = "1ms")]
pub(crate) struct Talk {
    /// Bytes of a picture.
    #[modulation(default = 64, min = 16, max = 921600, fixed)]
    bytes: Modulation<u32>,
    /// The time from one picture to the next; 0 for one in each iteration.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 60.0, fixed)]
    every: Modulation<f64>,
    /// When a picture is due after each multiple of that time.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 60.0, fixed)]
    phase: Modulation<f64>,
    /// The picture.
    #[export]
    out: Export<Image>,
    number: u64,
    turn: u64,
}

/// Records when pictures of a [`Talk`] or of a program of ROS 2 were sent and arrived, and when there is none any more as one
/// that was never sent. It is never ready.
#[derive(Describe)]
#[schema(motor, period = "1s")]
pub(crate) struct Listen {
    /// The picture.
    #[import(trigger)]
    input: Import<Image>,
    last: u64,
    arrivals: Vec<[u64; 3]>,
}

/// Exports what a robot measures, at 20 Hz.
#[derive(Describe)]
#[schema(driver, period = "50ms")]
pub(crate) struct Sensors {
    /// A scan.
    #[export]
    laser: Export<LaserScan>,
    /// A picture of 640 by 480.
    #[export]
    image: Export<Image>,
    /// The pose of the base.
    #[export]
    odometry: Export<Odometry>,
}

impl Schema for Talk {
    fn iterate(&mut self, cx: &Context) -> Result {
        let sent = wall();
        let (every, phase) = (nanos(self.every.get(cx)), nanos(self.phase.get(cx)));
        let turn = sent.saturating_sub(phase) / every.max(1);
        if core::mem::replace(&mut self.turn, turn) == turn || self.number == 0 && every > 0 {
            // The first one is not on time.
            self.number = self.number.max(1);
            return Ok(());
        }
        self.number += 1;
        let bytes = self.bytes.get(cx);
        let mut image = self.out.loan(cx);
        (image.height, image.width, image.step) = (1, bytes, bytes);
        image.encoding = Text::truncated("mono8");
        let data = image.data.resize(bytes as usize);
        data[..8].copy_from_slice(&sent.to_le_bytes());
        data[8..16].copy_from_slice(&self.number.to_le_bytes());
        image.publish();
        Ok(())
    }
}

impl Schema for Listen {
    fn awake(&mut self, _: &Context) -> Result {
        self.arrivals = Vec::with_capacity(MAX_ARRIVALS);
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let arrived = wall();
        let Some(image) = self.input.get(cx) else {
            if core::mem::take(&mut self.last) != 0 {
                self.arrivals.push([0, arrived, 0]);
            }
            return Ok(false.into());
        };
        if image.sequence() != self.last && self.arrivals.len() < MAX_ARRIVALS {
            self.last = image.sequence();
            let number = |at: usize| {
                image
                    .data
                    .get(at..)?
                    .first_chunk()
                    .copied()
                    .map(u64::from_le_bytes)
            };
            if let (Some(sent), Some(number)) = (number(0), number(8)) {
                self.arrivals.push([sent, arrived, number]);
            }
        }
        Ok(false.into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        let Some(mut file) = std::env::var_os(TIMES_FILE) else {
            return;
        };
        let mut text = String::new();
        for [sent, arrived, number] in &self.arrivals {
            let _ = writeln!(text, "{} {sent} {arrived} {number}", cx.name());
        }
        file.push(format!(".{}", cx.name()));
        if let Err(error) = fs::write(file, text) {
            error!(cx, "cannot write the arrivals: {error}");
        }
    }
}

impl Schema for Sensors {
    fn iterate(&mut self, cx: &Context) -> Result {
        let mut scan = self.laser.loan(cx);
        *scan = LaserScan {
            header: header("laser"),
            angle_min: -1.57,
            angle_max: 1.57,
            angle_increment: std::f32::consts::PI / BEAMS as f32,
            range_max: 12.0,
            ranges: (0..BEAMS).map(|beam| 1.0 + beam as f32 / BEAMS as f32).collect(),
            ..LaserScan::default()
        };
        scan.publish();
        let mut image = self.image.loan(cx);
        (image.height, image.width, image.step) = (480, 640, 3 * 640);
        image.encoding = Text::truncated("rgb8");
        image.header = header("camera");
        image.data.resize(3 * 640 * 480);
        image.publish();
        let odometry = Odometry::planar(cx.now(), Pose2D::ORIGIN, Twist::planar(0.1, 0.0));
        self.odometry.write(cx, odometry);
        Ok(())
    }
}

fn header(frame: &str) -> Header {
    Header {
        frame_id: Frame::truncated(frame),
        ..Header::default()
    }
}

fn wall() -> u64 {
    let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    time.as_nanos() as u64
}

fn nanos(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}
