//! The formats of cameras: which one is chosen, and how it is converted to red, green and blue.

use jde_picture::{Picture, PictureError, check_size, jpeg};

/// The encoding of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Red, green, blue.
    Rgb24,
    /// Brightness per pixel, colour per two pixels (BT.601).
    Yuyv,
    /// One JPEG per picture.
    Mjpeg,
    /// Brightness only.
    Grey,
}

/// Appends the pixels of a row.
type Row = fn(&[u8], &mut Vec<u8>);

/// A format and a size, as a camera reports them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub(crate) format: Format,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Bytes per row, including padding; 0 if the camera does not report them.
    pub(crate) stride: u32,
}

impl Format {
    /// In order of preference: first the format without cost, then at little cost, with loss of detail, with
    /// loss of colour.
    pub(crate) const ALL: [Self; 4] = [Self::Rgb24, Self::Yuyv, Self::Mjpeg, Self::Grey];

    /// The kernel's code of the format.
    pub(crate) fn code(self) -> [u8; 4] {
        match self {
            Self::Rgb24 => *b"RGB3",
            Self::Yuyv => *b"YUYV",
            Self::Mjpeg => *b"MJPG",
            Self::Grey => *b"GREY",
        }
    }

    /// The format of a name in an application.
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "rgb24" => Some(Self::Rgb24),
            "yuyv" => Some(Self::Yuyv),
            "mjpeg" => Some(Self::Mjpeg),
            "grey" => Some(Self::Grey),
            _ => None,
        }
    }

    fn of_code(code: [u8; 4]) -> Option<Self> {
        match &code {
            // JPEGs with and without tables can be decoded.
            b"JPEG" => Some(Self::Mjpeg),
            _ => Self::ALL.into_iter().find(|format| format.code() == code),
        }
    }

    /// Chooses the format to request from a camera that supports these.
    pub(crate) fn choose(requested: Option<Self>, supported: &[[u8; 4]]) -> Result<[u8; 4], String> {
        let code_of = |format: Self| {
            supported
                .iter()
                .copied()
                .find(|code| Self::of_code(*code) == Some(format))
        };
        let chosen = match requested {
            Some(format) => code_of(format),
            None => Self::ALL.into_iter().find_map(code_of),
        };
        chosen.ok_or_else(|| {
            let names: Vec<String> = supported
                .iter()
                .map(|code| code.escape_ascii().to_string())
                .collect();
            let expected = match requested {
                Some(format) => format.code().escape_ascii().to_string(),
                None => "RGB3, YUYV, MJPG or GREY".to_owned(),
            };
            format!("it sends {} and not {expected}", names.join(", "))
        })
    }
}

impl Shape {
    /// Checks that the camera's format can be decoded, and its size fits.
    pub(crate) fn from_driver(code: [u8; 4], width: u32, height: u32, stride: u32) -> Result<Self, String> {
        let Some(format) = Format::of_code(code) else {
            return Err(format!(
                "it replies with the format {}, which was not requested",
                code.escape_ascii()
            ));
        };
        check_size(width.into(), height.into()).map_err(|error| error.to_string())?;
        Ok(Self {
            format,
            width,
            height,
            stride,
        })
    }

    /// Decodes a picture.
    pub(crate) fn picture(self, bytes: &[u8]) -> Result<Picture, PictureError> {
        let Self {
            format,
            width,
            height,
            ..
        } = self;
        let pixels = width as usize;
        let (row, convert): (usize, Row) = match format {
            Format::Mjpeg => return jpeg(bytes),
            Format::Rgb24 => (pixels * 3, |row, rgb| rgb.extend_from_slice(row)),
            Format::Grey => (pixels, |row, rgb| {
                rgb.extend(row.iter().flat_map(|grey| [*grey; 3]))
            }),
            // With an odd width, the last pair has one pixel.
            Format::Yuyv => (pixels.next_multiple_of(2) * 2, |row, rgb| {
                rgb.extend(row.chunks_exact(4).flat_map(yuyv))
            }),
        };
        let stride = row.max(self.stride as usize);
        let mut rgb = Vec::with_capacity(pixels * height as usize * 3);
        for line in 0..height as usize {
            let Some(bytes) = bytes.get(line * stride..line * stride + row) else {
                return Err(PictureError::Broken(format!(
                    "only {} bytes of a picture arrived",
                    bytes.len()
                )));
            };
            convert(bytes, &mut rgb);
            rgb.truncate((line + 1) * pixels * 3);
        }
        Ok(Picture { width, height, rgb })
    }
}

/// Converts two pixels by BT.601 with brightness from 16 to 235, in steps of 1/256.
fn yuyv(pair: &[u8]) -> [u8; 6] {
    let [y0, u, y1, v] = [0, 1, 2, 3].map(|index| i32::from(pair[index]));
    let (u, v) = (u - 128, v - 128);
    let (red, green, blue) = (409 * v, -100 * u - 208 * v, 516 * u);
    let channel = |y: i32, colour: i32| ((298 * (y - 16) + colour + 128) >> 8).clamp(0, 255) as u8;
    [
        channel(y0, red),
        channel(y0, green),
        channel(y0, blue),
        channel(y1, red),
        channel(y1, green),
        channel(y1, blue),
    ]
}

