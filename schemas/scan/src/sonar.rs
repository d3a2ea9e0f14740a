//! What sonars tell of places: the arc on which an echo may be, what an echo from farther away shows to be gone, and which
//! of them measure nothing.

use core::time::Duration;
use std::collections::BTreeMap;

use jde_schema::types::{Echo, Point2D, Pose2D};

use crate::sensor::Measured;

/// Greatest distance of two points of an echo, m.
const SPACING: f64 = 0.04;
/// What a sonar and a laser differ by at the same thing, m.
const TOLERANCE: f64 = 0.1;
/// Time without a measurement after which a sonar counts as broken.
const SILENCE: Duration = Duration::from_secs(2);

/// The cone of a sonar up to an echo, in the frame of the odometry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    sonar: Pose2D,
    field_of_view: f64,
    range: f64,
}

impl Cone {
    /// Returns the cone up to the echo of a sonar on a base at `base`; `None` without an echo.
    pub(crate) fn new(measured: &Measured, base: &Pose2D) -> Option<Self> {
        Some(Self {
            sonar: base.transform(&measured.sensor),
            field_of_view: measured.field_of_view,
            range: measured.echo.distance(measured.least)?,
        })
    }

    /// Returns the distance of a place from the sonar, m; `None` if it is not in the direction of the cone.
    fn distance(&self, place: &Point2D) -> Option<f64> {
        let local = self.sonar.localize(&Pose2D::new(place.x, place.y, 0.0));
        (libm::atan2(local.y, local.x).abs() <= self.field_of_view / 2.0)
            .then(|| libm::hypot(local.x, local.y))
    }

    /// Whether the echo came through a place.
    pub(crate) fn passes(&self, place: &Point2D) -> bool {
        (self.distance(place)).is_some_and(|distance| distance < self.range - TOLERANCE)
    }

    /// Returns where the thing may be that the echo shows, if it is at most `most` m away: the arc across the cone. None
    /// if `seen` has a point in the cone that is as far, which explains the echo.
    pub(crate) fn arc(&self, most: f64, mut seen: impl Iterator<Item = Point2D>) -> Vec<Point2D> {
        let explains = |point: Point2D| {
            (self.distance(&point)).is_some_and(|distance| (distance - self.range).abs() <= TOLERANCE)
        };
        if self.range > most || seen.any(explains) {
            return Vec::new();
        }
        let count = (self.field_of_view * self.range / SPACING)
            .ceil()
            .clamp(1.0, 500.0);
        let points = (0..=count as u32).map(|step| {
            let part = f64::from(step) / count - 0.5;
            let (sin, cos) = libm::sincos(self.sonar.theta + self.field_of_view * part);
            Point2D {
                x: self.sonar.x + self.range * cos,
                y: self.sonar.y + self.range * sin,
            }
        });
        points.collect()
    }
}

/// Since when sonars measure nothing, by the number of their value in the list and their number in the ring; `None` of those
/// of which it was said.
#[derive(Debug, Default)]
pub(crate) struct Silence {
    since: BTreeMap<(usize, usize), Option<Duration>>,
}

impl Silence {
    /// Returns how many sonars have measured nothing for long.
    pub(crate) fn count(&self) -> usize {
        self.since.values().filter(|since| since.is_none()).count()
    }

    /// Adds what a sonar tells. Returns whether it has measured nothing for long, once.
    pub(crate) fn begins(&mut self, sonar: (usize, usize), echo: Echo, now: Duration) -> bool {
        if echo != Echo::Nothing {
            self.since.remove(&sonar);
            return false;
        }
        let since = self.since.entry(sonar).or_insert(Some(now));
        let is_long = since.is_some_and(|since| now.saturating_sub(since) > SILENCE);
        if is_long {
            *since = None;
        }
        is_long
    }
}
