//! The image of a map as shades of gray, and which of its pixels are transparent. The first bytes distinguish the formats.
//!
//! The shades are those that GraphicsMagick gives to the map server of ROS: eight bits, colours by their luminance, and
//! the colour of a transparent pixel as it is.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use jde_document::Fault;

use crate::pnm;

/// Greatest file of an image, in bytes, packed or not: the most pixels, in plain text.
const MAX_FILE: u64 = 512 << 20;
/// Ten thousand cells a side: 500 m at 5 cm.
pub(crate) const MAX_PIXELS: usize = 100_000_000;
/// Most bytes of the samples of an image, which are there beside the file and the shades.
const MAX_SAMPLES: usize = 512 << 20;
/// The same where a decoder holds as much again for itself.
const MAX_OTHER_SAMPLES: u64 = 128 << 20;

/// A picture in shades from 0 (black) to 255 (white), by rows from the top.
#[derive(Debug)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The shades of the pixels.
    pub shades: Vec<u8>,
    /// Whether each pixel is transparent, in part or as a whole; empty if none is.
    pub transparent: Vec<bool>,
}

/// What the shade of a pixel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// The luminance of its colour (ITU-R BT.601).
    Luminance,
    /// Its red alone.
    Red,
}

/// The line of a text format, and what is wrong there.
pub(crate) type Wrong = (Option<usize>, String);

impl Picture {
    /// Reads an image: a PNG, JPEG, BMP, GIF, TIFF or Netpbm file, as it is or as a gzip file.
    ///
    /// # Errors
    /// It cannot be read, is of no such kind, is damaged or has too many pixels.
    pub fn load(path: &Path, shade: Shade) -> Result<Self, Fault> {
        let bytes = jde_files::read_unpacked(path, MAX_FILE)
            .map_err(|error| Fault::of_file(path, format!("cannot read the image: {error}")))?;
        read(&bytes, shade).map_err(|(line, message)| {
            let message = format!("the image {message}");
            match line {
                Some(line) => Fault::at_line(path, line, message),
                None => Fault::of_file(path, message),
            }
        })
    }
}

impl Shade {
    pub(crate) fn of(self, [red, green, blue]: [u8; 3]) -> u8 {
        match self {
            Self::Red => red,
            // GraphicsMagick's weights, of 1/1024, without rounding.
            Self::Luminance => {
                let [red, green, blue] = [red, green, blue].map(u32::from);
                ((306 * red + 601 * green + 117 * blue) / 1024) as u8
            }
        }
    }
}

fn read(bytes: &[u8], shade: Shade) -> Result<Picture, Wrong> {
    let other = |name, format| {
        other(bytes, format, shade).map_err(|why| (None, format!("is no valid {name}: {why}")))
    };
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png(bytes, shade).map_err(|message| (None, message)),
        [0xff, 0xd8, ..] if !is_complete_jpeg(bytes) => Err((None, "is half a JPEG: its end is missing".to_owned())),
        [0xff, 0xd8, ..] => other("JPEG", ImageFormat::Jpeg),
        [b'B', b'M', ..] => other("BMP", ImageFormat::Bmp),
        [b'G', b'I', b'F', b'8', ..] => other("GIF", ImageFormat::Gif),
        [b'I', b'I', b'*', 0, ..] | [b'M', b'M', 0, b'*', ..] => other("TIFF", ImageFormat::Tiff),
        [b'P', b'1'..=b'6', ..] => {
            pnm::read(bytes, shade).map_err(|(line, message)| (Some(line), message))
        }
        _ => Err((
            None,
            "is of no known kind: expected a PNG, JPEG, BMP, GIF, TIFF, PGM, PPM or PBM file; convert it to PNG".to_owned(),
        )),
    }
}

fn png(bytes: &[u8], shade: Shade) -> Result<Picture, String> {
    let refuse = |error: png::DecodingError| format!("is no valid PNG: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    // Palettes, single bits and 16-bit channels all become bytes, and a transparent colour becomes a channel.
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(refuse)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let size = reader.output_buffer_size().filter(|size| *size <= MAX_SAMPLES);
    let size = size
        .filter(|_| fits(width, height))
        .ok_or_else(|| too_large(width, height))?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(refuse)?;
    let channels = info.color_type.samples();
    Ok(picture(
        width,
        height,
        channels,
        &samples[..info.buffer_size()],
        shade,
    ))
}

/// Reads the formats that the library `image` reads.
fn other(bytes: &[u8], format: ImageFormat, shade: Shade) -> Result<Picture, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(2 * MAX_OTHER_SAMPLES);
    reader.limits(limits);
    let refuse = |error: image::ImageError| error.to_string();
    let decoder = reader.into_decoder().map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    if !fits(width as usize, height as usize) || decoder.total_bytes() > MAX_OTHER_SAMPLES {
        return Err(too_large(width as usize, height as usize));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(refuse)?;
    let (width, height) = (width as usize, height as usize);
    let is_transparent = image.color().has_alpha();
    Ok(if image.color().has_color() && is_transparent {
        picture(width, height, 4, &image.into_rgba8(), shade)
    } else if image.color().has_color() {
        picture(width, height, 3, &image.into_rgb8(), shade)
    } else if is_transparent {
        picture(width, height, 2, &image.into_luma_alpha8(), shade)
    } else {
        picture(width, height, 1, &image.into_luma8(), shade)
    })
}

/// Makes a picture of samples: gray or colours, and then perhaps how opaque the pixel is.
fn picture(width: usize, height: usize, channels: usize, samples: &[u8], shade: Shade) -> Picture {
    let pixels = samples.chunks_exact(channels);
    let shades = pixels.clone().map(|pixel| match *pixel {
        [red, green, blue, ..] => shade.of([red, green, blue]),
        [gray, ..] => gray,
        [] => 0,
    });
    let is_opaque = |pixel: &[u8]| pixel.last() == Some(&u8::MAX);
    let has_alpha = channels.is_multiple_of(2) && !pixels.clone().all(is_opaque);
    Picture {
        width,
        height,
        shades: shades.collect(),
        transparent: match has_alpha {
            true => pixels.map(|pixel| !is_opaque(pixel)).collect(),
            false => Vec::new(),
        },
    }
}

/// Whether the last scan of a JPEG has an end. Decoders fill in what is missing.
fn is_complete_jpeg(bytes: &[u8]) -> bool {
    let scan = bytes.windows(2).rposition(|pair| pair == [0xff, 0xda]);
    scan.is_some_and(|scan| bytes[scan..].windows(2).any(|pair| pair == [0xff, 0xd9]))
}

pub(crate) fn fits(width: usize, height: usize) -> bool {
    width
        .checked_mul(height)
        .is_some_and(|pixels| (1..=MAX_PIXELS).contains(&pixels))
}

pub(crate) fn too_large(width: usize, height: usize) -> String {
    format!(
        "has {width} x {height} pixels, which are none or too many: expected at most {MAX_PIXELS}, in a gray PNG or PGM"
    )
}
