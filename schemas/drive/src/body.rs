//! What all schemas of this plugin share: the body of the robot, what its laser sees, and the check of a
//! command. A command that the body cannot stop from in time is slowed or refused, never replaced by another
//! way.

use jde_motion::{
    BaseDynamics, FootprintError, Maneuver, Momentum, Motors, OdometryHistory, Outline, ScanPoints, Stopping,
    Sweep, Travel,
};
use jde_schema::prelude::*;
use jde_schema::types::{Footprint, Point2D};

/// How long a command is in force at least before the next one takes effect, s: twice the period of the
/// schemas of this plugin, and the period of a driver.
pub(crate) const HOLD: f64 = 0.3;
/// The factors that a refused command is tried with, as the speed along the same arc.
const SPEED_FACTORS: [f64; 3] = [1.0, 0.5, 0.25];

/// The body of the robot, and what the laser saw last.
pub(crate) struct Body {
    outline: Outline,
    mount: Pose2D,
    history: OdometryHistory,
    scan_points: ScanPoints,
    momentum: Momentum,
    /// Where the base is and how it moves.
    travel: Travel,
    /// Where the base was while the last scan was taken.
    sweep: Option<Sweep>,
    /// Whether the times of scans say nothing, which the log says once.
    is_untimely: bool,
}

/// What the base can do, from the modulations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ability {
    /// How it follows its commands.
    pub(crate) dynamics: BaseDynamics,
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
            Self::Unknown => Some("the velocity is not a number, or a stop takes too long".into()),
        }
    }
}

impl Body {
    /// Returns the body of a footprint with a laser at `mount`.
    pub(crate) fn new(footprint: &Footprint, mount: Pose2D) -> Result<Self, FootprintError> {
        Ok(Self {
            outline: Outline::try_from(footprint)?,
            mount,
            history: OdometryHistory::default(),
            scan_points: ScanPoints::default(),
            momentum: Momentum::default(),
            travel: Travel::default(),
            sweep: None,
            is_untimely: false,
        })
    }

    /// Takes in a scan and the odometry of a base with these motors, and returns its pose now and its velocity; `None` if
    /// there is no scan or odometry, the motors are unknown, the scan measures nothing, its time or that of the odometry
    /// says nothing of the present, or a number of the odometry is not finite.
    pub(crate) fn observe(
        &mut self,
        cx: &Context,
        scan: Option<&Sample<'_, LaserScan>>,
        odometry: Option<&Sample<'_, Odometry>>,
        motors: Option<Motors>,
    ) -> Option<(Pose2D, Twist)> {
        let (scan, odometry) = (scan?, odometry?);
        measured(odometry)?;
        self.history.add(odometry.time(), odometry);
        let here = self.history.current(cx.now());
        let placed = here.and_then(|here| Ok((here, self.history.sweep(scan, scan.time(), cx.now())?)));
        let was_untimely = core::mem::replace(&mut self.is_untimely, placed.is_err());
        if let Err(words) = &placed
            && !was_untimely
        {
            warn!(cx, "stands: {words}");
        }
        self.sweep = placed.as_ref().ok().map(|(_, sweep)| *sweep);
        let (pose, sweep) = placed.ok()?;
        let laser = sweep.seen_from(&pose, &self.mount);
        self.scan_points.update(scan, laser).ok()?;
        // Not by its header: that of ROS may have no time.
        let moves = self.momentum.update(odometry.time(), &odometry.twist, &motors?);
        self.travel = Travel { pose, ..moves };
        Some((pose, moves.velocity))
    }

    /// Where the base is and how it moves, as it was observed last.
    pub(crate) fn travel(&self) -> &Travel {
        &self.travel
    }

    /// How often the odometry jumped: what was seen before is elsewhere.
    pub(crate) const fn jumps(&self) -> u64 {
        self.history.jumps()
    }

    /// Where the base was while the last scan was taken.
    pub(crate) const fn sweep(&self) -> Option<&Sweep> {
        self.sweep.as_ref()
    }

