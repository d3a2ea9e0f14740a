//! Canvases and plots: what is drawn in a plane.

use jde_abi::raw;
use jde_types::Pose2D;

use super::widget::Widget;
use super::{At, Mark};

/// A canvas that is to be drawn: what is said of it comes before [`show`](Self::show).
#[must_use = "a canvas is drawn by `show`"]
pub struct Canvas<'p> {
    widget: Widget<'p>,
}

/// The inside of a canvas: metres, x to the right and y up, or x up and y to the left if it is `forward_up`. What comes later
/// covers what came before.
pub struct Plane<'p> {
    pen: &'p raw::Pen,
}

/// A plot that is to be drawn.
#[must_use = "a plot is drawn by `show`"]
pub struct Plot<'p> {
    widget: Widget<'p>,
}

/// The inside of a plot.
pub struct Curves<'p> {
    pen: &'p raw::Pen,
}

impl<'p> Canvas<'p> {
    pub(super) fn new(widget: Widget<'p>) -> Self {
        Self { widget }
    }

    /// Begins with this part in view, from its least to its greatest x and y; else with all that is drawn.
    pub fn area(mut self, least: impl At<2>, greatest: impl At<2>) -> Self {
        let ([left, lower], [right, upper]) = (least.at(), greatest.at());
        self.widget.table.area = [left, lower, right, upper];
        self
    }

    /// With x up and y to the left, as a robot that looks up the screen sees its own frame.
    pub fn forward_up(self) -> Self {
        self.flag(raw::FORWARD_UP)
    }

    /// Hands clicks back.
    pub fn wants_clicks(self) -> Self {
        self.flag(raw::WANTS_CLICKS)
    }

    /// Hands drags back; without it a drag moves the view.
    pub fn wants_drags(self) -> Self {
        self.flag(raw::WANTS_DRAGS)
    }

    /// Hands keys back while it has the focus.
    pub fn wants_keys(self) -> Self {
        self.flag(raw::WANTS_KEYS)
    }

    /// Draws it.
    pub fn show(self, inside: impl FnOnce(&mut Plane)) {
        self.widget.around(|pen| inside(&mut Plane { pen }));
    }

    fn flag(mut self, flag: u32) -> Self {
        self.widget.flag(flag, true);
        self
    }
}

impl Plane<'_> {
    /// A line through points in turn.
    pub fn line(&mut self, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.mark(raw::SHAPE_LINE, points)
    }

    /// A line through points in turn and back to the first.
    pub fn outline(&mut self, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.line(points).flag(raw::CLOSED)
    }

    /// The outline of a rectangle, between its least and its greatest x and y.
    pub fn rectangle(&mut self, least: impl At<2>, greatest: impl At<2>) -> Mark<'_> {
        let ([left, lower], [right, upper]) = (least.at(), greatest.at());
        self.outline([[left, lower], [right, lower], [right, upper], [left, upper]])
    }

    /// What is between the corners of a convex polygon, filled.
    pub fn polygon(&mut self, corners: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.mark(raw::SHAPE_POLYGON, corners)
    }

    /// Points.
    pub fn points(&mut self, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.mark(raw::SHAPE_POINTS, points)
    }

    /// A circle.
    pub fn circle(&mut self, center: impl At<2>, radius: f64) -> Mark<'_> {
        self.mark(raw::SHAPE_CIRCLE, [center]).radius(radius)
    }

    /// A circle, filled.
    pub fn disc(&mut self, center: impl At<2>, radius: f64) -> Mark<'_> {
        self.circle(center, radius).flag(raw::FILLED)
    }

    /// A line with a head.
    pub fn arrow(&mut self, from: impl At<2>, to: impl At<2>) -> Mark<'_> {
        self.mark(raw::SHAPE_ARROW, [from.at(), to.at()])
    }

    /// A text of constant size on the screen, whose left lower corner is there.
    pub fn label(&mut self, at: impl At<2>, text: impl AsRef<str>) -> Mark<'_> {
        self.mark(raw::SHAPE_LABEL, [at]).text(text.as_ref())
    }

    /// The outline of the robot that the application drives.
    pub fn robot(&mut self, pose: &Pose2D) {
        self.mark(raw::SHAPE_ROBOT, [pose]).turned([0.0, 0.0, pose.theta]);
    }

    fn mark(&mut self, kind: u32, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        Mark::new(self.pen, kind, points)
    }
}

impl<'p> Plot<'p> {
    pub(super) fn new(widget: Widget<'p>) -> Self {
        Self { widget }
    }

    /// What the axes show, across and up: `("time, s", "speed, m/s")`.
    pub fn axes(self, across: &str, up: &str) -> Self {
        Self {
            widget: self.widget.texts([across, up]),
        }
    }

    /// Draws it.
    pub fn show(self, inside: impl FnOnce(&mut Curves)) {
        self.widget.around(|pen| inside(&mut Curves { pen }));
    }
}

impl Curves<'_> {
    /// A curve with its name.
    pub fn curve(&mut self, name: impl AsRef<str>, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        Mark::new(self.pen, raw::SHAPE_LINE, points).text(name.as_ref())
    }
}
