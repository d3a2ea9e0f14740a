//! Pictures in the encodings of ROS, as the pictures that schemas read: "rgb8", "bgr8" or "mono8", without bytes between
//! rows. The numbers are those of `cv_bridge` with OpenCV.

use core::fmt;

use crate::{Header, Image, Text};

/// The picture of another program. Its fields are those of `sensor_msgs/msg/Image`.
#[derive(Clone, Copy, Debug)]
pub struct ForeignPicture<'a> {
    /// Time, and the frame of the camera.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// The format of a pixel.
    pub encoding: &'a str,
    /// Whether numbers of several bytes begin with the most significant byte.
    pub is_bigendian: bool,
    /// Size of a row in bytes.
    pub step: u32,
    /// Rows, from top to bottom.
    pub data: &'a [u8],
}

/// Why a picture cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PictureFault {
    /// Its rows are not there, or are shorter than its pixels.
    Bytes,
    /// As a picture that schemas read it needs more bytes than fit: so many, of so many.
    TooLarge(usize, usize),
    /// A mosaic of colours with fewer than three rows or columns.
    Mosaic,
    /// The name of its encoding is longer than any known one.
    Encoding,
}

impl fmt::Display for PictureFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bytes => f.write_str("its bytes do not fit its size"),
            Self::TooLarge(bytes, most) => {
                write!(
                    f,
                    "the picture needs {bytes} bytes, and there is room for {most}: 640 x 480 pixels"
                )
            }
            Self::Mosaic => f.write_str("its mosaic has fewer than three rows or columns"),
            Self::Encoding => f.write_str("its encoding is not known"),
        }
    }
}

impl core::error::Error for PictureFault {}

/// What the bytes of a pixel are.
#[derive(Clone, Copy)]
enum Layout {
    /// Channels of one byte, of which the first so many are kept.
    Bytes(usize, usize),
    /// Channels of two bytes, of which the first so many are kept.
    Words(usize, usize),
    /// A colour for each pixel: where red is in a square of two by two, row and column, and whether it has two bytes.
    Mosaic([usize; 2], bool),
    /// Two pixels in four bytes: the places of the first brightness, and of the colour U.
    Pairs(usize, usize),
}

/// Returns the layout of an encoding, and the encoding of the picture that it becomes. `None` if it stays as it is.
fn layout(encoding: &str) -> Option<(Layout, &'static str)> {
    Some(match encoding {
        "rgb8" => (Layout::Bytes(3, 3), "rgb8"),
        "bgr8" | "8UC3" => (Layout::Bytes(3, 3), "bgr8"),
        "mono8" | "8UC1" => (Layout::Bytes(1, 1), "mono8"),
        "rgba8" => (Layout::Bytes(4, 3), "rgb8"),
        "bgra8" | "8UC4" => (Layout::Bytes(4, 3), "bgr8"),
        "mono16" => (Layout::Words(1, 1), "mono8"),
        "rgb16" => (Layout::Words(3, 3), "rgb8"),
        "bgr16" => (Layout::Words(3, 3), "bgr8"),
        "rgba16" => (Layout::Words(4, 3), "rgb8"),
        "bgra16" => (Layout::Words(4, 3), "bgr8"),
        "bayer_rggb8" => (Layout::Mosaic([0, 0], false), "rgb8"),
        "bayer_grbg8" => (Layout::Mosaic([0, 1], false), "rgb8"),
        "bayer_gbrg8" => (Layout::Mosaic([1, 0], false), "rgb8"),
        "bayer_bggr8" => (Layout::Mosaic([1, 1], false), "rgb8"),
        "bayer_rggb16" => (Layout::Mosaic([0, 0], true), "rgb8"),
        "bayer_grbg16" => (Layout::Mosaic([0, 1], true), "rgb8"),
        "bayer_gbrg16" => (Layout::Mosaic([1, 0], true), "rgb8"),
        "bayer_bggr16" => (Layout::Mosaic([1, 1], true), "rgb8"),
        "yuv422" | "uyvy" => (Layout::Pairs(1, 0), "rgb8"),
        "yuv422_yuy2" | "yuyv" => (Layout::Pairs(0, 1), "rgb8"),
        _ => return None,
    })
}

