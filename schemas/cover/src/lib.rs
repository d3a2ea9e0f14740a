//! Coverage of a floor by a tool: contours and tracks side by side, nearest first, until all that can be reached is covered. It
//! exports a path, and leaves driving to others.

mod held;
mod memory;
mod obstacles;
mod panel;
mod stroke;

use jde_grid::{
    Cell, CellSet, Costmap, Floor, Inflation, Occupancy, OccupancyGrid as Grid, PlanError, Prices, Unknown,
    nearest_open, walk,
};
use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

use held::Held;
use obstacles::{Obstacles, Standpoint};
use stroke::Driven;

/// A step of the pose that is no motion, m: nothing is covered between both places.
const JUMP: f64 = 0.5;
/// How long there may be nothing left to drive before the floor counts as covered: the map may be growing.
const SETTLING_TIME: Duration = Duration::from_secs(2);

/// Exports one path after another, along which a robot covers the floor of a map with a round tool.
///
/// The floor is where the tool comes from all places that the robot can reach. It drives along the contour of these places and along
/// tracks, each where the tool covers something new, the nearest first. Where a map grows, so does the floor. It leads around what `seen`
/// has and the map does not have. Where the robot comes no nearer for `patience`, it takes the place ahead for an obstacle, and the mission
/// says so. Before the end it tries once more what it left out. The mission is done when nothing is left. If the robot comes no nearer to
/// one place after another and does not move at all, the mission has failed, and there is no path until the robot is elsewhere, an
/// operator has what was left out tried again, or the schema awakes again.
#[derive(Describe)]
#[schema(perceptive, period = "200ms", budget = "400ms")]
pub struct Cover {
    /// The map. It may move and grow.
    #[import]
    map: Import<OccupancyGrid>,
    /// The estimated pose of the robot, in the frame of the map. One that is not finite counts as none.
    #[import]
    pose: Import<Odometry>,
    /// The obstacles that sensors see around the robot, in the frame of the map.
    #[import(optional)]
    seen: Import<OccupancyGrid>,
    /// Radius of a circle that the robot needs. Nearer to an obstacle it does not go.
    #[modulation(default = 0.2, unit = "m", min = 0.0, max = 5.0, was = "inscribed")]
    inscribed_radius: Modulation<f64>,
    /// Width of the tool, whose middle is that of the base.
    #[modulation(default = 0.3, unit = "m", min = 0.05, max = 5.0, was = "width")]
    operation_width: Modulation<f64>,
    /// The share of the width by which neighbouring tracks overlap.
    #[modulation(default = 0.2, min = 0.0, max = 0.9)]
    overlap: Modulation<f64>,
    /// The share of the tool that must be over something new for a place to be driven to.
    #[modulation(default = 0.1, min = 0.01, max = 1.0)]
    least: Modulation<f64>,
    /// Distance to a point of the path below which it is reached.
    #[modulation(default = 0.15, unit = "m", min = 0.01, max = 1.0)]
    tolerance: Modulation<f64>,
    /// Time without getting nearer to the next point of the path, after which the place ahead is left out.
    #[modulation(default = 20.0, unit = "s", min = 1.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// How long an obstacle of `seen` is remembered after it was seen last.
    #[modulation(default = 300.0, unit = "s", min = 0.0, max = 86400.0)]
    observation_persistence: Modulation<f64>,
    /// The path: the way to the next stroke, and the stroke.
    #[export]
    path: Export<Path>,
    /// DONE when nothing is left, with a note about the covered floor and the places that were left out; FAILED while the
    /// robot does not move. `reached` counts the strokes.
    #[export(lasting)]
    mission: Export<Mission>,
    /// The present activity, or the reason why there is none.
    #[export]
    state: Export<Text<160>>,
    /// The share of the floor that is covered.
    #[export(lasting)]
    covered: Export<f64>,
    /// The area that is covered.
    #[export(unit = "m2", lasting)]
    area: Export<f64>,
    obstacles: Option<Obstacles>,
    marks: Option<Marks>,
    stroke: Option<Driven>,
    /// The floor as it was at the last plan, with what is left out.
    floor: Option<Floor>,
    /// What the last plan that found no stroke was made from.
    exhausted: Option<Basis>,
    /// How much of it is covered, and all of it, m².
    areas: (f64, f64),
    left_out: Vec<(f64, f64)>,
    /// Whether what was left out was tried once more.
    has_retried: bool,
    strokes: u32,
    last: Option<Pose2D>,
    /// Since when there has been nothing left to drive.
    settled_since: Option<Duration>,
    is_done: bool,
    held: Held,
    words: String,
}

