//! The panel: the path, the cheapest sample and the trajectory that is driven, and what must not be touched.

use jde_schema::prelude::*;

use super::Mppi;

impl Panel for Mppi {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match self.reason() {
            Some(reason) => pen.text(reason),
            None => pen.value("left", self.track.left(), "m"),
        }
        let (Some(surroundings), Some(pose)) = (&self.surroundings, self.perception.pose.get(cx)) else {
            return;
        };
        let pose = pose.pose2d();
        let canvas = pen.canvas("around").forward_up();
        canvas.area((-2.0, -2.0), (4.0, 2.0)).show(|area| {
            area.points(surroundings.points().iter().map(|point| (point.x, point.y)))
                .ink(Ink::Seen)
                .width(2.5);
            area.line(self.track.poses().iter().map(|place| pose.localize(place)))
                .ink(Ink::Goal);
            let local = |place| pose.localize(&surroundings.to_odometry(place));
            if let (Some(controller), Some((base, start))) = (&self.controller, &self.planned) {
                area.line(controller.best(base, start).map(local)).ink(Ink::Faint);
                area.line(controller.found(base, start).map(local))
                    .ink(Ink::Accent)
                    .width(3.0);
            }
            area.robot(&Pose2D::ORIGIN);
        });
    }
}
