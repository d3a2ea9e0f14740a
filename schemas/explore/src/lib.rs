//! Exploration by frontiers (Yamauchi, "A frontier-based approach for autonomous exploration", 1997). It chooses where to
//! drive, and leaves planning and driving to others.

mod memory;
mod panel;
mod survey;

use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

use survey::{Survey, Surveyed};

/// How near to a target its frontier must be to be still there, m.
const NEAR: f64 = 0.5;

/// Chooses one frontier of a map after another as the target of a father, until none is left: then the mission is done.
///
/// A frontier is where free cells border on unknown ones. The next one is that with the least way less `gain` times its length.
/// It stays the target until it is seen, even if another one becomes better. One that the father gives up, or that is still
/// open `look` after the robot has reached it, is given up, with all of it within `apart` of the target. One to which no way leads
/// remains until the end, and may be reached later. The words of the mission say what was left out. If a frontier opens
/// afterwards, the exploration goes on.
#[derive(Describe)]
#[schema(perceptive, period = "200ms", budget = "100ms")]
pub struct Explore {
    /// The map.
    #[import]
    map: Import<OccupancyGrid>,
    /// The estimated pose of the robot, in the frame of the map. One that is not finite counts as none.
    #[import]
    pose: Import<Odometry>,
    /// What has become of the target: the mission of the father that drives to it.
    #[import]
    drive: Import<Mission>,
    /// Radius of a circle that the robot needs. Nearer to an obstacle there is no way.
    #[modulation(default = 0.2, unit = "m", min = 0.0, max = 5.0)]
    inscribed: Modulation<f64>,
    /// Least length of a frontier. A shorter one is not seen into.
    #[modulation(default = 0.5, unit = "m", min = 0.05, max = 10.0)]
    least: Modulation<f64>,
    /// How much farther the way to a frontier may be for each metre of its length. 0 chooses the nearest one.
    #[modulation(default = 0.5, min = 0.0, max = 100.0)]
    gain: Modulation<f64>,
    /// Time to see into a frontier that has been reached.
    #[modulation(default = 2.0, unit = "s", min = 0.0, max = 60.0)]
    look: Modulation<f64>,
    /// How far around a target a frontier is given up.
    #[modulation(default = 1.0, unit = "m", min = 0.1, max = 10.0)]
    apart: Modulation<f64>,
    /// How many cells of a map an iteration propagates the ways over. A larger map takes several iterations.
    #[modulation(default = 250_000, min = 1000)]
    cells: Modulation<u32>,
    /// Where to drive; none while no frontier is chosen.
    #[export]
    target: Export<Target>,
    /// DONE when no frontier is left, with a note that says what was left out. `reached` counts the frontiers that were seen.
    #[export]
    mission: Export<Mission>,
    /// What it does, or why it does nothing.
    #[export]
    state: Export<Text<160>>,
    /// The area that is known to be free.
    #[export(unit = "m2")]
    area: Export<f64>,
    survey: Option<Survey>,
    surveyed: Surveyed,
    aim: Option<Aim>,
    given_up: Vec<GivenUp>,
    /// Since when there has been no frontier to drive to.
    closed_since: Option<Duration>,
    /// Whether the closed map was reported.
    is_closed: bool,
    /// Frontiers that were seen.
    seen: u32,
    words: String,
}

/// The frontier that is driven to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Aim {
    target: Pose2D,
    /// The cell of the frontier that is nearest to the target.
    at: (f64, f64),
    /// When the father reached the target.
    reached_at: Option<Duration>,
}

/// A place whose frontier was given up.
#[derive(Clone, Debug, PartialEq)]
struct GivenUp {
    place: (f64, f64),
    reason: String,
}

impl Schema for Explore {
    fn awake(&mut self, _: &Context) -> Result {
        self.survey = None;
        self.closed_since = None;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.take_outcome(cx);
        match self.look_around(cx) {
            Ok(()) => self.words = self.situation(),
            Err(words) => self.words = words,
        }
        let pose = self.robot(cx);
        let target = self.aim.map_or(Target::NONE, |aim| Target::at(aim.target));
        let distance = target.get().zip(pose);
        self.target.write(cx, target);
        self.mission.write(
            cx,
            Mission {
                state: if self.is_closed {
                    Mission::DONE
                } else {
                    Mission::RUNNING
                },
                reached: self.seen,
                note: Text::truncated(&self.words),
                target: target.pose,
                distance: distance.map_or(0.0, |(target, pose)| pose.distance_to(&target)),
                ..Mission::default()
            },
        );
        self.state.write(cx, Text::truncated(&self.words));
        Ok(())
    }
}

impl Explore {
    /// Takes from the father what has become of the target.
    fn take_outcome(&mut self, cx: &Context) {
        let (Some(aim), Some(drive)) = (&mut self.aim, self.drive.get(cx)) else {
            return;
        };
        if drive.target == aim.target && drive.state == Mission::DONE {
            aim.reached_at.get_or_insert(cx.now());
        } else if drive.target == aim.target && drive.state == Mission::FAILED {
            self.give_up(cx, drive.note.as_str());
        }
    }

