//! The pixels of an image in the layout of panels: rows without gaps, red before blue.

use std::borrow::Cow;

use jde_types::Image;

/// Returns the bytes of each pixel, and the pixels.
///
/// Returns 0 and no pixels for an encoding that panels do not show, or if there is less data than the image
/// states. The host then reports the mistake.
pub(super) fn of(image: &Image) -> (u32, Cow<'_, [u8]>) {
    let (channels, swapped) = match image.encoding.as_str() {
        "mono8" | "8UC1" => (1, false),
        "rgb8" | "8UC3" => (3, false),
        "bgr8" => (3, true),
        "rgba8" => (4, false),
        "bgra8" => (4, true),
        _ => return (0, Cow::Borrowed(&[])),
    };
    let row = image.width as usize * channels;
    let (step, rows) = (image.step as usize, image.height as usize);
    let data = image.data.as_slice();
    let enough = step.checked_mul(rows).is_some_and(|all| all <= data.len());
    if row == 0 || step < row || !enough {
        return (0, Cow::Borrowed(&[]));
    }
    if step == row && !swapped {
        return (channels as u32, Cow::Borrowed(&data[..row * rows]));
    }
    let mut pixels = Vec::with_capacity(row * rows);
    for padded in data.chunks_exact(step).take(rows) {
        pixels.extend_from_slice(&padded[..row]);
    }
    if swapped {
        pixels
            .chunks_exact_mut(channels)
            .for_each(|pixel| pixel.swap(0, 2));
    }
    (channels as u32, Cow::Owned(pixels))
}

#[cfg(test)]
mod tests {
    use jde_types::{Text, TooLong};

    use super::*;

    /// Converts 2 by 2 pixels with rows of `step` bytes, and passes the result to `check`. An image is too large
    /// for the stack of a test.
    fn of_image<R>(
        encoding: &str,
        step: u32,
        data: &[u8],
        check: impl FnOnce((u32, &[u8])) -> R,
    ) -> Result<R, TooLong> {
        let mut image: Vec<Image> = Vec::with_capacity(1);
        // SAFETY: every pattern of bits is a valid value.
        unsafe {
            image.as_mut_ptr().write_bytes(0, 1);
            image.set_len(1);
        }
        let image = &mut image[0];
        (image.width, image.height, image.step) = (2, 2, step);
        image.encoding = Text::truncated(encoding);
        image.data.extend_from_slice(data)?;
        let (channels, pixels) = of(image);
        Ok(check((channels, &pixels)))
    }

    #[track_caller]
    fn check(encoding: &str, step: u32, data: &[u8], channels: u32, pixels: &[u8]) {
        let converted = of_image(encoding, step, data, |actual| {
            assert_eq!(actual, (channels, pixels), "{encoding}")
        });
        converted.expect("it fits");
    }

    #[test]
    fn conversion_removes_row_padding_and_puts_red_before_blue() {
        check("mono8", 2, &[1, 2, 3, 4], 1, &[1, 2, 3, 4]);
        check("mono8", 3, &[1, 2, 0, 3, 4, 0], 1, &[1, 2, 3, 4]);
        let colors = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
        check("rgb8", 6, &colors, 3, &colors);
        check("bgr8", 6, &colors, 3, &[3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10]);
        let more: Vec<u8> = (0..16).collect();
        check("rgba8", 8, &more, 4, &more);
        let swapped: Vec<u8> = more
            .chunks(4)
            .flat_map(|pixel| [pixel[2], pixel[1], pixel[0], pixel[3]])
            .collect();
        check("bgra8", 8, &more, 4, &swapped);
    }

    #[test]
    fn an_invalid_or_unknown_image_has_no_pixels() {
        check("yuv422", 4, &[0; 8], 0, &[]);
        check("mono8", 1, &[0; 2], 0, &[]);
        check("mono8", 2, &[0; 3], 0, &[]);
        check("rgb8", u32::MAX, &[0; 12], 0, &[]);
        check("", 2, &[0; 4], 0, &[]);
    }
}
