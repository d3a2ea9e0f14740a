//! A picture of a camera as numbers: resampled by the mean of each area, channel after channel.

use jde_types::Image;

use crate::file::Colours;

/// The part of brightness of red, green and blue (ITU-R BT.601), as OpenCV takes it.
const BRIGHTNESS: [f64; 3] = [0.299, 0.587, 0.114];

/// Writes a picture of this width and height, the rows of each channel from top to bottom: each pixel is the mean of the
/// area that it covers, from 0 to `white`. A grey picture has three equal channels.
///
/// # Errors
/// The picture has another encoding, or rows are missing.
pub(crate) fn pixels(
    image: &Image,
    (width, height): (usize, usize),
    colours: Colours,
    white: f64,
    to: &mut [f64],
) -> Result<(), String> {
    let (places, bytes) = match image.encoding.as_str() {
        "rgb8" => ([0, 1, 2], 3),
        "bgr8" => ([2, 1, 0], 3),
        "mono8" => ([0, 0, 0], 1),
        other => return Err(format!("its encoding is `{other}`, not rgb8, bgr8 or mono8")),
    };
    let (columns, rows) = (image.width as usize, image.height as usize);
    let (step, data) = (image.step as usize, image.data.as_slice());
    if columns == 0 || rows == 0 || step < columns * bytes || data.len() < step * (rows - 1) + columns * bytes
    {
        return Err("pixels of it are missing".to_owned());
    }
    let across: Vec<Vec<(usize, f64)>> = (0..width).map(|place| cover(place, width, columns)).collect();
    let plane = width * height;
    for y in 0..height {
        let down = cover(y, height, rows);
        for (x, across) in across.iter().enumerate() {
            let mut mean = [0.0; 3];
            for (row, share) in &down {
                for (column, part) in across {
                    let pixel = &data[row * step + column * bytes..];
                    for (mean, place) in mean.iter_mut().zip(places) {
                        *mean += share * part * f64::from(pixel[place]);
                    }
                }
            }
            let mean = mean.map(|mean| mean / 255.0 * white);
            let at = y * width + x;
            match colours {
                Colours::Grey => to[at] = mean.iter().zip(BRIGHTNESS).map(|(mean, part)| mean * part).sum(),
                Colours::Rgb => (0..3).for_each(|channel| to[channel * plane + at] = mean[channel]),
            }
        }
    }
    Ok(())
}

/// The pixels along one side that a pixel of the resampled picture covers, and the share of each; together 1.
fn cover(place: usize, count: usize, side: usize) -> Vec<(usize, f64)> {
    let scale = side as f64 / count as f64;
    let (from, until) = (place as f64 * scale, (place + 1) as f64 * scale);
    let last = (until.ceil() as usize).min(side);
    (from as usize..last)
        .map(|at| {
            let share = until.min((at + 1) as f64) - from.max(at as f64);
            (at, share / scale)
        })
        .filter(|(_, share)| *share > 0.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use jde_types::{Text, Value};

    use super::*;

    /// Two rows of four pixels: black, red, green and white above, and blue ones below.
    fn picture(encoding: &str) -> Box<Image> {
        let above = [[0, 0, 0], [255, 0, 0], [0, 255, 0], [255, 255, 255]];
        let mut image = Image::boxed();
        (image.width, image.height, image.step) = (4, 2, 13);
        image.encoding = Text::new(encoding);
        let row = |pixels: [[u8; 3]; 4]| [pixels.as_flattened(), &[7]].concat();
        let rows = [row(above), row([[0, 0, 255]; 4])].concat();
        image.data.extend_from_slice(&rows).expect("it fits");
        image
    }

    fn numbers(image: &Image, size: (usize, usize), colours: Colours) -> Vec<f64> {
        let channels = if colours == Colours::Rgb { 3 } else { 1 };
        let mut to = vec![f64::NAN; channels * size.0 * size.1];
        pixels(image, size, colours, 1.0, &mut to).expect("it is a picture");
        to.iter().map(|number| (number * 1e6).round() / 1e6).collect()
    }

    #[test]
    fn a_pixel_is_the_mean_of_its_area_channel_after_channel() {
        let rgb = picture("rgb8");
        let halves = numbers(&rgb, (2, 1), Colours::Rgb);
        assert_eq!(halves, [0.25, 0.25, 0.0, 0.5, 0.5, 0.75]);
        let bgr = numbers(&picture("bgr8"), (2, 1), Colours::Rgb);
        assert_eq!(bgr, [0.5, 0.75, 0.0, 0.5, 0.25, 0.25]);
        // A third of four pixels is one and a third of the next.
        let thirds = numbers(&rgb, (3, 2), Colours::Rgb);
        assert_eq!(thirds[..3], [0.25, 0.5, 0.75]);
        assert_eq!(
            numbers(&rgb, (4, 2), Colours::Grey)[..4],
            [0.0, 0.299, 0.587, 1.0]
        );
        // A larger picture repeats pixels.
        let larger = numbers(&rgb, (8, 2), Colours::Rgb);
        assert_eq!(larger[..8], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
        let mut white = [0.0];
        pixels(&rgb, (1, 1), Colours::Grey, 255.0, &mut white).expect("it is a picture");
        // The mean brightness is (0 + 0.299 + 0.587 + 1 + 4 * 0.114) / 8.
        assert!((white[0] - 255.0 * 2.342 / 8.0).abs() < 1e-9, "{white:?}");
    }

    #[test]
    fn a_picture_that_is_none_is_refused() {
        let words =
            |image: &Image| pixels(image, (1, 1), Colours::Grey, 1.0, &mut [0.0]).expect_err("it is none");
        assert_eq!(
            words(&picture("32FC1")),
            "its encoding is `32FC1`, not rgb8, bgr8 or mono8"
        );
        let mut short = picture("rgb8");
        short.height = 3;
        assert_eq!(words(&short), "pixels of it are missing");
        short.height = 0;
        assert_eq!(words(&short), "pixels of it are missing");
        let mut narrow = picture("rgb8");
        narrow.step = 11;
        assert_eq!(words(&narrow), "pixels of it are missing");
        assert_eq!(
            words(&Image::boxed()),
            "its encoding is ``, not rgb8, bgr8 or mono8"
        );
    }
}
