//! The panel: the map's outline and obstacles, the path, the target, what came of planning, and keep-out zones, which
//! an operator draws by clicks.

use jde_grid::costmap::LETHAL;
use jde_grid::{Costmap, Geometry};
use jde_schema::panel::Plane;
use jde_schema::prelude::*;
use jde_schema::types::Zone;

use super::{Plan, drawn};

/// Most points for the obstacles. Of a map with more, only every so many columns and rows are drawn.
const MOST_CELLS: usize = 20_000;

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
            self.draw_zones(cx, area);
            area.line(self.points.iter().copied()).ink(Ink::Good).width(2.0);
            if let Some(target) = self.target.get(cx).get() {
                area.circle(target, 0.15).ink(Ink::Goal);
            }
            if let Some(pose) = self.pose.get(cx) {
                area.robot(&pose.pose2d());
            }
        });
        pen.text("Click on the map for the corners of a keep-out zone.");
        pen.row(|pen| {
            let drawn = &self.drawn;
            pen.button("close", "Complete zone").enabled(drawn.can_close());
            pen.button("discard", "Discard corners")
                .enabled(!drawn.corners.corners.is_empty());
            pen.button("clear", "Clear drawn zones")
                .enabled(!drawn.zones.zones.is_empty());
        });
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let by = gesture.by();
        if let Some([x, y, _]) = gesture.clicked("map") {
            if !self.drawn.add_corner(x, y) {
                warn!(
                    cx,
                    "the corner at {x:.2}, {y:.2} of {by} does not fit into the zone"
                );
            }
        } else if gesture.pressed("close") {
            match self.drawn.close() {
                Some(zone) => info!(cx, "{by} drew the keep-out zone {}", in_a_file(&zone)),
                None => warn!(cx, "there is no room for another keep-out zone of {by}"),
            }
        } else if gesture.pressed("discard") {
            self.drawn.corners.corners.clear();
        } else if gesture.pressed("clear") {
            self.drawn.zones.zones.clear();
            info!(cx, "{by} cleared the drawn keep-out zones");
        }
        Ok(())
    }
}

impl Plan {
    /// Draws the zones, and the corners of the one that is being drawn.
    fn draw_zones(&self, cx: &Context, area: &mut Plane) {
        let stated = self.keep_out.sample(cx);
        for zone in stated.zones.iter().chain(&self.drawn.zones.zones) {
            area.outline(drawn::corners(zone)).ink(Ink::Bad).width(2.0);
        }
        let corners = drawn::corners(&self.drawn.corners);
        area.line(corners.iter().copied()).ink(Ink::Warn).width(2.0);
        area.points(corners).ink(Ink::Warn).width(6.0);
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
    let step = (cells.clone().count() as f64 / MOST_CELLS as f64)
        .sqrt()
        .ceil()
        .max(1.0) as u32;
    cells
        .map(|(index, _)| geometry.cell(index))
        .filter(|cell| cell.x % step == 0 && cell.y % step == 0)
        .take(MOST_CELLS)
        .map(|cell| geometry.center(cell))
        .collect()
}

/// A zone as the key `keep_out` takes it.
fn in_a_file(zone: &Zone) -> String {
    let corners: Vec<_> = drawn::corners(zone)
        .iter()
        .map(|(x, y)| format!("[{x:.2}, {y:.2}]"))
        .collect();
    format!("{{ corners = [{}] }}", corners.join(", "))
}
