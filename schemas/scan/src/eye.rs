//! What lasers have looked at: as far as their beams go, and nowhere else.

use core::f64::consts::TAU;
use core::time::Duration;
use std::collections::VecDeque;

use jde_motion::Sweep;
use jde_schema::types::{Echo, LaserScan, Point2D, Pose2D, normalize_angle};

/// What is so much farther than the end of a beam is not seen by it, m: more than the noise of a range, and than the
/// motion within a scan moves its end.
pub(crate) const TOLERANCE: f64 = 0.1;
/// How far beside a beam a place may be, m or rad, whichever is more. The rest between two beams is not looked at.
const ASIDE: (f64, f64) = (0.05, 0.01);
/// What the least range of a laser and a place at that range may differ by, m.
const ROUNDED: f64 = 0.01;

/// How long what was looked at counts, and how many scans of that time are kept.
const AGE: Duration = Duration::from_secs(1);
const COUNT: u32 = 5;

/// What a laser tells of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// A beam goes farther than that.
    Sees,
    /// A beam ends there, and what it ends at may be there.
    SeesEnd,
    /// As [`Look::Sees`], but nearer than the laser measures: what a level scan of a camera shows beyond may hide nothing
    /// of it, and what was there may be below the picture.
    SeesPast,
    /// A beam looks there and measures nothing.
    Nothing,
    /// No beam looks there, or it ends before that.
    Outside,
}

/// The beams of one scan, in the frame of the odometry.
#[derive(Debug)]
pub(crate) struct Eye {
    /// The number of the sensor in the list.
    pub(crate) sensor: usize,
    /// Where the laser was in the middle of the scan.
    middle: Pose2D,
    /// Where it was at each beam; empty if it did not move.
    poses: Vec<Pose2D>,
    /// The angle of the first beam and the angle from beam to beam, rad.
    angle_min: f64,
    increment: f64,
    /// The least and the greatest distance that it measures, m.
    limits: (f64, f64),
    /// How far each beam goes, m: 0 of one that ends at once, and NaN of one that measures nothing.
    lengths: Vec<f32>,
}

impl Eye {
    /// Returns the beams of a scan of a laser at `mount`.
    pub(crate) fn new(sensor: usize, scan: &LaserScan, sweep: &Sweep, mount: &Pose2D) -> Self {
        let lengths = scan.echoes().map(|(_, echo)| match echo {
            Echo::Hit(range) => range,
            Echo::Free if scan.range_max.is_finite() => scan.range_max,
            Echo::TooClose => 0.0,
            Echo::Free | Echo::Nothing => f32::NAN,
        });
        let lengths: Vec<f32> = lengths.collect();
        let pose = sweep.seen_from(&Pose2D::ORIGIN, mount);
        let poses = match sweep.first() == sweep.middle() {
            true => Vec::new(),
            false => (0..lengths.len()).map(pose).collect(),
        };
        Self {
            sensor,
            middle: sweep.middle().transform(mount),
            poses,
            angle_min: f64::from(scan.angle_min),
            increment: f64::from(scan.angle_increment),
            limits: (f64::from(scan.range_min), f64::from(scan.range_max)),
            lengths,
        }
    }

    /// Returns what the beam in the direction of a place tells of it.
    pub(crate) fn look(&self, place: &Point2D) -> Look {
        let Some((mut beam, mut distance, mut aside)) = self.toward(&self.middle, place) else {
            return Look::Outside;
        };
        if let Some(pose) = self.poses.get(beam) {
            match self.toward(pose, place) {
                Some(corrected) => (beam, distance, aside) = corrected,
                None => return Look::Outside,
            }
        }
        let length = f64::from(self.lengths[beam]);
        if distance > self.limits.1 + TOLERANCE || aside > ASIDE.1.max(ASIDE.0 / distance) {
            Look::Outside
        } else if length.is_nan() {
            Look::Nothing
        } else if length == 0.0 || distance > length + TOLERANCE {
            Look::Outside
        } else if distance < self.limits.0 - ROUNDED {
            Look::SeesPast
        } else if distance > length - TOLERANCE {
            Look::SeesEnd
        } else {
            Look::Sees
        }
    }

    /// Returns the beam nearest to the direction from `pose` to a place, the distance, m, and the angle between both, rad;
    /// `None` if the view does not reach there.
    fn toward(&self, pose: &Pose2D, place: &Point2D) -> Option<(usize, f64, f64)> {
        let (dx, dy) = (place.x - pose.x, place.y - pose.y);
        let count = self.lengths.len();
        let last = count.saturating_sub(1) as f64;
        // From the middle of the view, no direction of it is more than half a turn away.
        let middle = self.angle_min + self.increment * last / 2.0;
        let exact = normalize_angle(libm::atan2(dy, dx) - pose.theta - middle) / self.increment + last / 2.0;
        let mut beam = exact.round();
        let aside = ((exact - beam) * self.increment).abs();
        if self.increment.abs() * (count as f64 + 0.5) > TAU {
            beam = beam.rem_euclid(count as f64);
        }
        // The increment of a single beam may be 0, and the quotient none.
        let is_inside = beam >= 0.0 && beam < count as f64;
        is_inside.then(|| (beam as usize, libm::hypot(dx, dy), aside))
    }
}

/// What lasers have looked at within the last second. Beside a robot that moves, there is what they looked at before.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    /// The oldest first.
    recent: VecDeque<(Duration, Vec<Eye>)>,
}

impl Looks {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.recent.clear();
    }

    /// Adds what all lasers look at, and forgets what is old.
    pub(crate) fn add(&mut self, now: Duration, eyes: Vec<Eye>) {
        self.recent
            .retain(|(time, _)| *time <= now && now.saturating_sub(*time) <= AGE);
        let last = self.recent.back().map(|(time, _)| now.saturating_sub(*time));
        if last.is_none_or(|since| since >= AGE / COUNT) {
            self.recent.push_back((now, eyes));
        }
    }

    /// Returns whether a place is seen: a laser sees it now, or saw it within the last second and none looks there now.
    pub(crate) fn is_seen(&self, now: Duration, eyes: &[Eye], place: &Point2D) -> bool {
        let recent = (self.recent.iter()).filter(|(time, _)| now.saturating_sub(*time) <= AGE);
        match all(eyes, place) {
            Look::Sees | Look::SeesEnd | Look::SeesPast => true,
            Look::Nothing => false,
            Look::Outside => recent.rev().any(|(_, eyes)| all(eyes, place) == Look::Sees),
        }
    }
}

/// Returns what all lasers tell of a place: one that looks there and measures nothing outweighs those that see it.
fn all(eyes: &[Eye], place: &Point2D) -> Look {
    let mut known = Look::Outside;
    for eye in eyes {
        match eye.look(place) {
            look @ (Look::Sees | Look::SeesEnd | Look::SeesPast) => known = look,
            Look::Nothing => return Look::Nothing,
            Look::Outside => {}
        }
    }
    known
}
