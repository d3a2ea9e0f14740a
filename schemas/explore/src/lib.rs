//! Exploration by frontiers (Yamauchi, "A frontier-based approach for autonomous exploration", 1997). It chooses where to
//! drive, and leaves planning and driving to others.

mod memory;
mod panel;
mod survey;

use jde_grid::PlanError;
use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

use survey::{Survey, Surveyed};

/// How near to a target its frontier must be to be still there, m.
const SAME_FRONTIER_DISTANCE: f64 = 0.5;

/// Chooses one frontier of a map after another as the target of a father, until none is left: then the mission is
/// done.
///
/// A frontier is where free cells border on unknown ones. The next one is that with the least way less `gain_scale`
/// times its length. It stays the target until it is seen, even if another frontier becomes better. A frontier is
/// given up if the father gives up its target, or if it is still open `look` after the robot has reached it; then all
/// of it within `apart` of the target is left out until it is seen. A frontier to which no way leads remains until
/// the end, and may be reached later. The note of the mission names the places that were left out. If a frontier
/// opens afterwards, the exploration continues.
#[derive(Describe)]
#[schema(perceptive, period = "200ms", budget = "100ms")]
pub struct Explore {
    /// The map.
    #[import]
    map: Import<OccupancyGrid>,
    /// The estimated pose of the robot, in the frame of the map. One that is not finite counts as none.
    #[import]
    pose: Import<Odometry>,
    /// The outcome of the target: the mission of the father that drives to it.
    #[import]
    drive: Import<Mission>,
    /// Radius of a circle that the robot needs. Nearer to an obstacle there is no way.
    #[modulation(default = 0.2, unit = "m", min = 0.0, max = 5.0, was = "inscribed")]
    inscribed_radius: Modulation<f64>,
    /// Least length of a frontier. Shorter ones are ignored.
    #[modulation(default = 0.5, unit = "m", min = 0.05, max = 10.0, was = "least")]
    min_frontier_size: Modulation<f64>,
    /// How much farther the way to a frontier may be for each metre of its length. 0 chooses the nearest one.
    #[modulation(default = 0.5, min = 0.0, max = 100.0, was = "gain")]
    gain_scale: Modulation<f64>,
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
    /// DONE when no frontier is left, with a note about the places that were left out. `reached` counts the frontiers
    /// that were seen.
    #[export(lasting)]
    mission: Export<Mission>,
    /// The present activity, or the reason why there is none.
    #[export]
    state: Export<Text<160>>,
    /// The area that is known to be free.
    #[export(unit = "m2", lasting)]
    area: Export<f64>,
    /// How many places are left out: given up, or without a way to them.
    #[export(lasting)]
    left_out: Export<u32>,
    survey: Option<(Basis, Survey)>,
    /// The last survey that ended, and what it found.
    last: Option<(Basis, Survey)>,
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

/// What a survey depends on, beside the place of the robot: the number of the map, and the modulations.
type Basis = (u64, [f64; 3]);

/// The frontier that is driven to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Aim {
    /// The centre of one of its cells.
    target: Pose2D,
    /// When it was chosen. An older mission of the father is of an earlier drive.
    chosen_at: Duration,
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
        (self.survey, self.last) = (None, None);
        (self.aim, self.closed_since) = (None, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.target.retract(cx);
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
        self.left_out.write(cx, self.places_left_out().len() as u32);
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
        let is_of_aim = drive.target == aim.target && drive.time() > aim.chosen_at;
        if is_of_aim && drive.state == Mission::DONE {
            aim.reached_at.get_or_insert(cx.now());
        } else if is_of_aim && drive.state == Mission::FAILED {
            self.give_up(cx, drive.note.as_str());
        }
    }

    /// Goes on with the survey, and decides when it ends; the error is why there is none. Where the robot cannot be, it keeps its
    /// target, so that a recovery drives it out; without a map or a place it has none.
    fn look_around(&mut self, cx: &Context) -> Result<(), String> {
        let cells = self.cells.get(cx).into();
        if self.survey.is_none() && self.is_surveyed(cx) {
            self.surveyed.begun = cx.now();
            self.end_survey(cx);
            return Ok(());
        }
        let survey = match self.survey(cx) {
            Ok(survey) => survey,
            Err(error) => {
                (self.survey, self.last) = (None, None);
                self.aim.take_if(|_| !error.is::<PlanError>());
                return Err(error.to_string());
            }
        };
        if survey.1.advance(cells) {
            self.last = self.survey.take();
            if let Some((_, survey)) = &self.last {
                let apart = self.apart.get(cx);
                self.surveyed = survey.end(self.min_frontier_size.get(cx), apart, &mut self.given_up);
            }
            self.end_survey(cx);
        }
        Ok(())
    }

