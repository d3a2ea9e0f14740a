//! The image of a map as shades of gray. The first bytes distinguish PNG from PGM.
//!
//! Transparency is ignored, as in ROS map servers in their trinary mode.

use std::io::Cursor;
use std::path::Path;

use crate::fault::Fault;
use crate::{bytes, pgm};

/// Ten thousand cells a side: 500 m at 5 cm.
pub(crate) const MAX_PIXELS: usize = 100_000_000;

/// Shades from 0 (black) to 1 (white), by rows from the top.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) shades: Vec<f32>,
}

pub(crate) fn read(path: &Path) -> Result<Picture, Fault> {
    let fault = |line, message| Fault {
        file: path.to_owned(),
        line,
        message,
    };
    let bytes = bytes::read_limited(path, bytes::MAX_IMAGE)
        .map_err(|error| fault(None, format!("cannot read the image: {error}")))?;
    if bytes.starts_with(b"\x89PNG") {
        png(&bytes).map_err(|message| fault(None, message))
    } else {
        pgm::read(&bytes).map_err(|(line, message)| fault(Some(line), format!("the image {message}")))
    }
}

fn png(bytes: &[u8]) -> Result<Picture, String> {
    let refuse = |error: png::DecodingError| format!("the image is not a valid PNG: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    // Palettes, single bits and 16-bit channels all become bytes.
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(refuse)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let size = reader
        .output_buffer_size()
        .filter(|_| width * height <= MAX_PIXELS);
    let size = size
        .ok_or_else(|| format!("the image has {width} x {height} pixels: expected at most {MAX_PIXELS}"))?;
    let mut buffer = vec![0; size];
    let info = reader.next_frame(&mut buffer).map_err(refuse)?;
    let channels = info.color_type.samples();
    // In gray with alpha and in colour with alpha, the last channel is not a colour.
    let colours = if channels % 2 == 0 { channels - 1 } else { channels };
    let shades = buffer[..info.buffer_size()].chunks_exact(channels).map(|pixel| {
        let sum: u32 = pixel[..colours].iter().map(|&value| u32::from(value)).sum();
        sum as f32 / (255 * colours) as f32
    });
    Ok(Picture {
        width,
        height,
        shades: shades.collect(),
    })
}