#[cfg(test)]
mod tests {
    use jde_picture::{Color, Compression};
    use proptest::prelude::*;

    use super::*;

    #[track_caller]
    fn assert_nearly(picture: &Picture, size: (u32, u32), rgb: [u8; 3]) {
        assert_eq!((picture.width, picture.height), size);
        let expected = rgb.repeat((size.0 * size.1) as usize);
        assert_eq!(picture.rgb.len(), expected.len());
        let pairs = picture.rgb.iter().zip(&expected);
        assert!(
            pairs.map(|(a, b)| a.abs_diff(*b)).all(|far| far <= 4),
            "{:?}",
            &picture.rgb[..3]
        );
    }

    fn shape(format: Format, width: u32, height: u32, stride: u32) -> Shape {
        Shape {
            format,
            width,
            height,
            stride,
        }
    }

    #[test]
    fn the_cheapest_format_is_chosen_unless_one_is_requested() {
        let supported = [*b"GREY", *b"MJPG", *b"YUYV"];
        assert_eq!(Format::choose(None, &supported), Ok(*b"YUYV"));
        assert_eq!(Format::choose(Format::named("mjpeg"), &supported), Ok(*b"MJPG"));
        assert_eq!(Format::choose(Format::named("mjpeg"), &[*b"JPEG"]), Ok(*b"JPEG"));
        assert_eq!(
            Format::choose(Format::named("rgb24"), &supported),
            Err("it sends GREY, MJPG, YUYV and not RGB3".to_owned())
        );
        assert_eq!(
            Format::choose(None, &[*b"H264"]),
            Err("it sends H264 and not RGB3, YUYV, MJPG or GREY".to_owned())
        );
        assert_eq!(Format::named("h264"), None);
    }

    #[test]
    fn another_size_of_the_camera_is_accepted_if_it_fits() {
        assert_eq!(
            Shape::from_driver(*b"YUYV", 352, 288, 704),
            Ok(shape(Format::Yuyv, 352, 288, 704))
        );
        assert!(Shape::from_driver(*b"YUYV", 1280, 720, 0).is_err_and(|error| error.contains("1280 x 720")));
        assert!(Shape::from_driver(*b"H264", 320, 240, 0).is_err_and(|error| error.contains("H264")));
    }

    #[test]
    fn colours_of_yuyv_are_those_of_bt_601() {
        for (yuv, rgb) in [
            ([16, 128, 128], [0, 0, 0]),
            ([235, 128, 128], [255, 255, 255]),
            ([81, 90, 240], [255, 0, 0]),
            ([145, 54, 34], [0, 255, 0]),
            ([41, 240, 110], [0, 0, 255]),
        ] {
            let [y, u, v] = yuv;
            let picture = shape(Format::Yuyv, 2, 1, 0)
                .picture(&[y, u, y, v])
                .expect("a picture");
            assert_nearly(&picture, (2, 1), rgb);
        }
    }

    #[test]
    fn rows_are_found_by_the_stride() {
        let bytes = [1, 2, 3, 4, 5, 6, 0xee, 7, 8, 9, 10, 11, 12, 0xee];
        let picture = shape(Format::Rgb24, 2, 2, 7).picture(&bytes).expect("a picture");
        assert_eq!(picture.rgb, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
        let picture = shape(Format::Grey, 1, 2, 3)
            .picture(&[5, 0, 0, 6])
            .expect("a picture");
        assert_eq!(picture.rgb, [5, 5, 5, 6, 6, 6]);
        let odd = shape(Format::Yuyv, 1, 2, 0)
            .picture(&[16, 128, 0, 128, 235, 128, 0, 128])
            .expect("a picture");
        assert_eq!(odd.rgb, [0, 0, 0, 255, 255, 255]);
        let short = shape(Format::Rgb24, 2, 2, 7).picture(&bytes[..12]);
        assert_eq!(
            short,
            Err(PictureError::Broken(
                "only 12 bytes of a picture arrived".to_owned()
            ))
        );
    }

    #[test]
    fn the_size_of_a_jpeg_is_in_its_data() {
        let jpeg = Compression::Jpeg.encode((32, 16), Color::Rgb, &[9, 99, 199].repeat(32 * 16));
        let jpeg = jpeg.expect("a JPEG");
        let picture = shape(Format::Mjpeg, 640, 480, 0)
            .picture(&jpeg)
            .expect("a picture");
        assert_nearly(&picture, (32, 16), [9, 99, 199]);
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), kind in 0_usize..4, width in 1_u32..9, height in 1_u32..9, stride in 0_u32..30) {
            if let Ok(picture) = shape(Format::ALL[kind], width, height, stride).picture(&bytes)
                && kind != 2
            {
                prop_assert_eq!(picture.rgb.len() as u32, width * height * 3);
            }
        }
    }
}
