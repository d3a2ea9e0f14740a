//! The panel: the floor that is covered, the obstacles of the map, the path, and what was left out.

use jde_schema::prelude::*;

use super::Cover;
use super::held::Held;

/// Most points for the covered and for the occupied cells. Of more points, an even selection is drawn.
const MOST_CELLS: usize = 20_000;

impl Panel for Cover {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.heading("Coverage");
        pen.text(&self.words);
        pen.row(|pen| {
            pen.value("covered", self.areas.0, "m2");
            pen.value("strokes", f64::from(self.strokes), "");
        });
        pen.canvas("map").show(|area| {
            if let Some(marks) = &self.marks {
                area.points(marks.covered.places(MOST_CELLS))
                    .ink(Ink::Seen)
                    .width(3.0);
            }
            if let Some(map) = self.map.get(cx) {
                area.points(map.occupied(MOST_CELLS)).ink(Ink::Plain).width(2.0);
            }
            if let Some(stroke) = &self.stroke {
                area.line(stroke.points().iter().copied())
                    .ink(Ink::Good)
                    .width(2.0);
            }
            for &place in &self.left_out {
                area.circle(place, self.operation_width.get(cx)).ink(Ink::Bad);
            }
            if let Some(pose) = self.robot(cx) {
                area.robot(&pose);
            }
        });
        for (x, y) in &self.left_out {
            pen.text(format!("{x:.2}, {y:.2}: the robot came no nearer"));
        }
        pen.row(|pen| {
            pen.button("again", "Try again what was left out")
                .enabled(!self.left_out.is_empty() || self.held.is_held());
            pen.button("anew", "Cover all anew").enabled(self.marks.is_some());
        });
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let by = gesture.by();
        if gesture.pressed("again") {
            (self.left_out, self.held) = (Vec::new(), Held::default());
            (self.exhausted, self.has_retried) = (None, false);
            if let Some(marks) = &mut self.marks {
                marks.driven.clear();
            }
            info!(cx, "{by} has what was left out tried again");
        } else if gesture.pressed("anew") {
            (self.left_out, self.held) = (Vec::new(), Held::default());
            (self.marks, self.stroke, self.exhausted) = (None, None, None);
            (self.strokes, self.has_retried) = (0, false);
            info!(cx, "{by} has all covered anew");
        }
        Ok(())
    }
}