    /// The points of the last scan, in the frame of the base as it is now.
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

    /// Checks `wanted` among what the laser sees, for the base as it moves.
    pub(crate) fn permit(&self, wanted: Twist, ability: &Ability) -> Permit {
        self.permit_among(self.points(), wanted, ability)
    }

    /// Checks `wanted` among these points, in the frame of the base.
    ///
    /// A body that is nearer than twice the margin may move as long as it comes no nearer than it does if it stands, by the rule of
    /// a guard: what this permits, a guard of the same margin does not refuse.
    pub(crate) fn permit_among(&self, points: &[Point2D], wanted: Twist, ability: &Ability) -> Permit {
        let margin = ability.margin;
        let is_close = self.outline.clearance(&Pose2D::ORIGIN, points) < 2.0 * margin;
        let stopping = |command: Twist| {
            let maneuver = Maneuver {
                velocity: self.travel.velocity,
                lead: self.travel.lead,
                wait: 0.0,
                command,
                hold: ability.hold,
                dynamics: ability.dynamics,
            };
            match maneuver.stopping(&self.outline, points, margin) {
                Stopping::Touches { .. }
                    if is_close && maneuver.keeps_clear(&self.outline, points, margin) =>
                {
                    Stopping::Free
                }
                stopping => stopping,
            }
        };
        let turn = wanted.angular.z;
        let mut blocking = None;
        for factor in SPEED_FACTORS {
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

#[cfg(test)]
mod tests {
    use jde_motion::Surroundings;
    use jde_schema::types::Footprint;
    use proptest::prelude::*;

    use super::*;

    const DYNAMICS: BaseDynamics = BaseDynamics {
        acceleration: 0.9,
        deceleration: 0.9,
        turn_acceleration: 3.0,
        turn_deceleration: 3.0,
        lag: 0.1,
    };
    const MARGIN: f64 = 0.05;

    fn body() -> Body {
        Body::new(&Footprint::circle(0.25), Pose2D::ORIGIN).expect("a circle")
    }

    fn permit(points: &[Point2D], wanted: Twist) -> Permit {
        let ability = Ability {
            dynamics: DYNAMICS,
            margin: MARGIN,
            hold: HOLD,
        };
        body().permit_among(points, wanted, &ability)
    }

    #[test]
    fn a_body_within_its_margin_leaves_and_comes_no_nearer() {
        let ahead = Point2D { x: 0.28, y: 0.0 };
        assert_eq!(
            permit(&[ahead], Twist::planar(0.1, 0.0)),
            Permit::Turn(Twist::ZERO, ahead)
        );
        let away = Twist::planar(-0.1, 0.0);
        assert_eq!(permit(&[ahead], away), Permit::Go(away));
        let beside = Point2D { x: -0.02, y: 0.28 };
        let past = Twist::planar(0.1, 0.0);
        assert_eq!(permit(&[beside], past), Permit::Go(past));
        let before = Point2D { x: 0.1, y: 0.27 };
        assert!(
            !matches!(permit(&[before], past), Permit::Go(_)),
            "it would come nearer"
        );
    }

    proptest! {
        #[test]
        fn what_it_permits_a_guard_of_its_margin_permits(
            points in prop::collection::vec((-0.6..0.6_f64, -0.6..0.6_f64), 1..12),
            (speed, turn) in (-0.5..0.5_f64, -2.0..2.0_f64),
        ) {
            let mut state = Surroundings {
                footprint: Footprint::circle(0.25),
                reaction: HOLD,
                margin: MARGIN,
                dynamics: DYNAMICS,
                ..Surroundings::default()
            };
            let points: Vec<Point2D> = points.into_iter().map(|(x, y)| Point2D { x, y }).collect();
            for &point in &points {
                state.points.push(point).expect("few points");
            }
            let given = permit(&points, Twist::planar(speed, turn)).twist();
            prop_assert_eq!(state.judge(core::time::Duration::ZERO, &given), Ok(()));
        }
    }
}
