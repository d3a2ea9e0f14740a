//! Canvases and plots: drawings in a plane.

use jde_abi::raw;
use jde_types::Pose2D;

use super::widget::Widget;
use super::{At, Mark};

/// A canvas under construction. Set its options before [`show`](Self::show), which draws it.
#[must_use = "a canvas is drawn by `show`"]
pub struct Canvas<'p> {
    widget: Widget<'p>,
}

/// The inside of a canvas, in metres: x to the right and y up, or x up and y to the left if it is
/// `forward_up`. Later shapes cover earlier ones.
pub struct Plane<'p> {
    pen: &'p raw::Pen,
}

/// A plot under construction. [`show`](Self::show) draws it.
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

    /// Shows this part at first, from its least to its greatest x and y. The default is all that is drawn.
    pub fn area(mut self, least: impl At<2>, greatest: impl At<2>) -> Self {
        let ([left, lower], [right, upper]) = (least.at(), greatest.at());
        self.widget.table.area = [left, lower, right, upper];
        self
    }

    /// Points x up and y to the left, which is the frame of a robot that faces up the screen.
    pub fn forward_up(self) -> Self {
        self.flag(raw::FORWARD_UP)
    }

    /// Reports clicks to the schema.
    pub fn wants_clicks(self) -> Self {
        self.flag(raw::WANTS_CLICKS)
    }

    /// Reports drags to the schema. Otherwise a drag moves the view.
    pub fn wants_drags(self) -> Self {
        self.flag(raw::WANTS_DRAGS)
    }

    /// Reports keys to the schema while the canvas has the focus.
    pub fn wants_keys(self) -> Self {
        self.flag(raw::WANTS_KEYS)
    }

    /// Draws the canvas.
    pub fn show(self, inside: impl FnOnce(&mut Plane)) {
        self.widget.around(|pen| inside(&mut Plane { pen }));
    }

    fn flag(mut self, flag: u32) -> Self {
        self.widget.flag(flag, true);
        self
    }
}

impl Plane<'_> {
    /// Draws a line through points, in their order.
    pub fn line(&mut self, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.mark(raw::SHAPE_LINE, points)
    }

    /// Draws a line through points, in their order, and back to the first.
    pub fn outline(&mut self, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.line(points).flag(raw::CLOSED)
    }

    /// Draws the outline of a rectangle, from its least to its greatest x and y.
    pub fn rectangle(&mut self, least: impl At<2>, greatest: impl At<2>) -> Mark<'_> {
        let ([left, lower], [right, upper]) = (least.at(), greatest.at());
        self.outline([[left, lower], [right, lower], [right, upper], [left, upper]])
    }

    /// Draws a filled convex polygon with these corners.
    pub fn polygon(&mut self, corners: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.mark(raw::SHAPE_POLYGON, corners)
    }

    /// Draws points.
    pub fn points(&mut self, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        self.mark(raw::SHAPE_POINTS, points)
    }

    /// Draws a circle. The radius is in m.
    pub fn circle(&mut self, center: impl At<2>, radius: f64) -> Mark<'_> {
        self.mark(raw::SHAPE_CIRCLE, [center]).radius(radius)
    }

    /// Draws a filled circle. The radius is in m.
    pub fn disc(&mut self, center: impl At<2>, radius: f64) -> Mark<'_> {
        self.circle(center, radius).flag(raw::FILLED)
    }

    /// Draws an arrow.
    pub fn arrow(&mut self, from: impl At<2>, to: impl At<2>) -> Mark<'_> {
        self.mark(raw::SHAPE_ARROW, [from.at(), to.at()])
    }

    /// Draws a text of constant size on the screen. Its lower left corner is at `at`.
    pub fn label(&mut self, at: impl At<2>, text: impl AsRef<str>) -> Mark<'_> {
        self.mark(raw::SHAPE_LABEL, [at]).text(text.as_ref())
    }

    /// Draws the outline of the robot that the application drives.
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

    /// Names the axes, horizontal and vertical: `("time, s", "speed, m/s")`.
    pub fn axes(self, across: &str, up: &str) -> Self {
        Self {
            widget: self.widget.texts([across, up]),
        }
    }

    /// Draws the plot.
    pub fn show(self, inside: impl FnOnce(&mut Curves)) {
        self.widget.around(|pen| inside(&mut Curves { pen }));
    }
}

impl Curves<'_> {
    /// Draws a curve with its name.
    pub fn curve(&mut self, name: impl AsRef<str>, points: impl IntoIterator<Item = impl At<2>>) -> Mark<'_> {
        Mark::new(self.pen, raw::SHAPE_LINE, points).text(name.as_ref())
    }
}
