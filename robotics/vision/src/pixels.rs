//! The pixels of a colour image, as red, green and blue. It copies nothing.

use core::fmt;

use jde_types::Image;

/// The pixels of an image in "rgb8" or "bgr8".
#[derive(Clone, Copy, Debug)]
pub struct Pixels<'image> {
    data: &'image [u8],
    step: usize,
    size: [usize; 2],
    /// Whether the order is blue, green, red.
    reversed: bool,
}

/// Why the pixels of an image cannot be read: what it states, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownPixels(String);

impl fmt::Display for UnknownPixels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl core::error::Error for UnknownPixels {}

impl<'image> Pixels<'image> {
    /// Returns the pixels of an image.
    ///
    /// # Errors
    /// Another encoding, or fewer bytes than the stated size needs.
    pub fn of(image: &'image Image) -> Result<Self, UnknownPixels> {
        let reversed = match image.encoding.as_str() {
            "rgb8" => false,
            "bgr8" => true,
            other => {
                return Err(UnknownPixels(format!(
                    "the image is encoded as \"{other}\": expected \"rgb8\" or \"bgr8\"; bind a colour camera"
                )));
            }
        };
        let [width, height, step] = [image.width, image.height, image.step].map(|number| number as usize);
        let bytes = image.data.len();
        if step < 3 * width || step.checked_mul(height).is_none_or(|needed| bytes < needed) {
            return Err(UnknownPixels(format!(
                "the image states {width} x {height} pixels in rows of {step} bytes and has {bytes} bytes: expected three for \
                 each pixel"
            )));
        }
        Ok(Self {
            data: image.data.as_slice(),
            step,
            size: [width, height],
            reversed,
        })
    }

    /// Returns the columns and the rows.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns red, green and blue.
    ///
    /// # Panics
    /// A row or a column outside the image.
    #[must_use]
    pub fn at(&self, row: usize, column: usize) -> [u8; 3] {
        let from = row * self.step + 3 * column;
        let [a, b, c] = [self.data[from], self.data[from + 1], self.data[from + 2]];
        if self.reversed { [c, b, a] } else { [a, b, c] }
    }
}
