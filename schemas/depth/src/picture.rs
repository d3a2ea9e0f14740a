//! The depths of a picture, pixel by pixel.

use jde_schema::prelude::*;

/// The pixels of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Depths<'image> {
    image: &'image Image,
    /// Whether they are whole millimetres.
    is_whole: bool,
}

impl<'image> Depths<'image> {
    /// Returns the depths of a picture.
    ///
    /// # Errors
    /// It has another encoding, or bytes are missing.
    pub(crate) fn of(image: &'image Image) -> Result<Self, String> {
        let is_whole = match image.encoding.as_str() {
            "32FC1" => false,
            "16UC1" => true,
            other => return Err(format!("the picture is `{other}`: expected 32FC1 or 16UC1")),
        };
        let depths = Self { image, is_whole };
        let (row, rows) = (image.step as usize, image.height as usize);
        let needed = (image.width as usize).checked_mul(depths.bytes());
        let is_there = rows
            .checked_mul(row)
            .is_some_and(|bytes| bytes <= image.data.len());
        if image.width == 0 || rows == 0 || !is_there || needed.is_none_or(|needed| needed > row) {
            return Err("the bytes of the picture do not fit its size".to_owned());
        }
        Ok(depths)
    }

    /// Returns columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.image.width, self.image.height].map(|pixels| pixels as usize)
    }

    /// Returns each depth, m, row by row; `None` of a pixel that is not measured, where nothing is in range, or where
    /// something is too near (REP-118).
    pub(crate) fn iter(&self) -> impl Iterator<Item = Option<f64>> + 'image {
        let Self { image, is_whole } = *self;
        let (bytes, columns) = (self.bytes(), image.width as usize);
        let is_big = image.is_bigendian != 0;
        let depth = move |pixel: &[u8]| {
            let mut number = [0; 4];
            number[..bytes].copy_from_slice(pixel);
            if is_big {
                number[..bytes].reverse();
            }
            let depth = if is_whole {
                f64::from(u32::from_le_bytes(number)) / 1000.0
            } else {
                f64::from(f32::from_le_bytes(number))
            };
            (depth.is_finite() && depth > 0.0).then_some(depth)
        };
        let rows = image
            .data
            .chunks_exact(image.step as usize)
            .take(image.height as usize);
        rows.flat_map(move |row| row[..columns * bytes].chunks_exact(bytes).map(depth))
    }

    const fn bytes(&self) -> usize {
        if self.is_whole { 2 } else { 4 }
    }
}
