//! The panel of the father (the paper, figure 7): the field with the robot, the laser's points, the areas of
//! its children and the targets. A click on the field sets the target. The panel does not affect the
//! arbitration.

use jde_schema::prelude::*;

use super::Example;

impl Panel for Example {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.heading("Safe navigation");
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        let terms = self.terms(cx);
        pen.text(self.targets.status_text(&terms, pose));
        pen.canvas("field").wants_clicks().show(|field| {
            self.targets.draw_route(&terms, field);
            if let Some(pose) = pose {
                self.draw_around(cx, field, &pose);
            }
            self.targets.draw_target(&terms, field);
        });
        self.targets.draw_clear(pen);
        let children = [
            ("brake", &self.brake),
            ("avoid", &self.avoid),
            ("cruise", &self.cruise),
        ];
        let rows = children.map(|(role, child)| [role.to_owned(), state(child, cx).to_owned()]);
        pen.table("children", ["child", "state"], rows);
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        self.targets.touched(cx, gesture);
        Ok(())
    }
}

impl Example {
    /// Draws the robot, the laser's points and those of the two areas that are known. The scanner is assumed
    /// to be in the middle of the robot, as in the schemas that use it.
    fn draw_around(&self, cx: &Context, field: &mut jde_schema::panel::Plane, pose: &Pose2D) {
        let to_field = |x, y| pose.transform(&Pose2D::new(x, y, 0.0));
        let area = |ahead: &Import<f64>, half_width: &Import<f64>| {
            let (ahead, side) = (*ahead.get(cx)?.value(), *half_width.get(cx)?.value());
            Some([(0.0, -side), (ahead, -side), (ahead, side), (0.0, side)].map(|(x, y)| to_field(x, y)))
        };
        if let Some(area) = area(&self.avoid_ahead, &self.avoid_half_width) {
            field.outline(area).ink(Ink::Warn);
        }
        if let Some(area) = area(&self.brake_ahead, &self.brake_half_width) {
            field.outline(area).ink(Ink::Bad);
        }
        if let Some(laser) = self.laser.get(cx) {
            let points = laser.points().map(|point| to_field(point.x, point.y));
            field.points(points).ink(Ink::Seen).width(2.5);
        }
        field.robot(pose);
    }
}

fn state(child: &Child, cx: &Context) -> &'static str {
    match child.status(cx) {
        None => "not there",
        Some(status) if status.faulted => "faulted",
        Some(status) => match status.state {
            State::Slept => "slept",
            State::Checking => "checking",
            State::Ready => "ready",
            State::Winner => "winner",
        },
    }
}
