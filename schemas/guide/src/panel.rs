//! The panel: the tasks, and a button for each room.

use jde_schema::prelude::*;

use super::Guide;

/// The prefix of the buttons of rooms.
const ROOM: &str = "room ";

impl Panel for Guide {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.heading("Guide");
        for (name, _, task) in self.tasks(cx) {
            let reason = task.reason().unwrap_or("not due");
            pen.text(format!("{name}: {reason}; done {}", task.done()));
        }
        if let Some(battery) = self.battery.get(cx) {
            pen.value("battery", 100.0 * f64::from(battery.percentage), "%");
        }
        let rooms = self.rooms.sample(cx);
        pen.row(|pen| {
            for room in &rooms.rooms {
                let name = room.name.as_str();
                pen.button(&format!("{ROOM}{name}"), format!("To the {name}"));
            }
        });
        pen.row(|pen| {
            pen.button("stop leading", "Stop leading")
                .enabled(self.leading.is_due());
            pen.button("stop following", "Stop following")
                .enabled(self.following.is_due());
        });
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let rooms = self.rooms.sample(cx);
        let mut names = rooms.rooms.iter().map(|room| room.name);
        if let Some(name) = names.find(|name| gesture.pressed(&format!("{ROOM}{}", name.as_str()))) {
            self.ask(cx, name.as_str(), gesture.by());
        } else if gesture.pressed("stop leading") {
            self.leading
                .end(cx, false, &format!("{} stopped it", gesture.by()));
        } else if gesture.pressed("stop following") {
            self.following
                .end(cx, false, &format!("{} stopped it", gesture.by()));
        }
        Ok(())
    }
}
