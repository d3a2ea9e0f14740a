//! The panel: the map's outline and obstacles, those that are seen, the path, the target, what came of planning, and
//! keep-out zones and lanes, which an operator draws by clicks.

use jde_grid::costmap::LETHAL;
use jde_grid::{Costmap, Geometry};
use jde_schema::panel::Plane;
use jde_schema::prelude::*;
use jde_schema::types::{Lanes, Point2D, Strip, Zone, Zones};

use super::Plan;

/// Most points for the obstacles. Of more points, an even selection is drawn.
const MOST_CELLS: usize = 20_000;
/// The widths of lanes that an operator can choose, m.
const WIDTHS: core::ops::RangeInclusive<f64> = 0.1..=5.0;

impl Panel for Plan {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match &self.situation {
            None => pen.text("not planned yet"),
            Some(situation) => pen.text(situation.to_string()),
        }
        let Some(followed) = &self.followed else { return };
        let geometry = followed.costs().geometry();
        pen.row(|pen| {
            pen.value("columns", f64::from(geometry.width()), "");
            pen.value("rows", f64::from(geometry.height()), "");
            pen.value("resolution", geometry.resolution(), "m");
        });
        let outline = outline(geometry);
        let least = |pick: fn(&(f64, f64)) -> f64| outline.iter().map(pick).fold(f64::INFINITY, f64::min);
        let most = |pick: fn(&(f64, f64)) -> f64| outline.iter().map(pick).fold(f64::NEG_INFINITY, f64::max);
        let canvas = pen.canvas("map").wants_clicks();
        let (low, high) = ((least(|c| c.0), least(|c| c.1)), (most(|c| c.0), most(|c| c.1)));
        canvas.area(low, high).show(|area| {
            area.outline(outline).ink(Ink::Faint);
            area.points(obstacles(followed.obstacles()))
                .ink(Ink::Plain)
                .width(2.0);
            if let Some(seen) = &self.remembered {
                let cells = seen
                    .cells(geometry)
                    .take(MOST_CELLS)
                    .map(|cell| geometry.center(cell));
                area.points(cells).ink(Ink::Warn).width(2.0);
            }
            self.draw_layers(area);
            area.line(self.points.iter().copied()).ink(Ink::Good).width(2.0);
            if let Some(target) = self.target.get(cx).get() {
                area.circle(target, 0.15).ink(Ink::Goal);
            }
            if let Some(pose) = self.pose.get(cx) {
                area.robot(&pose.pose2d());
            }
        });
        pen.text("Click on the map for the corners of a keep-out zone, or the points of a lane.");
        let drawn = &self.drawn;
        let points = drawn.points.corners.len();
        pen.row(|pen| {
            pen.button("zone", "Complete zone").enabled(points >= 3);
            pen.button("lane", "Complete lane").enabled(points >= 2);
            pen.button("discard", "Discard points").enabled(points > 0);
            let is_drawn = !(drawn.zones.zones.is_empty() && drawn.lanes.lanes.is_empty());
            pen.button("clear", "Clear what is drawn").enabled(is_drawn);
        });
        pen.slider("width", "Width of the lane", drawn.width, WIDTHS, "m");
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let by = gesture.by();
        let drawn = &mut self.drawn;
        if let Some([x, y, _]) = gesture.clicked("map") {
            if !drawn.add_point(x, y) {
                warn!(
                    cx,
                    "there is no room for another point of {by}, at {x:.2}, {y:.2}"
                );
            }
        } else if let Some(width) = gesture.moved("width") {
            drawn.width = width;
        } else if gesture.pressed("zone") {
            match drawn.complete_zone(&self.keep_out.sample(cx)) {
                Some(Zone { corners }) => {
                    info!(
                        cx,
                        "{by} drew the keep-out zone {{ corners = {} }}",
                        in_a_file(&corners)
                    );
                }
                None => warn!(cx, "there is no room for another keep-out zone of {by}"),
            }
        } else if gesture.pressed("lane") {
            match drawn.complete_strip(&self.lanes.sample(cx)) {
                Some(Strip { width, points }) => {
                    let points = in_a_file(&points);
                    info!(
                        cx,
                        "{by} drew the lane {{ width = {width:.2}, points = {points} }}"
                    );
                }
                None => warn!(cx, "there is no room for another lane of {by}"),
            }
        } else if gesture.pressed("discard") {
            drawn.points.corners.clear();
        } else if gesture.pressed("clear") {
            (drawn.zones, drawn.lanes) = (Zones::EMPTY, Lanes::EMPTY);
            info!(cx, "{by} cleared the drawn keep-out zones and lanes");
        }
        Ok(())
    }
}

impl Plan {
    /// Draws lanes and zones, and the points of the next.
    fn draw_layers(&self, area: &mut Plane) {
        for lane in &self.in_force.lanes.lanes {
            area.line(&lane.points).ink(Ink::Accent).width(3.0);
            for point in &lane.points {
                area.circle(point, lane.width / 2.0).ink(Ink::Accent);
            }
        }
        for zone in &self.in_force.zones.zones {
            area.outline(&zone.corners).ink(Ink::Bad).width(2.0);
        }
        let points = &self.drawn.points.corners;
        area.line(points).ink(Ink::Warn).width(2.0);
        area.points(points).ink(Ink::Warn).width(6.0);
    }
}

/// The corners of the map, in metres.
fn outline(geometry: &Geometry) -> [(f64, f64); 4] {
    let (right, top) = (f64::from(geometry.width()), f64::from(geometry.height()));
    [(0.0, 0.0), (right, 0.0), (right, top), (0.0, top)].map(|corner| geometry.to_world(corner))
}

/// The centres of obstacles, in metres.
fn obstacles(costs: &Costmap) -> Vec<(f64, f64)> {
    let geometry = costs.geometry();
    let cells = costs.costs().iter().enumerate();
    let cells = cells.filter(|(_, cost)| **cost == LETHAL);
    let step = cells.clone().count().div_ceil(MOST_CELLS).max(1);
    cells
        .step_by(step)
        .map(|(index, _)| geometry.center(geometry.cell(index)))
        .collect()
}

/// Points as a file has them.
fn in_a_file(points: &[Point2D]) -> String {
    let points = points.iter().map(|Point2D { x, y }| format!("[{x:.2}, {y:.2}]"));
    format!("[{}]", points.collect::<Vec<_>>().join(", "))
}
