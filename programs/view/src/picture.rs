//! Camera images as pixels. A value that is not an image, or that exceeds the graphics card's limits, is
//! refused with a message.

use eframe::egui;
use jde_abi::describe::{Field, Form, Type};
use jde_link::Sample;

/// The encoding of depths in metres (REP-118).
const DEPTH_ENCODING: &[u8] = b"32FC1";

/// An image, with rows from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Picture {
    /// Width and height, in pixels.
    pub(crate) size: [usize; 2],
    /// Red, green, blue and alpha of each pixel, 0 to 255.
    pub(crate) rgba: Vec<u8>,
}

impl Picture {
    /// Decodes the image of a sample. The value is too large to be copied through a stack, so its fields are
    /// read in place, at the offsets of its description.
    ///
    /// # Errors
    /// Why the sample is not an image that can be shown.
    pub(crate) fn read(sample: &Sample) -> Result<Self, String> {
        let bytes = sample.bytes.as_deref().ok_or("it has no value")?;
        let fields = Fields(&sample.value_type, bytes);
        let number = |name: &str| fields.number(name).ok_or("it is not an image");
        let (width, height, step) = (number("width")?, number("height")?, number("step")?);
        let encoding = fields.bytes_of("encoding").ok_or("it is not an image")?;
        let pixels = fields.bytes_of("data").ok_or("it is not an image")?;
        let (depth, order) = match encoding {
            b"rgb8" => (3, [0, 1, 2]),
            b"bgr8" => (3, [2, 1, 0]),
            b"mono8" => (1, [0, 0, 0]),
            DEPTH_ENCODING => (4, [0, 0, 0]),
            other => {
                let other = String::from_utf8_lossy(other);
                return Err(format!(
                    "its pixels are `{other}`: expected rgb8, bgr8, mono8 or 32FC1"
                ));
            }
        };
        let row = width.checked_mul(depth).ok_or("it is not an image")?;
        // The last row needs no padding.
        let total = step
            .checked_mul(height.saturating_sub(1))
            .and_then(|rows| rows.checked_add(row))
            .ok_or("it is not an image")?;
        if width == 0 || height == 0 || step < row || pixels.len() < total {
            let length = pixels.len();
            return Err(format!(
                "its {length} bytes are not {width} × {height} pixels in rows of {step}"
            ));
        }
        let pixels = pixels
            .chunks(step)
            .take(height)
            .flat_map(|line| line[..row].chunks_exact(depth));
        let rgba = if encoding == DEPTH_ENCODING {
            let is_bigendian = fields
                .of("is_bigendian")
                .and_then(|field| bytes.get(field.offset))
                == Some(&1);
            greys(
                &pixels
                    .map(|pixel| metres(pixel, is_bigendian))
                    .collect::<Vec<_>>(),
            )
        } else {
            pixels
                .flat_map(|pixel| rgba(order.map(|place| pixel[place])))
                .collect()
        };
        Ok(Self {
            size: [width, height],
            rgba,
        })
    }

    /// The image as an egui color image.
    pub(crate) fn image(&self) -> egui::ColorImage {
        egui::ColorImage::from_rgba_premultiplied(self.size, &self.rgba)
    }
}

/// Checks that an image fits on a graphics card with at most `limit` pixels per side.
///
/// # Errors
/// A message with both sizes.
pub(crate) fn fits([width, height]: [usize; 2], limit: usize) -> Result<(), String> {
    if width.max(height) <= limit {
        return Ok(());
    }
    Err(format!(
        "{width} × {height} pixels are too large for this graphics card, which takes {limit} × {limit}"
    ))
}

fn rgba([red, green, blue]: [u8; 3]) -> [u8; 4] {
    [red, green, blue, 255]
}

fn metres(pixel: &[u8], is_bigendian: bool) -> f32 {
    let bytes = pixel.try_into().unwrap_or_default();
    if is_bigendian {
        f32::from_be_bytes(bytes)
    } else {
        f32::from_le_bytes(bytes)
    }
}

/// Depths as grey levels: the nearest are light, those at the greatest depth, in whole metres, are dark, and
/// pixels without a depth are black. By REP-117, -∞ is nearer than what can be measured.
fn greys(depths: &[f32]) -> Vec<u8> {
    let is_depth = |depth: &&f32| depth.is_finite();
    let greatest = depths
        .iter()
        .filter(is_depth)
        .fold(1.0_f32, |far, depth| far.max(*depth))
        .ceil();
    let grey = |depth: &f32| match *depth {
        depth if depth.is_finite() => 255.0 - 215.0 * (depth / greatest).max(0.0),
        f32::NEG_INFINITY => 255.0,
        _ => 0.0,
    };
    depths
        .iter()
        .flat_map(|depth| rgba([grey(depth) as u8; 3]))
        .collect()
}

