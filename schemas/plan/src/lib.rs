//! Plans a path over a map to a target. It commands nothing, and it knows only the obstacles of the map, those that are
//! seen, and what an operator draws on the map.

mod beyond;
mod drawn;
mod ends;
mod followed;
mod memory;
mod panel;
mod points;
mod situation;
mod verdict;

use jde_grid::{
    Angles, Cell, Costmap, Drawing, Field, Inflation, Lanes as DrawnLanes, PlanError, Prices, Route as Way,
    SeenObstacles, Unknown,
};
use jde_schema::prelude::*;
use jde_schema::types::{Lanes, Quaternion, Zones};

use beyond::Exit;
use drawn::{Drawn, InForce};
use ends::Ends;
use followed::{Change, Followed};
use points::{apart, length, points};
use situation::Situation;
use verdict::Verdict;

/// The largest step of the pose from one iteration to the next, m, beside what the robot drives: a localizer corrects less.
const LARGEST_STEP: f64 = 1.0;

/// How long a map must have no place for the target before that is certain: a pose or a map may be wrong for an instant.
const CERTAIN_AFTER: Duration = Duration::from_secs(2);

/// A field to a goal, with the prices that it was made from.
type PricedField = Option<(Prices, Field)>;

/// How it plans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
enum Planner {
    /// Down a field of prices to the target, which it repairs when the map changes (Konolige 2000). Smooth,
    /// and the quickest while the target stays.
    Gradient,
    /// A*, along eight directions.
    Grid,
    /// Theta*, in straight lines at any angle.
    AnyAngle,
}

/// Exports the path from the robot to the target, or says why there is none.
///
/// The map, the pose and the target are in one frame. If unknown cells are open, the path to a target off the map leads to
/// the edge of the map, which may grow. A robot that is too close to an obstacle, although its centre
/// is in none, is led out of there first, and so is one in a keep-out zone. A path is never older than the last
/// iteration: without a way it is retracted.
#[derive(Describe)]
// A map of a thousand by a thousand cells takes up to 0.3 s with A*, most others a tenth of it.
#[schema(perceptive, period = "500ms", budget = "400ms")]
pub struct Plan {
    /// The map.
    #[import]
    map: Import<OccupancyGrid>,
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The obstacles that sensors see around the robot, in the frame of the map.
    #[import(optional)]
    seen: Import<OccupancyGrid>,
    /// The target. If it has a heading, the path ends with it.
    #[modulation(default = Target::NONE)]
    target: Modulation<Target>,
    /// The planner: `gradient`, `grid` (A*) or `any-angle` (Theta*).
    #[modulation(default = Planner::Gradient)]
    planner: Modulation<Planner>,
    /// Radius of the largest circle within the footprint. Closer to an obstacle there is no way.
    #[modulation(default = 0.2, unit = "m", min = 0.0, max = 5.0, was = "inscribed")]
    inscribed_radius: Modulation<f64>,
    /// Radius of the smallest circle around the footprint; at least `inscribed_radius`.
    #[modulation(default = 0.27, unit = "m", min = 0.0, max = 5.0, was = "circumscribed")]
    circumscribed_radius: Modulation<f64>,
    /// Distance beyond which an obstacle costs nothing.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 10.0, was = "reach")]
    inflation_radius: Modulation<f64>,
    /// Rate at which costs decay with the distance to an obstacle.
    #[modulation(default = 3.0, unit = "1/m", min = 0.0, max = 100.0, was = "decay")]
    cost_scaling_factor: Modulation<f64>,
    /// How many times its length a way along an obstacle costs more. 0 is the shortest way.
    #[modulation(default = 4.0, min = 0.0, max = 20.0, was = "clearance")]
    cost_travel_multiplier: Modulation<f64>,
    /// How far from a target that cannot be reached the path may end.
    #[modulation(default = 0.0, unit = "m", min = 0.0, max = 5.0)]
    tolerance: Modulation<f64>,
    /// How long an obstacle of `seen` is remembered after it was seen last.
    #[modulation(default = 300.0, unit = "s", min = 0.0, max = 86400.0)]
    observation_persistence: Modulation<f64>,
    /// How long there may be no way to a target before `planning` fails. It fails after 2 s if the target is off the map or
    /// in one of its obstacles, unless unknown cells are open: then the map may grow. It also fails after 2 s if the target is
    /// farther than a map can reach.
    #[modulation(default = 28.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// Whether the way may lead through unknown cells.
    #[modulation(default = false, was = "unknown")]
    allow_unknown: Modulation<bool>,
    /// Keep-out zones, in the frame of the map: the path leads `inscribed_radius` around them. An operator draws more of
    /// them on the panel.
    #[modulation(default = Zones::EMPTY)]
    keep_out: Modulation<Zones>,
    /// Preferred lanes, in the frame of the map. An operator draws more of them on the panel.
    #[modulation(default = Lanes::EMPTY)]
    lanes: Modulation<Lanes>,
    /// How many times its length a way off the lanes costs more, if there are lanes.
    #[modulation(default = 2.0, min = 0.0, max = 20.0)]
    off_lanes: Modulation<f64>,
    /// The path, from the robot to the target.
    #[export]
    path: Export<Path>,
    /// The outcome of the last iteration, in words.
    #[export]
    state: Export<Text<160>>,
    /// Whether the target can be reached: it fails with the reason where no way leads there, and once more after each
    /// further `patience`.
    #[export(lasting)]
    planning: Export<Mission>,
    /// The keep-out zones that count: those of the application, and the drawn ones.
    #[export]
    zones_in_force: Export<Zones>,
    /// The lanes that count: those of the application, and the drawn ones.
    #[export]
    lanes_in_force: Export<Lanes>,
    followed: Option<Followed>,
    remembered: Option<SeenObstacles>,
    /// The number of the last value of `seen`, and when it came.
    view: Option<(u64, Duration)>,
    /// The last pose, and when it was read.
    stood: Option<(Pose2D, Duration)>,
    verdict: Verdict,
    /// The fields to the last target, and to the place near it where the path ends instead.
    fields: [PricedField; 2],
    /// The target that no way reaches, and the place near it where the path ends, in metres.
    place: Option<((f64, f64), (f64, f64))>,
    /// Where the map is left on the way to a target that is off it.
    exit: Option<Exit>,
    situation: Option<Situation>,
    /// What an operator has drawn on the panel.
    drawn: Drawn,
    in_force: InForce,
    /// The points of the last path, in metres; none without a path.
    points: Vec<(f64, f64)>,
}

