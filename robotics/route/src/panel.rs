//! The targets on a panel: words, marks on a field, and the gestures that set and clear a target.

use jde_schema::panel::Plane;
use jde_schema::prelude::*;

use super::{Targets, Terms};

impl Targets {
    /// Describes the progress in words.
    #[must_use]
    pub fn status_text(&self, terms: &Terms<'_>, pose: Option<Pose2D>) -> String {
        let distance = |target: Pose2D| match pose {
            Some(pose) => format!("{:.2} m away", pose.distance_to(&target)),
            None => "at an unknown distance".to_owned(),
        };
        let of = match Self::total(terms) {
            0 => String::new(),
            total => format!(" of {total}"),
        };
        match (&self.request, self.next(terms)) {
            (Some(request), _) => format!(
                "To the target of {}, {}",
                request.operator,
                distance(request.position)
            ),
            (None, Some(next)) => format!("To target {}{of}, {}", self.reached + 1, distance(next)),
            (None, None) if self.reached > 0 => "All targets are reached".to_owned(),
            (None, None) => "No target".to_owned(),
        }
    }

    /// Draws the route.
    pub fn draw_route(&self, terms: &Terms<'_>, field: &mut Plane) {
        field.line(terms.route.poses.as_slice()).ink(Ink::Faint);
        field
            .points(terms.route.poses.as_slice())
            .ink(Ink::Faint)
            .width(5.0);
    }

    /// Draws the current target: the circle within which it counts as reached, and a cross.
    pub fn draw_target(&self, terms: &Terms<'_>, field: &mut Plane) {
        if let Some(target) = self.current(terms) {
            field.circle(target, terms.tolerance).ink(Ink::Goal);
            let Pose2D { x, y, .. } = target;
            for (dx, dy) in [(0.2, 0.2), (0.2, -0.2)] {
                field
                    .line([(x - dx, y - dy), (x + dx, y + dy)])
                    .ink(Ink::Goal)
                    .width(3.0);
            }
        }
    }

    /// Draws the button that clears the target of an operator.
    pub fn draw_clear(&self, pen: &mut Pen) {
        pen.row(|pen| {
            pen.button("clear", "Clear target")
                .enabled(self.request.is_some());
            pen.text("Click on the field to send the robot there first.");
        });
    }

    /// Handles a click on the canvas `field`, and the button that [`Self::draw_clear`] draws.
    pub fn touched(&mut self, cx: &Context, gesture: &Gesture) {
        if let Some([x, y, _]) = gesture.clicked("field") {
            info!(cx, "{} sends the robot to {x:.2}, {y:.2} first", gesture.by());
            self.request(Pose2D::new(x, y, 0.0), gesture.by());
        } else if gesture.pressed("clear") && self.request.take().is_some() {
            info!(cx, "{} cleared the target; on along the route", gesture.by());
        }
    }
}