/// What a plan depends on, beside what is covered: the number of the map, how many cells of what is seen lie over it, the cell of the
/// robot, how many places are left out, and the modulations.
type Basis = (u64, usize, Option<Cell>, usize, [f64; 4]);

/// The cells that were covered, and those of the lines that were driven along.
struct Marks {
    covered: CellSet,
    driven: CellSet,
}

impl Schema for Cover {
    fn awake(&mut self, _: &Context) -> Result {
        (self.stroke, self.exhausted) = (None, None);
        self.last = None;
        self.settled_since = None;
        self.held = Held::default();
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.path.retract(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let result = self.go_on(cx);
        self.measure(cx);
        self.words = match result {
            Ok(()) => self.situation(),
            Err(error) => {
                self.stroke = None;
                error.to_string()
            }
        };
        let stroke = self.stroke.as_ref();
        match stroke.zip(self.pose.get(cx)) {
            Some((stroke, pose)) => {
                let header = Header {
                    stamp: cx.now().into(),
                    frame_id: pose.header.frame_id,
                };
                self.path.write(cx, Path::through(header, stroke.path()))
            }
            None => self.path.retract(cx),
        }
        let end = stroke.map(Driven::end).zip(self.last);
        self.mission.write(
            cx,
            Mission {
                state: match (self.held.is_held(), self.is_done) {
                    (true, _) => Mission::FAILED,
                    (false, true) => Mission::DONE,
                    (false, false) => Mission::RUNNING,
                },
                reached: self.strokes,
                note: Text::truncated(&self.words),
                target: end.map_or(Pose2D::ORIGIN, |(end, _)| end),
                distance: end.map_or(0.0, |(end, robot)| robot.distance_to(&end)),
                ..Mission::default()
            },
        );
        self.state.write(cx, Text::truncated(&self.words));
        Ok(())
    }
}

impl Cover {
    /// Follows the map and the robot, and plans when a stroke has ended.
    fn go_on(&mut self, cx: &Context) -> Result {
        let map = self.map.get(cx).ok_or("there is no map")?;
        let robot = self.robot(cx).ok_or("the place of the robot is not known")?;
        let from = self
            .last
            .replace(robot)
            .filter(|last| last.distance_to(&robot) < JUMP);
        self.look(cx, &map, &robot, from.is_none())?;
        let obstacles = self.obstacles.as_ref().ok_or("there is no map")?;
        let geometry = *obstacles.known().geometry();
        let marks = self.marks.get_or_insert_with(|| Marks {
            covered: CellSet::none(geometry),
            driven: CellSet::none(geometry),
        });
        marks.covered.follow(geometry);
        marks.driven.follow(geometry);
        let from = from.unwrap_or(robot);
        let radius = self.operation_width.get(cx) / 2.0;
        marks.covered.sweep((from.x, from.y), (robot.x, robot.y), radius);
        if self.held.follow(&robot) {
            info!(cx, "the robot moves again");
        }
        if self.held.is_held() {
            return Ok(());
        }
        let patience = Duration::from_secs_f64(self.patience.get(cx));
        if let Some(stroke) = &mut self.stroke {
            stroke.advance(&robot, self.tolerance.get(cx), cx.now());
            let ahead = self.inscribed_radius.get(cx) + geometry.resolution();
            if let Some((x, y)) = stroke.stuck(cx.now(), patience, ahead) {
                warn!(
                    cx,
                    "leaves out the floor around {x:.2}, {y:.2}: the robot comes no nearer"
                );
                self.left_out.push((x, y));
                self.stroke = None;
                if let Some(places) = self.held.fail(&robot) {
                    self.stand(cx, places);
                    return Ok(());
                }
            } else if stroke.is_at_end() {
                for &cell in stroke.cells() {
                    marks.driven.sweep(cell, cell, geometry.resolution() / 2.0);
                }
                self.strokes += 1;
                self.stroke = None;
            } else if !is_blocked(obstacles, stroke.ahead(), &robot, self.inscribed_radius.get(cx)) {
                return Ok(());
            }
        }
        let modulations = [
            &self.inscribed_radius,
            &self.operation_width,
            &self.overlap,
            &self.least,
        ];
        let modulations = modulations.map(|modulation| modulation.get(cx));
        let cell = geometry.cell_at((robot.x, robot.y));
        let seen = obstacles.over().len();
        let basis = (map.sequence(), seen, cell, self.left_out.len(), modulations);
        if self.exhausted != Some(basis) {
            self.plan(cx, &robot)?;
            self.exhausted = self.stroke.is_none().then_some(basis);
        }
        if self.stroke.is_some() {
            (self.settled_since, self.is_done) = (None, false);
        } else if let Some(places) = self.held.exhaust() {
            self.stand(cx, places);
        } else if !self.left_out.is_empty() && !self.has_retried {
            info!(cx, "tries once more what was left out");
            self.has_retried = true;
            self.left_out.clear();
        } else if cx.now() >= *self.settled_since.get_or_insert(cx.now()) + SETTLING_TIME && !self.is_done {
            self.is_done = true;
            info!(cx, "{}", self.situation());
        }
        Ok(())
    }

