//! The pixels of an image as panels have them: rows without gaps, red before blue.

use std::borrow::Cow;

use jde_types::Image;

/// Bytes of a pixel, and the pixels; no bytes for an encoding that panels do not show, or fewer than the image says it has: the
/// host then says what is wrong.
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
