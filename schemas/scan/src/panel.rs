//! The panel: what is around the robot, or why nobody knows.

use jde_schema::prelude::*;

use crate::merge::Merge;

impl Panel for Merge {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        match self.lacks() {
            Some(lacks) => pen.text(format!("No scan: {lacks}")),
            None => match self.silent() {
                0 => pen.text("All sensors measure"),
                silent => pen.text(format!("Sonars that measure nothing: {silent}")),
            },
        }
        let canvas = pen.canvas("around").forward_up();
        canvas.area((-3.0, -3.0), (3.0, 3.0)).show(|area| {
            area.points(self.points()).ink(Ink::Seen).width(2.5);
            area.robot(&Pose2D::ORIGIN);
        });
    }
}