    /// The robot does not move: the last places were left out for that alone.
    fn stand(&mut self, cx: &Context, places: usize) {
        warn!(
            cx,
            "the robot does not move: it stands until it is elsewhere, or an operator has it try again"
        );
        self.left_out.truncate(self.left_out.len().saturating_sub(places));
        self.exhausted = None;
    }

    /// Follows the map and what is seen over it.
    fn look(
        &mut self,
        cx: &Context,
        map: &Sample<'_, OccupancyGrid>,
        robot: &Pose2D,
        jumped: bool,
    ) -> Result {
        let mut obstacles = match self.obstacles.take() {
            Some(obstacles) => obstacles,
            None => Obstacles::new(map, map.sequence())?,
        };
        obstacles.follow(map, map.sequence())?;
        if jumped {
            obstacles.forget();
        }
        let persistence = Duration::from_secs_f64(self.observation_persistence.get(cx));
        let from = Standpoint {
            robot: (robot.x, robot.y),
            radius: self.inscribed_radius.get(cx),
            now: cx.now(),
            since: cx.now().saturating_sub(persistence),
        };
        let view = self.seen.get(cx);
        let frame = self.pose.get(cx).map(|pose| pose.header.frame_id);
        if view
            .as_ref()
            .is_some_and(|view| Some(view.header.frame_id) != frame)
        {
            return Err("the obstacles of `seen` are in another frame than the pose".into());
        }
        obstacles.look(view.as_ref().map(|view| (view.value(), view.sequence())), &from)?;
        self.obstacles = Some(obstacles);
        Ok(())
    }

    /// Computes the floor, and plans the next stroke.
    fn plan(&mut self, cx: &Context, robot: &Pose2D) -> Result {
        self.stroke = None;
        let obstacles = self.obstacles.as_ref().ok_or("there is no map")?;
        let geometry = *obstacles.known().geometry();
        let whole = self.floor_around(cx, obstacles.known(), robot)?;
        let is_known = self.left_out.is_empty() && obstacles.over().is_empty();
        let mut floor = if is_known {
            whole
        } else {
            let mut grid = obstacles.grid().clone();
            for cell in self.left_out.iter().filter_map(|&place| geometry.cell_at(place)) {
                grid.set(cell, Occupancy::Occupied);
            }
            self.floor = Some(whole);
            match self.floor_around(cx, &grid, robot) {
                // What is left out is all around it.
                Err(_) if !self.left_out.is_empty() => return Ok(()),
                floor => floor?,
            }
        };
        let width = self.operation_width.get(cx) / geometry.resolution();
        let tool = core::f64::consts::PI * (width / 2.0).powi(2);
        let least = (self.least.get(cx) * tool).ceil() as usize;
        let next = self
            .marks
            .as_ref()
            .and_then(|marks| floor.next(&marks.covered, &marks.driven, least));
        self.stroke = next.map(|stroke| Driven::new(stroke, &geometry, cx.now()));
        if is_known {
            self.floor = Some(floor);
        }
        Ok(())
    }

