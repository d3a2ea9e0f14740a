//! The panel: the scan, what looks like legs, and the persons with their numbers and velocities.

use jde_schema::prelude::*;

use crate::People;

/// The radius of a person, m.
const RADIUS: f64 = 0.25;

impl Panel for People {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        if let Some(trouble) = &self.trouble {
            pen.text(format!("No persons: {trouble}"));
            return;
        }
        let Some(base) = self.last else { return };
        let persons: Vec<_> = self.tracker.persons().collect();
        pen.canvas("around").show(|area| {
            if let Some(laser) = self.laser.get(cx) {
                let sensor = base.transform(&self.mount.get(cx));
                let place = |point: LaserPoint| sensor.transform(&Pose2D::new(point.x, point.y, 0.0));
                area.points(laser.points().map(place)).ink(Ink::Seen).width(2.0);
            }
            let legs = self.tracker.legs().filter(|(_, confidence)| *confidence >= 0.5);
            area.points(legs.map(|([x, y], _)| (x, y)))
                .ink(Ink::Accent)
                .width(4.0);
            for person in &persons {
                let [x, y] = person.position;
                let ink = if person.unseen > 0.0 {
                    Ink::Plain
                } else {
                    Ink::Good
                };
                area.circle((x, y), RADIUS).ink(ink).width(2.0);
                let [ahead, left] = person.velocity;
                area.arrow((x, y), (x + ahead, y + left)).ink(ink);
                area.label((x, y + RADIUS), person.id.to_string());
            }
            area.robot(&base);
        });
        let rows = persons.iter().map(|person| {
            let [x, y] = person.position;
            let [ahead, left] = person.velocity;
            [
                person.id.to_string(),
                format!("{x:.2}, {y:.2}"),
                format!("{:.2}", libm::hypot(ahead, left)),
                format!("{:.2}", person.confidence),
                format!("{:.1}", person.unseen),
            ]
        });
        pen.table(
            "persons",
            ["person", "place, m", "speed, m/s", "confidence", "unseen, s"],
            rows,
        );
    }
}
