//! The sensors that are merged: what an entry of the application file states, and what a value of each type tells.

use jde_schema::ListedImport;
use jde_schema::prelude::*;
use jde_schema::types::{Echo, Point2D};

/// Greatest distance of two points of an echo, m.
const SPACING: f64 = 0.04;

/// Where a sensor is, and what of it counts.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/MergedSensor")]
pub(crate) struct Mounting {
    /// Pose on the base of a laser or of a single range sensor. A ring states the poses of its sensors.
    pub(crate) mount: Pose2D,
    /// How far below a range sensor that looks down the floor is; 0 for one that looks ahead.
    #[value(unit = "m")]
    pub(crate) floor: f64,
    /// Greatest distance at which an echo of a range sensor counts.
    #[value(unit = "m")]
    pub(crate) obstacle_max_range: f64,
    /// The angle that the bumpers of a side cover together, around ahead or behind.
    #[value(unit = "rad")]
    pub(crate) field_of_view: f64,
}

/// A type of sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Laser,
    Ring,
    Range,
    Bumpers,
}

/// One distance: where it is measured from and in which direction, in the frame of the base, and what it tells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    pub(crate) sensor: Pose2D,
    field_of_view: f64,
    pub(crate) echo: Echo,
    least: f32,
}

impl Mounting {
    pub(crate) const DEFAULT: Self = Self {
        mount: Pose2D::ORIGIN,
        floor: 0.0,
        obstacle_max_range: 2.5,
        field_of_view: core::f64::consts::PI,
    };
}

impl Kind {
    /// Returns the type of sensor of an entry.
    ///
    /// # Errors
    /// That it is none which can be merged.
    pub(crate) fn of(entry: &ListedImport<Mounting>) -> Result<Self, String> {
        let own = entry.value_type();
        let known = [
            (LaserScan::describe(), Self::Laser),
            (RangeRing::describe(), Self::Ring),
            (Range::describe(), Self::Range),
            (Bumpers::describe(), Self::Bumpers),
        ];
        let found = known.into_iter().find(|(of, _)| own.difference(of).is_none());
        found.map(|(_, kind)| kind).ok_or_else(|| {
            format!(
                "`{}` is a {}: expected a LaserScan, RangeRing, Range or Bumpers",
                entry.label(),
                own.name
            )
        })
    }

    /// Checks that the numbers of an entry are possible.
    ///
    /// # Errors
    /// Which one is not.
    pub(crate) fn check(entry: &ListedImport<Mounting>) -> Result<Self, String> {
        let kind = Self::of(entry)?;
        let Mounting {
            mount,
            floor,
            obstacle_max_range,
            field_of_view,
        } = *entry.settings();
        let numbers = [
            ("mount", mount.is_finite(), "finite numbers"),
            ("floor", (0.0..=10.0).contains(&floor), "0 to 10 m"),
            (
                "obstacle_max_range",
                (0.0..=1e3).contains(&obstacle_max_range),
                "0 to 1000 m",
            ),
            (
                "field_of_view",
                (0.0..=core::f64::consts::TAU).contains(&field_of_view),
                "0 to 360 degrees",
            ),
        ];
        match numbers.into_iter().find(|(_, is_valid, _)| !is_valid) {
            Some((name, _, expected)) => Err(format!("`{name}` of `{}`: expected {expected}", entry.label())),
            None => Ok(kind),
        }
    }
}

impl Measured {
    /// Returns the distance that a single sensor at `mount` measures.
    pub(crate) fn of_range(range: &Range, mount: Pose2D) -> Self {
        Self {
            sensor: mount,
            field_of_view: f64::from(range.field_of_view),
            echo: range.echo(),
            least: range.min_range,
        }
    }

    /// Returns the distances that the sensors of a ring measure.
    pub(crate) fn of_ring(ring: &RangeRing) -> impl Iterator<Item = Self> + '_ {
        (ring.poses.iter().zip(&ring.ranges)).map(|(pose, &range)| Self {
            sensor: *pose,
            field_of_view: f64::from(ring.field_of_view),
            echo: Echo::of(range, ring.min_range, ring.max_range),
            least: ring.min_range,
        })
    }

    /// Whether the floor is missing below a sensor that looks down, or lies too deep; `None` if it does not measure.
    pub(crate) fn is_cliff(&self, deepest: f64) -> Option<bool> {
        match self.echo {
            Echo::Hit(range) => Some(f64::from(range) > deepest),
            Echo::TooClose => Some(false),
            Echo::Free => Some(true),
            Echo::Nothing => None,
        }
    }

    /// Returns where the thing may be that an echo shows, if it is at most `most` m away: the arc across the cone. None
    /// if `seen` has a point in the cone that is as near, which explains the echo.
    pub(crate) fn arc<'a>(
        &self,
        most: f64,
        base: &Pose2D,
        seen: impl IntoIterator<Item = &'a Point2D>,
    ) -> Vec<Point2D> {
        /// What a sonar and a laser differ by at the same thing, m.
        const TOLERANCE: f64 = 0.1;
        let Some(range) = self.echo.distance(self.least).filter(|range| *range <= most) else {
            return Vec::new();
        };
        let sonar = base.transform(&self.sensor);
        let half = self.field_of_view / 2.0;
        let explains = |point: &Point2D| {
            let local = sonar.localize(&Pose2D::new(point.x, point.y, 0.0));
            local.x.hypot(local.y) <= range + TOLERANCE && local.y.atan2(local.x).abs() <= half
        };
        if seen.into_iter().any(explains) {
            return Vec::new();
        }
        let count = (self.field_of_view * range / SPACING).ceil().clamp(1.0, 500.0);
        let points = (0..=count as u32).map(|step| {
            let (sin, cos) = (sonar.theta - half + self.field_of_view * f64::from(step) / count).sin_cos();
            Point2D {
                x: sonar.x + range * cos,
                y: sonar.y + range * sin,
            }
        });
        points.collect()
    }
}

/// Returns the sectors of the pressed bumpers, from one direction to another, in the frame of the base, rad.
pub(crate) fn pressed(bumpers: &Bumpers, field_of_view: f64) -> impl Iterator<Item = (f64, f64)> {
    // From left to right: clockwise ahead, counter-clockwise behind.
    let sides = [
        (bumpers.front, field_of_view / 2.0, -field_of_view),
        (
            bumpers.rear,
            core::f64::consts::PI - field_of_view / 2.0,
            field_of_view,
        ),
    ];
    sides.into_iter().flat_map(|(segments, first, whole)| {
        let width = whole / segments.len().max(1) as f64;
        let pressed = (0..segments.len()).filter(move |&at| segments[at].get());
        pressed.map(move |at| {
            let from = first + width * at as f64;
            (from, from + width)
        })
    })
}