impl ForeignPicture<'_> {
    /// Writes the picture into `image`: in colours or grey, one byte each. Others, such as depths, stay in their encoding.
    ///
    /// # Errors
    /// [`PictureFault`]. The contents of `image` are then unspecified.
    pub fn write_to(&self, image: &mut Image) -> Result<(), PictureFault> {
        let [rows, columns, step] = [self.height, self.width, self.step].map(|number| number as usize);
        let (known, encoding) = match layout(self.encoding) {
            Some((layout, encoding)) => (Some(layout), encoding),
            None => (None, self.encoding),
        };
        image.header = self.header;
        (image.height, image.width) = (self.height, self.width);
        image.is_bigendian = u8::from(known.is_none() && self.is_bigendian);
        image.encoding = Text::truncated(encoding);
        if image.encoding.as_str() != encoding {
            return Err(PictureFault::Encoding);
        }
        let Some(layout) = known else {
            image.step = self.step;
            return write(image, self.data.len(), |target| target.copy_from_slice(self.data));
        };
        let (pixel, channels) = match layout {
            Layout::Bytes(pixel, channels) => (pixel, channels),
            Layout::Words(pixel, channels) => (2 * pixel, channels),
            Layout::Mosaic(_, is_wide) => (1 + usize::from(is_wide), 3),
            Layout::Pairs(..) => (2, 3),
        };
        let row = columns.checked_mul(pixel).filter(|row| *row <= step);
        let row = row.ok_or(PictureFault::Bytes)?;
        // The last row needs no bytes behind its pixels.
        let needed = step
            .checked_mul(rows.saturating_sub(1))
            .and_then(|bytes| bytes.checked_add(row));
        if rows > 0 && needed.is_none_or(|needed| needed > self.data.len()) {
            return Err(PictureFault::Bytes);
        }
        let target_row = columns.saturating_mul(channels);
        image.step = u32::try_from(target_row).map_err(|_| PictureFault::Bytes)?;
        if matches!(layout, Layout::Mosaic(..)) && rows.min(columns) < 3 {
            return Err(PictureFault::Mosaic);
        }
        let lines = || (0..rows).map(|line| &self.data[line * step..][..row]);
        write(image, target_row.saturating_mul(rows), |target| match layout {
            Layout::Bytes(pixel, channels) => {
                for (line, target) in lines().zip(target.chunks_exact_mut(target_row.max(1))) {
                    for (from, to) in line.chunks_exact(pixel).zip(target.chunks_exact_mut(channels)) {
                        to.copy_from_slice(&from[..channels]);
                    }
                }
            }
            Layout::Words(pixel, channels) => {
                for (line, target) in lines().zip(target.chunks_exact_mut(target_row.max(1))) {
                    for (from, to) in line
                        .chunks_exact(2 * pixel)
                        .zip(target.chunks_exact_mut(channels))
                    {
                        for (from, to) in from.chunks_exact(2).zip(to) {
                            *to = narrowed(self.word(from));
                        }
                    }
                }
            }
            Layout::Mosaic(red, is_wide) => self.mosaic(red, is_wide, target),
            Layout::Pairs(first, u) => {
                for (line, target) in lines().zip(target.chunks_exact_mut(target_row.max(1))) {
                    for (column, to) in target.chunks_exact_mut(3).enumerate() {
                        // The last pixel of an odd row has no pair of its own.
                        let pair = (column / 2).min((line.len() / 4).saturating_sub(1));
                        let colour = |place: usize| line.get(4 * pair + place).copied().unwrap_or(128);
                        let brightness = line[2 * column + first.min(1)];
                        to.copy_from_slice(&rgb(brightness, colour(u), colour(u + 2)));
                    }
                }
            }
        })
    }

    fn word(&self, bytes: &[u8]) -> u32 {
        let bytes = [bytes[0], bytes[1]];
        u32::from(match self.is_bigendian {
            true => u16::from_be_bytes(bytes),
            false => u16::from_le_bytes(bytes),
        })
    }

    /// Fills in the two colours that each pixel of a mosaic lacks: the means of its neighbours. Pixels at the edge are as
    /// the nearest ones inside.
    fn mosaic(&self, [red_row, red_column]: [usize; 2], is_wide: bool, target: &mut [u8]) {
        let [rows, columns, step] = [self.height, self.width, self.step].map(|number| number as usize);
        let at = |row: usize, column: usize| match is_wide {
            true => self.word(&self.data[row * step + 2 * column..]),
            false => u32::from(self.data[row * step + column]),
        };
        let byte = |number: u32| if is_wide { narrowed(number) } else { number as u8 };
        for (index, pixel) in target.chunks_exact_mut(3).enumerate() {
            let (row, column) = (
                (index / columns).clamp(1, rows - 2),
                (index % columns).clamp(1, columns - 2),
            );
            let own = at(row, column);
            let (left, right) = (at(row, column - 1), at(row, column + 1));
            let (above, below) = (at(row - 1, column), at(row + 1, column));
            let beside = (left + right).div_ceil(2);
            let upright = (above + below).div_ceil(2);
            let is_red_row = row % 2 == red_row;
            let is_red_column = column % 2 == red_column;
            let colours = if is_red_row == is_red_column {
                let cross = (left + right + above + below + 2) / 4;
                let corners = at(row - 1, column - 1) + at(row - 1, column + 1) + at(row + 1, column - 1);
                let diagonal = (corners + at(row + 1, column + 1) + 2) / 4;
                if is_red_row {
                    [own, cross, diagonal]
                } else {
                    [diagonal, cross, own]
                }
            } else if is_red_row {
                [beside, own, upright]
            } else {
                [upright, own, beside]
            };
            pixel.copy_from_slice(&colours.map(byte));
        }
    }
}

