//! The numbers of each kind of source, in SI units, from the values of variables.

use jde_types::{Echo, LaserScan, Odometry, Path, Pose2D};

/// Writes the least distance in each of as many equal sectors as `to` has, from one angle to another, counter-clockwise. A
/// direction in which nothing is counts as free up to the greatest distance of the sensor.
///
/// # Errors
/// A sector has no measurement, and `unknown` is none.
pub(crate) fn rays(
    scan: &LaserScan,
    from: f64,
    until: f64,
    unknown: Option<f64>,
    to: &mut [f64],
) -> Result<(), String> {
    let width = (until - from) / to.len() as f64;
    to.fill(f64::NAN);
    for (beam, echo) in scan.echoes() {
        let distance = match echo {
            Echo::Hit(distance) => f64::from(distance),
            Echo::Free => f64::from(scan.range_max),
            Echo::TooClose => f64::from(scan.range_min),
            Echo::Nothing => continue,
        };
        let sector = ((scan.angle(beam) - from) / width).floor();
        if sector >= 0.0 && (sector as usize) < to.len() {
            let least = &mut to[sector as usize];
            // Not NaN, which a sector without a measurement still is.
            *least = least.min(distance);
        }
    }
    for (index, distance) in to.iter_mut().enumerate() {
        if distance.is_nan() {
            let middle = (from + (index as f64 + 0.5) * width).to_degrees();
            *distance =
                unknown.ok_or_else(|| format!("no beam measures anything around {middle:.0} degrees"))?;
        }
    }
    Ok(())
}

/// Returns the pose of an odometry.
///
/// # Errors
/// A number of it is not finite.
pub(crate) fn pose(odometry: &Odometry) -> Result<Pose2D, String> {
    let pose = odometry.pose2d();
    match pose.is_finite() {
        true => Ok(pose),
        false => Err("it is not finite".to_owned()),
    }
}

/// Returns the point of a path that is `ahead` m along it from the pose nearest to the robot; its last one if it ends before.
///
/// # Errors
/// The path has no pose, or one that is not finite.
pub(crate) fn ahead_on(path: &Path, here: &Pose2D, ahead: f64) -> Result<Pose2D, String> {
    let poses: Vec<Pose2D> = path.poses.iter().map(|stamped| stamped.pose.into()).collect();
    if !poses.iter().all(Pose2D::is_finite) {
        return Err("a pose of it is not finite".to_owned());
    }
    let nearest = poses
        .iter()
        .enumerate()
        .min_by(|(_, a), (_, b)| here.distance_to(a).total_cmp(&here.distance_to(b)));
    let (nearest, _) = nearest.ok_or("it is empty")?;
    let mut left = ahead;
    for pair in poses[nearest..].windows(2) {
        let length = pair[0].distance_to(&pair[1]);
        if length >= left && length > 0.0 {
            let share = left / length;
            let between = |a: f64, b: f64| a + share * (b - a);
            return Ok(Pose2D::new(
                between(pair[0].x, pair[1].x),
                between(pair[0].y, pair[1].y),
                0.0,
            ));
        }
        left -= length;
    }
    Ok(poses[poses.len() - 1])
}

/// Returns a point in the frame of the base, at most `reach` m away in its direction.
pub(crate) fn local(here: &Pose2D, point: &Pose2D, reach: f64) -> [f64; 2] {
    let Pose2D { x, y, .. } = here.localize(point);
    let distance = libm::hypot(x, y);
    let factor = if distance > reach { reach / distance } else { 1.0 };
    [x * factor, y * factor]
}
