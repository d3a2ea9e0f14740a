//! The panel: the path, the pursued point, and what the laser sees.

use jde_schema::prelude::*;

use super::{Chase, Path};

impl Panel for Path {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match self.reason() {
            Some(reason) => pen.text(reason),
            None => pen.value("left", self.track.left(), "m"),
        }
        let Some(body) = &self.body else { return };
        let pose = self.perception.pose.get(cx).map(|odometry| odometry.pose2d());
        let canvas = pen.canvas("around").forward_up();
        canvas.area((-2.0, -2.0), (4.0, 2.0)).show(|area| {
            area.points(body.points().iter().map(|point| (point.x, point.y)))
                .ink(Ink::Seen)
                .width(2.5);
            if let Some(pose) = pose {
                area.line(self.track.poses().iter().map(|place| pose.localize(place)))
                    .ink(Ink::Goal);
            }
            area.robot(&Pose2D::ORIGIN);
            if let Chase::Point(point) = self.chase {
                area.circle(point, 0.1).ink(Ink::Accent);
            }
        });
    }
}
