//! Wandering: it goes straight until something is near, and then turns to the freer side. It reaches no
//! place in particular and covers no area for certain.

use jde_schema::prelude::*;
use jde_schema::types::normalize_angle;

use crate::body::{Body, HOLD, Permit};
use crate::ports::{Perception, RobotBase};

/// The least turn before an obstacle, rad. It leaves the direction that was blocked.
const LEAST_TURN: f64 = 30_f64.to_radians();
/// The greatest random part on top of it, rad, so that the robot does not go to and fro between two walls.
const RANDOM_TURN: f64 = 90_f64.to_radians();
/// Share of `vx_max` at the distance from which it turns, so that it does not brake at once there.
const MIN_SPEED_SHARE: f64 = 0.25;

/// Drives straight until something is near, and turns toward the freer side by an angle with a random part.
///
/// It is ready while it has a pose, a scan that measures something, and no value of `known` for `patience`; with the imports
/// `mission` and `state`, only while the mission runs and `state` has a value. The random part comes from the application's
/// seed. A robot without a free way turns on.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Wander {
    #[ports]
    perception: Perception,
    /// The place on a map. While it is known there is nothing to look for.
    #[import(optional)]
    known: Import<Odometry>,
    /// The state of the localizer. If it is bound, the robot stands while the localizer is stopped or faulted.
    #[import(optional)]
    state: Import<Text<160>>,
    /// The mission that needs the place. If it is bound, the robot stands when the mission is done.
    #[import(optional)]
    mission: Import<Mission>,
    /// Time without `known` after which it drives.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    #[ports]
    robot: RobotBase,
    /// Distance to keep from obstacles, also beside the robot.
    #[modulation(default = 0.1, unit = "m", min = 0.0, margin)]
    margin: Modulation<f64>,
    /// Free way ahead of the body below which it turns.
    #[modulation(default = 0.5, unit = "m", min = 0.0)]
    near: Modulation<f64>,
    /// Free way ahead from which it drives at full speed.
    #[modulation(default = 1.5, unit = "m", min = 0.0)]
    far: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0, limit, was = "fast")]
    vx_max: Modulation<f64>,
    /// Turn rate on the spot.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01, limit, was = "turn")]
    wz_max: Modulation<f64>,
    body: Option<Body>,
    random: Option<fastrand::Rng>,
    gait: Gait,
    permit: Option<Permit>,
    /// Since when the place has not been known.
    unknown_since: Option<Duration>,
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
        self.body = Some(self.robot.body(cx)?);
        self.random
            .get_or_insert_with(|| fastrand::Rng::with_seed(cx.seed()));
        (self.gait, self.unknown_since) = (Gait::Straight, None);
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.is_needed(cx) && self.observe(cx).is_some()).into())
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
impl Inspect for Wander {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
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
    /// Whether there is something to look for.
    fn is_needed(&mut self, cx: &Context) -> bool {
        if self.known.get(cx).is_some() {
            self.unknown_since = None;
            return false;
        }
        let since = *self.unknown_since.get_or_insert(cx.now());
        let is_localized = !self.state.is_bound(cx) || self.state.get(cx).is_some();
        let mission = self.mission.get(cx);
        let is_wanted =
            !self.mission.is_bound(cx) || mission.is_some_and(|mission| mission.state == Mission::RUNNING);
        let patience = Duration::from_secs_f64(self.patience.get(cx));
        is_localized && is_wanted && cx.now().saturating_sub(since) >= patience
    }

    fn observe(&mut self, cx: &Context) -> Option<(Pose2D, Twist)> {
        let (laser, pose) = (self.perception.laser.get(cx), self.perception.pose.get(cx));
        self.body
            .as_mut()?
            .observe(cx, laser.as_ref(), pose.as_ref(), self.robot.motors(cx))
    }

    fn drive(&mut self, cx: &Context) -> Option<Permit> {
        let (Pose2D { theta: heading, .. }, _) = self.observe(cx)?;
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
                Twist::planar(self.vx_max.get(cx) * room.clamp(MIN_SPEED_SHARE, 1.0), 0.0)
            }
            Gait::Turning(turn) => Twist::planar(0.0, turn.side * self.wz_max.get(cx)),
        };
        let ability = self.robot.ability(cx, margin / 2.0, HOLD);
        let permit = self.body.as_ref()?.permit(wanted, &ability);
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
