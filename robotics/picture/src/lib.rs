//! Pictures as JPEG and PNG: decoded from the contents of files, cameras and messages, and encoded. It opens no files.

mod encode;
mod jpeg;

use std::io::Cursor;

use jde_types::{Image, Text};
use png::{ColorType, Decoder, Transformations};

pub use encode::{Color, Compression};
pub use jpeg::jpeg;

/// Most pixels, by the capacity of the exported type.
const MAX_PIXELS: u64 = 640 * 480;

/// A picture: rows from the top, pixels from the left, in red, green, blue.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Three bytes for each pixel.
    pub rgb: Vec<u8>,
}

/// The reason why data is not a usable picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// It has more pixels than fit, or none.
    #[error(
        "it is {width} x {height} pixels, and at most 640 x 480 fit, or as many in another shape: make it smaller"
    )]
    TooLarge {
        /// Its columns.
        width: u64,
        /// Its rows.
        height: u64,
    },
    /// It has another format.
    #[error("it is neither a PNG nor a JPEG")]
    Kind,
    /// Its pixels have an encoding that is not compressed.
    #[error("its pixels are \"{0}\", and those of \"rgb8\", \"bgr8\" and \"mono8\" are compressed")]
    Pixels(String),
    /// Something else is wrong.
    #[error("{0}")]
    Broken(String),
}

/// Checks that a picture of this size fits.
///
/// # Errors
/// [`PictureError::TooLarge`].
pub fn check_size(width: u64, height: u64) -> Result<(), PictureError> {
    match width.checked_mul(height) {
        Some(1..=MAX_PIXELS) => Ok(()),
        _ => Err(PictureError::TooLarge { width, height }),
    }
}

impl Picture {
    /// Decodes a PNG or a JPEG, detected by its contents.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn read(bytes: &[u8]) -> Result<Self, PictureError> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => png(bytes),
            [0xff, 0xd8, ..] => jpeg(bytes),
            _ => Err(PictureError::Kind),
        }
    }

    /// Copies the picture into an image, except for the header.
    ///
    /// # Errors
    /// [`PictureError::TooLarge`].
    pub fn write_to(&self, image: &mut Image) -> Result<(), PictureError> {
        check_size(self.width.into(), self.height.into())?;
        image.width = self.width;
        image.height = self.height;
        image.encoding = Text::new("rgb8");
        image.is_bigendian = 0;
        image.step = self.width * 3;
        let room = image.data.resize(self.rgb.len());
        room.copy_from_slice(&self.rgb[..room.len()]);
        Ok(())
    }
}

impl core::fmt::Debug for Picture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Picture({} x {})", self.width, self.height)
    }
}

fn png(bytes: &[u8]) -> Result<Picture, PictureError> {
    let broken = |error: png::DecodingError| PictureError::Broken(error.to_string());
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = reader.info().size();
    check_size(width.into(), height.into())?;
    let mut pixels = vec![0; reader.output_buffer_size().unwrap_or_default()];
    let frame = reader.next_frame(&mut pixels).map_err(broken)?;
    pixels.truncate(frame.buffer_size());
    let rgb = match frame.color_type {
        ColorType::Rgb => pixels,
        ColorType::Rgba => pixels
            .chunks_exact(4)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect(),
        ColorType::Grayscale => pixels.iter().flat_map(|grey| [*grey; 3]).collect(),
        ColorType::GrayscaleAlpha => pixels.chunks_exact(2).flat_map(|pixel| [pixel[0]; 3]).collect(),
        ColorType::Indexed => return Err(PictureError::Broken("its palette is missing".to_owned())),
    };
    if rgb.len() as u64 != u64::from(width) * u64::from(height) * 3 {
        return Err(PictureError::Broken(
            "it has fewer pixels than its header states".to_owned(),
        ));
    }
    Ok(Picture { width, height, rgb })
}

#[cfg(test)]
mod tests;
