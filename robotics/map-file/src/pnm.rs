//! Portable bitmaps, graymaps and pixmaps, plain (P1, P2, P3) and raw (P4, P5, P6): ROS map servers write P5.
//!
//! One image a file. Comments may occur anywhere in the header, and in a plain raster.

use crate::picture::{Picture, Shade, fits, too_large};

/// The line of the file, and what is wrong there.
type Wrong = (usize, String);

struct Scanner<'a> {
    bytes: &'a [u8],
    position: usize,
    line: usize,
}

pub(crate) fn read(bytes: &[u8], shade: Shade) -> Result<Picture, Wrong> {
    let kind = match bytes {
        [b'P', kind @ b'1'..=b'6', ..] => kind - b'0',
        _ => return Err((1, "has no header: expected P1 to P6".to_owned())),
    };
    let (is_plain, is_bitmap) = (kind <= 3, kind % 3 == 1);
    let channels = if kind % 3 == 0 { 3 } else { 1 };
    let mut scanner = Scanner {
        bytes,
        position: 2,
        line: 1,
    };
    let width = scanner.number("width", 1..=1 << 20)? as usize;
    let height = scanner.number("height", 1..=1 << 20)? as usize;
    let deepest = match is_bitmap {
        true => 1,
        false => scanner.number("greatest value", 1..=65535)?,
    };
    if !fits(width, height) {
        return Err((scanner.line, too_large(width, height)));
    }
    let count = width * height * channels;
    let samples = match (is_plain, is_bitmap) {
        (true, true) => scanner.digits(count),
        (true, false) => scanner.plain(count, deepest),
        (false, true) => scanner.bits(width, height),
        (false, false) => scanner.raw(count, deepest),
    }?;
    let shades = match channels {
        3 => (samples.as_chunks().0.iter())
            .map(|&color| shade.of(color))
            .collect(),
        _ => samples,
    };
    Ok(Picture {
        width,
        height,
        shades,
        transparent: Vec::new(),
    })
}

/// Returns the shade of a bit: 1 is black.
const fn ink(bit: u8) -> u8 {
    if bit == 0 { 255 } else { 0 }
}

/// Returns a value up to `deepest` as one up to 255.
const fn scale(value: u32, deepest: u32) -> u8 {
    ((value * 255 + deepest / 2) / deepest) as u8
}

impl Scanner<'_> {
    fn next(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.position)?;
        self.position += 1;
        self.line += usize::from(byte == b'\n');
        Some(byte)
    }

    /// Skips white space and comments.
    fn skip(&mut self) {
        loop {
            match self.bytes.get(self.position) {
                Some(b'#') => while self.next().is_some_and(|byte| byte != b'\n') {},
                Some(byte) if byte.is_ascii_whitespace() => {
                    self.next();
                }
                _ => break,
            }
        }
    }

    /// Reads a decimal number after white space and comments.
    fn number(&mut self, what: &str, fits: std::ops::RangeInclusive<u32>) -> Result<u32, Wrong> {
        self.skip();
        let digits = self.bytes[self.position..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count();
        let text =
            std::str::from_utf8(&self.bytes[self.position..self.position + digits]).unwrap_or_default();
        self.position += digits;
        match text.parse() {
            Ok(number) if fits.contains(&number) => Ok(number),
            _ => {
                let (least, most) = (fits.start(), fits.end());
                let found = if text.is_empty() { "missing" } else { text };
                Err((
                    self.line,
                    format!("has the {what} {found}: expected a number from {least} to {most}"),
                ))
            }
        }
    }

    /// Refuses a file that is too short before memory is allocated.
    fn expect_bytes(&self, least: usize, count: usize) -> Result<(), Wrong> {
        if self.bytes.len() - self.position < least {
            return Err((
                self.line,
                format!("ends early: expected {count} values of pixels"),
            ));
        }
        Ok(())
    }

    /// Reads the digits of a plain bitmap, which may follow each other without a space.
    fn digits(&mut self, count: usize) -> Result<Vec<u8>, Wrong> {
        self.expect_bytes(count, count)?;
        let mut digit = || {
            self.skip();
            match self.next() {
                Some(bit @ (b'0' | b'1')) => Ok(ink(bit - b'0')),
                _ => Err((self.line, "has a pixel that is neither 0 nor 1".to_owned())),
            }
        };
        (0..count).map(|_| digit()).collect()
    }

    fn plain(&mut self, count: usize, deepest: u32) -> Result<Vec<u8>, Wrong> {
        // Each value takes a digit and a space.
        self.expect_bytes(2 * count - 1, count)?;
        (0..count)
            .map(|_| Ok(scale(self.number("pixel", 0..=deepest)?, deepest)))
            .collect()
    }

    /// Reads packed bits, the first in the highest bit of a byte. A row begins with a byte.
    fn bits(&mut self, width: usize, height: usize) -> Result<Vec<u8>, Wrong> {
        let bytes = width.div_ceil(8);
        let rows = self.raster(bytes * height)?.0.chunks_exact(bytes);
        let row = |row: &[u8]| {
            let bits = row
                .iter()
                .flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1));
            bits.take(width).map(ink).collect::<Vec<u8>>()
        };
        Ok(rows.flat_map(row).collect())
    }

    fn raw(&mut self, count: usize, deepest: u32) -> Result<Vec<u8>, Wrong> {
        let is_wide = deepest > 255;
        let (raster, line) = self.raster(if is_wide { 2 * count } else { count })?;
        let sample = |value: u32| {
            if value <= deepest {
                return Ok(scale(value, deepest));
            }
            let message = format!("has a pixel brighter than its greatest value {deepest}");
            Err((line, message))
        };
        if is_wide {
            let values = raster.as_chunks().0.iter();
            values
                .map(|pair| sample(u16::from_be_bytes(*pair).into()))
                .collect()
        } else {
            raster.iter().map(|byte| sample((*byte).into())).collect()
        }
    }

    /// Returns the bytes of a raw raster, and the line on which it begins.
    fn raster(&mut self, expected: usize) -> Result<(&[u8], usize), Wrong> {
        // Exactly one white space ends the header: the next byte may be a pixel with the value of white
        // space.
        if !self.next().is_some_and(|byte| byte.is_ascii_whitespace()) {
            return Err((
                self.line,
                "has no white space between header and pixels".to_owned(),
            ));
        }
        let raster = &self.bytes[self.position..];
        let raster_of = raster.get(..expected).map(|pixels| (pixels, self.line));
        raster_of.ok_or_else(|| {
            let given = raster.len();
            (
                self.line,
                format!("ends early: {given} of {expected} bytes of pixels are present"),
            )
        })
    }
}
