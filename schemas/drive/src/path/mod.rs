//! Regulated pure pursuit: Macenski, Singh, Martin and Ginés, "Regulated pure pursuit for robot path tracking",
//! Autonomous Robots, 2023. It follows a path and leaves it for nothing: before an obstacle it stops.

mod panel;
mod pursuit;

use jde_schema::prelude::*;
use jde_schema::types::{Footprint, normalize_angle};

use crate::body::{Ability, Body, Permit};
use crate::track::Track;
use pursuit::curvature;

/// Turn rate for a heading error of 1 rad while it turns on the spot, 1/s.
const GAIN: f64 = 2.0;

/// Follows a path by arcs to a point ahead on it, slower in bends and beside obstacles.
///
/// It is ready while it has a path, a pose, and a scan that measures something. The path is in the frame of
/// the odometry: the import if it is bound, or else the route of the file. Before an obstacle it stops and
/// states the reason in the note of its mission.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Path {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The path.
    #[import(optional)]
    path: Import<jde_schema::types::Path>,
    /// The path if the import is not bound.
    #[modulation(default = Route::EMPTY)]
    route: Modulation<Route>,
    /// Distance to the end of the path below which it is reached.
    #[modulation(default = 0.15, unit = "m", min = 0.01)]
    tolerance: Modulation<f64>,
    /// Error of the last heading below which it is reached. The default accepts any heading.
    #[modulation(default = core::f64::consts::PI, unit = "rad", min = 0.01)]
    heading_tolerance: Modulation<f64>,
    /// Time by which the pursued point is ahead at the present speed.
    #[modulation(default = 1.5, unit = "s", min = 0.0)]
    lookahead_time: Modulation<f64>,
    /// Least distance of the pursued point.
    #[modulation(default = 0.3, unit = "m", min = 0.01)]
    lookahead_min: Modulation<f64>,
    /// Greatest distance of the pursued point.
    #[modulation(default = 0.9, unit = "m", min = 0.01)]
    lookahead_max: Modulation<f64>,
    /// Radius of a bend below which it slows in proportion.
    #[modulation(default = 0.9, unit = "m", min = 0.0)]
    slow_radius: Modulation<f64>,
    /// Clearance below which it slows in proportion.
    #[modulation(default = 0.4, unit = "m", min = 0.0)]
    slow_clearance: Modulation<f64>,
    /// Angle to the pursued point from which it turns on the spot.
    #[modulation(default = 45_f64.to_radians(), unit = "rad", min = 0.01)]
    spot: Modulation<f64>,
    /// Time for which the arc ahead must be free, before the time to stop.
    #[modulation(default = 1.0, unit = "s", min = 0.3, max = 10.0)]
    free_time: Modulation<f64>,
    /// The outline of the robot.
    #[modulation(default = Footprint::circle(0.25), fixed)]
    footprint: Modulation<Footprint>,
    /// Where the laser is on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    mount: Modulation<Pose2D>,
    /// Distance to keep from obstacles.
    #[modulation(default = 0.05, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Least speed of the regulation by bends and clearance.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0)]
    slow: Modulation<f64>,
    /// Greatest turn rate.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01)]
    turn: Modulation<f64>,
    /// Greatest change of speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Greatest change of turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Done at the end of the path. The distance is the way to it; the note states why the robot stands.
    #[export(lasting)]
    mission: Export<Mission>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    body: Option<Body>,
    track: Track,
    chase: Chase,
    permit: Option<Permit>,
}

/// What the robot does about its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Chase {
    /// There is no path, no pose or no usable scan.
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
        self.body = Some(Body::new(&self.footprint.get(cx), self.mount.get(cx))?);
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
        self.base.command(cx, twist);
        let note = self.reason().unwrap_or_default();
        self.mission
            .write(cx, self.track.mission(self.chase == Chase::Done, &note));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Path {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(
            &self.footprint,
            Body::new(&self.footprint.get(cx), self.mount.get(cx)),
        );
    }
}

impl Path {
    fn chase(&mut self, cx: &Context) -> Chase {
        let (laser, odometry) = (self.laser.get(cx), self.pose.get(cx));
        let observed = self
            .body
            .as_mut()
            .and_then(|body| body.observe(laser.as_deref(), odometry.as_deref()));
        let has_track = self.track.follow(cx, &self.path, &self.route);
        let Some((pose, velocity)) = observed.filter(|_| has_track) else {
            return Chase::Missing;
        };
        let progress = self.track.advance(&pose);
        let track = &self.track;
        let goal = track.goal();
        let (low, high) = (self.lookahead_min.get(cx), self.lookahead_max.get(cx));
        let speed = velocity.linear.x.abs();
        let lookahead = (speed * self.lookahead_time.get(cx)).min(high).max(low);
        let point = pose.localize(&track.at(progress + lookahead));
        let near_the_end = track.left() <= lookahead;
        if !near_the_end || pose.distance_to(&goal) > self.tolerance.get(cx) {
            return Chase::Point(point);
        }
        let error = normalize_angle(goal.theta - pose.theta);
        if error.abs() > self.heading_tolerance.get(cx) {
            Chase::Heading(error)
        } else {
            Chase::Done
        }
    }

    /// The command without regard to what is in the way; `None` if there is none to give.
    fn wanted(&self, cx: &Context) -> Option<Twist> {
        let most = self.turn.get(cx);
        let spot = |angle: f64| Twist::planar(0.0, (GAIN * angle).clamp(-most, most));
        let point = match self.chase {
            Chase::Missing | Chase::Done => return None,
            Chase::Heading(error) => return Some(spot(error)),
            Chase::Point(point) => point,
        };
        let angle = point.y.atan2(point.x);
        if angle.abs() > self.spot.get(cx) {
            return Some(spot(angle));
        }
        let curve = curvature(&point);
        let (fast, slow) = (self.fast.get(cx), self.slow.get(cx));
        let clearance = self.body.as_ref()?.clearance();
        let bend = fast / (curve.abs() * self.slow_radius.get(cx)).max(1.0);
        let close = fast * clearance / self.slow_clearance.get(cx).max(f64::EPSILON);
        let left = self.track.left();
        let arrival = (2.0 * self.acceleration.get(cx) * left.max(point.x.hypot(point.y))).sqrt();
        let speed = bend.min(close).max(slow).min(fast).min(arrival);
        // Both fall together, so that the arc stays.
        let speed = speed.min(most / curve.abs().max(f64::EPSILON));
        Some(Twist::planar(speed, speed * curve))
    }

    fn permit(&self, cx: &Context, wanted: Twist) -> Option<Permit> {
        let ability = Ability {
            acceleration: self.acceleration.get(cx),
            turn_acceleration: self.turn_acceleration.get(cx),
            margin: self.margin.get(cx),
            hold: self.free_time.get(cx),
        };
        let velocity = self.pose.get(cx)?.twist.twist;
        Some(self.body.as_ref()?.permit(&velocity, wanted, &ability))
    }

    /// Why the robot does not go on; `None` if it does.
    fn reason(&self) -> Option<String> {
        match (self.chase, self.permit) {
            (Chase::Missing, _) => Some("no path, no pose or no usable scan".into()),
            (Chase::Done, _) => Some("at the end of the path".into()),
            (Chase::Point(_) | Chase::Heading(_), permit) => permit?.obstacle(),
        }
    }
}

#[cfg(test)]
mod tests;
