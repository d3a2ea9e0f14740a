//! The noise of the pixels of a camera.

use crate::random::Noise;

/// The standard deviation of the sum of five uniform bytes: √(5 · (256² - 1) / 12).
const DEVIATION: f64 = 165.246;
/// The mean of that sum.
const MEAN: i32 = 5 * 255 / 2;

/// Adds noise of a standard deviation to each part of each colour. It is the sum of five uniform draws, which is normal but
/// for its tails beyond 3.8 deviations.
pub(crate) fn add_noise(picture: &mut [u8], deviation: f64, noise: &Noise) {
    let (pixels, _) = picture.as_chunks_mut::<3>();
    for (index, pixel) in (0..).zip(pixels) {
        let draws = noise.bytes(index);
        for (part, draws) in pixel.iter_mut().zip(draws.chunks(5)) {
            let sum: i32 = draws.iter().map(|draw| i32::from(*draw)).sum();
            let error = f64::from(sum - MEAN) * (deviation / DEVIATION);
            *part = (f64::from(*part) + error + 0.5).clamp(0.0, 255.0) as u8;
        }
    }
}
