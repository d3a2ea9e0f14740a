//! Regulated pure pursuit: Macenski, Singh, Martin and Ginés, "Regulated pure pursuit for robot path tracking",
//! Autonomous Robots, 2023. It follows a path and leaves it for nothing: before an obstacle it stops.

mod panel;
mod pursuit;

use jde_schema::prelude::*;

use crate::body::{Body, Permit};
use crate::ports::{PathGoal, PathToFollow, Perception, RobotBase, VelocityLimits};
use crate::track::Track;
use pursuit::curvature;

/// Follows a path by arcs to a point ahead on it, slower in bends and beside obstacles.
///
/// It is ready while it has a path, a pose, and a scan that measures something. The path is in the frame of
/// the odometry: the import if it is bound, or else the route of the file. Before an obstacle it stops and
/// states the reason in the note of its mission.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Path {
    #[ports]
    perception: Perception,
    #[ports]
    path: PathToFollow,
    #[ports]
    goal: PathGoal,
    /// Time by which the pursued point is ahead at the present speed.
    #[modulation(default = 1.5, unit = "s", min = 0.0)]
    lookahead_time: Modulation<f64>,
    /// Least distance of the pursued point.
    #[modulation(default = 0.3, unit = "m", min = 0.01, was = "lookahead_min")]
    min_lookahead_dist: Modulation<f64>,
    /// Greatest distance of the pursued point.
    #[modulation(default = 0.9, unit = "m", min = 0.01, was = "lookahead_max")]
    max_lookahead_dist: Modulation<f64>,
    /// Radius of a bend below which it slows in proportion.
    #[modulation(default = 0.9, unit = "m", min = 0.0, was = "slow_radius")]
    regulated_linear_scaling_min_radius: Modulation<f64>,
    /// Clearance below which it slows in proportion.
    #[modulation(default = 0.4, unit = "m", min = 0.0, was = "slow_clearance")]
    cost_scaling_dist: Modulation<f64>,
    /// Angle to the pursued point from which it turns on the spot.
    #[modulation(default = 45_f64.to_radians(), unit = "rad", min = 0.01, was = "spot")]
    rotate_to_heading_min_angle: Modulation<f64>,
    /// Time for which the arc ahead must be free, before the time to stop.
    #[modulation(default = 1.0, unit = "s", min = 0.3, max = 10.0, was = "free_time")]
    max_allowed_time_to_collision: Modulation<f64>,
    #[ports]
    robot: RobotBase,
    /// Distance to keep from obstacles.
    #[modulation(default = 0.05, unit = "m", min = 0.0, margin)]
    margin: Modulation<f64>,
    #[ports]
    limits: VelocityLimits,
    /// Least speed of the regulation by bends and clearance.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0, was = "slow")]
    regulated_linear_scaling_min_speed: Modulation<f64>,
    body: Option<Body>,
    track: Track,
    chase: Chase,
    permit: Option<Permit>,
}

/// What the robot does about its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Chase {
    /// There is no path, no pose, no usable scan or no dynamics of the base.
    #[default]
    Missing,
    /// It pursues this point, in the frame of the base.
    Point(Pose2D),
    /// It turns to the last heading, by this angle to the left, rad.
    Heading(f64),
    /// It is at the end of the path.
    Done,
}

impl Schema for Path {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(self.robot.body(cx)?);
        self.track = Track::default();
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.chase(cx) != Chase::Missing).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.chase = self.chase(cx);
        self.permit = self.wanted(cx).and_then(|wanted| self.permit(cx, wanted));
        let twist = match self.permit {
            Some(Permit::Go(twist)) => twist,
            // A turn alone would leave the path.
            Some(Permit::Turn(..) | Permit::Stay(_) | Permit::Unknown) | None => Twist::ZERO,
        };
        self.robot.base.command(cx, twist);
        let note = self.reason().unwrap_or_default();
        self.goal
            .mission
            .write(cx, self.track.mission(self.chase == Chase::Done, &note));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Path {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
    }
}

impl Path {
    fn chase(&mut self, cx: &Context) -> Chase {
        let (laser, odometry) = (self.perception.laser.get(cx), self.perception.pose.get(cx));
        let observed = self
            .body
            .as_mut()
            .and_then(|body| body.observe(cx, laser.as_ref(), odometry.as_ref(), self.robot.motors(cx)));
        let has_track = self.track.follow(cx, &self.path.path, &self.path.route);
        let Some((pose, velocity)) = observed.filter(|_| has_track) else {
            return Chase::Missing;
        };
        let progress = self.track.advance(&pose);
        let track = &self.track;
        let goal = track.goal();
        let (low, high) = (self.min_lookahead_dist.get(cx), self.max_lookahead_dist.get(cx));
        let speed = velocity.linear.x.abs();
        let lookahead = (speed * self.lookahead_time.get(cx)).min(high).max(low);
        let point = pose.localize(&track.at(progress + lookahead));
        let near_the_end = track.left() <= lookahead;
        if !near_the_end || pose.distance_to(&goal) > self.goal.xy_goal_tolerance.get(cx) {
            return Chase::Point(point);
        }
        let turn = self.goal.turn(cx, pose.theta, &goal);
        turn.map_or(Chase::Done, Chase::Heading)
    }

    /// The command without regard to what is in the way; `None` if there is none to give.
    fn wanted(&self, cx: &Context) -> Option<Twist> {
        let most = self.limits.wz_max.get(cx);
        let point = match self.chase {
            Chase::Missing | Chase::Done => return None,
            Chase::Heading(error) => {
                return Some(
                    self.limits
                        .spot(cx, error, self.goal.min_in_place_vel_theta.get(cx)),
                );
            }
            Chase::Point(point) => point,
        };
        let angle = libm::atan2(point.y, point.x);
        if angle.abs() > self.rotate_to_heading_min_angle.get(cx) {
            return Some(
                self.limits
                    .spot(cx, angle, self.goal.min_in_place_vel_theta.get(cx)),
            );
        }
        let curve = curvature(&point);
        let (fast, slow) = (
            self.limits.vx_max.get(cx),
            self.regulated_linear_scaling_min_speed.get(cx),
        );
        let clearance = self.body.as_ref()?.clearance();
        let bend = fast / (curve.abs() * self.regulated_linear_scaling_min_radius.get(cx)).max(1.0);
        let close = fast * clearance / self.cost_scaling_dist.get(cx).max(f64::EPSILON);
        let left = self.track.left();
        let arrival = self
            .robot
            .dynamics(cx)
            .arrival(left.max(libm::hypot(point.x, point.y)));
        let speed = bend.min(close).max(slow).min(fast).min(arrival);
        // Both fall together, so that the arc stays.
        let speed = speed.min(most / curve.abs().max(f64::EPSILON));
        Some(Twist::planar(speed, speed * curve))
    }

    fn permit(&self, cx: &Context, wanted: Twist) -> Option<Permit> {
        let ability = self.robot.ability(
            cx,
            self.margin.get(cx),
            self.max_allowed_time_to_collision.get(cx),
        );
        Some(self.body.as_ref()?.permit(wanted, &ability))
    }

    /// Why the robot does not go on; `None` if it does.
    fn reason(&self) -> Option<String> {
        match (self.chase, self.permit) {
            (Chase::Missing, _) => Some("no path, pose, usable scan or dynamics of the base".into()),
            (Chase::Done, _) => Some("at the end of the path".into()),
            (Chase::Point(_) | Chase::Heading(_), permit) => permit?.obstacle(),
        }
    }
}

#[cfg(test)]
mod tests;
