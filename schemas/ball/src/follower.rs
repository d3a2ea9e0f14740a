//! The father: it wakes the children of its two groups, arbitrates between them, and exports the progress of
//! its mission. It commands no actuator itself.

use jde_schema::prelude::*;

use crate::ball::{self, Ball};

/// Leads base and head to a ball.
///
/// In the group of the base, a child that turns on the spot precedes `brake`, because it cannot collide and
/// may turn away from an obstacle. `brake`, `avoid`, `approach` and `roam` follow in this order. The mission
/// is done when the robot has been at the ball for a while.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Follower {
    /// Where the ball is, in the frame of the base.
    #[import]
    ball: Import<Ball>,
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// Distance along the floor up to which the robot is at the ball. Greater than the distances at which
    /// `approach` ends and starts again.
    #[modulation(default = 1.0, unit = "m", min = 0.0)]
    near: Modulation<f64>,
    /// Distance along the floor up to which `avoid` has no target, because the obstacle would be the ball.
    #[modulation(default = 1.3, unit = "m", min = 0.0)]
    direct: Modulation<f64>,
    /// Heading error from which `avoid` turns on the spot and may win against `brake`.
    #[modulation(default = 40_f64.to_radians(), unit = "rad", min = 0.0, max = 7.0)]
    turning: Modulation<f64>,
    /// How long it stays at the ball before the mission is done.
    #[modulation(default = 3.0, unit = "s", min = 0.0)]
    stay: Modulation<f64>,
    /// Time without the ball, without pictures, or braking before an obstacle, after which the mission fails;
    /// 0 for no limit.
    #[modulation(default = 120.0, unit = "s", min = 0.0)]
    give_up: Modulation<f64>,
    /// Progress of the mission: whether the robot has stayed at the ball.
    #[export(lasting)]
    mission: Export<Mission>,
    /// Brakes before an obstacle that is very close.
    #[child(group = "base")]
    brake: Child,
    /// Drives around a close obstacle.
    #[child(group = "base")]
    avoid: Child,
    /// Turns the base on the spot.
    #[child(group = "base")]
    turn: Child,
    /// Drives to the ball.
    #[child(group = "base")]
    approach: Child,
    /// Drives on to find a place from which the ball is visible.
    #[child(group = "base")]
    roam: Child,
    /// Keeps the camera on the ball.
    #[child(group = "head")]
    track: Child,
    /// Searches for the ball.
    #[child(group = "head")]
    search: Child,
    /// Target of `avoid`: the ball, while it is far.
    #[modulates(child = "avoid", name = "target")]
    avoid_target: Modulates<Target>,
    progress: Progress,
    /// Time at which `brake` became WINNER, while it is.
    braking_since: Option<Duration>,
    /// Time of the first iteration without a usable ball, while there is none.
    no_ball_since: Option<Duration>,
    /// Last known position of the ball, in the frame of the odometry.
    target: Pose2D,
}

/// Progress of the mission.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Progress {
    #[default]
    Searching,
    Approaching,
    /// At the ball, since this time.
    Arrived(Duration),
    Done,
    /// The ball was lost for too long.
    BallLost,
    /// There were no pictures for too long.
    NoImages,
    /// An obstacle blocked the path for too long.
    Blocked,
}

impl Schema for Follower {
    fn awake(&mut self, _: &Context) -> Result {
        // Time asleep does not count as time without pictures.
        self.no_ball_since = None;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let base = [&self.brake, &self.avoid, &self.turn, &self.approach, &self.roam];
        for child in base.into_iter().chain([&self.track, &self.search]) {
            child.wake(cx);
        }
        let brakes = self.brake.state(cx) == State::Winner;
        self.braking_since = brakes.then(|| self.braking_since.unwrap_or(cx.now()));
        let ball = ball::read(&self.ball, cx);
        self.no_ball_since = match ball {
            Some(_) => None,
            None => Some(self.no_ball_since.unwrap_or(cx.now())),
        };
        let known = ball.filter(Ball::is_known);
        let next = self.next(cx, ball);
        if core::mem::discriminant(&next) != core::mem::discriminant(&self.progress) {
            self.export_mission(cx, next, known);
        }
        self.progress = next;
        if let (Some(ball), Some(pose)) = (known, self.pose.get(cx)) {
            self.target = pose.pose2d().transform(&ball.place());
        }
        let far = known.filter(|ball| ball.ahead() > self.direct.get(cx));
        let avoid_target = far.map_or(Target::NONE, |_| Target::at(self.target));
        self.avoid_target.set(cx, avoid_target);
        self.mission.write(
            cx,
            Mission {
                state: match next {
                    Progress::Searching | Progress::Approaching | Progress::Arrived(_) => Mission::RUNNING,
                    Progress::Done => Mission::DONE,
                    Progress::BallLost | Progress::NoImages | Progress::Blocked => Mission::FAILED,
                },
                reached: (next == Progress::Done).into(),
                total: 1,
                note: Text::new(match next {
                    Progress::Searching => "looking for the ball",
                    Progress::Approaching => "going to the ball",
                    Progress::Arrived(_) => "at the ball",
                    Progress::Done => "stayed at the ball",
                    Progress::BallLost => "the ball was not to be found",
                    Progress::NoImages => "there were no pictures",
                    Progress::Blocked => "something stayed in the way to the ball",
                }),
                target: self.target,
                distance: known.map_or(0.0, |ball| ball.ahead()),
                ..Mission::default()
            },
        );
        Ok(())
    }
}

