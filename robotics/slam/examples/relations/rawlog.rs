//! A log in the form that the programs of MRPT read, version 2.5.8: for each scan a motion with its noise, and the ranges.

use jde_types::Pose2D;

use crate::{NOISE, Record};

/// What is added to the standard deviations of a motion, m and rad: a robot that stands has a covariance too.
const LEAST_NOISE: (f32, f32) = (0.001, 0.001);
/// The greatest range, m.
const RANGE: f32 = 50.0;

/// The records as a rawlog, a second apart. The laser is at `x` on the base.
pub(crate) fn rawlog(records: &[Record], x: f64) -> Vec<u8> {
    let mut log = Vec::new();
    let mut last = records.first().map_or(Pose2D::ORIGIN, |record| record.odometry);
    for (time, record) in (1..).zip(records) {
        // In units of 100 ns.
        let time = (time * 10_000_000_u64).to_le_bytes();
        let motion = motion(&last.localize(&record.odometry), time);
        let scan = scan(record, x, time);
        last = record.odometry;
        object(
            &mut log,
            "obs::CActionCollection",
            0,
            &[1_u32.to_le_bytes().to_vec(), motion].concat(),
        );
        object(
            &mut log,
            "obs::CSensoryFrame",
            2,
            &[1_u32.to_le_bytes().to_vec(), scan].concat(),
        );
    }
    log
}

fn object(to: &mut Vec<u8>, name: &str, version: u8, content: &[u8]) {
    let name = format!("mrpt::{name}");
    to.push(name.len() as u8 | 0x80);
    to.extend(name.bytes());
    to.push(version);
    to.extend(content);
    to.push(0x88);
}

fn doubles(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    values.into_iter().flat_map(f64::to_le_bytes).collect()
}

fn floats(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

fn motion(motion: &Pose2D, time: [u8; 8]) -> Vec<u8> {
    let (way, turn, turn_by_way) = (NOISE.0 as f32, NOISE.1 as f32, NOISE.2 as f32);
    // By odometry.
    let mut content = 0_u32.to_le_bytes().to_vec();
    object(
        &mut content,
        "poses::CPose2D",
        1,
        &doubles([motion.x, motion.y, motion.theta]),
    );
    // Gaussian: way by way, way by turn, turn by way, turn by turn. The model with particles behind it is not used.
    content.extend(0_u32.to_le_bytes());
    content.extend(floats([
        way,
        0.0,
        turn_by_way,
        turn,
        LEAST_NOISE.0,
        LEAST_NOISE.1,
    ]));
    content.extend(0_u32.to_le_bytes());
    content.extend(floats([0.0; 6]));
    // Neither velocities nor encoders.
    content.extend([0, 0]);
    content.extend(time);
    let mut action = Vec::new();
    object(&mut action, "obs::CActionRobotMovement2D", 7, &content);
    action
}

fn scan(record: &Record, x: f64, time: [u8; 8]) -> Vec<u8> {
    let scan = &record.scan;
    let aperture = scan.angle_increment * scan.ranges.len().saturating_sub(1) as f32;
    // The beams are symmetric about the sensor's axis.
    let (sin, cos) = f64::from(scan.angle_min + aperture / 2.0).sin_cos();
    let mut content = floats([aperture]);
    // From right to left.
    content.push(1);
    content.extend(floats([RANGE]));
    let pose = [x, 0.0, 0.0, cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0];
    object(&mut content, "poses::CPose3D", 3, &doubles(pose));
    content.extend((scan.ranges.len() as u32).to_le_bytes());
    content.extend(floats(
        scan.ranges
            .iter()
            .map(|range| if range.is_finite() { *range } else { RANGE }),
    ));
    content.extend(scan.ranges.iter().map(|range| u8::from(range.is_finite())));
    // The standard error of a range, m.
    content.extend(floats([0.01]));
    content.extend(time);
    // The width of a beam, rad, no label, no pitch, no intensities.
    content.extend(floats([0.0]));
    content.extend(0_u32.to_le_bytes());
    content.extend(doubles([0.0]));
    content.push(0);
    let mut observation = Vec::new();
    object(&mut observation, "obs::CObservation2DRangeScan", 7, &content);
    observation
}