/// The fields of a value: its type and its bytes.
struct Fields<'a>(&'a Type, &'a [u8]);

impl<'a> Fields<'a> {
    fn of(&self, name: &str) -> Option<&'a Field> {
        self.0.fields.iter().find(|field| field.name == name)
    }

    fn word(&self, at: usize) -> Option<usize> {
        let word = self.1.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_ne_bytes(word) as usize)
    }

    fn number(&self, name: &str) -> Option<usize> {
        self.word(self.of(name)?.offset)
    }

    /// The bytes of a text or of a sequence of bytes.
    fn bytes_of(&self, name: &str) -> Option<&'a [u8]> {
        let field = self.of(name)?;
        let (Form::Text {
            capacity,
            length_offset,
        }
        | Form::Sequence {
            capacity,
            length_offset,
        }) = field.form
        else {
            return None;
        };
        let length = self.word(length_offset)?.min(capacity);
        self.1.get(field.offset..field.offset + length)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use jde_types::{Image, Value};

    use super::*;

    /// An image of these bytes, composed in place: a whole `Image` is too large for the stack of a test.
    fn sample(size: [u32; 2], step: u32, encoding: &str, data: &[u8]) -> Sample {
        let of = Image::describe();
        let mut bytes = vec![0; size_of::<Image>()];
        let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
        let field = |name: &str| of.fields.iter().find(|field| field.name == name);
        for (name, number) in [("width", size[0]), ("height", size[1]), ("step", step)] {
            put(field(name).expect(name).offset, &number.to_ne_bytes());
        }
        for (name, part) in [("encoding", encoding.as_bytes()), ("data", data)] {
            let field = field(name).expect(name);
            put(field.offset, part);
            let length = field.form.length_offset().expect("the length varies");
            put(length, &(part.len() as u32).to_ne_bytes());
        }
        Sample {
            value_type: Arc::new(of),
            bytes: Some(bytes.into()),
            sequence: 1,
            time: 0,
            age: 0,
            valid_until: u64::MAX,
            writer: String::new(),
        }
    }

    #[test]
    fn pixels_are_read_in_every_encoding_and_rows_may_be_padded() {
        let colors = [1, 2, 3, 4, 5, 6, 0, 7, 8, 9, 10, 11, 12];
        let read = |encoding| Picture::read(&sample([2, 2], 7, encoding, &colors)).expect(encoding);
        let rgb = [1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255, 10, 11, 12, 255];
        assert_eq!(read("rgb8").rgba, rgb);
        let bgr = [3, 2, 1, 255, 6, 5, 4, 255, 9, 8, 7, 255, 12, 11, 10, 255];
        assert_eq!(read("bgr8").rgba, bgr);
        let grey = Picture::read(&sample([1, 2], 1, "mono8", &[5, 9])).expect("grey");
        assert_eq!((grey.size, grey.rgba), ([1, 2], vec![5, 5, 5, 255, 9, 9, 9, 255]));
        assert_eq!(
            read("rgb8").image().pixels[3],
            egui::Color32::from_rgb(10, 11, 12)
        );
    }

    #[test]
    fn depths_are_lighter_the_nearer_they_are() {
        let depths = [f32::NEG_INFINITY, 1.0, 3.5, f32::INFINITY, f32::NAN];
        let data: Vec<u8> = depths.iter().flat_map(|depth| depth.to_le_bytes()).collect();
        let picture = Picture::read(&sample([5, 1], 20, "32FC1", &data)).expect("depths");
        let greys: Vec<u8> = picture.rgba.chunks(4).map(|pixel| pixel[0]).collect();
        assert_eq!(greys, [255, 201, 66, 0, 0]);
    }

    #[test]
    fn an_invalid_image_is_refused_with_a_message() {
        for (size, step, encoding, bytes, reason) in [
            ([2, 2], 6, "rgb8", 11, "its 11 bytes are not 2 × 2 pixels"),
            ([2, 2], 5, "rgb8", 12, "in rows of 5"),
            ([0, 2], 6, "rgb8", 12, "not 0 × 2 pixels"),
            ([2, 2], 8, "yuv422", 12, "its pixels are `yuv422`"),
            ([u32::MAX, u32::MAX], u32::MAX, "rgb8", 12, "not "),
        ] {
            let refused = Picture::read(&sample(size, step, encoding, &vec![0; bytes]));
            let refused = refused.expect_err("the image is refused");
            assert!(refused.contains(reason), "{refused}");
        }
    }

    #[test]
    fn a_picture_fits_if_no_side_exceeds_the_limit() {
        assert_eq!(fits([4096, 1], 4096), Ok(()));
        assert!(fits([1, 4097], 4096).unwrap_err().contains("1 × 4097 pixels"));
    }
}