impl Follower {
    fn next(&self, cx: &Context, ball: Option<Ball>) -> Progress {
        let since = match self.progress {
            // Final states do not change.
            Progress::Done | Progress::BallLost | Progress::NoImages | Progress::Blocked => {
                return self.progress;
            }
            Progress::Arrived(since) => since,
            Progress::Searching | Progress::Approaching => cx.now(),
        };
        let seconds = |since: Duration| cx.now().saturating_sub(since).as_secs_f64();
        let give_up = self.give_up.get(cx);
        let too_long = |time: f64| give_up > 0.0 && time > give_up;
        let Some(ball) = ball else {
            return if self.no_ball_since.is_some_and(|since| too_long(seconds(since))) {
                Progress::NoImages
            } else {
                Progress::Searching
            };
        };
        if !ball.is_known() {
            if too_long(ball.unseen) {
                Progress::BallLost
            } else {
                Progress::Searching
            }
        } else if ball.ahead() <= self.near.get(cx) {
            if seconds(since) >= self.stay.get(cx) {
                Progress::Done
            } else {
                Progress::Arrived(since)
            }
        } else if self.braking_since.is_some_and(|since| too_long(seconds(since))) {
            Progress::Blocked
        } else {
            Progress::Approaching
        }
    }

    /// Logs the change of progress.
    fn export_mission(&self, cx: &Context, next: Progress, known: Option<Ball>) {
        let (ahead, bearing) = known.map_or((0.0, 0.0), |ball| (ball.ahead(), ball.bearing.to_degrees()));
        let side = if bearing < 0.0 { "right" } else { "left" };
        match next {
            Progress::Searching => info!(cx, "lost the ball"),
            Progress::Approaching => info!(
                cx,
                "sees the ball {ahead:.2} m away, {:.0} deg to the {side}",
                bearing.abs()
            ),
            Progress::Arrived(_) => info!(cx, "at the ball, {ahead:.2} m away"),
            Progress::Done => info!(cx, "stayed at the ball for {} s", self.stay.get(cx)),
            Progress::BallLost => info!(cx, "did not find the ball for {} s", self.give_up.get(cx)),
            Progress::NoImages => info!(cx, "had no pictures for {} s", self.give_up.get(cx)),
            Progress::Blocked => info!(cx, "was blocked by an obstacle for {} s", self.give_up.get(cx)),
        }
    }
}

impl Arbitrate for Follower {
    fn arbitrate(&mut self, cx: &Context, level: &Level) -> Result<Verdict> {
        let turning_reason = "it turns on the spot, which is safe under the brake's nose";
        let avoid = level.candidate(&self.avoid).filter(|avoid| avoid.ready);
        let turns = avoid.is_some_and(|avoid| avoid.urgency >= self.turning.get(cx));
        // Close to an obstacle, `turn` would turn back to it.
        let order = [
            (turns, &self.avoid, turning_reason),
            (avoid.is_none(), &self.turn, turning_reason),
            (true, &self.brake, "something is too near to drive on"),
            (true, &self.avoid, "something is in the way to the ball"),
            (true, &self.approach, "the way to the ball is free"),
            (true, &self.roam, "the ball is not to be seen from here"),
            (true, &self.track, "the ball is here"),
            (true, &self.search, "the ball is lost"),
        ];
        let chosen = order
            .into_iter()
            .find(|(allowed, child, _)| *allowed && level.is_ready(child));
        Ok(chosen.map_or_else(
            || Verdict::nobody("no child is ready"),
            |(_, child, reason)| Verdict::choose(child, reason),
        ))
    }
}
