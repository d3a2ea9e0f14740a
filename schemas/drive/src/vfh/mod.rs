//! The vector field histogram plus: Ulrich and Borenstein, "VFH+: reliable obstacle avoidance for fast mobile
//! robots", ICRA 1998. It sees one scan, keeps no map, and can get stuck in a dead end.

mod histogram;
mod panel;

use jde_schema::prelude::*;

use crate::body::{Ability, Body, HOLD, Permit};
use crate::ports::{Perception, RobotBase, VelocityLimits};
use histogram::{Costs, Free, Histogram, Surroundings};

/// Turn rate for a heading error of 1 rad, 1/s: the error falls to a third in half a second, a few periods.
const GAIN: f64 = 2.0;
/// Heading error from which it turns on the spot, rad.
const SPOT: f64 = 60_f64.to_radians();
/// The least share of `vx_max` beside a close obstacle, so that a passage takes a finite time.
const MIN_SPEED_SHARE: f64 = 0.25;

/// Drives to the target through the openings between obstacles.
///
/// It is ready while it has a target, a pose, and a scan that measures something. The urgency is the absolute
/// angle to the chosen direction, rad.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Vfh {
    #[ports]
    perception: Perception,
    /// The target.
    #[modulation(default = Target::NONE)]
    target: Modulation<Target>,
    /// Distance to the target below which it stands still.
    #[modulation(default = 0.1, unit = "m", min = 0.0)]
    tolerance: Modulation<f64>,
    #[ports]
    robot: RobotBase,
    /// Distance to keep from obstacles.
    #[modulation(default = 0.1, unit = "m", min = 0.0, margin)]
    margin: Modulation<f64>,
    /// Free distance below which a direction is blocked.
    #[modulation(default = 0.8, unit = "m", min = 0.0)]
    near: Modulation<f64>,
    /// How much more than `near` a blocked direction needs to be free again.
    #[modulation(default = 0.2, unit = "m", min = 0.0)]
    hysteresis: Modulation<f64>,
    /// Width from which an opening is wide: the robot then keeps half of this from its edge.
    #[modulation(default = 80_f64.to_radians(), unit = "rad", min = 0.0)]
    wide: Modulation<f64>,
    /// Cost of an angle to the target. It must exceed the sum of the other two to be goal-oriented.
    #[modulation(default = 5.0, min = 0.0)]
    target_cost: Modulation<f64>,
    /// Cost of an angle to the present heading.
    #[modulation(default = 2.0, min = 0.0)]
    heading_cost: Modulation<f64>,
    /// Cost of an angle to the last chosen direction.
    #[modulation(default = 2.0, min = 0.0)]
    change_cost: Modulation<f64>,
    #[ports]
    limits: VelocityLimits,
    body: Option<Body>,
    histogram: Histogram,
    /// The directions that were free at the last check.
    free: Option<Free>,
    /// The direction that was chosen last, in the frame of the odometry, rad.
    chosen: Option<f64>,
    choice: Steering,
    permit: Option<Permit>,
}

/// What the histogram says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Steering {
    /// There is no target, no pose, no usable scan or no dynamics of the base.
    #[default]
    Missing,
    /// The target is reached.
    Arrived,
    /// No direction is free.
    Enclosed,
    /// Toward this angle to the left, rad.
    Toward(f64),
}

impl Schema for Vfh {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(self.robot.body(cx)?);
        self.histogram = Histogram::default();
        self.chosen = None;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        self.choice = self.steer(cx);
        Ok(match self.choice {
            Steering::Missing => false.into(),
            Steering::Arrived | Steering::Enclosed => true.into(),
            Steering::Toward(angle) => Precondition::from(true).urgency(angle.abs()),
        })
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.choice = self.steer(cx);
        let (Steering::Toward(angle), Some(pose), Some(body)) =
            (self.choice, self.perception.pose.get(cx), self.body.as_ref())
        else {
            self.chosen = None;
            self.permit = None;
            self.robot.base.command(cx, Twist::ZERO);
            return Ok(());
        };
        let heading = pose.pose2d().theta;
        self.chosen = Some(jde_schema::types::normalize_angle(heading + angle));
        let distance = self.target_distance(cx, &pose.pose2d()).unwrap_or(0.0);
        let ability = self.ability(cx);
        let turn = self.limits.wz_max.get(cx);
        // The speed from which the base still stops at the target.
        let arrival = ability.dynamics.arrival(distance);
        let closeness = (body.clearance() / self.near.get(cx).max(f64::EPSILON)).clamp(MIN_SPEED_SHARE, 1.0);
        let straightness = (1.0 - angle.abs() / SPOT).max(0.0);
        let speed = (self.limits.vx_max.get(cx) * closeness * straightness).min(arrival);
        let wanted = Twist::planar(speed, (GAIN * angle).clamp(-turn, turn));
        let permit = body.permit(wanted, &ability);
        self.robot.base.command(cx, permit.twist());
        self.permit = Some(permit);
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Vfh {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
    }
}

impl Vfh {
    fn steer(&mut self, cx: &Context) -> Steering {
        let (laser, odometry) = (self.perception.laser.get(cx), self.perception.pose.get(cx));
        let Some(body) = self.body.as_mut() else {
            return Steering::Missing;
        };
        let observed = body.observe(cx, laser.as_ref(), odometry.as_ref(), self.robot.motors(cx));
        let (Some((pose, velocity)), Some(target)) = (observed, self.target.get(cx).get()) else {
            return Steering::Missing;
        };
        let distance = pose.distance_to(&target);
        if distance <= self.tolerance.get(cx) {
            return Steering::Arrived;
        }
        // What stands behind the target is not in the way.
        let near = self.near.get(cx).min(distance);
        let free = self.histogram.update(&Surroundings {
            points: body.points(),
            heading: pose.theta,
            enlargement: body.reach() + self.margin.get(cx),
            near,
            far: near + self.hysteresis.get(cx),
            turn_radius: velocity.linear.x.abs() / self.limits.wz_max.get(cx),
        });
        let costs = Costs {
            target: self.target_cost.get(cx),
            heading: self.heading_cost.get(cx),
            change: self.change_cost.get(cx),
        };
        let bearing = pose.theta + pose.bearing_to(&target);
        let chosen = self.chosen.unwrap_or(pose.theta);
        self.free = Some(free);
        match free.direction(bearing, pose.theta, chosen, self.wide.get(cx), &costs) {
            Some(direction) => Steering::Toward(jde_schema::types::normalize_angle(direction - pose.theta)),
            None => Steering::Enclosed,
        }
    }

    fn target_distance(&self, cx: &Context, pose: &Pose2D) -> Option<f64> {
        Some(pose.distance_to(&self.target.get(cx).get()?))
    }

    fn ability(&self, cx: &Context) -> Ability {
        self.robot.ability(cx, self.margin.get(cx) / 2.0, HOLD)
    }
}

#[cfg(test)]
mod tests;
