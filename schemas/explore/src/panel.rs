//! The panel: the map, its frontiers, the target, and the places that were given up.

use jde_grid::Occupancy;
use jde_schema::prelude::*;
use jde_schema::types::OccupancyGrid;

use super::Explore;
use super::survey::geometry;

/// Most points for the occupied cells, and for those of frontiers. Of more, only every so many are drawn.
const MOST_CELLS: usize = 20_000;

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
                area.points(occupied(&map)).ink(Ink::Plain).width(2.0);
            }
            for frontier in &self.surveyed.frontiers {
                let ink = if frontier.place.is_some() {
                    Ink::Accent
                } else {
                    Ink::Faint
                };
                let step = frontier.cells.len().div_ceil(MOST_CELLS).max(1);
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
            info!(cx, "{} has what was given up tried again", gesture.by());
        }
        Ok(())
    }
}

/// The centres of the occupied cells, in the frame of the map; none of a map that is wrong.
fn occupied(map: &OccupancyGrid) -> Vec<(f64, f64)> {
    let Ok(geometry) = geometry(map) else {
        return Vec::new();
    };
    let cells = map.data.iter().take(geometry.cells()).enumerate();
    let cells = cells.filter(|(_, number)| Occupancy::from_ros(**number) == Occupancy::Occupied);
    let step = cells.clone().count().div_ceil(MOST_CELLS).max(1);
    cells
        .step_by(step)
        .map(|(index, _)| geometry.center(geometry.cell(index)))
        .collect()
}
