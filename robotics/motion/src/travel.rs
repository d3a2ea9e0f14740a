//! The motion of a base in the plane: exact arcs, and velocities that follow a command.
//!
//! Only the velocity ahead, the velocity to the left and the turn rate of a twist count.

use core::f64::consts::FRAC_PI_2;

use jde_types::{Odometry, Pose2D, Twist};

use crate::BaseDynamics;

/// A lagging speed ends where so little way is left, m or rad: far below what a sensor measures. Without an end the
/// base would never stand.
const MIN_REST: f64 = 1e-4;

/// Where a base is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Travel {
    /// The pose.
    pub pose: Pose2D,
    /// The velocity, in the frame of the base.
    pub velocity: Twist,
    /// What the velocity lacks of the one that a lagging base strives for.
    pub lead: Twist,
}

impl Travel {
    /// Returns the travel after `step` s, while the base strives for `command` as its dynamics permit.
    ///
    /// The pose follows the arc of the mean velocity. Its heading is exact without a lag; its position is exact for a
    /// constant velocity, and has an error of third order in `step` otherwise.
    #[must_use]
    pub fn after(&self, step: f64, command: &Twist, dynamics: &BaseDynamics) -> Self {
        let (up, down) = (dynamics.acceleration * step, dynamics.deceleration * step);
        let (turn_up, turn_down) = (
            dynamics.turn_acceleration * step,
            dynamics.turn_deceleration * step,
        );
        let kept = if dynamics.lag > 0.0 {
            libm::exp(-step / dynamics.lag)
        } else {
            0.0
        };
        // The velocity after the step, and what it lacks.
        let follow = |now: f64, lead: f64, goal: f64, (up, down): (f64, f64)| {
            if dynamics.lag == 0.0 {
                return (approach(now, goal, up, down), 0.0);
            }
            let target = now + lead;
            let next = approach(target, goal, up, down);
            let mean = f64::midpoint(target, next);
            let follows = mean + (now - mean) * kept;
            let lead = next - follows;
            if lead.abs() * dynamics.lag < MIN_REST {
                (next, 0.0)
            } else {
                (follows, lead)
            }
        };
        let (linear, angular, lead) = (self.velocity.linear, self.velocity.angular, self.lead);
        let ahead = follow(linear.x, lead.linear.x, command.linear.x, (up, down));
        let left = follow(linear.y, lead.linear.y, command.linear.y, (up, down));
        let turn = follow(angular.z, lead.angular.z, command.angular.z, (turn_up, turn_down));
        let twist = |ahead: f64, left: f64, turn: f64| {
            let mut twist = Twist::planar(ahead, turn);
            twist.linear.y = left;
            twist
        };
        let mean = twist(
            f64::midpoint(linear.x, ahead.0),
            f64::midpoint(linear.y, left.0),
            f64::midpoint(angular.z, turn.0),
        );
        Self {
            pose: self.pose.transform(&arc(&mean, step)),
            velocity: twist(ahead.0, left.0, turn.0),
            lead: twist(ahead.1, left.1, turn.1),
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
    libm::hypot(step.x, step.y) > way || step.theta.abs() > FRAC_PI_2
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
        (libm::sin(turn) / turn, (1.0 - libm::cos(turn)) / turn)
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

    const DYNAMICS: BaseDynamics = BaseDynamics {
        acceleration: 0.5,
        deceleration: 1.0,
        turn_acceleration: 2.0,
        turn_deceleration: 4.0,
        lag: 0.0,
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
        assert_eq!(travel.after(0.5, &back, &DYNAMICS).velocity.linear.x, 0.0);
        assert!((travel.after(0.1, &back, &DYNAMICS).velocity.linear.x - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_lagging_base_follows_as_a_first_order_system_and_comes_to_rest() {
        let quick = BaseDynamics {
            acceleration: 1e6,
            deceleration: 1e6,
            lag: 0.2,
            ..DYNAMICS
        };
        let mut travel = Travel {
            velocity: Twist::planar(1.0, 0.0),
            ..Travel::default()
        };
        // The limits are passed within the first step, of which half counts.
        travel = travel.after(1e-6, &Twist::ZERO, &quick);
        for _ in 0..10 {
            travel = travel.after(0.02, &Twist::ZERO, &quick);
        }
        assert!(
            (travel.velocity.linear.x - (-1.0_f64).exp()).abs() < 1e-4,
            "{travel:?}"
        );
        for _ in 0..100 {
            travel = travel.after(0.02, &Twist::ZERO, &quick);
        }
        assert_eq!((travel.velocity, travel.lead), (Twist::ZERO, Twist::ZERO));
        assert!((travel.pose.x - 0.2).abs() < 2e-3, "{travel:?}");
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
                travel = travel.after(0.02, &command, &DYNAMICS);
                prop_assert!((low..=high).contains(&travel.velocity.linear.x));
            }
            prop_assert_eq!(travel.velocity.linear.x, goal);
        }
    }
}
