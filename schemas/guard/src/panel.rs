//! The panel: what the laser sees, and the boundary of what is known to be free.

use jde_schema::prelude::*;
use jde_schema::types::Point2D;

use crate::footprint::Footprint;

impl Panel for Footprint {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match self.lacks() {
            Some(lacks) => pen.text(format!("Refuses everything: {lacks}")),
            None => pen.text("Judges"),
        }
        let place = |point: &Point2D| (point.x, point.y);
        let canvas = pen.canvas("around").forward_up();
        canvas.area((-3.0, -3.0), (3.0, 3.0)).show(|area| {
            area.points(self.remembered(cx).iter().map(place)).ink(Ink::Faint);
            area.points(self.seen().iter().map(place))
                .ink(Ink::Seen)
                .width(2.5);
            area.robot(&Pose2D::ORIGIN);
        });
    }
}