fn write(image: &mut Image, bytes: usize, fill: impl FnOnce(&mut [u8])) -> Result<(), PictureFault> {
    let room = image.data.resize(bytes);
    if room.len() < bytes {
        return Err(PictureFault::TooLarge(bytes, room.len()));
    }
    fill(room);
    Ok(())
}

/// Two bytes as one, white as white.
fn narrowed(word: u32) -> u8 {
    ((word * 255 + 32767) / 65535) as u8
}

/// The colour of BT.601 with brightness from 16 to 235, in OpenCV's fixed point.
fn rgb(y: u8, u: u8, v: u8) -> [u8; 3] {
    let y = (i32::from(y) - 16).max(0) * 1_220_542;
    let (u, v) = (i32::from(u) - 128, i32::from(v) - 128);
    let red = y + 1_673_527 * v;
    let green = y - 852_492 * v - 409_993 * u;
    let blue = y + 2_116_026 * u;
    [red, green, blue].map(|number| ((number + (1 << 19)) >> 20).clamp(0, 255) as u8)
}

#[cfg(test)]
mod tests {
    use crate::Value as _;

    use super::*;

    /// Reads a picture of `[width, height]` pixels, and returns its encoding and its bytes.
    fn read(
        encoding: &str,
        [width, height]: [u32; 2],
        step: u32,
        data: &[u8],
    ) -> Result<(String, Vec<u8>), PictureFault> {
        let picture = ForeignPicture {
            header: Header::default(),
            height,
            width,
            encoding,
            is_bigendian: false,
            step,
            data,
        };
        let mut image = Image::boxed();
        picture.write_to(&mut image)?;
        assert_eq!((image.width, image.height), (width, height));
        Ok((image.encoding.as_str().to_owned(), image.data.to_vec()))
    }

    #[track_caller]
    fn check(encoding: &str, size: [u32; 2], step: u32, data: &[u8], expected: (&str, &[u8])) {
        let (name, bytes) = read(encoding, size, step, data).unwrap();
        assert_eq!((name.as_str(), bytes.as_slice()), expected, "{encoding}");
    }

    #[test]
    fn bytes_between_rows_and_opacity_are_dropped() {
        check(
            "bgra8",
            [2, 1],
            8,
            &[1, 2, 3, 9, 4, 5, 6, 9],
            ("bgr8", &[1, 2, 3, 4, 5, 6]),
        );
        check("rgba8", [1, 1], 4, &[1, 2, 3, 9], ("rgb8", &[1, 2, 3]));
        check("mono8", [2, 2], 3, &[1, 2, 0, 3, 4], ("mono8", &[1, 2, 3, 4]));
        check(
            "8UC3",
            [1, 2],
            4,
            &[1, 2, 3, 0, 4, 5, 6],
            ("bgr8", &[1, 2, 3, 4, 5, 6]),
        );
    }

