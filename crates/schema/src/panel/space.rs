//! Scenes: what is drawn in space.

use jde_abi::raw;

use super::widget::Widget;
use super::{At, Mark};

/// A scene that is to be drawn: what is said of it comes before [`show`](Self::show).
#[must_use = "a scene is drawn by `show`"]
pub struct Scene<'p> {
    widget: Widget<'p>,
}

/// The inside of a scene: metres, x ahead, y left, z up (REP-103). Angles are roll, pitch and yaw, rad: about z first, then y,
/// then x.
pub struct Space<'p> {
    pen: &'p raw::Pen,
}

impl<'p> Scene<'p> {
    pub(super) fn new(widget: Widget<'p>) -> Self {
        Self { widget }
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
    pub fn show(self, inside: impl FnOnce(&mut Space)) {
        self.widget.around(|pen| inside(&mut Space { pen }));
    }

    fn flag(mut self, flag: u32) -> Self {
        self.widget.flag(flag, true);
        self
    }
}

impl Space<'_> {
    /// A line through points in turn.
    pub fn line(&mut self, points: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        self.mark(raw::SHAPE_LINE, points)
    }

    /// Points.
    pub fn points(&mut self, points: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        self.mark(raw::SHAPE_POINTS, points)
    }

    /// A line with a head.
    pub fn arrow(&mut self, from: impl At<3>, to: impl At<3>) -> Mark<'_> {
        self.mark(raw::SHAPE_ARROW, [from.at(), to.at()])
    }

    /// A text that faces whoever looks.
    pub fn label(&mut self, at: impl At<3>, text: impl AsRef<str>) -> Mark<'_> {
        self.mark(raw::SHAPE_LABEL, [at]).text(text.as_ref())
    }

    /// A box about its middle, so long along its x, y and z.
    pub fn cuboid(&mut self, middle: impl At<3>, turned: [f64; 3], size: [f64; 3]) -> Mark<'_> {
        self.mark(raw::SHAPE_BOX, [middle]).turned(turned).extent(size)
    }

    /// A sphere.
    pub fn sphere(&mut self, center: impl At<3>, radius: f64) -> Mark<'_> {
        self.mark(raw::SHAPE_SPHERE, [center]).radius(radius)
    }

    /// A cylinder along its z, about its middle.
    pub fn cylinder(&mut self, middle: impl At<3>, turned: [f64; 3], radius: f64, height: f64) -> Mark<'_> {
        self.mark(raw::SHAPE_CYLINDER, [middle])
            .turned(turned)
            .radius(radius)
            .extent([0.0, 0.0, height])
    }

    /// Triangles, three corners each, counter-clockwise from outside.
    pub fn mesh(&mut self, corners: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        self.mark(raw::SHAPE_MESH, corners)
    }

    fn mark(&mut self, kind: u32, points: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        Mark::new(self.pen, kind, points)
    }
}