impl Schema for Plan {
    fn awake(&mut self, _: &Context) -> Result {
        self.verdict = Verdict::default();
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let situation = self.plan(cx).unwrap_or_else(|situation| {
            self.path.retract(cx);
            self.points.clear();
            situation
        });
        self.state.write(cx, Text::truncated(&situation.to_string()));
        self.judge(cx, &situation);
        self.situation = Some(situation);
        Ok(())
    }
}

impl Inspect for Plan {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.keep_out, drawn::check_zones(&self.keep_out.sample(cx)));
        problems.expect(&self.lanes, drawn::check_lanes(&self.lanes.sample(cx)));
    }
}

impl Plan {
    /// Exports the zones and lanes that count, and the path; the error is why there is none.
    fn plan(&mut self, cx: &Context) -> Result<Situation, Situation> {
        self.in_force = self
            .drawn
            .over(&self.keep_out.sample(cx), &self.lanes.sample(cx))?;
        self.zones_in_force.write(cx, self.in_force.zones);
        self.lanes_in_force.write(cx, self.in_force.lanes);
        let wanted = self.target.get(cx);
        let target = wanted.get().ok_or(Situation::NoTarget)?;
        let map = self.map.get(cx).ok_or(Situation::NoMap)?;
        let pose = self.pose.get(cx).ok_or(Situation::NoPose)?;
        let inflation = self.inflation(cx);
        let drawing = self.drawing(cx);
        let prices = self.prices(cx, &drawing);
        let map = (map.value(), map.sequence());
        let change = Followed::follow(&mut self.followed, map, inflation, drawing);
        match &change {
            Ok(Change::Cells(cells)) => self.repair(cells),
            Ok(Change::All) | Err(_) => self.fields = Default::default(),
        }
        change?;
        self.look(cx, &pose)?;
        let robot = pose.pose2d();
        let way = self.way_past_unseen(cx, &prices, (robot.x, robot.y), (target.x, target.y))?;
        let geometry = *self.followed.as_ref().ok_or(Situation::NoMap)?.costs().geometry();
        let ends = [(robot.x, robot.y), (target.x, target.y)];
        let points = points(&geometry, &way, ends);
        let left = match geometry.cell_at(ends[1]) {
            None => points.last().map(|&end| apart(end, ends[1])),
            Some(_) => None,
        };
        let header = Header {
            stamp: cx.now().into(),
            frame_id: pose.header.frame_id,
        };
        let mut path = Path::through(header, &points);
        let cut = path.poses.len() < points.len();
        if let Some(last) = path.poses.as_mut_slice().last_mut()
            && wanted.has_heading.get()
            && !cut
            && left.is_none()
        {
            last.pose.orientation = Quaternion::from_yaw(target.theta);
        }
        let length = length(&points);
        let situation = match left {
            Some(left) => beyond::toward(length, cut, left)?,
            None => Situation::Path { length, cut },
        };
        self.path.write(cx, path);
        self.points = points;
        Ok(situation)
    }

