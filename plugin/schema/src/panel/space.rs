//! Scenes: drawings in space.

use jde_abi::raw;

use super::widget::Widget;
use super::{At, Mark};

/// A scene under construction. Set its options before [`show`](Self::show), which draws it.
#[must_use = "a scene is drawn by `show`"]
pub struct Scene<'p> {
    widget: Widget<'p>,
}

/// The inside of a scene, in metres: x ahead, y left, z up (REP-103). Angles are roll, pitch and yaw in rad,
/// applied about z first, then y, then x.
pub struct Space<'p> {
    pen: &'p raw::Pen,
}

impl<'p> Scene<'p> {
    pub(super) fn new(widget: Widget<'p>) -> Self {
        Self { widget }
    }

    /// Reports clicks to the schema.
    pub fn wants_clicks(self) -> Self {
        self.flag(raw::WANTS_CLICKS)
    }

    /// Reports drags to the schema. Otherwise a drag moves the view.
    pub fn wants_drags(self) -> Self {
        self.flag(raw::WANTS_DRAGS)
    }

    /// Reports keys to the schema while the scene has the focus.
    pub fn wants_keys(self) -> Self {
        self.flag(raw::WANTS_KEYS)
    }

    /// Draws the scene.
    pub fn show(self, inside: impl FnOnce(&mut Space)) {
        self.widget.around(|pen| inside(&mut Space { pen }));
    }

    fn flag(mut self, flag: u32) -> Self {
        self.widget.flag(flag, true);
        self
    }
}

impl Space<'_> {
    /// Draws a line through points, in their order.
    pub fn line(&mut self, points: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        self.mark(raw::SHAPE_LINE, points)
    }

    /// Draws points.
    pub fn points(&mut self, points: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        self.mark(raw::SHAPE_POINTS, points)
    }

    /// Draws an arrow.
    pub fn arrow(&mut self, from: impl At<3>, to: impl At<3>) -> Mark<'_> {
        self.mark(raw::SHAPE_ARROW, [from.at(), to.at()])
    }

    /// Draws a text that always faces the viewer.
    pub fn label(&mut self, at: impl At<3>, text: impl AsRef<str>) -> Mark<'_> {
        self.mark(raw::SHAPE_LABEL, [at]).text(text.as_ref())
    }

    /// Draws a box about its middle. `size` is its extent along its own x, y and z, in m.
    pub fn cuboid(&mut self, middle: impl At<3>, turned: [f64; 3], size: [f64; 3]) -> Mark<'_> {
        self.mark(raw::SHAPE_BOX, [middle]).turned(turned).extent(size)
    }

    /// Draws a sphere. The radius is in m.
    pub fn sphere(&mut self, center: impl At<3>, radius: f64) -> Mark<'_> {
        self.mark(raw::SHAPE_SPHERE, [center]).radius(radius)
    }

    /// Draws a cylinder along its own z, about its middle. The radius and the height are in m.
    pub fn cylinder(&mut self, middle: impl At<3>, turned: [f64; 3], radius: f64, height: f64) -> Mark<'_> {
        self.mark(raw::SHAPE_CYLINDER, [middle])
            .turned(turned)
            .radius(radius)
            .extent([0.0, 0.0, height])
    }

    /// Draws triangles with three corners each, counter-clockwise seen from outside.
    pub fn mesh(&mut self, corners: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        self.mark(raw::SHAPE_MESH, corners)
    }

    fn mark(&mut self, kind: u32, points: impl IntoIterator<Item = impl At<3>>) -> Mark<'_> {
        Mark::new(self.pen, kind, points)
    }
}