    /// The floor of a map around the robot.
    fn floor_around(&self, cx: &Context, grid: &Grid, robot: &Pose2D) -> Result<Floor> {
        let (geometry, radius) = (*grid.geometry(), self.inscribed_radius.get(cx));
        let costs = Costmap::new(grid, &Inflation::circle(radius))?;
        let prices = Prices::new(0.0, Unknown::Closed);
        let cell = geometry
            .cell_at((robot.x, robot.y))
            .ok_or(PlanError::StartOutside)?;
        let reach = radius / geometry.resolution() + 2.0;
        let start = nearest_open(&costs, &prices, cell, reach).ok_or(PlanError::StartClosed)?;
        let width = self.operation_width.get(cx) / geometry.resolution();
        let distance = (width * (1.0 - self.overlap.get(cx))).round().max(1.0) as u32;
        Ok(Floor::new(&costs, &prices, start, width / 2.0, distance)?)
    }

    /// Exports how much of the floor is covered.
    fn measure(&mut self, cx: &Context) {
        let (Some(marks), Some(floor)) = (&self.marks, &self.floor) else {
            return;
        };
        if let Some((covered, all)) = floor.share(&marks.covered) {
            let area = |cells: usize| cells as f64 * floor.geometry().resolution().powi(2);
            self.areas = (area(covered), area(all));
            self.covered.write(cx, covered as f64 / all.max(1) as f64);
            self.area.write(cx, self.areas.0);
        }
    }

    /// What it does, in words.
    fn situation(&self) -> String {
        let (covered, all) = self.areas;
        let share = 100.0 * covered / all.max(f64::EPSILON);
        let out = match self.left_out.len() {
            0 => String::new(),
            1 => ", 1 place is left out".to_owned(),
            several => format!(", {several} places are left out"),
        };
        let of = if self.is_done { "covered" } else { "so far" };
        let stands = if self.held.is_held() {
            "the robot does not move: "
        } else {
            ""
        };
        format!("{stands}{share:.1} % of {all:.1} m2 {of}{out}")
    }

    /// Where the robot is; `None` also for numbers that are not finite.
    fn robot(&self, cx: &Context) -> Option<Pose2D> {
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        pose.filter(Pose2D::is_finite)
    }
}

/// Whether an obstacle is on a path that was not there when the path was planned: nearer by more than a cell than the robot may be.
/// What is seen that near to the robot itself concerns its driver.
fn is_blocked(obstacles: &Obstacles, path: &[(f64, f64)], robot: &Pose2D, inscribed: f64) -> bool {
    let geometry = obstacles.known().geometry();
    let reach = inscribed / geometry.resolution() - 1.0;
    let side = reach.max(0.0) as i32;
    let is_clear = |cell: Cell, _: f64| {
        let (x, y) = geometry.center(cell);
        let grid = if libm::hypot(x - robot.x, y - robot.y) < inscribed {
            obstacles.known()
        } else {
            obstacles.grid()
        };
        let around = (-side..=side).flat_map(|y| (-side..=side).map(move |x| (x, y)));
        let within = around.filter(|&(x, y)| f64::from(x * x + y * y) <= reach * reach);
        !within
            .filter_map(|(x, y)| cell.offset(x, y))
            .any(|cell| grid.get(cell) == Occupancy::Occupied)
    };
    path.windows(2).any(|pair| {
        let ends = geometry.cell_at(pair[0]).zip(geometry.cell_at(pair[1]));
        ends.is_some_and(|(from, to)| !walk(from, to, is_clear))
    })
}

jde_schema::export!(
    "cover",
    "Leads a robot over all of a floor that it can reach.",
    [Cover]
);

#[cfg(test)]
mod tests;
