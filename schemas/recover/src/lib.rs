//! Recovery of a robot that is stuck. It plans nothing, and it commands no motion that the guard's knowledge of
//! the surroundings does not permit.

mod attempt;
mod panel;
mod trail;

use jde_motion::{Outline, Surroundings};
use jde_schema::prelude::*;
use jde_schema::types::{Point2D, normalize_angle};

use attempt::{Action, Attempt, Due, Terms};
use trail::Trail;

/// The period, and so the time for which a command must be safe beyond what the guard requires, s.
const PERIOD: f64 = 0.1;
/// Below these speeds the base stands still, m/s and rad/s.
const STANDING_SPEED: (f64, f64) = (0.02, 0.05);
/// The least motion of an action after which the others are worth a trial, m and rad.
const MIN_MOTION: (f64, f64) = (0.1, 0.5);
/// The factors that a refused command is tried with, as the speed along the same arc.
const SPEED_FACTORS: [f64; 2] = [1.0, 0.5];

/// Moves a robot that is stuck: it has a target and moved less than 0.25 m within `patience`.
///
/// It is READY for one action after another; after each the other schemas have `patience` to make progress. It goes
/// back the way it came, turns on the spot to see around, has the map cleared around it, and lets the others wait. An
/// action that is not possible is left out. After the last action it gives up in words, and begins again. It knows
/// from `guard/footprint` what is around the robot, and commands nothing that this guard would refuse.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Recover {
    /// The surroundings of the robot, from `guard/footprint`.
    #[import]
    surroundings: Import<Surroundings>,
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The mission whose target the robot must reach.
    #[import]
    mission: Import<Mission>,
    /// Time without progress after which the robot counts as stuck, and after which the next action begins.
    #[modulation(default = 10.0, unit = "s", min = 1.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// Way back.
    #[modulation(default = 0.3, unit = "m", min = 0.0, was = "back")]
    backup_dist: Modulation<f64>,
    /// Longest way back, as long as the robot has no room.
    #[modulation(default = 2.0, unit = "m", min = 0.0)]
    back_most: Modulation<f64>,
    /// Distance beyond the margin of the guard that is room, whatever the heading.
    #[modulation(default = 0.1, unit = "m", min = 0.0)]
    room: Modulation<f64>,
    /// Speed on the way back.
    #[modulation(default = 0.15, unit = "m/s", min = 0.01, limit, was = "speed")]
    backup_speed: Modulation<f64>,
    /// Least radius of an arc of the base; 0 for a base that can turn on the spot.
    #[modulation(default = 0.0, unit = "m", min = 0.0)]
    radius: Modulation<f64>,
    /// Turn rate on the spot.
    #[modulation(default = 50_f64.to_radians(), unit = "rad/s", min = 0.01, limit, was = "turn")]
    max_rotational_vel: Modulation<f64>,
    /// Angle that it turns.
    #[modulation(default = core::f64::consts::TAU, unit = "rad", min = 0.0, was = "angle")]
    spin_dist: Modulation<f64>,
    /// Time of the last action, for people to pass.
    #[modulation(default = 20.0, unit = "s", min = 0.0, max = 3600.0, was = "wait")]
    wait_duration: Modulation<f64>,
    /// Distance from the place where it was stuck beyond which it is no longer stuck.
    #[modulation(default = 1.0, unit = "m", min = 0.3)]
    away: Modulation<f64>,
    /// FAILED with the target and a note in words, once each time that every action was in vain; else RUNNING, with
    /// the present action.
    #[export(lasting)]
    recovery: Export<Mission>,
    /// Where the map is to be cleared, in the frame of the pose; each value is one request.
    #[export(lasting)]
    clear: Export<Point2D>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    trail: Trail,
    attempt: Option<Attempt>,
    work: Option<Work>,
    words: String,
}

/// The action that is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Work {
    /// The way back from this pose.
    Back { from: Pose2D },
    /// A turn on the spot.
    Turn {
        /// 1 to the left, −1 to the right.
        side: f64,
        /// Whether the other side was tried before.
        switched: bool,
        /// The angle so far, rad.
        turned: f64,
        /// The heading at the last iteration, rad.
        heading: f64,
    },
    /// A request to clear the map.
    Clear,
}

