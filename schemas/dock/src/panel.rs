//! The panel: the mark, the line before it, and the base.

use jde_schema::prelude::*;

use crate::{Dock, astray};

impl Panel for Dock {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let Some((_, local)) = self.step else {
            pen.text(self.waiting(cx));
            return;
        };
        let distance = self.distance.get(cx);
        pen.value("distance to go", local.x - distance, "m");
        pen.value("beside the line", local.y, "m");
        pen.value("heading", astray(&local), "rad");
        let canvas = pen.canvas("field").forward_up();
        canvas.area((-0.2, -1.5), (2.8, 1.5)).show(|field| {
            field.line([(0.0, -0.2), (0.0, 0.2)]).width(3.0);
            field.line([(0.0, 0.0), (2.8, 0.0)]).ink(Ink::Faint);
            field.circle((distance, 0.0), 0.02).ink(Ink::Good);
            field.robot(&local);
        });
    }
}
