//! Pictures of all kinds: valid, broken and too large.

use jde_types::Value as _;
use proptest::prelude::*;

use super::*;

/// A PNG in which every pixel has these bytes.
fn png_of(width: u32, height: u32, color: ColorType, pixel: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    let mut writer = encoder.write_header().expect("a header");
    writer
        .write_image_data(&pixel.repeat((width * height) as usize))
        .expect("pixels");
    writer.finish().expect("an end");
    file
}

/// A JPEG of one colour.
fn jpeg_of(width: u32, height: u32, rgb: [u8; 3]) -> Vec<u8> {
    let pixels = rgb.repeat((width * height) as usize);
    let file = Compression::Jpeg.encode((width, height), Color::Rgb, &pixels);
    file.expect("a JPEG")
}

#[track_caller]
fn assert_nearly(picture: &Picture, size: (u32, u32), rgb: [u8; 3]) {
    assert_eq!((picture.width, picture.height), size);
    assert_eq!(picture.rgb.len(), (size.0 * size.1 * 3) as usize);
    let far = |pixel: &[u8]| {
        pixel
            .iter()
            .zip(rgb)
            .any(|(actual, expected)| actual.abs_diff(expected) > 4)
    };
    assert!(!picture.rgb.chunks_exact(3).any(far), "{:?}", &picture.rgb[..3]);
}

#[test]
fn every_kind_of_png_becomes_red_green_and_blue() {
    for (color, pixel, rgb) in [
        (ColorType::Rgb, &[10, 20, 30][..], [10, 20, 30]),
        (ColorType::Rgba, &[10, 20, 30, 0], [10, 20, 30]),
        (ColorType::Grayscale, &[77], [77; 3]),
        (ColorType::GrayscaleAlpha, &[77, 5], [77; 3]),
    ] {
        let picture = Picture::read(&png_of(3, 2, color, pixel)).expect("a picture");
        assert_eq!(
            (picture.width, picture.height, &*picture.rgb),
            (3, 2, &*rgb.repeat(6))
        );
    }
}

#[test]
fn a_jpeg_is_read_with_and_without_its_tables() {
    let whole = jpeg_of(64, 48, [200, 100, 50]);
    assert_nearly(
        &Picture::read(&whole).expect("a picture"),
        (64, 48),
        [200, 100, 50],
    );

    // Cameras send all segments except the Huffman tables.
    let (mut bare, mut at) = (whole[..2].to_vec(), 2);
    while whole[at + 1] != 0xda {
        let next = at + 2 + usize::from(u16::from_be_bytes([whole[at + 2], whole[at + 3]]));
        if whole[at + 1] != 0xc4 {
            bare.extend_from_slice(&whole[at..next]);
        }
        at = next;
    }
    bare.extend_from_slice(&whole[at..]);
    assert!(bare.len() < whole.len());
    assert_nearly(
        &Picture::read(&bare).expect("a picture"),
        (64, 48),
        [200, 100, 50],
    );
}

#[test]
fn a_picture_that_does_not_fit_is_refused_with_its_size() {
    let error = Picture::read(&png_of(641, 480, ColorType::Grayscale, &[0]))
        .expect_err("too large")
        .to_string();
    assert!(
        error.starts_with("it is 641 x 480 pixels, and at most 640 x 480 fit"),
        "{error}"
    );
    let error = Picture::read(&jpeg_of(1280, 720, [0; 3]))
        .expect_err("too large")
        .to_string();
    assert!(error.starts_with("it is 1280 x 720 pixels"), "{error}");
    assert!(
        Picture::read(&png_of(480, 640, ColorType::Grayscale, &[0])).is_ok(),
        "another shape with as many pixels"
    );
    assert!(check_size(u64::MAX, 2).is_err() && check_size(0, 5).is_err());
}

