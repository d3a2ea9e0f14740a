//! The panel of the father (the paper, figure 7): the field with the robot, the laser's points, the areas of
//! its children and the targets. A click on the field sets the target. The panel does not affect the
//! arbitration.

use jde_schema::prelude::*;

use super::{Example, TargetRequest};

impl Panel for Example {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.heading("Safe navigation");
        pen.text(self.status_text(cx));
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        pen.canvas("field").wants_clicks().show(|field| {
            let route = self.route.sample(cx);
            field.line(route.poses.as_slice()).ink(Ink::Faint);
            field.points(route.poses.as_slice()).ink(Ink::Faint).width(5.0);
            if let Some(pose) = pose {
                self.draw_around(cx, field, &pose);
            }
            if let Some(target) = self.target(cx) {
                // The circle within which the target counts as reached, and a cross.
                field.circle(target, self.tolerance.get(cx)).ink(Ink::Goal);
                let Pose2D { x, y, .. } = target;
                for (dx, dy) in [(0.2, 0.2), (0.2, -0.2)] {
                    field
                        .line([(x - dx, y - dy), (x + dx, y + dy)])
                        .ink(Ink::Goal)
                        .width(3.0);
                }
            }
        });
        pen.row(|pen| {
            pen.button("clear", "Clear target")
                .enabled(self.requested_target.is_some());
            pen.text("Click on the field to send the robot there first.");
        });
        let children = [
            ("brake", &self.brake),
            ("avoid", &self.avoid),
            ("cruise", &self.cruise),
        ];
        let rows = children.map(|(role, child)| [role.to_owned(), state(child, cx).to_owned()]);
        pen.table("children", ["child", "state"], rows);
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        if let Some([x, y, _]) = gesture.clicked("field") {
            info!(cx, "{} sends the robot to {x:.2}, {y:.2} first", gesture.by());
            self.requested_target = Some(TargetRequest {
                position: Pose2D::new(x, y, 0.0),
                by: gesture.by().to_owned(),
            });
        } else if gesture.pressed("clear") && self.requested_target.take().is_some() {
            info!(cx, "{} cleared the target; on along the route", gesture.by());
        }
        Ok(())
    }
}

impl Example {
    /// Describes the progress of the mission.
    fn status_text(&self, cx: &Context) -> String {
        let away = |target: Pose2D| match self.pose.get(cx) {
            Some(pose) => format!("{:.2} m away", pose.pose2d().distance_to(&target)),
            None => "at an unknown distance".to_owned(),
        };
        let of = match self.total(cx) {
            0 => String::new(),
            total => format!(" of {total}"),
        };
        match (&self.requested_target, self.next(cx)) {
            (Some(requested_target), _) => format!(
                "To the target of {}, {}",
                requested_target.by,
                away(requested_target.position)
            ),
            (None, Some(next)) => format!("To target {}{of}, {}", self.reached + 1, away(next)),
            (None, None) if self.reached > 0 => "All targets are reached".to_owned(),
            (None, None) => "No target".to_owned(),
        }
    }

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
