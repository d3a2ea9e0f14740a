//! What later scans look through leaves the map: people who have gone, doors that were opened, furniture that was moved.
//!
//! One scan says little: its pose errs, a thin leg is between two beams, and a wall along a beam is missed by a small turn. So a
//! point goes only when several more scans looked through it than met it, from near enough that a beam could not have missed it.

use jde_types::Pose2D;

use super::{Anchor, JOINED, MAX_CONFLICT, Settings, Slam};
use crate::scan::{Scan, SurfacePoint};

/// How many more scans must look through a point than meet it.
const LOOKS: i8 = 6;
/// For how many looks through it a scan counts that meets a point, and how many a point has in advance at most.
const MET: i8 = 3;
const MOST_MET: i8 = 4;
/// How far beams must go beyond a point, and to either side of it, m.
const THROUGH: (f32, f32) = (0.2, 0.1);
/// How far a scan tells of points, m: heading errors move what is farther.
const REACH: f32 = 6.0;
/// The most that two beams may be apart at a point which is no surface, and at one of a surface, m: the leg of a chair, and
/// that of a table. Scans of a robot that stands have the same beams: half of it.
const NARROW: (f32, f32) = (0.04, 0.1);
/// The least cosine between a beam and the normal of a surface.
const STEEP: f32 = 0.25;
/// Other points that show the same thing are so near, m, in keyframes that are so far, m.
const SAME: f32 = 0.15;
const KEYFRAMES: f64 = 25.0;
/// The share of its points from which on a keyframe that lost them is replaced by a scan at its place.
const WORN: f64 = 0.15;

/// Whether the robot has moved since the last scan that was looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    Standing,
    Moved,
}

impl Slam {
    /// Returns how often the map was changed otherwise than by new keyframes and moves of the graph.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// Counts for the keyframes around an anchor what a scan there looks through, and takes away what is gone. A scan that
    /// looks through much of what it should meet is elsewhere: it takes nothing.
    pub(super) fn forget(&mut self, anchor: &Anchor, scan: &Scan, motion: Motion) {
        let place = self.place(anchor);
        let keyframes = self.around(anchor.keyframe, &place, JOINED);
        let mut looks = Vec::new();
        let mut differ = 0;
        for &keyframe in &keyframes {
            let seen = Seen::from(&place, &self.graph.poses()[keyframe]);
            for (number, point) in self.scans[keyframe].points().iter().enumerate() {
                if let Some(through) = tells(scan, &seen.point(point), motion) {
                    differ += usize::from(through);
                    looks.push((keyframe, number, through));
                }
            }
        }
        if differ as f64 > MAX_CONFLICT * looks.len() as f64 {
            return;
        }
        let mut gone = Vec::new();
        for (keyframe, number, through) in looks {
            let scan = &mut self.scans[keyframe];
            let doubt = &mut scan.doubts[number];
            *doubt = if through {
                *doubt + 1
            } else {
                (*doubt - MET).max(-MOST_MET)
            };
            if *doubt >= LOOKS {
                let seen = Seen::from(&place, &self.graph.poses()[keyframe]);
                gone.push(seen.point(&scan.points()[number]).at);
            }
        }
        if !gone.is_empty() {
            self.take_away(anchor, &place, scan, &gone);
        }
    }

    /// Takes away the points of all keyframes at what is gone, if the scan looks through them.
    fn take_away(&mut self, anchor: &Anchor, place: &Pose2D, scan: &Scan, gone: &[(f32, f32)]) {
        let is_near = |at: (f32, f32)| {
            let near = |&(x, y): &(f32, f32)| libm::hypotf(at.0 - x, at.1 - y) < SAME;
            gone.iter().any(near)
        };
        for keyframe in self.linked(anchor.keyframe, place, KEYFRAMES) {
            let seen = Seen::from(place, &self.graph.poses()[keyframe]);
            self.scans[keyframe].forget(|point| {
                let at = seen.point(point).at;
                is_near(at) && scan.sees_through(at, THROUGH) == Some(true)
            });
        }
        self.revision += 1;
        self.surface = None;
    }

    /// Lets a scan at an anchor take the place of its keyframe, if that has lost much of what it showed.
    pub(super) fn renew(&mut self, settings: &Settings, anchor: &Anchor, scan: &Scan) -> bool {
        let worn = &self.scans[anchor.keyframe];
        let is_here = self.distance(anchor.keyframe, &self.place(anchor)) < 0.5 * settings.keyframe.0;
        let is_as_wide = scan.is_all_around() || scan.view() >= worn.view();
        if worn.forgotten_share() < WORN || !is_here || !is_as_wide {
            return false;
        }
        self.graph.shift(anchor.keyframe, &anchor.pose);
        self.scans[anchor.keyframe] = scan.clone();
        self.revision += 1;
        self.surface = None;
        true
    }
}

/// Whether a scan looks through a point in its frame; `None` if it cannot tell.
fn tells(scan: &Scan, point: &SurfacePoint, motion: Motion) -> Option<bool> {
    let ray = scan.ray_to(point.at);
    let square = ray.0 * ray.0 + ray.1 * ray.1;
    if square > REACH * REACH {
        return None;
    }
    if !scan.sees_through(point.at, THROUGH)? {
        return Some(false);
    }
    let length = libm::sqrtf(square);
    let narrow = if point.is_flat() { NARROW.1 } else { NARROW.0 };
    let most = match motion {
        Motion::Standing => 0.5 * narrow,
        Motion::Moved => narrow,
    };
    let is_along =
        point.is_flat() && (ray.0 * point.normal.0 + ray.1 * point.normal.1).abs() < STEEP * length;
    (length * scan.increment() <= most && !is_along).then_some(true)
}

/// A keyframe as it is seen from the robot.
struct Seen {
    at: (f32, f32),
    turn: (f32, f32),
}

impl Seen {
    fn from(robot: &Pose2D, keyframe: &Pose2D) -> Self {
        let pose = robot.localize(keyframe);
        let (sin, cos) = libm::sincos(pose.theta);
        Self {
            at: (pose.x as f32, pose.y as f32),
            turn: (sin as f32, cos as f32),
        }
    }

    fn point(&self, point: &SurfacePoint) -> SurfacePoint {
        point.moved(self.at, self.turn)
    }
}
