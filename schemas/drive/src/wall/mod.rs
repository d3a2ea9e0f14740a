//! Following a wall: Mataric, "Integration of representation into goal-driven behavior-based robots", IEEE
//! Transactions on Robotics and Automation 8 (3), 1992, follows boundaries by such rules. It keeps a distance,
//! turns at inner corners, and goes around outer ones, so that it enters open doors on its side.

use jde_schema::prelude::*;
use jde_schema::types::{Point2D, normalize_angle};

use crate::body::{Body, HOLD, Permit};
use crate::ports::{Perception, RobotBase};

/// Turn rate for an angle of 1 rad between the wall and the heading, 1/s.
const ALIGN: f64 = 1.5;
/// Turn rate for an error of distance of 1 m, rad/(s·m): with [`ALIGN`] it meets the wall at about 50° per
/// metre, without passing the distance.
const APPROACH: f64 = 1.3;
/// How far ahead of the side a point still belongs to the wall, rad. What is more ahead is an obstacle.
const SIDE: f64 = 45_f64.to_radians();
/// The part of `vx_max` that is left while it turns at full rate, or goes around a corner.
const TURNING_SPEED: f64 = 0.4;

/// Follows the wall on one side at a distance.
///
/// It is ready while it has a pose, and a scan that measures something. Without a wall on its side it goes
/// straight until one is near. A laser that looks ahead by half a turn is enough.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Wall {
    #[ports]
    perception: Perception,
    /// The side on which the wall is.
    #[modulation(default = Side::Right)]
    side: Modulation<Side>,
    /// Distance from the body to the wall.
    #[modulation(default = 0.4, unit = "m", min = 0.05)]
    distance: Modulation<f64>,
    /// Free way ahead of the body below which it turns away from the wall.
    #[modulation(default = 0.4, unit = "m", min = 0.0)]
    near: Modulation<f64>,
    #[ports]
    robot: RobotBase,
    /// Distance to keep from everything in any case.
    #[modulation(default = 0.05, unit = "m", min = 0.0, margin)]
    margin: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.3, unit = "m/s", min = 0.0, limit, was = "fast")]
    vx_max: Modulation<f64>,
    /// Greatest turn rate.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01, limit, was = "turn")]
    wz_max: Modulation<f64>,
    body: Option<Body>,
    gait: Gait,
    permit: Option<Permit>,
}

/// A side of the robot.
#[derive(Clone, Copy, Choice)]
#[repr(u8)]
enum Side {
    /// The left side.
    Left,
    /// The right side.
    Right,
}

/// What the robot does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Gait {
    /// No wall is near its side: it goes straight.
    #[default]
    Searching,
    /// It keeps its distance.
    Following,
    /// The way ahead is not free: it turns away from the wall on the spot.
    Turning,
    /// The wall ended: it goes around the corner.
    Rounding {
        /// The angle turned since the wall ended, rad. After a whole turn there is no wall.
        turned: f64,
        /// The heading at the last iteration, rad.
        heading: f64,
    },
}

impl Schema for Wall {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(self.robot.body(cx)?);
        self.gait = Gait::Searching;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.observe(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.permit = self.drive(cx);
        self.robot
            .base
            .command(cx, self.permit.map_or(Twist::ZERO, |permit| permit.twist()));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Wall {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
    }
}

impl Panel for Wall {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.text(match self.gait {
            Gait::Searching => "searches a wall",
            Gait::Following => "follows the wall",
            Gait::Turning => "turns away from what is ahead",
            Gait::Rounding { .. } => "goes around a corner",
        });
        if let Some(obstacle) = self.permit.and_then(|permit| permit.obstacle()) {
            pen.text(obstacle);
        }
        if let Some((_, distance)) = self.wall(cx) {
            pen.value("distance", distance, "m");
        }
    }
}

impl Wall {
    fn observe(&mut self, cx: &Context) -> Option<(Pose2D, Twist)> {
        let (laser, pose) = (self.perception.laser.get(cx), self.perception.pose.get(cx));
        self.body
            .as_mut()?
            .observe(cx, laser.as_ref(), pose.as_ref(), self.robot.motors(cx))
    }

    fn drive(&mut self, cx: &Context) -> Option<Permit> {
        let (pose, _) = self.observe(cx)?;
        let margin = self.margin.get(cx);
        let ahead = self.body.as_ref()?.free_ahead(margin);
        let wall = self.wall(cx);
        self.gait = self.next(cx, ahead, wall, pose.theta);
        let (fast, most) = (self.vx_max.get(cx), self.wz_max.get(cx));
        // A positive turn leads away from the wall.
        let (speed, away) = match self.gait {
            Gait::Searching => (fast, 0.0),
            Gait::Turning => (0.0, most),
            Gait::Rounding { .. } => {
                let radius = self.distance.get(cx) + self.body.as_ref()?.reach();
                (TURNING_SPEED * fast, -(TURNING_SPEED * fast / radius).min(most))
            }
            Gait::Following => {
                let (angle, distance) = wall?;
                let error = distance - self.distance.get(cx);
                let turn = (ALIGN * angle - APPROACH * error).clamp(-most, most);
                (fast * (1.0 - (1.0 - TURNING_SPEED) * turn.abs() / most), turn)
            }
        };
        // The speed from which it still stops before what is ahead.
        let speed = speed.min(self.robot.dynamics(cx).arrival(ahead));
        let ability = self.robot.ability(cx, margin, HOLD);
        let wanted = Twist::planar(speed, self.left(cx) * -away);
        Some(self.body.as_ref()?.permit(wanted, &ability))
    }

    fn next(&self, cx: &Context, ahead: f64, wall: Option<(f64, f64)>, heading: f64) -> Gait {
        let near = self.near.get(cx);
        // What is beyond twice the distance is another wall.
        let beside = wall.is_some_and(|(_, distance)| distance < 2.0 * self.distance.get(cx));
        // It turns until there is more room than made it turn; otherwise it would stutter.
        let blocked = ahead
            < if self.gait == Gait::Turning {
                1.5 * near
            } else {
                near
            };
        if blocked {
            return Gait::Turning;
        }
        if beside {
            return Gait::Following;
        }
        match self.gait {
            Gait::Searching => Gait::Searching,
            Gait::Following | Gait::Turning => Gait::Rounding { turned: 0.0, heading },
            Gait::Rounding {
                turned,
                heading: last,
            } => {
                let turned = turned + normalize_angle(heading - last).abs();
                if turned < core::f64::consts::TAU {
                    Gait::Rounding { turned, heading }
                } else {
                    Gait::Searching
                }
            }
        }
    }

    /// 1 if the wall is on the left, −1 if it is on the right.
    fn left(&self, cx: &Context) -> f64 {
        match self.side.get(cx) {
            Side::Left => 1.0,
            Side::Right => -1.0,
        }
    }

    /// By how much the nearest point of the side is ahead of the side's axis, rad, and its distance from the
    /// body, m; `None` without a point there.
    fn wall(&self, cx: &Context) -> Option<(f64, f64)> {
        let (left, body) = (self.left(cx), self.body.as_ref()?);
        let range = |point: &Point2D| libm::hypot(point.x, point.y);
        let angle = |point: &Point2D| libm::atan2(point.x, left * point.y);
        let beside = body.points().iter().filter(|point| angle(point).abs() <= SIDE);
        let nearest = beside.min_by(|a, b| range(a).total_cmp(&range(b)))?;
        Some((angle(nearest), range(nearest) - body.reach()))
    }
}

#[cfg(test)]
mod tests;
