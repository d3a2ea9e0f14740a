//! The motion of a base in the plane: exact arcs, and velocities that follow a command within limits.
//!
//! Only the velocity ahead, the velocity to the left and the turn rate of a twist count.

use core::f64::consts::FRAC_PI_2;

use jde_types::{Odometry, Pose2D, Twist};

/// The most time between a picture and the odometry that the velocity bridges, s.
const BRIDGED: f64 = 0.5;

/// How fast a base can change its velocity. Each number must be above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest growth of a speed, m/s².
    pub acceleration: f64,
    /// Greatest decline of a speed, m/s².
    pub deceleration: f64,
    /// Greatest growth of the turn rate, rad/s².
    pub turn_acceleration: f64,
    /// Greatest decline of the turn rate, rad/s².
    pub turn_deceleration: f64,
}

/// Where a base is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Travel {
    /// The pose.
    pub pose: Pose2D,
    /// The velocity, in the frame of the base.
    pub velocity: Twist,
}

impl Travel {
    /// Returns the travel after `step` s, while the velocity approaches `command` as fast as the limits
    /// permit.
    ///
    /// The pose follows the arc of the mean velocity. Its heading is exact; its position is exact for a
    /// constant velocity, and has an error of third order in `step` otherwise.
    #[must_use]
    pub fn after(&self, step: f64, command: &Twist, limits: &Limits) -> Self {
        let (linear, angular) = (self.velocity.linear, self.velocity.angular);
        let (up, down) = (limits.acceleration * step, limits.deceleration * step);
        let (turn_up, turn_down) = (limits.turn_acceleration * step, limits.turn_deceleration * step);
        let mut next = Twist::planar(
            approach(linear.x, command.linear.x, up, down),
            approach(angular.z, command.angular.z, turn_up, turn_down),
        );
        next.linear.y = approach(linear.y, command.linear.y, up, down);
        let mut mean = Twist::planar(
            f64::midpoint(linear.x, next.linear.x),
            f64::midpoint(angular.z, next.angular.z),
        );
        mean.linear.y = f64::midpoint(linear.y, next.linear.y);
        Self {
            pose: self.pose.transform(&arc(&mean, step)),
            velocity: next,
        }
    }
}

/// Returns whether what counts of an odometry is finite: the pose and the velocity in the plane.
#[must_use]
pub fn is_finite(odometry: &Odometry) -> bool {
    let (pose, Twist { linear, angular }) = (odometry.pose2d(), odometry.twist.twist);
    pose.is_finite() && [linear.x, linear.y, angular.z].into_iter().all(f64::is_finite)
}

/// Returns whether a step of the odometry is a jump and no motion: it is longer than `way` m, or a turn by more than 90
/// degrees.
#[must_use]
pub fn is_jump(from: &Pose2D, to: &Pose2D, way: f64) -> bool {
    let step = from.localize(to);
    step.x.hypot(step.y) > way || step.theta.abs() > FRAC_PI_2
}

/// Returns what is said of a jump of the odometry.
#[must_use]
pub fn jumped(from: &Pose2D, to: &Pose2D) -> String {
    let (way, turn) = (from.distance_to(to), from.localize(to).theta.abs());
    format!(
        "the odometry jumped by {way:.2} m and {:.0} degrees",
        turn.to_degrees()
    )
}

/// Checks that the velocity bridges the time of `since` s from the odometry to what a sensor sees, its "pictures" or
/// "scans": 0.5 s at most. Where the base was earlier is not known.
///
/// # Errors
/// What is said of them.
pub fn check_time(what: &str, since: f64) -> Result<(), String> {
    if since.abs() <= BRIDGED {
        return Ok(());
    }
    let older = if since < 0.0 { "older" } else { "newer" };
    Err(format!(
        "the {what} are {:.1} s {older} than the odometry",
        since.abs()
    ))
}

/// Returns the pose after `time` s at the constant velocity `twist`, from the origin: the exponential map of
/// SE(2).
#[must_use]
pub fn arc(twist: &Twist, time: f64) -> Pose2D {
    let (x, y, turn) = (
        twist.linear.x * time,
        twist.linear.y * time,
        twist.angular.z * time,
    );
    // Below this angle the series to the second order is exact to the last bit.
    let (s, c) = if turn.abs() < 1e-4 {
        (1.0 - turn * turn / 6.0, turn / 2.0)
    } else {
        (turn.sin() / turn, (1.0 - turn.cos()) / turn)
    };
    Pose2D::new(s * x - c * y, c * x + s * y, jde_types::normalize_angle(turn))
}

