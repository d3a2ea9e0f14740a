//! The panel: what it does, what is known around the robot, and the way that it came.

use jde_schema::prelude::*;

use super::Recover;

impl Panel for Recover {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match self.words.as_str() {
            "" => pen.text("not stuck"),
            words => pen.text(words),
        }
        let canvas = pen.canvas("around").forward_up();
        canvas.area((-3.0, -3.0), (3.0, 3.0)).show(|area| {
            if let Some(around) = self.surroundings.get(cx) {
                let points = around.points.iter().map(|point| (point.x, point.y));
                area.points(points).ink(Ink::Seen).width(2.5);
            }
            if let Some(pose) = self.pose.get(cx).map(|odometry| odometry.pose2d()) {
                let way = self.trail.poses().map(|place| pose.localize(place));
                area.line(way).ink(Ink::Good).width(2.0);
            }
            area.robot(&Pose2D::ORIGIN);
        });
    }
}
