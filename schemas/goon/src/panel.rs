//! The panel: the area that must be free, the target, the heading error and the reaction to it.

use jde_schema::prelude::*;

use super::{Band, Goon};

impl Panel for Goon {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let target = self.local_target(cx);
        match target {
            None => pen.text("No target, or no pose"),
            Some(target) => {
                let error = Pose2D::ORIGIN.bearing_to(&target);
                pen.value("target ahead", libm::hypot(target.x, target.y), "m");
                pen.value("heading error", error, "rad");
                pen.text(match self.band(cx, error) {
                    Band::Straight => "straight and fast",
                    Band::Veer => "slowly while turning",
                    Band::Turn => "turns on the spot",
                });
            }
        }
        let (side, ahead) = (self.half_width.get(cx), self.ahead.get(cx));
        let canvas = pen.canvas("area").forward_up();
        canvas.area((-1.0, -2.5), (4.0, 2.5)).show(|area| {
            area.rectangle((0.0, -side), (ahead, side))
                .ink(if self.is_free(cx) { Ink::Good } else { Ink::Bad })
                .width(2.0);
            if let Some(laser) = self.laser.get(cx) {
                area.points(laser.points()).ink(Ink::Seen).width(2.5);
            }
            if let Some(target) = target {
                for limit in [self.straight.get(cx), self.veer.get(cx)] {
                    for (sin, cos) in [libm::sincos(limit), libm::sincos(-limit)] {
                        area.line([(0.0, 0.0), (1.5 * cos, 1.5 * sin)]).ink(Ink::Faint);
                    }
                }
                area.arrow((0.0, 0.0), target).ink(Ink::Goal).width(2.0);
            }
            area.robot(&Pose2D::ORIGIN);
        });
    }
}