    /// Follows the costs of these cells.
    fn repair(&mut self, cells: &[Cell]) {
        let Some(followed) = &self.followed else { return };
        for (_, field) in self.fields.iter_mut().flatten() {
            field.update(followed.costs(), cells);
        }
    }

    /// Remembers what is seen now, and puts what is remembered over the map.
    fn look(&mut self, cx: &Context, pose: &Odometry) -> Result<(), Situation> {
        let has_jumped = self.has_jumped(cx, pose);
        let Some(followed) = &self.followed else {
            return Ok(());
        };
        let resolution = followed.known().geometry().resolution();
        let remembered = match self.remembered.take() {
            Some(same) if same.resolution() == resolution && !has_jumped => same,
            _ => SeenObstacles::new(resolution),
        };
        let remembered = self.remembered.insert(remembered);
        if let Some(view) = self.seen.get(cx)
            && self.view.is_none_or(|(sequence, _)| sequence != view.sequence())
        {
            if view.header.frame_id != pose.header.frame_id {
                return Err(Situation::OtherFrame);
            }
            self.view = Some((view.sequence(), cx.now()));
            remembered.observe(followed.known(), &followed::grid(&view)?, cx.now());
        }
        let persistence = Duration::from_secs_f64(self.observation_persistence.get(cx));
        remembered.forget(cx.now().saturating_sub(persistence));
        let robot = pose.pose2d();
        remembered.forget_around((robot.x, robot.y), self.inscribed_radius.get(cx));
        self.cover();
        Ok(())
    }

    /// Whether the robot is where it cannot have driven since the last pose: what it saw was elsewhere.
    fn has_jumped(&mut self, cx: &Context, pose: &Odometry) -> bool {
        let robot = pose.pose2d();
        let Some((before, time)) = self.stood.replace((robot, cx.now())) else {
            return false;
        };
        let passed = cx.now().saturating_sub(time).as_secs_f64();
        let speed = libm::hypot(pose.twist.twist.linear.x, pose.twist.twist.linear.y);
        before.distance_to(&robot) > LARGEST_STEP + speed * passed
    }

    /// Returns the way. Where there is none, those obstacles are forgotten that are out of sight, if that helps.
    fn way_past_unseen(
        &mut self,
        cx: &Context,
        prices: &Prices,
        from: (f64, f64),
        to: (f64, f64),
    ) -> Result<Way, Situation> {
        let way = self.way(cx, prices, from, to);
        let Err(
            Situation::NoWay(_) | Situation::NoWayPast | Situation::NoWayOutside | Situation::TargetInZone,
        ) = &way
        else {
            return way;
        };
        let last = self.view.map_or(Duration::MAX, |(_, time)| time);
        let before = self.remembered.clone();
        if !self.remembered.as_mut().is_some_and(|places| places.forget(last)) {
            return way;
        }
        self.cover();
        let past = self.way(cx, prices, from, to);
        if past.is_err() {
            self.remembered = before;
            self.cover();
            return way;
        }
        past
    }

    /// Puts what is remembered over the map.
    fn cover(&mut self) {
        let (Some(followed), Some(remembered)) = (&mut self.followed, &self.remembered) else {
            return;
        };
        let geometry = *followed.known().geometry();
        let changed = followed.put_over(remembered.cells(&geometry).collect());
        self.repair(&changed);
    }

    /// Says whether the target can be reached.
    fn judge(&mut self, cx: &Context, situation: &Situation) {
        let Some(target) = self.target.get(cx).get() else {
            self.verdict = Verdict::default();
            self.planning.retract(cx);
            return;
        };
        let may_grow = self.allow_unknown.get(cx);
        let is_seen = self.followed.as_ref().is_some_and(Followed::has_seen_obstacles);
        // What is seen may go away, and a map with open unknown cells may grow.
        let is_final = match situation {
            Situation::NoWay(PlanError::GoalOutside) => !may_grow,
            Situation::TooFar { .. } => true,
            Situation::NoWay(PlanError::GoalClosed) => !may_grow && !is_seen,
            _ => false,
        };
        let patience = match is_final {
            true => CERTAIN_AFTER,
            false => Duration::from_secs_f64(self.patience.get(cx)),
        };
        let Some(state) = self.verdict.judge(target, situation, cx.now(), patience) else {
            return;
        };
        let words = situation.to_string();
        let note = if state == Mission::FAILED {
            words.as_str()
        } else {
            ""
        };
        let mission = Mission {
            state,
            target,
            note: Text::truncated(note),
            ..Mission::default()
        };
        self.planning.write(cx, mission);
    }

