//! Shapes that are passed to the host.

use core::ptr;
use std::ffi::CString;

use jde_abi::raw;
use jde_panel::{Color, Ink};

use super::At;
use super::widget::c;

/// A shape under construction. It is drawn at the end of the expression that builds it:
/// `plane.line(points).ink(Ink::Goal);`.
pub struct Mark<'p> {
    pen: &'p raw::Pen,
    numbers: Vec<f64>,
    text: CString,
    /// Everything except the points and the text.
    pub(super) table: raw::Shape,
}

impl<'p> Mark<'p> {
    pub(super) fn new<const N: usize>(
        pen: &'p raw::Pen,
        kind: u32,
        points: impl IntoIterator<Item = impl At<N>>,
    ) -> Self {
        let numbers: Vec<f64> = points.into_iter().flat_map(|point| point.at()).collect();
        Self {
            pen,
            table: raw::Shape {
                size: size_of::<raw::Shape>() as u32,
                kind,
                points: ptr::null(),
                point_count: u32::try_from(numbers.len() / N).unwrap_or(u32::MAX),
                color: raw::INK_PLAIN,
                width: 0.0,
                radius: 0.0,
                extent: [0.0; 3],
                turned: [0.0; 3],
                text: ptr::null(),
                flags: 0,
                reserved: 0,
            },
            numbers,
            text: CString::default(),
        }
    }

    /// Sets a color that fits the viewer's theme.
    pub fn ink(self, ink: Ink) -> Self {
        self.color(Color::Ink(ink))
    }

    /// Sets any color.
    pub fn color(mut self, color: Color) -> Self {
        self.table.color = color.code();
        self
    }

    /// Sets the line width, or the diameter of points, in points of the screen.
    pub fn width(mut self, width: f64) -> Self {
        self.table.width = width;
        self
    }

    pub(super) fn text(mut self, text: &str) -> Self {
        self.text = c(text);
        self
    }

    pub(super) fn radius(mut self, radius: f64) -> Self {
        self.table.radius = radius;
        self
    }

    pub(super) fn turned(mut self, turned: [f64; 3]) -> Self {
        self.table.turned = turned;
        self
    }

    pub(super) fn extent(mut self, extent: [f64; 3]) -> Self {
        self.table.extent = extent;
        self
    }

    pub(super) fn flag(mut self, flag: u32) -> Self {
        self.table.flags |= flag;
        self
    }
}

impl Drop for Mark<'_> {
    fn drop(&mut self) {
        self.table.points = self.numbers.as_ptr();
        self.table.text = self.text.as_ptr();
        // SAFETY: the host's pen, which lives as long as the call that `self` cannot outlive. The table and
        // all it points to live until the function returns.
        unsafe { (self.pen.shape)(self.pen.drawing, &raw const self.table) };
    }
}
