//! The panel: the map's outline, the path, the target, and what came of planning.

use jde_schema::prelude::*;

use super::Plan;

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
        let (right, top) = (f64::from(geometry.width()), f64::from(geometry.height()));
        let corners = [(0.0, 0.0), (right, 0.0), (right, top), (0.0, top), (0.0, 0.0)];
        let corners = corners.map(|corner| geometry.to_world(corner));
        let least = |pick: fn(&(f64, f64)) -> f64| corners.iter().map(pick).fold(f64::INFINITY, f64::min);
        let most = |pick: fn(&(f64, f64)) -> f64| corners.iter().map(pick).fold(f64::NEG_INFINITY, f64::max);
        let canvas = pen.canvas("map");
        let (low, high) = ((least(|c| c.0), least(|c| c.1)), (most(|c| c.0), most(|c| c.1)));
        canvas.area(low, high).show(|area| {
            area.line(corners).ink(Ink::Faint);
            area.line(self.drawn.iter().copied()).ink(Ink::Good).width(2.0);
            if let Some(target) = self.target.get(cx).get() {
                area.circle(target, 0.15).ink(Ink::Goal);
            }
            if let Some(pose) = self.pose.get(cx) {
                area.robot(&pose.pose2d());
            }
        });
    }
}
