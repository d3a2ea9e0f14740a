//! Plans a path over a map to a target. It commands nothing, and it knows only the obstacles of the map and what
//! an operator draws on it.

mod drawn;
mod ends;
mod followed;
mod memory;
mod panel;
mod situation;

use jde_grid::{
    Angles, Cell, Costmap, Drawing, Field, Inflation, Lanes as DrawnLanes, PlanError, Prices, Route as Way,
    Unknown,
};
use jde_schema::prelude::*;
use jde_schema::types::{Lanes, Zones};

use drawn::{Drawn, InForce};
use ends::Ends;
use followed::{Change, Followed};
use situation::Situation;

/// By how much a path may leave the planned way, in cells: far below what a cell itself leaves open.
const TOLERANCE: f64 = 0.25;

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
/// The map, the pose and the target are in one frame. A robot that is too close to an obstacle, although its centre
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
    /// The target.
    #[modulation(default = Target::NONE)]
    target: Modulation<Target>,
    /// How it plans: `gradient`, `grid` (A*) or `any-angle` (Theta*).
    #[modulation(default = Planner::Gradient)]
    planner: Modulation<Planner>,
    /// Radius of the largest circle within the footprint. Closer to an obstacle there is no way.
    #[modulation(default = 0.2, unit = "m", min = 0.0, max = 5.0)]
    inscribed: Modulation<f64>,
    /// Radius of the smallest circle around the footprint; at least `inscribed`.
    #[modulation(default = 0.27, unit = "m", min = 0.0, max = 5.0)]
    circumscribed: Modulation<f64>,
    /// Distance to an obstacle from which on it costs nothing.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 10.0)]
    reach: Modulation<f64>,
    /// Rate at which costs decay with the distance to an obstacle.
    #[modulation(default = 3.0, unit = "1/m", min = 0.0, max = 100.0)]
    decay: Modulation<f64>,
    /// How many times its length a way along an obstacle costs more. 0 is the shortest way.
    #[modulation(default = 4.0, min = 0.0, max = 20.0)]
    clearance: Modulation<f64>,
    /// How far from a target that cannot be reached the path may end.
    #[modulation(default = 0.0, unit = "m", min = 0.0, max = 5.0)]
    tolerance: Modulation<f64>,
    /// Whether the way may lead through unknown cells.
    #[modulation(default = false)]
    unknown: Modulation<bool>,
    /// Keep-out zones, in the frame of the map: the path leads `inscribed` around them. An operator draws more of
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
    /// What came of the last iteration, in words.
    #[export]
    state: Export<Text<160>>,
    /// The keep-out zones that count: those of the application, and the drawn ones.
    #[export]
    zones_in_force: Export<Zones>,
    /// The lanes that count: those of the application, and the drawn ones.
    #[export]
    lanes_in_force: Export<Lanes>,
    followed: Option<Followed>,
    /// The fields to the last target, and to the place near it where the path ends instead.
    fields: [PricedField; 2],
    /// The target that no way reaches, and the place near it where the path ends, in metres.
    place: Option<((f64, f64), (f64, f64))>,
    situation: Option<Situation>,
    /// What an operator has drawn on the panel.
    drawn: Drawn,
    in_force: InForce,
    /// The points of the last path, in metres; none without a path.
    points: Vec<(f64, f64)>,
}

impl Schema for Plan {
    fn iterate(&mut self, cx: &Context) -> Result {
        let situation = self.plan(cx).unwrap_or_else(|situation| {
            self.path.retract(cx);
            self.points.clear();
            situation
        });
        self.state.write(cx, Text::truncated(&situation.to_string()));
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
        let target = self.target.get(cx).get().ok_or(Situation::NoTarget)?;
        let map = self.map.get(cx).ok_or(Situation::NoMap)?;
        let pose = self.pose.get(cx).ok_or(Situation::NoPose)?;
        let inflation = self.inflation(cx);
        let drawing = self.drawing(cx);
        let prices = self.prices(cx, &drawing);
        let map = (map.value(), map.sequence());
        let change = Followed::follow(&mut self.followed, map, inflation, drawing);
        match &change {
            Ok(Change::Cells(cells)) => {
                if let Some(followed) = &self.followed {
                    for (_, field) in self.fields.iter_mut().flatten() {
                        field.update(followed.costs(), cells);
                    }
                }
            }
            Ok(Change::All) | Err(_) => self.fields = Default::default(),
        }
        change?;
        let robot = pose.pose2d();
        let way = self.way(cx, prices, (robot.x, robot.y), (target.x, target.y))?;
        let points = self.points(&way, (robot.x, robot.y), (target.x, target.y));
        let header = Header {
            stamp: cx.now().into(),
            frame_id: pose.header.frame_id,
        };
        let path = Path::through(header, &points);
        let situation = Situation::Path {
            length: length(&points),
            cut: path.poses.len() < points.len(),
        };
        self.path.write(cx, path);
        self.points = points;
        Ok(situation)
    }

