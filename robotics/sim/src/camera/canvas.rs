//! A picture with the depth of every pixel: near things hide far ones, in any order of drawing.
//!
//! This module handles pixels only, no shapes.

/// A picture in progress.
pub(super) struct Canvas<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Three bytes a pixel, by rows from the top.
    colors: &'a mut [u8],
    /// The inverse of the depth in metres, which is linear along a row of a flat face; 0 for an empty pixel.
    near: Vec<f32>,
}

impl<'a> Canvas<'a> {
    pub(super) fn new(width: usize, height: usize, colors: &'a mut [u8]) -> Self {
        debug_assert_eq!(colors.len(), 3 * width * height);
        Self {
            width,
            height,
            colors,
            near: vec![0.0; width * height],
        }
    }

    /// Returns the colours and inverse depths of the pixels from `left` until `right` of a row.
    pub(super) fn span(
        &mut self,
        row: usize,
        left: usize,
        right: usize,
    ) -> impl Iterator<Item = (&mut [u8; 3], &mut f32)> {
        let (from, to) = (row * self.width + left, row * self.width + right);
        let (colors, _) = self.colors[3 * from..3 * to].as_chunks_mut::<3>();
        colors.iter_mut().zip(&mut self.near[from..to])
    }

    /// Returns the inverse depths of all pixels, by rows from the top.
    pub(super) fn into_near(self) -> Vec<f32> {
        self.near
    }
}

/// Returns the range of pixels whose middles lie between two positions along a row or column of `count`
/// pixels.
pub(super) fn middles(from: f64, to: f64, count: usize) -> (usize, usize) {
    let bound = |place: f64| libm::ceil(place - 0.5).clamp(0.0, count as f64) as usize;
    let (first, end) = (bound(from), bound(to));
    (first, end.max(first))
}
