//! The sensors that are merged: what an entry of the application file states, and what a value of each type tells.

use jde_schema::ListedImport;
use jde_schema::prelude::*;
use jde_schema::types::Echo;

/// The most that a field of view may be, rad: a turn, rounded up.
const TURN: f32 = 6.3;

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
    pub(crate) field_of_view: f64,
    pub(crate) echo: Echo,
    pub(crate) least: f32,
    greatest: f32,
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

    /// Checks that the numbers of an entry are possible, and that its type of sensor reads what is stated.
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
        if let Some((name, _, expected)) = numbers.into_iter().find(|(_, is_valid, _)| !is_valid) {
            return Err(format!("`{name}` of `{}`: expected {expected}", entry.label()));
        }
        let default = Mounting::DEFAULT;
        let (is_bumper, is_sonar) = (kind == Self::Bumpers, matches!(kind, Self::Ring | Self::Range));
        let (is_mounted, looks_down) = (matches!(kind, Self::Laser | Self::Range), floor != default.floor);
        let settings = [
            ("mount", mount == default.mount || is_mounted),
            ("floor", !looks_down || is_sonar),
            (
                "obstacle_max_range",
                obstacle_max_range == default.obstacle_max_range || is_sonar && !looks_down,
            ),
            (
                "field_of_view",
                field_of_view == default.field_of_view || is_bumper,
            ),
        ];
        match settings.into_iter().find(|(_, is_read)| !is_read) {
            Some((name, _)) => Err(format!(
                "`{}` does not read `{name}`: leave it out",
                entry.label()
            )),
            None => Ok(kind),
        }
    }
}

impl Measured {
    /// Returns the distance that a single sensor at `mount` measures.
    ///
    /// # Errors
    /// That its cone is none.
    pub(crate) fn of_range(range: &Range, mount: Pose2D) -> Result<Self, String> {
        check_cone(range.field_of_view)?;
        Ok(Self {
            sensor: mount,
            field_of_view: f64::from(range.field_of_view),
            echo: range.echo(),
            least: range.min_range,
            greatest: range.max_range,
        })
    }

    /// Returns the distances that the sensors of a ring measure.
    ///
    /// # Errors
    /// That its cones or poses are none, or that there are more or fewer than ranges.
    pub(crate) fn of_ring(ring: &RangeRing) -> Result<impl Iterator<Item = Self> + '_, String> {
        check_cone(ring.field_of_view)?;
        let (poses, ranges) = (ring.poses.len(), ring.ranges.len());
        if poses != ranges {
            return Err(format!("it states {poses} poses and {ranges} ranges"));
        }
        if !ring.poses.iter().all(Pose2D::is_finite) {
            return Err("a pose of it is not finite".to_owned());
        }
        Ok((ring.poses.iter().zip(&ring.ranges)).map(|(pose, &range)| Self {
            sensor: *pose,
            field_of_view: f64::from(ring.field_of_view),
            echo: Echo::of(range, ring.min_range, ring.max_range),
            least: ring.min_range,
            greatest: ring.max_range,
        }))
    }

    /// Whether the floor, which should be `floor` m below a sensor that looks down, is missing or more than `max_drop` m
    /// deeper.
    ///
    /// # Errors
    /// That it does not measure the floor: it cannot, or something covers it.
    pub(crate) fn is_cliff(&self, floor: f64, max_drop: f64) -> Result<bool, String> {
        let (least, greatest) = (self.least, self.greatest);
        // A sensor of a fixed distance tells only whether something is nearer than that.
        let is_fixed = least == greatest;
        if is_fixed && f64::from(greatest) <= floor {
            return Err(format!(
                "it notices what is nearer than {greatest} m, and `floor` is {floor} m"
            ));
        }
        if !is_fixed && f64::from(least) >= floor {
            return Err(format!("it measures from {least} m on, and `floor` is {floor} m"));
        }
        match self.echo {
            Echo::Hit(range) if f64::from(range) >= floor - max_drop => {
                Ok(f64::from(range) > floor + max_drop)
            }
            Echo::TooClose if is_fixed => Ok(false),
            Echo::Free => Ok(true),
            Echo::Hit(_) | Echo::TooClose | Echo::Nothing => Err("it does not measure the floor".to_owned()),
        }
    }
}

fn check_cone(field_of_view: f32) -> Result<(), String> {
    match (0.0..=TURN).contains(&field_of_view) {
        true => Ok(()),
        false => Err(format!("its field of view is {field_of_view} rad")),
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
