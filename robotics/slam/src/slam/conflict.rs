//! Whether a scan contradicts what is known. A wall where the robot has looked through is no wall that was not seen yet.

use jde_types::Pose2D;

use super::{Anchor, JOINED, Slam, placed, thin};
use crate::scan::{Scan, THROUGH};

/// How many points of a scan, and how many known ones, are compared.
const COMPARED: (usize, usize) = (60, 200);
/// Fewer comparisons than this say less.
const FEW: f64 = 8.0;

impl Slam {
    /// The share of what can be compared that contradicts a scan at an anchor: of its points, those where keyframes look
    /// through; or of the known points, those through which it looks, whichever is more.
    pub(super) fn conflict(&mut self, anchor: &Anchor, scan: &Scan) -> f64 {
        self.surface(anchor);
        let Some(surface) = &self.surface else { return 0.0 };
        let (sin, cos) = libm::sincos(anchor.pose.theta);
        let (place, turn) = (
            (anchor.pose.x as f32, anchor.pose.y as f32),
            (sin as f32, cos as f32),
        );
        let (robot, poses) = (self.place(anchor), self.graph.poses());
        let keyframes = self.around(anchor.keyframe, &robot, JOINED);
        let (mut agree, mut differ) = (0.0, 0.0);
        for point in thin(scan.points(), COMPARED.0) {
            if surface.nearest(point.moved(place, turn).at).is_some() {
                agree += 1.0;
                continue;
            }
            let at = placed(&robot, point.at);
            let looks = |&keyframe: &usize| {
                self.scans[keyframe].sees_through(seen_from(&poses[keyframe], at), THROUGH)
            };
            if keyframes.iter().filter_map(looks).any(|through| through) {
                differ += 1.0;
            }
        }
        let mut most: f64 = differ / f64::max(agree + differ, FEW);
        (agree, differ) = (0.0, 0.0);
        for point in thin(surface.points(), COMPARED.1) {
            let at = (f64::from(point.at.0), f64::from(point.at.1));
            match scan.sees_through(seen_from(&anchor.pose, at), THROUGH) {
                Some(true) => differ += 1.0,
                Some(false) => agree += 1.0,
                None => {}
            }
        }
        most = most.max(differ / f64::max(agree + differ, FEW));
        most
    }
}

/// A place in the frame of a pose.
fn seen_from(pose: &Pose2D, (x, y): (f64, f64)) -> (f32, f32) {
    let local = pose.localize(&Pose2D::new(x, y, 0.0));
    (local.x as f32, local.y as f32)
}
