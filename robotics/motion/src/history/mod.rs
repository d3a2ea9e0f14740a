//! Where the base was when a sensor saw something. It corrects no pose and guesses no motion of anything but the base.

use core::time::Duration;
use std::collections::VecDeque;

use jde_types::{LaserScan, Odometry, Point2D, Pose2D, Twist, normalize_angle};

use crate::{arc, is_finite};

/// The most time beyond the known poses that the velocity bridges, s.
const MAX_EXTRAPOLATION: f64 = 0.5;
/// The greatest age of what a sensor saw, s: what moves by itself is elsewhere then.
const MAX_AGE: f64 = 1.0;
/// A sensor whose clock is set by that of this machine is ahead of it by less, s.
const MAX_AHEAD: f64 = 0.1;
/// From this age on, the clock is another one, s: nothing waits so long in a queue.
const OTHER_CLOCK: f64 = 10.0;
/// What a step of the odometry may differ from its velocity, m and rad. One that differs more, as when a map is corrected,
/// moves nothing, and the poses before it are of another frame.
const MAX_STEP_ERROR: (f64, f64) = (0.25, 0.5);

/// The odometry of the last second.
#[derive(Clone, Debug, Default)]
pub struct OdometryHistory {
    /// The oldest first.
    known: VecDeque<Known>,
    /// How often it began anew.
    jumps: u64,
}

#[derive(Clone, Copy, Debug)]
struct Known {
    time: Duration,
    pose: Pose2D,
    velocity: Twist,
}

impl OdometryHistory {
    /// Returns how often it began anew, as at a jump: what a sensor saw before is of another frame, and must be dropped.
    #[must_use]
    pub const fn jumps(&self) -> u64 {
        self.jumps
    }

    fn begin_anew(&mut self) {
        self.jumps += u64::from(!self.known.is_empty());
        self.known.clear();
    }

    /// Adds the odometry of a time. The same time counts once; an earlier one, or a jump, begins anew.
    pub fn add(&mut self, time: Duration, odometry: &Odometry) {
        if !is_finite(odometry) {
            return self.begin_anew();
        }
        let next = Known {
            time,
            pose: odometry.pose2d(),
            velocity: odometry.twist.twist,
        };
        match self.known.back() {
            Some(last) if last.time > time || last.jumps_to(&next) => self.begin_anew(),
            Some(last) if last.time == time => drop(self.known.pop_back()),
            Some(_) | None => {}
        }
        self.known.push_back(next);
        let oldest = time.saturating_sub(Duration::from_secs_f64(MAX_AGE));
        // One before it remains, so that every time since is between two.
        while self.known.get(1).is_some_and(|second| second.time <= oldest) {
            self.known.pop_front();
        }
    }

    /// Returns where the base was at the time `seen` of what a sensor sees, its "pictures" or "scans".
    ///
    /// # Errors
    /// Why nobody knows, in words: they are more than 1 s old, ahead of the clock, or too far from the odometry.
    pub fn base(&self, what: &str, seen: Duration, now: Duration) -> Result<Pose2D, String> {
        let age = seconds(now, seen);
        if !(-MAX_AHEAD..=OTHER_CLOCK).contains(&age) {
            let side = if age < 0.0 { "ahead of" } else { "behind" };
            return Err(format!(
                "the {what} are stamped {:.1} s {side} the clock of this machine: set the clock of their sensor by it",
                age.abs()
            ));
        }
        if age > MAX_AGE {
            return Err(format!("the {what} are {age:.1} s old"));
        }
        let (Some(first), Some(last)) = (self.known.front(), self.known.back()) else {
            return Err("there is no odometry".to_owned());
        };
        let since = seconds(seen, last.time);
        if !(-MAX_AGE..=MAX_EXTRAPOLATION).contains(&since) || seconds(first.time, seen) > MAX_EXTRAPOLATION {
            let older = if since < 0.0 { "older" } else { "newer" };
            return Err(format!(
                "the {what} are {:.1} s {older} than the odometry",
                since.abs()
            ));
        }
        Ok(self.pose(seen.as_secs_f64()).unwrap_or_default())
    }

    /// Returns where the base is now, by its velocity since the newest odometry.
    ///
    /// # Errors
    /// That there is no odometry, or that it is more than 0.5 s old.
    pub fn current(&self, now: Duration) -> Result<Pose2D, String> {
        let last = self.known.back().ok_or("there is no odometry")?;
        let age = seconds(now, last.time);
        if age > MAX_EXTRAPOLATION {
            return Err(format!("the odometry is {age:.1} s old"));
        }
        Ok(last.after(age.max(0.0)))
    }

