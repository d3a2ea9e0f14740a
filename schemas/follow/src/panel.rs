//! The panel: the persons, the way to go, and what the robot does. A click chooses a person.

use jde_schema::prelude::*;

use crate::{Person, State};

/// The radius of a person, and how near a click must be, m.
const RADIUS: f64 = 0.25;
const CLICK_RADIUS: f64 = 1.0;

impl Panel for Person {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.text(self.words());
        pen.canvas("around").wants_clicks().show(|area| {
            if let Some(persons) = self.persons.get(cx) {
                for person in &persons.persons {
                    let place = (person.position.x, person.position.y);
                    let is_own = person.id == self.following.id();
                    let ink = if is_own { Ink::Goal } else { Ink::Plain };
                    area.circle(place, RADIUS).ink(ink).width(2.0);
                    area.label((place.0, place.1 + RADIUS), person.id.to_string());
                }
            }
            let trail = self.following.trail().map(|point| (point.x, point.y));
            area.line(trail).ink(Ink::Good).width(2.0);
            if let Some(pose) = self.from {
                area.robot(&pose);
            }
        });
        pen.text("Click on a person to follow.");
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let (Some([x, y, _]), Some(persons)) = (gesture.clicked("around"), self.persons.get(cx)) else {
            return Ok(());
        };
        let away =
            |person: &&jde_schema::types::Person| libm::hypot(person.position.x - x, person.position.y - y);
        let nearest = persons.persons.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        if let Some(person) = nearest.filter(|person| away(person) < CLICK_RADIUS) {
            self.following.choose(person);
            self.state = State::Follows(0.0);
            info!(cx, "{} chooses person {}", gesture.by(), person.id);
        }
        Ok(())
    }
}
