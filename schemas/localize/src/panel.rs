//! The panel: the map, the particles, the scan at the estimated pose, and how sure it is. A click says where the robot is.

use jde_schema::prelude::*;

use super::Mcl;

/// Most points for the occupied cells. Of more points, an even selection is drawn.
const MOST_CELLS: usize = 20_000;
/// Most points for the particles.
const MOST_PARTICLES: usize = 1000;
/// How far from a click the robot is searched, m.
const SEARCH_RADIUS: f64 = 1.0;

impl Panel for Mcl {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.text(&self.words);
        let Some(localizer) = &self.localizer else { return };
        pen.row(|pen| {
            pen.value("particles", localizer.particles() as f64, "");
            pen.value("agreeing", 100.0 * localizer.agreement(), "%");
        });
        pen.canvas("map").wants_clicks().show(|area| {
            area.points(localizer.field().obstacles(MOST_CELLS))
                .ink(Ink::Plain)
                .width(2.0);
            area.points(localizer.places(MOST_PARTICLES))
                .ink(Ink::Accent)
                .width(2.0);
            let Some(pose) = self.last.and_then(|last| localizer.pose(&last)) else {
                return;
            };
            if let Some(laser) = self.laser.get(cx) {
                let sensor = pose.transform(&self.mounted(cx, &laser));
                let place = |point: LaserPoint| sensor.transform(&Pose2D::new(point.x, point.y, 0.0));
                area.points(laser.points().map(place)).ink(Ink::Seen).width(2.5);
            }
            area.robot(&pose);
        });
        pen.text("Click on the map where the robot is; its heading is searched there.");
        pen.button("anywhere", "Find me anywhere");
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let by = gesture.by();
        let Some(localizer) = &mut self.localizer else {
            return Ok(());
        };
        if let Some([x, y, _]) = gesture.clicked("map") {
            localizer.start_around((x, y), SEARCH_RADIUS);
            self.known = None;
            info!(cx, "{by} says that the robot is at {x:.2}, {y:.2}");
        } else if gesture.pressed("anywhere") {
            localizer.start_anywhere();
            self.known = None;
            info!(cx, "{by} lets the robot be searched on the whole map");
        }
        Ok(())
    }
}
