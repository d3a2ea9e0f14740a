//! JPEG pictures of files and of cameras, which often omit the standard tables.

use std::borrow::Cow;

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use super::{Picture, PictureError, check_size};

const TABLES: u8 = 0xc4;
const SCAN: u8 = 0xda;
const END: u8 = 0xd9;
/// The segment which marks that a picture uses the standard Huffman tables: APP0, 16 bytes, "AVI1".
const STANDARD_TABLES: [u8; 18] = *b"\xff\xe0\x00\x10AVI1\0\0\0\0\0\0\0\0\0\0";

/// Decodes a JPEG.
///
/// # Errors
/// [`PictureError`].
pub fn jpeg(bytes: &[u8]) -> Result<Picture, PictureError> {
    let broken = |error: zune_jpeg::errors::DecodeErrors| PictureError::Broken(error.to_string());
    let (pixels, has_tables) = headers(bytes);
    // The decoder would take the pixels that there are, and grey ones for the others. Among pixels, 0xff is never before the
    // number of the end.
    if !bytes[pixels..].windows(2).rev().any(|pair| pair == [0xff, END]) {
        return Err(PictureError::Broken(
            "it is cut short: its end is missing".to_owned(),
        ));
    }
    let bytes = with_tables(bytes, has_tables);
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&*bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let Some(info) = decoder.info() else {
        return Err(PictureError::Broken("it does not state its size".to_owned()));
    };
    check_size(info.width.into(), info.height.into())?;
    let rgb = decoder.decode().map_err(broken)?;
    if rgb.len() != usize::from(info.width) * usize::from(info.height) * 3 {
        return Err(PictureError::Broken(
            "its colours cannot be converted to red, green and blue".to_owned(),
        ));
    }
    Ok(Picture {
        width: info.width.into(),
        height: info.height.into(),
        rgb,
    })
}

/// Marks a picture without Huffman tables, as cameras often send, so that the decoder uses the standard ones.
fn with_tables(bytes: &[u8], has_tables: bool) -> Cow<'_, [u8]> {
    match (has_tables, bytes) {
        (false, [0xff, 0xd8, rest @ ..]) => Cow::Owned([&[0xff, 0xd8], &STANDARD_TABLES[..], rest].concat()),
        _ => Cow::Borrowed(bytes),
    }
}

/// Returns where the segments before the pixels end, and whether there are Huffman tables among them.
fn headers(bytes: &[u8]) -> (usize, bool) {
    let (mut at, mut has_tables) = (2, false);
    while let Some(&[0xff, marker, high, low, ..]) = bytes.get(at..)
        && marker != SCAN
    {
        has_tables |= marker == TABLES;
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
    }
    (at.min(bytes.len()), has_tables)
}