#[test]
fn data_without_a_complete_picture_is_refused() {
    assert_eq!(Picture::read(b"GIF89a"), Err(PictureError::Kind));
    assert_eq!(Picture::read(b""), Err(PictureError::Kind));
    let png = png_of(64, 48, ColorType::Rgb, &[1, 2, 3]);
    assert!(matches!(
        Picture::read(&png[..png.len() / 2]),
        Err(PictureError::Broken(_))
    ));
    // Pixels that say nothing would be grey; more of them take more bytes.
    let pixels: Vec<u8> = (0..64 * 48 * 3_u32)
        .map(|byte| (byte.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let jpeg = Compression::Jpeg
        .encode((64, 48), Color::Rgb, &pixels)
        .expect("a JPEG");
    for part in [2, 4, 10] {
        for end in [
            100,
            jpeg.len() / part,
            jpeg.len() * (part - 1) / part,
            jpeg.len() - 2,
        ] {
            let broken = Picture::read(&jpeg[..end]);
            assert!(
                matches!(broken, Err(PictureError::Broken(_))),
                "{end} of {} bytes",
                jpeg.len()
            );
        }
    }
    let surplus = Picture::read(&[&jpeg[..], &[0; 64]].concat());
    assert_eq!(surplus, Picture::read(&jpeg), "cameras fill their buffers");
}

/// An image of two rows, with two bytes of surplus behind each.
fn image(encoding: &str, pixels: [&[u8]; 2]) -> Box<Image> {
    let mut image = Image::boxed();
    image.encoding = Text::new(encoding);
    let width = if encoding == "mono8" {
        pixels[0].len()
    } else {
        pixels[0].len() / 3
    };
    (image.width, image.height) = (width as u32, 2);
    image.step = pixels[0].len() as u32 + 2;
    for row in pixels {
        image
            .data
            .extend_from_slice(&[row, &[99, 99]].concat())
            .expect("there is room");
    }
    image
}

#[test]
fn what_is_compressed_without_losses_is_the_same_picture() {
    for (encoding, rows, rgb) in [
        ("rgb8", [&[1, 2, 3][..], &[4, 5, 6]], [1, 2, 3, 4, 5, 6]),
        ("bgr8", [&[1, 2, 3], &[4, 5, 6]], [3, 2, 1, 6, 5, 4]),
        ("mono8", [&[7], &[9]], [7, 7, 7, 9, 9, 9]),
    ] {
        let file = Compression::Png.compress(&image(encoding, rows)).expect("a PNG");
        assert_eq!(Picture::read(&file).expect("a picture").rgb, rgb, "{encoding}");
    }
}

#[test]
fn a_jpeg_is_smaller_and_nearly_the_same() {
    let row = [200, 100, 50].repeat(320);
    let mut image = image("rgb8", [&row, &row]);
    let file = Compression::Jpeg.compress(&image).expect("a JPEG");
    assert!(file.len() < image.data.len(), "{}", file.len());
    assert_nearly(
        &Picture::read(&file).expect("a picture"),
        (320, 2),
        [200, 100, 50],
    );
    image.data.resize(300);
    assert!(Compression::Jpeg.compress(&image).is_err(), "rows are missing");
}

#[test]
fn an_image_that_cannot_be_compressed_is_refused() {
    let refused = |change: fn(&mut Image)| {
        let mut image = image("rgb8", [&[1, 2, 3], &[4, 5, 6]]);
        change(&mut image);
        Compression::Png
            .compress(&image)
            .expect_err("it is refused")
            .to_string()
    };
    assert!(refused(|image| image.encoding = Text::new("32FC1")).contains("\"32FC1\""));
    for change in [
        |image: &mut Image| image.height = 3,
        |image: &mut Image| image.height = 0,
        |image: &mut Image| image.width = u32::MAX,
        |image: &mut Image| image.width = 2,
        |image: &mut Image| (image.width, image.step) = (0, 0),
    ] {
        assert!(refused(change).contains("fewer pixels"));
    }
}

proptest! {
    #[test]
    fn no_bytes_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..300), kind in 0..4, index in 0_usize..600, bit in 0..8) {
        match kind {
            0 => {}
            1 => bytes.splice(0..0, [0xff, 0xd8]).for_each(drop),
            2 => bytes = jpeg_of(16, 16, [1, 2, 3]),
            _ => bytes = png_of(16, 16, ColorType::Rgb, &[1, 2, 3]),
        }
        if let Some(byte) = bytes.get_mut(index) {
            *byte ^= 1_u8 << bit;
        }
        let _ = Picture::read(&bytes);
    }
}
