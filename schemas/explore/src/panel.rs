//! The panel: the map, its frontiers, the target, and the places that were given up.

use jde_schema::prelude::*;

use super::Explore;

/// Most points for the occupied cells, and for those of all frontiers. Of more points, an even selection is drawn.
const MOST_POINTS: usize = 20_000;

impl Panel for Explore {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.heading("Exploration");
        pen.text(&self.words);
        pen.row(|pen| {
            pen.value("known to be free", self.surveyed.area, "m2");
            pen.value("frontiers seen", f64::from(self.seen), "");
        });
        pen.canvas("map").show(|area| {
            if let Some(map) = self.map.get(cx) {
                area.points(map.occupied(MOST_POINTS)).ink(Ink::Plain).width(2.0);
            }
            let frontiers = &self.surveyed.frontiers;
            let cells: usize = frontiers.iter().map(|frontier| frontier.cells.len()).sum();
            let step = cells.div_ceil(MOST_POINTS).max(1);
            for frontier in frontiers {
                let ink = if frontier.place.is_some() {
                    Ink::Accent
                } else {
                    Ink::Faint
                };
                area.points(frontier.cells.iter().copied().step_by(step))
                    .ink(ink)
                    .width(3.0);
            }
            for past in &self.given_up {
                area.circle(past.place, self.apart.get(cx)).ink(Ink::Bad);
            }
            if let Some(aim) = self.aim {
                area.circle(aim.target, 0.15).ink(Ink::Goal);
            }
            if let Some(pose) = self.robot(cx) {
                area.robot(&pose);
            }
        });
        for (x, y, reason) in self.places_left_out() {
            pen.text(format!("{x:.2}, {y:.2}: {reason}"));
        }
        pen.button("again", "Try again what was given up")
            .enabled(!self.given_up.is_empty());
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        if gesture.pressed("again") {
            self.given_up.clear();
            self.last = None;
            info!(cx, "{} has what was given up tried again", gesture.by());
        }
        Ok(())
    }
}