    #[test]
    fn two_bytes_become_one_and_white_stays_white() {
        check(
            "mono16",
            [3, 1],
            6,
            &[0, 0, 0xff, 0xff, 0x80, 0x80],
            ("mono8", &[0, 255, 128]),
        );
        check(
            "rgb16",
            [1, 1],
            6,
            &[0xff, 0xff, 0, 0, 1, 1],
            ("rgb8", &[255, 0, 1]),
        );
        let big = ForeignPicture {
            header: Header::default(),
            height: 1,
            width: 1,
            encoding: "mono16",
            is_bigendian: true,
            step: 2,
            data: &[0x80, 0],
        };
        let mut image = Image::boxed();
        big.write_to(&mut image).unwrap();
        assert_eq!((image.data[0], image.is_bigendian), (128, 0));
    }

    #[test]
    fn a_mosaic_is_the_means_of_neighbours() {
        // Red 100, green 50, blue 10 all over, in each order.
        let colours = |pattern: &str| {
            let value = |letter: u8| match letter {
                b'r' => 100,
                b'g' => 50,
                _ => 10,
            };
            let letters = pattern.as_bytes();
            let rows =
                (0..4_usize).flat_map(|row| (0..4_usize).map(move |column| 2 * (row % 2) + column % 2));
            rows.map(|place| value(letters[place])).collect::<Vec<u8>>()
        };
        for pattern in ["rggb", "bggr", "gbrg", "grbg"] {
            let expected = [100, 50, 10].repeat(16);
            check(
                &format!("bayer_{pattern}8"),
                [4, 4],
                4,
                &colours(pattern),
                ("rgb8", &expected),
            );
        }
        let lone = [0, 0, 0, 0, 80, 0, 0, 0, 0];
        let (_, pixels) = read("bayer_bggr8", [3, 3], 3, &lone).unwrap();
        assert_eq!(pixels, [80, 0, 0].repeat(9), "the edge is as the pixel inside");
        assert_eq!(read("bayer_bggr8", [2, 2], 2, &[0; 4]), Err(PictureFault::Mosaic));
    }

    #[test]
    fn brightness_and_colour_of_pairs_become_red_green_and_blue() {
        // Black, white, and the red of BT.601.
        check(
            "yuv422",
            [2, 1],
            4,
            &[128, 16, 128, 235],
            ("rgb8", &[0, 0, 0, 255, 255, 255]),
        );
        check(
            "yuv422_yuy2",
            [2, 1],
            4,
            &[82, 90, 82, 240],
            ("rgb8", &[255, 1, 0, 255, 1, 0]),
        );
        check("yuyv", [1, 1], 2, &[16, 128], ("rgb8", &[0, 0, 0]));
    }

    #[test]
    fn a_picture_without_its_bytes_or_that_is_too_large_is_refused() {
        assert_eq!(read("rgb8", [2, 2], 6, &[0; 11]), Err(PictureFault::Bytes));
        assert_eq!(read("rgb8", [2, 2], 5, &[0; 12]), Err(PictureFault::Bytes));
        assert_eq!(
            read("mono8", [u32::MAX, u32::MAX], u32::MAX, &[0; 9]),
            Err(PictureFault::Bytes)
        );
        let whole = vec![7; 640 * 480 * 4];
        let (encoding, bytes) = read("bgra8", [640, 480], 2560, &whole).unwrap();
        assert_eq!((encoding.as_str(), bytes.len()), ("bgr8", 640 * 480 * 3));
        let large = read("rgb8", [800, 600], 2400, &vec![0; 800 * 600 * 3]);
        assert_eq!(large, Err(PictureFault::TooLarge(1_440_000, 921_600)));
        check("16UC1", [1, 1], 2, &[7, 8], ("16UC1", &[7, 8]));
    }
}
