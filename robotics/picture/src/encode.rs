//! Images as JPEG and PNG.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use jde_types::Image;
use png::ColorType;

use crate::PictureError;

/// The quality of a JPEG, 1 to 100: few bytes, and no faults that one sees.
const QUALITY: u8 = 80;

/// How pictures are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// JPEG, with losses.
    Jpeg,
    /// PNG, without losses.
    Png,
}

/// What a pixel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Color {
    /// One byte, the brightness.
    Grey,
    /// Red, green and blue, a byte each.
    Rgb,
}

impl Color {
    const fn bytes(self) -> u32 {
        match self {
            Self::Grey => 1,
            Self::Rgb => 3,
        }
    }
}

impl Compression {
    /// Returns the compression of this name, "jpeg" or "png".
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Jpeg, Self::Png]
            .into_iter()
            .find(|known| known.name() == name)
    }

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Jpeg => "jpeg",
            Self::Png => "png",
        }
    }

    /// Returns an image of "rgb8", "bgr8" or "mono8" as a file. It takes milliseconds: the pictures of a robot's schema are
    /// best compressed by another thread.
    ///
    /// # Errors
    /// If its pixels are others, or some are missing.
    pub fn compress(self, image: &Image) -> Result<Vec<u8>, PictureError> {
        let (color, is_reversed) = match image.encoding.as_str() {
            "rgb8" => (Color::Rgb, false),
            "bgr8" => (Color::Rgb, true),
            "mono8" => (Color::Grey, false),
            other => return Err(PictureError::Pixels(other.to_owned())),
        };
        let missing = || PictureError::Broken("it has fewer pixels than its header states".to_owned());
        let bytes = image
            .width
            .checked_mul(color.bytes())
            .filter(|bytes| *bytes <= image.step);
        let (bytes, step) = (bytes.ok_or_else(missing)? as usize, image.step as usize);
        let rows = image.data.chunks_exact(step.max(1)).take(image.height as usize);
        let mut pixels = rows.flat_map(|row| &row[..bytes]).copied().collect::<Vec<u8>>();
        if is_reversed {
            pixels.chunks_exact_mut(3).for_each(<[u8]>::reverse);
        }
        self.encode((image.width, image.height), color, &pixels)
    }

    /// Returns pixels of a width and a height, row by row, as a file.
    ///
    /// # Errors
    /// If there are none, or not as many.
    pub fn encode(
        self,
        (width, height): (u32, u32),
        color: Color,
        pixels: &[u8],
    ) -> Result<Vec<u8>, PictureError> {
        let expected = u64::from(width) * u64::from(height) * u64::from(color.bytes());
        if expected == 0 || expected != pixels.len() as u64 {
            return Err(PictureError::Broken(
                "it has fewer pixels than its header states".to_owned(),
            ));
        }
        match self {
            Self::Jpeg => jpeg((width, height), color, pixels),
            Self::Png => png((width, height), color, pixels),
        }
    }
}

fn jpeg((width, height): (u32, u32), color: Color, pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    let mut file = Vec::new();
    let color = match color {
        Color::Grey => ExtendedColorType::L8,
        Color::Rgb => ExtendedColorType::Rgb8,
    };
    let written = JpegEncoder::new_with_quality(&mut file, QUALITY).encode(pixels, width, height, color);
    written.map_err(|error| PictureError::Broken(error.to_string()))?;
    Ok(file)
}

fn png((width, height): (u32, u32), color: Color, pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(match color {
        Color::Grey => ColorType::Grayscale,
        Color::Rgb => ColorType::Rgb,
    });
    encoder.set_compression(png::Compression::Fast);
    let broken = |error: png::EncodingError| PictureError::Broken(error.to_string());
    let mut writer = encoder.write_header().map_err(broken)?;
    writer.write_image_data(pixels).map_err(broken)?;
    writer.finish().map_err(broken)?;
    Ok(file)
}