    fn way(
        &mut self,
        cx: &Context,
        prices: Prices,
        robot: (f64, f64),
        target: (f64, f64),
    ) -> Result<Way, Situation> {
        let followed = self.followed.as_ref().ok_or(Situation::NoMap)?;
        let ends = Ends {
            followed,
            prices: &prices,
        };
        let tolerance = self.tolerance.get(cx);
        let goal = match ends.goal(target) {
            Err(situation) if tolerance == 0.0 => return Err(situation),
            goal => goal,
        };
        let (mut points, start) = ends.start(robot, 2.0 * self.circumscribed.get(cx))?;
        let (costs, planner) = (followed.costs(), self.planner.get(cx));
        let [exact, instead] = &mut self.fields;
        let exact = goal.and_then(|goal| Ok(search(planner, costs, &prices, exact, (start, goal))?));
        let nearby = match exact {
            Err(
                Situation::NoWay(PlanError::GoalClosed | PlanError::Unreachable) | Situation::TargetInZone,
            ) => {
                let mut way_to = |place| search(planner, costs, &prices, instead, (start, place)).ok();
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
            other => other,
        })?;
        points.extend(way.points);
        Ok(Way { points, ..way })
    }

    /// The points of the path in metres. Its ends are robot and target themselves, not the centres of their
    /// cells; a target in an obstacle is not its end.
    fn points(&self, way: &Way, robot: (f64, f64), target: (f64, f64)) -> Vec<(f64, f64)> {
        let Some(geometry) = self
            .followed
            .as_ref()
            .map(|followed| *followed.costs().geometry())
        else {
            return Vec::new();
        };
        let way = way.simplified(TOLERANCE);
        let mut points: Vec<_> = way.points.iter().map(|&point| geometry.to_world(point)).collect();
        let end = points
            .pop()
            .filter(|&end| geometry.cell_at(end) != geometry.cell_at(target));
        points.push(end.unwrap_or(target));
        if points.len() > 1 {
            points[0] = robot;
        } else {
            points.insert(0, robot);
        }
        points
    }

    fn inflation(&self, cx: &Context) -> Inflation {
        Inflation {
            inscribed: self.inscribed.get(cx),
            circumscribed: self.circumscribed.get(cx),
            reach: self.reach.get(cx),
            decay: self.decay.get(cx),
        }
    }

    fn drawing(&self, cx: &Context) -> Drawing {
        let lanes = DrawnLanes {
            lines: Vec::new(),
            weight: self.clearance.get(cx),
            aside: self.off_lanes.get(cx),
            unknown: self.unknown(cx),
        };
        self.in_force.drawing(self.inscribed.get(cx), lanes)
    }

    fn prices(&self, cx: &Context, drawing: &Drawing) -> Prices {
        match &drawing.lanes {
            Some(lanes) => lanes.prices(),
            None => Prices::new(self.clearance.get(cx), self.unknown(cx)),
        }
    }

    fn unknown(&self, cx: &Context) -> Unknown {
        if self.unknown.get(cx) {
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

fn length(points: &[(f64, f64)]) -> f64 {
    points.windows(2).map(|pair| apart(pair[0], pair[1])).sum()
}

fn apart(a: (f64, f64), b: (f64, f64)) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

jde_schema::export!("plan", "Plans a path over a map to a target.", [Plan]);

#[cfg(test)]
mod tests;
