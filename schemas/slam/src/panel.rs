//! The panel: what the keyframes show, the keyframes and the loops, the scan and the robot.

use jde_schema::prelude::*;

use super::Slam;

/// Most points for what the keyframes show. Of more points, an even selection is drawn.
const MOST_POINTS: usize = 15_000;
/// Most keyframes that are drawn.
const MOST_KEYFRAMES: usize = 1000;

impl Panel for Slam {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.text(&self.words);
        let (slam, graph) = (&self.slam, self.slam.graph());
        pen.row(|pen| {
            pen.value("keyframes", graph.poses().len() as f64, "");
            pen.value("loops", graph.loops().count() as f64, "");
        });
        pen.canvas("map").show(|area| {
            area.points(slam.points(MOST_POINTS)).ink(Ink::Plain).width(2.0);
            let step = graph.poses().len().div_ceil(MOST_KEYFRAMES).max(1);
            let keyframes = graph.poses().iter().step_by(step);
            area.points(keyframes.map(|pose| (pose.x, pose.y)))
                .ink(Ink::Accent)
                .width(2.0);
            let Some(anchor) = self.last.and_then(|last| slam.anchor(&last)) else {
                return;
            };
            let pose = slam.place(&anchor);
            if let Some(laser) = self.laser.get(cx) {
                let sensor = pose.transform(&self.mounted(cx, &laser));
                let place = |point: LaserPoint| sensor.transform(&Pose2D::new(point.x, point.y, 0.0));
                area.points(laser.points().map(place)).ink(Ink::Seen).width(2.5);
            }
            area.robot(&pose);
        });
        if !self.map_file.map_file_name.get(cx).is_empty() {
            pen.button("save", "Save the map");
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let file = self.map_file.map_file_name.get(cx);
        if gesture.pressed("save") && !file.is_empty() {
            info!(cx, "{} asks to save the map to {}", gesture.by(), file.as_str());
            self.save(cx);
        }
        Ok(())
    }
}