    /// Returns where the base was from the first to the last beam of a scan whose oldest beam was measured at `seen`.
    ///
    /// # Errors
    /// As [`Self::base`], of its oldest or its newest beam.
    pub fn sweep(&self, scan: &LaserScan, seen: Duration, now: Duration) -> Result<Sweep, String> {
        let lasts = scan_duration(scan);
        let ended = seen + Duration::from_secs_f64(lasts.abs());
        let oldest = self.base("scans", seen, now)?;
        let newest = self.base("scans", ended, now)?;
        let (first, last) = if lasts < 0.0 {
            (newest, oldest)
        } else {
            (oldest, newest)
        };
        let beams = scan.ranges.len().saturating_sub(1) as f64;
        Ok(Sweep {
            first,
            motion: if ended == seen {
                Pose2D::ORIGIN
            } else {
                first.localize(&last)
            },
            beams: beams.max(1.0),
            ended,
        })
    }

    /// The pose at a time in seconds, between two that are known, or by the velocity beyond them.
    fn pose(&self, time: f64) -> Option<Pose2D> {
        let next = self
            .known
            .partition_point(|known| known.time.as_secs_f64() <= time);
        let before = next.checked_sub(1).and_then(|at| self.known.get(at));
        match (before, self.known.get(next)) {
            (Some(a), Some(b)) => {
                let share = (time - a.time.as_secs_f64()) / seconds(b.time, a.time);
                Some(a.pose.transform(&part(&a.pose.localize(&b.pose), share)))
            }
            (Some(only), None) | (None, Some(only)) => Some(only.after(time - only.time.as_secs_f64())),
            (None, None) => None,
        }
    }
}

impl Known {
    fn after(&self, time: f64) -> Pose2D {
        self.pose.transform(&arc(&self.velocity, time))
    }

    fn jumps_to(&self, next: &Self) -> bool {
        let half = seconds(next.time, self.time) / 2.0;
        // Each velocity for half of the time.
        let expected = self.after(half).transform(&arc(&next.velocity, half));
        let error = expected.localize(&next.pose);
        libm::hypot(error.x, error.y) > MAX_STEP_ERROR.0 || error.theta.abs() > MAX_STEP_ERROR.1
    }
}

/// Where the base was while a scan was taken, in the frame of the odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    first: Pose2D,
    /// From the first to the last beam.
    motion: Pose2D,
    /// From the first to the last.
    beams: f64,
    ended: Duration,
}

impl Sweep {
    /// Returns where the base was at the first beam.
    #[must_use]
    pub const fn first(&self) -> Pose2D {
        self.first
    }

    /// Returns when the newest beam was measured.
    #[must_use]
    pub const fn ended(&self) -> Duration {
        self.ended
    }

    /// Returns where the base was in the middle of the scan.
    #[must_use]
    pub fn middle(&self) -> Pose2D {
        self.first.transform(&part(&self.motion, 0.5))
    }

    /// Returns where a laser at `mount` was at each beam, in the frame of a base at `base`.
    pub fn seen_from(&self, base: &Pose2D, mount: &Pose2D) -> impl Fn(usize) -> Pose2D + use<> {
        let (first, motion, beams, mount) = (base.localize(&self.first), self.motion, self.beams, *mount);
        let still = first.transform(&mount);
        move |beam| {
            if motion == Pose2D::ORIGIN {
                return still;
            }
            first
                .transform(&part(&motion, beam as f64 / beams))
                .transform(&mount)
        }
    }

    /// Returns where each measured beam of the scan ends for a laser at `mount`, in the frame of the odometry, and whether
    /// it ends at an object, as [`LaserScan::rays`].
    pub fn rays(&self, scan: &LaserScan, mount: &Pose2D) -> impl Iterator<Item = (Point2D, bool)> {
        let laser = self.seen_from(&Pose2D::ORIGIN, mount);
        scan.lengths()
            .map(move |(beam, length, hit)| (end(&laser(beam), scan.angle(beam), f64::from(length)), hit))
    }
}

/// Where a beam ends.
pub(crate) fn end(laser: &Pose2D, angle: f64, length: f64) -> Point2D {
    let (sin, cos) = libm::sincos(laser.theta + angle);
    Point2D {
        x: laser.x + length * cos,
        y: laser.y + length * sin,
    }
}

/// The time from the first beam of a scan to the last, s: by the time from beam to beam, but no longer than a scan. It is
/// negative where the last beam was measured first, and 0 where the numbers are none.
#[must_use]
pub fn scan_duration(scan: &LaserScan) -> f64 {
    let beams = scan.ranges.len().saturating_sub(1) as f64;
    let (taken, turn) = (f64::from(scan.time_increment) * beams, f64::from(scan.scan_time));
    let most = if turn > 0.0 {
        turn.min(MAX_EXTRAPOLATION)
    } else {
        MAX_EXTRAPOLATION
    };
    if taken.is_finite() {
        taken.clamp(-most, most)
    } else {
        0.0
    }
}

/// A part of a short motion.
fn part(motion: &Pose2D, share: f64) -> Pose2D {
    Pose2D::new(
        share * motion.x,
        share * motion.y,
        normalize_angle(share * motion.theta),
    )
}

fn seconds(later: Duration, earlier: Duration) -> f64 {
    later.as_secs_f64() - earlier.as_secs_f64()
}

#[cfg(test)]
mod tests;
