//! The panel: the occupied cells of the map, zones and lanes, the robot, the path and the targets. A click on the field sets
//! the target.

use jde_schema::prelude::*;

use super::Navigate;

/// Most points for the occupied cells. Of more points, an even selection is drawn.
const MOST_CELLS: usize = 20_000;

impl Panel for Navigate {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        let terms = self.terms(cx);
        pen.heading("Navigation");
        pen.text(self.targets.status_text(&terms, pose));
        if let Some(state) = self.state.get(cx) {
            pen.text(format!("Planner: {}", state.as_str()));
        }
        pen.canvas("field").wants_clicks().show(|field| {
            if let Some(map) = self.map.get(cx) {
                field.points(map.occupied(MOST_CELLS)).ink(Ink::Plain).width(2.0);
            }
            if let Some(lanes) = self.lanes.get(cx) {
                for lane in &lanes.lanes {
                    field.line(&lane.points).ink(Ink::Accent).width(3.0);
                }
            }
            if let Some(zones) = self.zones.get(cx) {
                for zone in &zones.zones {
                    field.outline(&zone.corners).ink(Ink::Bad).width(2.0);
                }
            }
            self.targets.draw_route(&terms, field);
            if let Some(path) = self.path.get(cx) {
                let points = path.poses.iter().map(|stamped| stamped.pose.position);
                field
                    .line(points.map(|point| (point.x, point.y)))
                    .ink(Ink::Good)
                    .width(2.0);
            }
            if let Some(pose) = pose {
                if let Some(laser) = self.laser.get(cx) {
                    let points = laser
                        .points()
                        .map(|point| pose.transform(&Pose2D::new(point.x, point.y, 0.0)));
                    field.points(points).ink(Ink::Seen).width(2.5);
                }
                field.robot(&pose);
            }
            self.targets.draw_target(&terms, field);
        });
        self.targets.draw_clear(pen);
        pen.text("New keep-out zones and lanes are drawn in the panel of the planner.");
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        self.targets.touched(cx, gesture);
        Ok(())
    }
}