/// Returns `value` moved toward `goal` by at most `up` away from zero or `down` toward it. A change of sign
/// stops at zero.
fn approach(value: f64, goal: f64, up: f64, down: f64) -> f64 {
    if value * goal < 0.0 {
        return approach(value, 0.0, up, down);
    }
    let step = if goal.abs() < value.abs() { down } else { up };
    let change = goal - value;
    if change.abs() <= step {
        goal
    } else {
        value + step.copysign(change)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    const LIMITS: Limits = Limits {
        acceleration: 0.5,
        deceleration: 1.0,
        turn_acceleration: 2.0,
        turn_deceleration: 4.0,
    };

    #[test]
    fn a_half_turn_of_1_m_radius_ends_2_m_to_the_left() {
        let end = arc(&Twist::planar(1.0, 1.0), PI);
        assert!(end.x.abs() < 1e-12 && (end.y - 2.0).abs() < 1e-12);
        assert!((end.theta.abs() - PI).abs() < 1e-12);
    }

    #[test]
    fn a_reversal_brakes_to_zero_first() {
        let travel = Travel {
            velocity: Twist::planar(0.3, 0.0),
            ..Travel::default()
        };
        let back = Twist::planar(-0.5, 0.0);
        assert_eq!(travel.after(0.5, &back, &LIMITS).velocity.linear.x, 0.0);
        assert!((travel.after(0.1, &back, &LIMITS).velocity.linear.x - 0.2).abs() < 1e-12);
    }

    #[test]
    fn only_what_counts_of_an_odometry_must_be_finite() {
        let with = |change: fn(&mut Twist)| {
            let mut odometry = Odometry::default();
            change(&mut odometry.twist.twist);
            is_finite(&odometry)
        };
        assert!(with(|twist| twist.linear.z = f64::NAN));
        assert!(with(
            |twist| (twist.angular.x, twist.angular.y) = (f64::NAN, f64::INFINITY)
        ));
        assert!(!with(|twist| twist.linear.x = f64::INFINITY));
        assert!(!with(|twist| twist.linear.y = f64::NAN));
        assert!(!with(|twist| twist.angular.z = f64::NAN));
        let mut nowhere = Odometry::default();
        nowhere.pose.pose.position.y = f64::NAN;
        assert!(!is_finite(&nowhere));
    }

    #[test]
    fn a_long_way_or_a_turn_by_more_than_90_degrees_is_a_jump() {
        let from = Pose2D::new(1.0, 2.0, 3.0);
        let is_jump = |x, theta| is_jump(&from, &from.transform(&Pose2D::new(x, 0.0, theta)), 0.5);
        assert!(!is_jump(0.49, 1.57) && !is_jump(-0.49, -1.57));
        assert!(is_jump(0.51, 0.0) && is_jump(-0.51, 0.0));
        assert!(is_jump(0.0, 1.58) && is_jump(0.0, -1.58));
    }

    proptest! {
        #[test]
        fn two_arcs_of_half_the_time_make_one(x in -1.0..1.0, y in -1.0..1.0, turn in -2.0..2.0, time in 0.0..3.0) {
            let mut twist = Twist::planar(x, turn);
            twist.linear.y = y;
            let half = arc(&twist, time / 2.0);
            let (twice, whole) = (half.transform(&half), arc(&twist, time));
            prop_assert!(twice.distance_to(&whole) < 1e-9);
        }

        #[test]
        fn the_velocity_reaches_its_command_and_never_passes_it(now in -1.0..1.0, goal in -1.0..1.0) {
            let mut travel = Travel { velocity: Twist::planar(now, 0.0), ..Travel::default() };
            let command = Twist::planar(goal, 0.0);
            let (low, high) = (f64::min(now, goal), f64::max(now, goal));
            for _ in 0..300 {
                travel = travel.after(0.02, &command, &LIMITS);
                prop_assert!((low..=high).contains(&travel.velocity.linear.x));
            }
            prop_assert_eq!(travel.velocity.linear.x, goal);
        }
    }
}
