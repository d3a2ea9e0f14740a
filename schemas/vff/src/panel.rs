//! The panel: the area, the target, and the forces that the base follows.

use jde_schema::prelude::*;

use super::Vff;

/// Metres on the canvas for a force of 1.
const SCALE: f64 = 1.5;

impl Panel for Vff {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let forces = self.forces(cx);
        match self.heading(cx) {
            None => pen.text("No target, no pose or no scan"),
            Some(error) => pen.value("heading error", error, "rad"),
        }
        if let Some(forces) = forces {
            let strength = |(x, y): (f64, f64)| libm::hypot(x, y);
            pen.row(|pen| {
                pen.value("attraction", strength(forces.pull), "");
                pen.value("repulsion", strength(forces.push), "");
                pen.value("together", strength(forces.sum()), "");
            });
        }
        let (side, ahead) = (self.half_width.get(cx), self.ahead.get(cx));
        let margin = self.checked_margin;
        let canvas = pen.canvas("area").forward_up();
        canvas.area((-1.0, -2.5), (4.0, 2.5)).show(|area| {
            area.rectangle((0.0, -side - margin), (ahead + margin, side + margin))
                .ink(if self.obstacle { Ink::Warn } else { Ink::Good })
                .width(2.0);
            if let Some(laser) = self.laser.get(cx) {
                area.points(laser.points()).ink(Ink::Seen).width(2.5);
            }
            if let Some(target) = self.local_target(cx) {
                area.circle(target, 0.15).ink(Ink::Goal);
            }
            area.robot(&Pose2D::ORIGIN);
            if let Some(forces) = forces {
                for (name, (x, y), ink) in [
                    ("attraction", forces.pull, Ink::Goal),
                    ("repulsion", forces.push, Ink::Bad),
                    ("together", forces.sum(), Ink::Accent),
                ] {
                    let tip = (SCALE * x, SCALE * y);
                    area.arrow((0.0, 0.0), tip).ink(ink).width(3.0);
                    area.label(tip, name).ink(ink);
                }
            }
        });
    }
}