/// What an action wants.
enum Demand {
    /// This command.
    Go(Twist),
    /// Its end; whether it did anything.
    End(bool),
}

impl Schema for Recover {
    fn awake(&mut self, _: &Context) -> Result {
        self.trail.clear();
        self.attempt = None;
        self.work = None;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some((pose, target)) = self.situation(cx) else {
            self.attempt = None;
            self.work = None;
            return Ok(false.into());
        };
        let terms = self.terms(cx);
        if !self
            .attempt
            .as_ref()
            .is_some_and(|attempt| attempt.is_to(&target))
        {
            self.attempt = Some(Attempt::new(target, pose, cx.now(), &terms));
            self.work = None;
        }
        if self.work.is_none() {
            self.trail.extend(&pose);
            self.begin_what_is_due(cx, pose, target, &terms);
        }
        Ok(self.work.is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = match (self.situation(cx), self.work) {
            (Some((pose, _)), Some(work)) => self.work_on(cx, work, pose),
            (None, _) | (_, None) => Twist::ZERO,
        };
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Recover {
    /// The pose and the target; `None` if there is no target, or not all that a recovery needs.
    fn situation(&self, cx: &Context) -> Option<(Pose2D, Pose2D)> {
        let (mission, pose) = (self.mission.get(cx)?, self.pose.get(cx)?.pose2d());
        self.surroundings.get(cx)?;
        let has_target = mission.state == Mission::RUNNING && mission.distance > 0.0;
        (pose.is_finite() && has_target).then_some((pose, mission.target))
    }

    fn terms(&self, cx: &Context) -> Terms {
        Terms {
            patience: Duration::from_secs_f64(self.patience.get(cx)),
            wait: Duration::from_secs_f64(self.wait_duration.get(cx)),
            away: self.away.get(cx),
        }
    }

    fn begin_what_is_due(&mut self, cx: &Context, pose: Pose2D, target: Pose2D, terms: &Terms) {
        let Some(attempt) = &mut self.attempt else { return };
        let was_stuck = attempt.is_stuck();
        match attempt.advance(&pose, cx.now(), terms) {
            Due::Nothing if was_stuck && !attempt.is_stuck() => self.report(cx, Mission::RUNNING, target, ""),
            Due::Nothing => {}
            Due::GiveUp(words) => self.report(cx, Mission::FAILED, target, &words),
            Due::Begin(action) => {
                self.work = match action {
                    Action::Back => Some(Work::Back { from: pose }),
                    Action::Turn => Some(Work::Turn {
                        side: 1.0,
                        switched: false,
                        turned: 0.0,
                        heading: pose.theta,
                    }),
                    Action::Clear => Some(Work::Clear),
                    Action::Wait => None,
                };
                self.report(cx, Mission::RUNNING, target, action.does());
            }
        }
    }

    fn report(&mut self, cx: &Context, state: u8, target: Pose2D, words: &str) {
        self.words = words.to_owned();
        let recovery = Mission {
            state,
            note: Text::truncated(words),
            target,
            ..Mission::default()
        };
        self.recovery.write(cx, recovery);
    }

    /// Returns the command of the action that is under way, or ends it.
    fn work_on(&mut self, cx: &Context, work: Work, pose: Pose2D) -> Twist {
        let (action, step) = match work {
            Work::Back { from } => (Action::Back, self.back(cx, &from, &pose)),
            Work::Turn { .. } => (Action::Turn, self.turn(cx, &pose)),
            Work::Clear => {
                self.clear.write(cx, Point2D { x: pose.x, y: pose.y });
                (Action::Clear, Demand::End(true))
            }
        };
        match step {
            Demand::Go(twist) => twist,
            Demand::End(possible) => {
                let terms = self.terms(cx);
                if let Some(attempt) = &mut self.attempt {
                    attempt.end(action, possible, &pose, cx.now(), &terms);
                }
                self.work = None;
                Twist::ZERO
            }
        }
    }

    fn back(&mut self, cx: &Context, from: &Pose2D, pose: &Pose2D) -> Demand {
        let driven = from.distance_to(pose);
        let (radius, enough) = (self.radius.get(cx), self.backup_dist.get(cx));
        if driven >= self.back_most.get(cx) || (driven >= enough && self.has_room(cx)) {
            return Demand::End(true);
        }
        let along = self.trail.retrace(pose).and_then(|point| curvature(&point));
        let curves = [along, Some(0.0)].into_iter().flatten();
        let most = if radius > 0.0 { 1.0 / radius } else { f64::INFINITY };
        let speed = -self.backup_speed.get(cx);
        for curve in curves.map(|curve| curve.clamp(-most, most)) {
            // Both fall together, so that the arc stays.
            let speed = speed / (speed.abs() * curve.abs() / self.max_rotational_vel.get(cx)).max(1.0);
            for factor in SPEED_FACTORS {
                let twist = Twist::planar(factor * speed, factor * speed * curve);
                if self.permits(cx, &twist) {
                    return Demand::Go(twist);
                }
            }
        }
        self.stand(cx, driven > MIN_MOTION.0)
    }

    fn turn(&mut self, cx: &Context, pose: &Pose2D) -> Demand {
        let Some(Work::Turn {
            side,
            switched,
            turned,
            heading,
        }) = &mut self.work
        else {
            return Demand::End(false);
        };
        *turned += normalize_angle(pose.theta - *heading).abs();
        *heading = pose.theta;
        let (turned, to, can_switch) = (*turned, *side, !*switched);
        if self.radius.get(cx) > 0.0 || turned >= self.spin_dist.get(cx) {
            return Demand::End(turned > MIN_MOTION.1);
        }
        let twist = Twist::planar(0.0, to * self.max_rotational_vel.get(cx));
        if self.permits(cx, &twist) {
            return Demand::Go(twist);
        }
        if can_switch && self.is_still(cx) {
            self.work = Some(Work::Turn {
                side: -to,
                switched: true,
                turned,
                heading: pose.theta,
            });
            return Demand::Go(Twist::ZERO);
        }
        self.stand(cx, turned > MIN_MOTION.1)
    }

    /// Waits until the base stands still, because a command that is refused while it moves may be permitted
    /// then; and then ends the action.
    fn stand(&self, cx: &Context, possible: bool) -> Demand {
        if self.is_still(cx) {
            Demand::End(possible)
        } else {
            Demand::Go(Twist::ZERO)
        }
    }

    fn is_still(&self, cx: &Context) -> bool {
        self.surroundings.get(cx).is_none_or(|around| {
            let Twist { linear, angular } = around.velocity;
            libm::hypot(linear.x, linear.y) < STANDING_SPEED.0 && angular.z.abs() < STANDING_SPEED.1
        })
    }

    fn permits(&self, cx: &Context, twist: &Twist) -> bool {
        self.surroundings.get(cx).is_some_and(|around| {
            let age = around.age(cx) + Duration::from_secs_f64(PERIOD);
            around.judge(age, twist).is_ok()
        })
    }

    /// Whether the robot has room to turn, and to drive ahead in any direction.
    fn has_room(&self, cx: &Context) -> bool {
        self.surroundings.get(cx).is_some_and(|around| {
            let reach = Outline::try_from(&around.footprint).map_or(f64::INFINITY, |outline| outline.reach());
            let least = reach + around.margin + self.room.get(cx);
            around
                .points
                .iter()
                .all(|point| libm::hypot(point.x, point.y) > least)
        })
    }
}

/// Returns the curvature of the arc from the base to a point behind it, 1/m, positive to the left; `None` if the
/// point is more beside the base than behind it.
fn curvature(point: &Pose2D) -> Option<f64> {
    let square = point.x * point.x + point.y * point.y;
    (point.x < 0.0 && point.y.abs() <= -point.x && square > 0.0).then(|| 2.0 * point.y / square)
}

jde_schema::export!(
    "recover",
    "Moves a robot out of a place in which it is stuck.",
    [Recover]
);

#[cfg(test)]
mod tests;