    /// Exports the area, and decides.
    fn end_survey(&mut self, cx: &Context) {
        self.area.write(cx, self.surveyed.area);
        self.decide(cx);
    }

    /// Whether a survey would find the same frontiers as the last one. While there is a target, the ways to them do not matter.
    fn is_surveyed(&self, cx: &Context) -> bool {
        let last = self.last.as_ref().zip(self.map.get(cx)).zip(self.robot(cx));
        self.aim.is_some()
            && last.is_some_and(|(((basis, survey), map), robot)| {
                *basis == self.basis(cx, map.sequence()) && survey.reaches((robot.x, robot.y))
            })
    }

    /// What a survey of the map of this number depends on.
    fn basis(&self, cx: &Context, map: u64) -> Basis {
        let modulations = [&self.inscribed_radius, &self.min_frontier_size, &self.apart];
        (map, modulations.map(|modulation| modulation.get(cx)))
    }

    /// The survey under way, or a new one.
    fn survey(&mut self, cx: &Context) -> Result<&mut (Basis, Survey)> {
        let map = self.map.get(cx).ok_or("there is no map")?;
        let robot = self.robot(cx).ok_or("the place of the robot is not known")?;
        let survey = match self.survey.take() {
            Some(survey) => survey,
            None => (
                self.basis(cx, map.sequence()),
                Survey::new(&map, (robot.x, robot.y), self.inscribed_radius.get(cx), cx.now())?,
            ),
        };
        Ok(self.survey.insert(survey))
    }

    /// Keeps the target or chooses another one, by the newest survey.
    fn decide(&mut self, cx: &Context) {
        if let Some(aim) = self.aim {
            let frontiers = self.surveyed.frontiers.iter();
            let near = frontiers
                .filter(|frontier| frontier.is_near((aim.target.x, aim.target.y), SAME_FRONTIER_DISTANCE));
            // Behind a wall there may be another one.
            match near.max_by_key(|frontier| frontier.place.is_some()) {
                Some(frontier) => {
                    let begun = self.surveyed.begun;
                    if aim.reached_at.is_some_and(|at| begun >= at + self.look(cx)) {
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
        let gain = self.gain_scale.get(cx);
        let reached = self.surveyed.frontiers.iter().filter_map(|frontier| {
            let (target, way) = frontier.place?;
            Some((way - gain * frontier.size, target))
        });
        let best = reached.min_by(|a, b| a.0.total_cmp(&b.0));
        self.aim = best.map(|(_, target)| Aim {
            target,
            chosen_at: cx.now(),
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
            for (x, y, reason) in self.places_left_out() {
                warn!(cx, "left out the frontier at {x:.2}, {y:.2}: {reason}");
            }
        }
    }

    fn give_up(&mut self, cx: &Context, reason: &str) {
        let Some(Aim { target, .. }) = self.aim.take() else {
            return;
        };
        let Pose2D { x, y, .. } = target;
        warn!(cx, "gives up the frontier at {x:.2}, {y:.2}: {reason}");
        self.given_up.push(GivenUp {
            place: (x, y),
            reason: reason.to_owned(),
        });
    }

    /// The frontiers that were given up, and those to which no way leads.
    fn places_left_out(&self) -> Vec<(f64, f64, &str)> {
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
        let out = match self.places_left_out().len() {
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
        pose.filter(Pose2D::is_finite)
    }

    fn look(&self, cx: &Context) -> Duration {
        Duration::from_secs_f64(self.look.get(cx))
    }
}

impl GivenUp {
    fn is_near(&self, (x, y): (f64, f64), distance: f64) -> bool {
        libm::hypot(x - self.place.0, y - self.place.1) <= distance
    }
}

jde_schema::export!(
    "explore",
    "Chooses frontiers of a map as targets until the map is closed.",
    [Explore]
);

#[cfg(test)]
mod tests;
