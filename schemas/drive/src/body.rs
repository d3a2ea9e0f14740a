//! What all schemas of this plugin share: the body of the robot, what its laser sees, and the check of a
//! command. A command that the body cannot stop from in time is slowed or refused, never replaced by another
//! way.

use jde_motion::{FootprintError, Limits, Maneuver, Outline, ScanPoints, Stopping};
use jde_schema::types::{Footprint, LaserScan, Odometry, Point2D, Pose2D, Twist};

/// How long a command is in force at least before the next one takes effect, s: twice the period of the
/// schemas of this plugin, and the period of a driver.
pub(crate) const HOLD: f64 = 0.3;
/// The factors that a refused command is tried with, as the speed along the same arc.
const SLOWER: [f64; 3] = [1.0, 0.5, 0.25];

/// The body of the robot, and what the laser saw last.
pub(crate) struct Body {
    outline: Outline,
    mount: Pose2D,
    scan_points: ScanPoints,
}

/// What the base can do, from the modulations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ability {
    /// Greatest change of speed, m/s².
    pub(crate) acceleration: f64,
    /// Greatest change of the turn rate, rad/s².
    pub(crate) turn_acceleration: f64,
    /// Distance to keep from everything, m.
    pub(crate) margin: f64,
    /// How long a command must be free before the stop, s; at least [`HOLD`].
    pub(crate) hold: f64,
}

/// The answer to a wanted command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Permit {
    /// The command, perhaps slower along the same arc.
    Go(Twist),
    /// Only the turn of the command, on the spot: this point is in the way.
    Turn(Twist, Point2D),
    /// Stand still: this point is in the way even of the turn.
    Stay(Point2D),
    /// Stand still: the command or the measured velocity is not a number, or the stop takes too long.
    Unknown,
}

/// Returns pose and velocity of the base; `None` if a number is not finite.
pub(crate) fn measured(odometry: &Odometry) -> Option<(Pose2D, Twist)> {
    let (pose, velocity) = (odometry.pose2d(), odometry.twist.twist);
    let numbers = [
        pose.x,
        pose.y,
        pose.theta,
        velocity.linear.x,
        velocity.linear.y,
        velocity.angular.z,
    ];
    numbers
        .iter()
        .all(|number| number.is_finite())
        .then_some((pose, velocity))
}

impl Permit {
    /// The command to give.
    pub(crate) fn twist(&self) -> Twist {
        match self {
            Self::Go(twist) | Self::Turn(twist, _) => *twist,
            Self::Stay(_) | Self::Unknown => Twist::ZERO,
        }
    }

    /// What is in the way of the command that was wanted; `None` if nothing is.
    pub(crate) fn obstacle(&self) -> Option<String> {
        match self {
            Self::Go(_) => None,
            Self::Turn(_, Point2D { x, y }) | Self::Stay(Point2D { x, y }) => Some(format!(
                "something is in the way, {x:.2} m ahead and {y:.2} m left"
            )),
            Self::Unknown => Some("the velocity is no number, or a stop takes too long".into()),
        }
    }
}

impl Body {
    /// Returns the body of a footprint with a laser at `mount`.
    pub(crate) fn new(footprint: &Footprint, mount: Pose2D) -> Result<Self, FootprintError> {
        Ok(Self {
            outline: Outline::try_from(footprint)?,
            mount,
            scan_points: ScanPoints::default(),
        })
    }

    /// Takes in a scan, and returns pose and velocity of the base; `None` if there is no scan or odometry, the
    /// scan measures nothing, or a number of the odometry is not finite.
    pub(crate) fn observe(
        &mut self,
        scan: Option<&LaserScan>,
        odometry: Option<&Odometry>,
    ) -> Option<(Pose2D, Twist)> {
        self.scan_points.update(scan?, &self.mount).ok()?;
        measured(odometry?)
    }

    /// The points of the last scan, in the frame of the base.
    pub(crate) fn points(&self) -> &[Point2D] {
        self.scan_points.as_slice()
    }

    /// The radius of a circle around the origin that contains the body, m.
    pub(crate) fn reach(&self) -> f64 {
        self.outline.reach()
    }

    /// The distance from the body to the nearest point, m; +∞ without points.
    pub(crate) fn clearance(&self) -> f64 {
        self.outline.clearance(&Pose2D::ORIGIN, self.points())
    }

    /// How far a circle around the body can go straight ahead with `margin` m to either side, m; below 0 if a
    /// point ahead is within the circle, +∞ if nothing is ahead.
    pub(crate) fn free_ahead(&self, margin: f64) -> f64 {
        let radius = self.reach() + margin;
        let ahead = self
            .points()
            .iter()
            .filter(|point| point.x > 0.0 && point.y.abs() < radius);
        ahead
            .map(|point| point.x - (radius * radius - point.y * point.y).sqrt())
            .fold(f64::INFINITY, f64::min)
    }

    /// The side with fewer and farther points: 1 for the left, −1 for the right.
    pub(crate) fn freer_side(&self) -> f64 {
        // The area that a point hides behind it grows as its distance falls; the constant keeps one very close
        // point from outweighing all others.
        let crowd = |point: &Point2D| 1.0 / (0.1 + point.x * point.x + point.y * point.y);
        let left: f64 = self
            .points()
            .iter()
            .map(|point| crowd(point).copysign(point.y))
            .sum();
        if left > 0.0 { -1.0 } else { 1.0 }
    }

    /// The body without a scan.
    pub(crate) fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Checks `wanted` for a base that moves at `velocity` among what the laser sees.
    pub(crate) fn permit(&self, velocity: &Twist, wanted: Twist, ability: &Ability) -> Permit {
        self.permit_among(self.points(), velocity, wanted, ability)
    }

    /// Checks `wanted` for a base that moves at `velocity` among these points, in the frame of the base.
    ///
    /// Within the margin, half of the present clearance counts instead, so that a body that came too close
    /// can leave.
    pub(crate) fn permit_among(
        &self,
        points: &[Point2D],
        velocity: &Twist,
        wanted: Twist,
        ability: &Ability,
    ) -> Permit {
        let clearance = self.outline.clearance(&Pose2D::ORIGIN, points);
        let margin = ability.margin.min(clearance / 2.0);
        let stopping = |command: Twist| {
            let maneuver = Maneuver {
                velocity: *velocity,
                command,
                hold: ability.hold,
                limits: Limits {
                    acceleration: ability.acceleration,
                    deceleration: ability.acceleration,
                    turn_acceleration: ability.turn_acceleration,
                    turn_deceleration: ability.turn_acceleration,
                },
            };
            maneuver.stopping(&self.outline, points, margin)
        };
        let turn = wanted.angular.z;
        let mut blocking = None;
        for factor in SLOWER {
            let mut slower = Twist::planar(factor * wanted.linear.x, factor * turn);
            slower.linear.y = factor * wanted.linear.y;
            match stopping(slower) {
                Stopping::Free => return Permit::Go(slower),
                Stopping::Touches { point, .. } => blocking = blocking.or(Some(point)),
                Stopping::Unknown => return Permit::Unknown,
            }
        }
        let spot = Twist::planar(0.0, turn);
        match stopping(spot) {
            Stopping::Free => Permit::Turn(spot, blocking.unwrap_or_default()),
            Stopping::Touches { point, .. } => Permit::Stay(point),
            Stopping::Unknown => Permit::Unknown,
        }
    }
}
