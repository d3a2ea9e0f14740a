//! Compares the estimate with the truth on simulated drives, and writes the measurements of the first one for the filter
//! beside it, `peer.py`:
//!
//! ```sh
//! cargo run --release -p jde-fuse --example peer -- 20 > drives.csv      # the errors are printed to the error stream
//! pip install filterpy && python3 robotics/fuse/examples/peer/peer.py drives.csv
//! ```
//!
//! Each line is the number of the drive, a time in s, a kind, and numbers: those of the gyro (`turn`), of the wheels
//! (`wheels`: speeds, turn rate, whether it stands), of a fix (`fix`) or of the true pose (`truth`).

use core::time::Duration;
use std::io::{self, Write};
use std::time::Instant;

use jde_fuse::Measurement;

#[expect(dead_code, reason = "tests use the rest")]
#[path = "../../tests/it/drive.rs"]
mod drive;

use drive::{Drive, angle, take, timeline};

/// The legs of a drive: s, m/s and rad/s.
const LEGS: [(f64, f64, f64); 12] = [
    (3.0, 0.0, 0.0),
    (8.0, 0.5, 0.0),
    (5.0, 0.4, 0.8),
    (3.0, 0.0, 0.0),
    (5.0, 0.0, -1.0),
    (8.0, 0.6, -0.3),
    (8.0, 0.3, 0.5),
    (3.0, 0.0, 0.0),
    (8.0, 0.5, 0.1),
    (8.0, 0.5, -0.6),
    (6.0, 0.2, 0.9),
    (5.0, 0.6, 0.0),
];

fn main() -> io::Result<()> {
    let drives: u64 = std::env::args()
        .nth(1)
        .and_then(|number| number.parse().ok())
        .unwrap_or(20);
    let mut out = io::BufWriter::new(io::stdout().lock());
    let mut sums = [[0.0; 4]; 2];
    let (mut taken, mut measurements) = (Duration::ZERO, 0);
    for number in 0..drives {
        for (fixes, sum) in [false, true].into_iter().zip(&mut sums) {
            let mut drive = Drive::new(number);
            (drive.has_fixes, drive.bias_growth) = (fixes, drive::NOISE.bias);
            LEGS.iter()
                .for_each(|(seconds, vx, rate)| drive.go(*seconds, *vx, *rate));
            let mut timeline = timeline();
            let start = Instant::now();
            take(&mut timeline, &drive.log);
            taken += start.elapsed();
            measurements += drive.log.len();
            let filter = timeline.newest().1;
            let (state, truth) = (filter.state(), drive.truth);
            let errors = [
                (state.x - truth.x).hypot(state.y - truth.y),
                angle(state.yaw - truth.yaw),
                state.bias - truth.bias,
            ];
            for (sum, error) in sum.iter_mut().zip(errors) {
                *sum += error * error;
            }
            sum[3] += drive.nees(filter);
            let key = format!("{number}{}", if fixes { "f" } else { "" });
            for (time, measurement) in &drive.log {
                let time = time.as_secs_f64();
                match measurement {
                    Measurement::Turn(turn) => writeln!(out, "{key},{time},turn,{}", turn.rate)?,
                    Measurement::Wheels(wheels) => {
                        let [ahead, left] = wheels.velocity;
                        let stands = u8::from(wheels.is_standing);
                        writeln!(out, "{key},{time},wheels,{ahead},{left},{},{stands}", wheels.rate)?;
                    }
                    Measurement::Position(fix) => {
                        let [x, y] = fix.position;
                        writeln!(out, "{key},{time},fix,{x},{y}")?;
                    }
                    Measurement::Heading(_) | Measurement::Place(_) => {}
                }
            }
            let bias = truth.bias;
            writeln!(out, "{key},0,truth,{},{},{},{bias}", truth.x, truth.y, truth.yaw)?;
        }
    }
    for (name, sum) in ["wheels and gyro", "with fixes"].into_iter().zip(sums) {
        let [way, turn, bias, nees] = sum.map(|sum| sum / drives as f64);
        eprintln!(
            "{name}: {:.3} m, {:.2} degrees, bias {:.3} degrees/s, NEES {nees:.2}",
            way.sqrt(),
            turn.sqrt().to_degrees(),
            bias.sqrt().to_degrees()
        );
    }
    eprintln!(
        "{:.2} us a measurement",
        taken.as_secs_f64() * 1e6 / measurements as f64
    );
    out.flush()
}
