//! Wandering: it goes straight until something is near, and then turns to the freer side. It reaches no
//! place in particular and covers no area for certain.

use jde_schema::prelude::*;
use jde_schema::types::{Footprint, normalize_angle};

use crate::body::{Ability, Body, HOLD, Permit};

/// The least turn before an obstacle, rad. It leaves the direction that was blocked.
const LEAST_TURN: f64 = 30_f64.to_radians();
/// The greatest random part on top of it, rad, so that the robot does not go to and fro between two walls.
const RANDOM_TURN: f64 = 90_f64.to_radians();
/// Share of `fast` at the distance from which it turns, so that it does not brake at once there.
const CREEP: f64 = 0.25;

/// Drives straight until something is near, and turns toward the freer side by an angle with a random part.
///
/// It is ready while it has a pose, a scan that measures something, and no value of `known`. The random part comes from the
/// application's seed. A robot without a free way turns on.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Wander {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The place on a map. While it is known there is nothing to look for.
    #[import(optional)]
    known: Import<Odometry>,
    /// The outline of the robot.
    #[modulation(default = Footprint::circle(0.25), fixed)]
    footprint: Modulation<Footprint>,
    /// Where the laser is on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    mount: Modulation<Pose2D>,
    /// Distance to keep from obstacles, also beside the robot.
    #[modulation(default = 0.1, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Free way ahead of the body below which it turns.
    #[modulation(default = 0.5, unit = "m", min = 0.0)]
    near: Modulation<f64>,
    /// Free way ahead from which it drives at full speed.
    #[modulation(default = 1.5, unit = "m", min = 0.0)]
    far: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    fast: Modulation<f64>,
    /// Turn rate on the spot.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01)]
    turn: Modulation<f64>,
    /// Greatest change of speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Greatest change of turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    body: Option<Body>,
    random: Option<fastrand::Rng>,
    gait: Gait,
    permit: Option<Permit>,
}

/// What the robot does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Gait {
    /// It goes straight.
    #[default]
    Straight,
    /// It turns on the spot.
    Turning(Turn),
}

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    /// 1 to the left, −1 to the right. It is kept, so that a corner cannot trap the robot.
    side: f64,
    /// The angle still to turn, rad; below 0 it ends as soon as the way is free.
    rest: f64,
    /// The heading at the last iteration, rad.
    heading: f64,
}

impl Schema for Wander {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(Body::new(&self.footprint.get(cx), self.mount.get(cx))?);
        self.random
            .get_or_insert_with(|| fastrand::Rng::with_seed(cx.seed()));
        self.gait = Gait::Straight;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.known.get(cx).is_none() && self.observe(cx).is_some()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.permit = self.drive(cx);
        self.base
            .command(cx, self.permit.map_or(Twist::ZERO, |permit| permit.twist()));
        Ok(())
    }
}

/// Refuses a footprint that is no convex area.
impl Inspect for Wander {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(
            &self.footprint,
            Body::new(&self.footprint.get(cx), self.mount.get(cx)),
        );
    }
}

impl Panel for Wander {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match (self.gait, self.permit.and_then(|permit| permit.obstacle())) {
            (_, Some(reason)) => pen.text(reason),
            (Gait::Straight, None) => pen.text("goes straight"),
            (Gait::Turning(turn), None) if turn.side > 0.0 => pen.text("turns to the left"),
            (Gait::Turning(_), None) => pen.text("turns to the right"),
        }
        let free = self
            .body
            .as_ref()
            .map(|body| body.free_ahead(self.margin.get(cx)));
        match free {
            Some(free) if free.is_finite() => pen.value("free ahead", free, "m"),
            Some(_) => pen.text("nothing is ahead"),
            None => {}
        }
    }
}

impl Wander {
    fn observe(&mut self, cx: &Context) -> Option<(Pose2D, Twist)> {
        let (laser, pose) = (self.laser.get(cx), self.pose.get(cx));
        self.body.as_mut()?.observe(laser.as_deref(), pose.as_deref())
    }

    fn drive(&mut self, cx: &Context) -> Option<Permit> {
        let (Pose2D { theta: heading, .. }, velocity) = self.observe(cx)?;
        let (margin, near, far) = (self.margin.get(cx), self.near.get(cx), self.far.get(cx));
        let ahead = self.body.as_ref()?.free_ahead(margin);
        // To go straight again takes more room than to turn, or noise at `near` would make it stutter.
        self.gait = match self.gait {
            Gait::Straight if ahead < near => self.begin_turn(heading),
            Gait::Straight => Gait::Straight,
            Gait::Turning(turn) => turn.on(heading, ahead > f64::midpoint(near, far)),
        };
        let wanted = match self.gait {
            Gait::Straight => {
                let room = (ahead - near) / (far - near).max(f64::EPSILON);
                Twist::planar(self.fast.get(cx) * room.clamp(CREEP, 1.0), 0.0)
            }
            Gait::Turning(turn) => Twist::planar(0.0, turn.side * self.turn.get(cx)),
        };
        let ability = Ability {
            acceleration: self.acceleration.get(cx),
            turn_acceleration: self.turn_acceleration.get(cx),
            margin: margin / 2.0,
            hold: HOLD,
        };
        let permit = self.body.as_ref()?.permit(&velocity, wanted, &ability);
        if self.gait == Gait::Straight && permit.obstacle().is_some() {
            self.gait = self.begin_turn(heading);
        }
        Some(permit)
    }

    fn begin_turn(&mut self, heading: f64) -> Gait {
        let side = self.body.as_ref().map_or(1.0, Body::freer_side);
        let random = self.random.as_mut().map_or(0.0, fastrand::Rng::f64);
        Gait::Turning(Turn {
            side,
            rest: LEAST_TURN + RANDOM_TURN * random,
            heading,
        })
    }
}

impl Turn {
    /// What follows at `heading`.
    fn on(self, heading: f64, free: bool) -> Gait {
        let rest = self.rest - self.side * normalize_angle(heading - self.heading);
        if rest <= 0.0 && free {
            Gait::Straight
        } else {
            Gait::Turning(Self {
                rest,
                heading,
                ..self
            })
        }
    }
}

#[cfg(test)]
mod tests;
