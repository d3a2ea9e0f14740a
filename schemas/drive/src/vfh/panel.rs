//! The panel: the points, the target, the free directions, and the one that is taken.

use jde_schema::prelude::*;

use super::{Steering, Vfh};

impl Panel for Vfh {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let reason = self.permit.as_ref().and_then(|permit| permit.obstacle());
        match (self.choice, reason) {
            (Steering::Missing, _) => pen.text("No target, pose, usable scan or dynamics of the base"),
            (Steering::Arrived, _) => pen.text("At the target"),
            (Steering::Enclosed, _) => pen.text("No direction is free"),
            (Steering::Toward(_), Some(reason)) => pen.text(&reason),
            (Steering::Toward(angle), None) => pen.value("direction", angle, "rad"),
        }
        let Some(body) = &self.body else { return };
        let pose = self.perception.pose.get(cx).map(|odometry| odometry.pose2d());
        let canvas = pen.canvas("around").forward_up();
        canvas.area((-2.0, -2.0), (4.0, 2.0)).show(|area| {
            area.points(body.points().iter().map(|point| (point.x, point.y)))
                .ink(Ink::Seen)
                .width(2.5);
            if let (Some(free), Some(pose)) = (&self.free, pose) {
                for direction in free.middles() {
                    let (sin, cos) = libm::sincos(direction - pose.theta);
                    area.line([(0.5 * cos, 0.5 * sin), (0.8 * cos, 0.8 * sin)])
                        .ink(Ink::Good);
                }
            }
            if let (Some(target), Some(pose)) = (self.target.get(cx).get(), pose) {
                area.circle(pose.localize(&target), 0.15).ink(Ink::Goal);
            }
            area.robot(&Pose2D::ORIGIN);
            if let Steering::Toward(angle) = self.choice {
                area.arrow((0.0, 0.0), (libm::cos(angle), libm::sin(angle)))
                    .ink(Ink::Accent)
                    .width(3.0);
            }
        });
    }
}
