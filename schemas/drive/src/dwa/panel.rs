//! The panel: the path, the arc that is chosen, and what the laser sees.

use jde_schema::prelude::*;

use super::Dwa;

impl Panel for Dwa {
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
            area.robot(&Pose2D::ORIGIN);
            let Some(pose) = pose else { return };
            let path = self.track.poses().iter();
            area.line(path.map(|place| pose.localize(place))).ink(Ink::Goal);
            if let Some(end) = self.end {
                let end = pose.localize(&end);
                area.arrow((0.0, 0.0), (end.x, end.y)).ink(Ink::Accent).width(3.0);
            }
        });
    }
}
