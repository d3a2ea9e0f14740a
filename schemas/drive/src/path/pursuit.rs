//! The arc of pure pursuit to a point.

use jde_schema::types::Pose2D;

/// Returns the curvature of the arc from the origin, along x, to a point in the frame of the base, 1/m, left
/// positive: Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01.
pub(super) fn curvature(point: &Pose2D) -> f64 {
    let squared = point.x * point.x + point.y * point.y;
    if squared > 0.0 {
        2.0 * point.y / squared
    } else {
        0.0
    }
}