    fn way(
        &mut self,
        cx: &Context,
        prices: &Prices,
        robot: (f64, f64),
        target: (f64, f64),
    ) -> Result<Way, Situation> {
        let followed = self.followed.as_ref().ok_or(Situation::NoMap)?;
        let ends = Ends { followed, prices };
        let tolerance = self.tolerance.get(cx);
        let goal = ends.goal(target);
        let is_beyond = goal == Err(PlanError::GoalOutside.into()) && self.allow_unknown.get(cx);
        if is_beyond {
            beyond::check_distance(followed.costs().geometry(), robot, target)?;
        }
        let goal = match goal {
            Err(situation) if tolerance == 0.0 && !is_beyond => return Err(situation),
            goal => goal,
        };
        let (mut points, start) = ends.start(robot, 2.0 * self.circumscribed_radius.get(cx))?;
        let (costs, planner) = (followed.costs(), self.planner.get(cx));
        let [exact, instead] = &mut self.fields;
        if is_beyond {
            let way_to = |place| search(planner, costs, prices, instead, (start, place)).ok();
            let way = beyond::way_off(&mut self.exit, (followed, prices), start, target, way_to)?;
            points.extend(way.points);
            return Ok(Way { points, ..way });
        }
        let exact = goal.and_then(|goal| Ok(search(planner, costs, prices, exact, (start, goal))?));
        let nearby = match exact {
            Err(
                Situation::NoWay(PlanError::GoalClosed | PlanError::Unreachable) | Situation::TargetInZone,
            ) => {
                let mut way_to = |place| search(planner, costs, prices, instead, (start, place)).ok();
                // A place stays while a way leads there: on the two sides of a wall are places equally near.
                let kept = self
                    .place
                    .filter(|&(of, place)| of == target && apart(target, place) <= tolerance);
                let kept = kept.and_then(|(_, place)| way_to(costs.geometry().cell_at(place)?));
                kept.or_else(|| {
                    let place = ends.reachable(start, target, tolerance)?;
                    self.place = Some((target, costs.geometry().to_world(ends::center(place))));
                    way_to(place)
                })
            }
            _ => {
                (self.place, *instead) = (None, None);
                None
            }
        };
        let way = nearby.map_or(exact, Ok).map_err(|situation| match situation {
            Situation::NoWay(PlanError::Unreachable) if followed.has_zones() => Situation::NoWayOutside,
            Situation::NoWay(PlanError::Unreachable) if followed.has_seen_obstacles() => Situation::NoWayPast,
            other => other,
        })?;
        points.extend(way.points);
        Ok(Way { points, ..way })
    }

    fn inflation(&self, cx: &Context) -> Inflation {
        Inflation {
            inscribed: self.inscribed_radius.get(cx),
            circumscribed: self.circumscribed_radius.get(cx),
            reach: self.inflation_radius.get(cx),
            decay: self.cost_scaling_factor.get(cx),
        }
    }

    fn drawing(&self, cx: &Context) -> Drawing {
        let lanes = DrawnLanes {
            lines: Vec::new(),
            weight: self.cost_travel_multiplier.get(cx),
            aside: self.off_lanes.get(cx),
            unknown: self.unknown(cx),
        };
        self.in_force.drawing(self.inscribed_radius.get(cx), lanes)
    }

    fn prices(&self, cx: &Context, drawing: &Drawing) -> Prices {
        match &drawing.lanes {
            Some(lanes) => lanes.prices(),
            None => Prices::new(self.cost_travel_multiplier.get(cx), self.unknown(cx)),
        }
    }

    fn unknown(&self, cx: &Context) -> Unknown {
        if self.allow_unknown.get(cx) {
            Unknown::Open
        } else {
            Unknown::Closed
        }
    }
}

/// Returns the way between two cells. The gradient field is kept for the next one.
fn search(
    planner: Planner,
    costs: &Costmap,
    prices: &Prices,
    kept: &mut PricedField,
    (start, goal): (Cell, Cell),
) -> Result<Way, PlanError> {
    let angles = match planner {
        Planner::Grid => Angles::Eight,
        Planner::AnyAngle => Angles::Any,
        Planner::Gradient => {
            let is_same = |(made, field): &(Prices, Field)| made == prices && field.goal() == goal;
            let field = match kept.take().filter(is_same) {
                Some((_, field)) => field,
                None => Field::new(costs, prices, goal)?,
            };
            let (_, field) = kept.insert((prices.clone(), field));
            return field.route(start);
        }
    };
    jde_grid::plan(costs, prices, angles, start, goal)
}

jde_schema::export!("plan", "Plans a path over a map to a target.", [Plan]);

#[cfg(test)]
mod tests;
