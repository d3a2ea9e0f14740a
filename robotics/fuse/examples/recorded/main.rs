//! Runs the filter on the measurements of a recorded drive, with what `fuse/ekf` has as its defaults. `recorded.py` beside it writes
//! them, runs another filter on the same, and compares both with positions that neither has seen.
//!
//! Each line is a time in s, a kind, and numbers: `start` (x, y, heading, their deviations), `turn` (rad/s, variance), `wheels`
//! (speeds, turn rate, whether it stands, variances of speed and turn rate), `fix` (x, y, variance) or `check`. For each `check`
//! a line has the time, the pose, and the covariance of its position; the last one has the constants.

use core::time::Duration;
use std::io::{self, BufRead, Write};

use jde_fuse::{
    Filter, Initial, Measurement, Outcome, Position, ProcessNoise, State, Thresholds, Timeline, Turn, Wheels,
};

/// Before anything is measured, beside the pose.
const INITIAL: Initial = Initial {
    position: 0.0,
    yaw: 0.0,
    bias: 0.02,
    way_scale: 0.02,
    turn_scale: 0.1,
    drift: 0.05,
};
const NOISE: ProcessNoise = ProcessNoise {
    position: 1e-6,
    yaw: 1e-7,
    vx: 0.5,
    vy: 0.01,
    rate: 0.2,
    bias: 1e-7,
    standstill: 0.5,
};
const THRESHOLDS: Thresholds = Thresholds {
    turn: 8.0,
    wheels: 5.0,
    heading: 5.0,
    position: 5.0,
    place: 5.0,
};
/// Standard deviation of the speed to the left, m/s.
const SIDE_DEVIATION: f64 = 0.01;

fn main() -> io::Result<()> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let mut timeline = None;
    let mut refused = 0;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let mut words = line.split(',');
        let time = number(words.next());
        let kind = words.next().unwrap_or_default();
        let n: Vec<f64> = words.map(|word| number(Some(word))).collect();
        let time = Duration::from_secs_f64(time);
        let measurement = match (kind, &*n) {
            ("start", [x, y, yaw, position, heading]) => {
                let state = State {
                    x: *x,
                    y: *y,
                    yaw: *yaw,
                    ..State::default()
                };
                let initial = Initial {
                    position: *position,
                    yaw: *heading,
                    ..INITIAL
                };
                let start = Filter::new(state, &initial);
                timeline = Some(Timeline::new(time, start, Duration::from_secs(1)));
                continue;
            }
            ("check", _) => {
                let Some(timeline) = &timeline else { continue };
                let filter = timeline.at(time, &NOISE);
                let (s, p) = (filter.state(), filter.pose_covariance());
                let [x, y] = [p[0], p[1]];
                writeln!(
                    out,
                    "{},{},{},{},{},{},{}",
                    time.as_secs_f64(),
                    s.x,
                    s.y,
                    s.yaw,
                    x[0],
                    x[1],
                    y[1]
                )?;
                continue;
            }
            ("turn", [rate, variance]) => Measurement::Turn(Turn {
                rate: *rate,
                variance: *variance,
            }),
            ("wheels", [ahead, left, rate, stands, of_speed, of_rate]) => Measurement::Wheels(Wheels {
                velocity: [*ahead, *left],
                rate: *rate,
                covariance: [
                    [*of_speed, 0.0, 0.0],
                    [0.0, SIDE_DEVIATION * SIDE_DEVIATION, 0.0],
                    [0.0, 0.0, *of_rate],
                ],
                lasts: Duration::ZERO,
                is_standing: *stands > 0.0,
            }),
            ("fix", [x, y, variance]) => Measurement::Position(Position {
                position: [*x, *y],
                covariance: [[*variance, 0.0], [0.0, *variance]],
                antenna: [0.0; 2],
            }),
            _ => {
                return Err(io::Error::other(format!(
                    "this is no line of measurements: {line}"
                )));
            }
        };
        let Some(timeline) = &mut timeline else { continue };
        let outcome = timeline
            .add(time, measurement, &NOISE, &THRESHOLDS)
            .map_err(io::Error::other)?;
        if outcome != Outcome::Taken {
            refused += 1;
            eprintln!("{} {kind}: {outcome:?}", time.as_secs_f64());
        }
    }
    if let Some(timeline) = &timeline {
        writeln!(out, "constants,{:?}", timeline.newest().1.state())?;
    }
    eprintln!("{refused} refused");
    out.flush()
}

fn number(word: Option<&str>) -> f64 {
    word.and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
}