    /// Goes on with the survey, and decides when it ends; the error is why there is none.
    fn look_around(&mut self, cx: &Context) -> Result<(), String> {
        let map = self.map.get(cx).ok_or("there is no map")?;
        let robot = self.robot(cx).ok_or("the place of the robot is not known")?;
        let survey = match &mut self.survey {
            Some(survey) => survey,
            None => {
                let survey = Survey::new(map.value(), (robot.x, robot.y), self.inscribed.get(cx));
                self.survey.insert(survey.map_err(|error| error.to_string())?)
            }
        };
        if survey.advance(self.cells.get(cx).into())
            && let Some(survey) = self.survey.take()
        {
            let apart = self.apart.get(cx);
            let is_left_out = |cell: (f64, f64)| self.given_up.iter().any(|past| past.is_near(cell, apart));
            self.surveyed = survey.end(self.least.get(cx), is_left_out);
            self.area.write(cx, self.surveyed.area);
            self.decide(cx);
        }
        Ok(())
    }

    /// Keeps the target or chooses another one, by the newest survey.
    fn decide(&mut self, cx: &Context) {
        if let Some(aim) = self.aim {
            let mut frontiers = self.surveyed.frontiers.iter();
            match frontiers.find(|frontier| frontier.is_near(aim.at, NEAR)) {
                Some(frontier) => {
                    let seen_at = Duration::from(self.surveyed.stamp);
                    if aim.reached_at.is_some_and(|at| seen_at >= at + self.look(cx)) {
                        self.give_up(cx, "it stays open");
                        return;
                    }
                    if frontier.place.is_some() {
                        return;
                    }
                }
                None => self.seen += 1,
            }
        }
        let gain = self.gain.get(cx);
        let reached = self.surveyed.frontiers.iter().filter_map(|frontier| {
            let (target, way) = frontier.place?;
            Some((way - gain * frontier.size, target, frontier))
        });
        let best = reached.min_by(|a, b| a.0.total_cmp(&b.0));
        self.aim = best.map(|(_, target, frontier)| Aim {
            target,
            at: frontier.nearest((target.x, target.y)),
            reached_at: None,
        });
        self.close(cx);
    }

    /// Reports that the map is closed, once there has been no frontier to drive to for `look`.
    fn close(&mut self, cx: &Context) {
        if self.aim.is_some() {
            (self.closed_since, self.is_closed) = (None, false);
            return;
        }
        let since = *self.closed_since.get_or_insert(cx.now());
        if !self.is_closed && cx.now() >= since + self.look(cx) {
            self.is_closed = true;
            info!(cx, "{}", self.situation());
            for (x, y, reason) in self.left_out() {
                warn!(cx, "left out the frontier at {x:.2}, {y:.2}: {reason}");
            }
        }
    }

    fn give_up(&mut self, cx: &Context, reason: &str) {
        let Some(Aim { target, at, .. }) = self.aim.take() else {
            return;
        };
        let Pose2D { x, y, .. } = target;
        warn!(cx, "gives up the frontier at {x:.2}, {y:.2}: {reason}");
        self.given_up.push(GivenUp {
            place: at,
            reason: reason.to_owned(),
        });
    }

    /// The frontiers that were given up, and those to which no way leads.
    fn left_out(&self) -> Vec<(f64, f64, &str)> {
        let closed = self
            .surveyed
            .frontiers
            .iter()
            .filter(|frontier| frontier.place.is_none());
        let closed = closed.map(|frontier| {
            let (x, y) = frontier.cells[frontier.cells.len() / 2];
            (x, y, "no way leads there")
        });
        let given_up = self.given_up.iter();
        given_up
            .map(|past| (past.place.0, past.place.1, past.reason.as_str()))
            .chain(closed)
            .collect()
    }

    /// What it does, in words.
    fn situation(&self) -> String {
        let out = match self.left_out().len() {
            0 => String::new(),
            1 => ", 1 place is left out".to_owned(),
            several => format!(", {several} places are left out"),
        };
        match (self.aim, self.is_closed) {
            (Some(Aim { target, .. }), _) => {
                let open = self
                    .surveyed
                    .frontiers
                    .iter()
                    .filter(|frontier| frontier.place.is_some());
                format!("to {:.2}, {:.2}; {} open{out}", target.x, target.y, open.count())
            }
            (None, true) => format!("the map is closed{out}"),
            (None, false) => "no frontier is known".to_owned(),
        }
    }

    /// Where the robot is; `None` also for numbers that are not finite.
    fn robot(&self, cx: &Context) -> Option<Pose2D> {
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        pose.filter(|pose| pose.x.is_finite() && pose.y.is_finite() && pose.theta.is_finite())
    }

    fn look(&self, cx: &Context) -> Duration {
        Duration::from_secs_f64(self.look.get(cx))
    }
}

impl GivenUp {
    fn is_near(&self, (x, y): (f64, f64), distance: f64) -> bool {
        (x - self.place.0).hypot(y - self.place.1) <= distance
    }
}

jde_schema::export!(
    "explore",
    "Chooses frontiers of a map as targets until the map is closed.",
    [Explore]
);

#[cfg(test)]
mod tests;
