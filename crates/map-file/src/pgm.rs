//! Portable graymaps, plain (P2) and raw (P5), as ROS map servers write them.
//!
//! One image a file. Comments may occur anywhere in the header, and in a plain raster.

use crate::picture::{MAX_PIXELS, Picture};

/// The line of the file, and what is wrong there.
pub(crate) type PgmError = (usize, String);

struct Scanner<'a> {
    bytes: &'a [u8],
    position: usize,
    line: usize,
}

pub(crate) fn read(bytes: &[u8]) -> Result<Picture, PgmError> {
    let plain = match bytes.get(..2) {
        Some(b"P2") => true,
        Some(b"P5") => false,
        _ => {
            return Err((
                1,
                "is not a graymap: expected it to begin with P2 or P5".to_owned(),
            ));
        }
    };
    let mut scanner = Scanner {
        bytes,
        position: 2,
        line: 1,
    };
    let width = scanner.number("width", 1..=1 << 20)?;
    let height = scanner.number("height", 1..=1 << 20)?;
    let deepest = scanner.number("greatest value", 1..=65535)?;
    let count = width as usize * height as usize;
    if count > MAX_PIXELS {
        return Err((
            scanner.line,
            format!("has {width} x {height} pixels: expected at most {MAX_PIXELS} in all"),
        ));
    }
    let shades = if plain {
        scanner.plain(count, deepest)?
    } else {
        scanner.raw(count, deepest)?
    };
    Ok(Picture {
        width: width as usize,
        height: height as usize,
        shades,
    })
}

impl Scanner<'_> {
    fn next(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.position)?;
        self.position += 1;
        self.line += usize::from(byte == b'\n');
        Some(byte)
    }

    /// Reads a decimal number after white space and comments.
    fn number(&mut self, what: &str, fits: std::ops::RangeInclusive<u32>) -> Result<u32, PgmError> {
        loop {
            match self.bytes.get(self.position) {
                Some(b'#') => while self.next().is_some_and(|byte| byte != b'\n') {},
                Some(byte) if byte.is_ascii_whitespace() => {
                    self.next();
                }
                _ => break,
            }
        }
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

    fn plain(&mut self, count: usize, deepest: u32) -> Result<Vec<f32>, PgmError> {
        // Each pixel takes a digit and a space, so a file that is too short is rejected before memory is
        // allocated.
        if self.bytes.len() - self.position < 2 * count - 1 {
            return Err((self.line, format!("ends early: expected {count} pixels")));
        }
        (0..count)
            .map(|_| Ok(self.number("pixel", 0..=deepest)? as f32 / deepest as f32))
            .collect()
    }

    fn raw(&mut self, count: usize, deepest: u32) -> Result<Vec<f32>, PgmError> {
        // Exactly one white space ends the header: the next byte may be a pixel with the value of white
        // space.
        if !self.next().is_some_and(|byte| byte.is_ascii_whitespace()) {
            return Err((
                self.line,
                "has no white space between header and pixels".to_owned(),
            ));
        }
        let wide = deepest > 255;
        let (raster, expected) = (&self.bytes[self.position..], if wide { 2 * count } else { count });
        if raster.len() < expected {
            let given = raster.len();
            return Err((
                self.line,
                format!("ends early: {given} of {expected} bytes of pixels are present"),
            ));
        }
        let values: Box<dyn Iterator<Item = u32>> = if wide {
            Box::new(
                raster[..expected]
                    .chunks_exact(2)
                    .map(|pair| u32::from(pair[0]) << 8 | u32::from(pair[1])),
            )
        } else {
            Box::new(raster[..expected].iter().map(|&byte| u32::from(byte)))
        };
        let too_bright = || {
            (
                self.line,
                format!("has a pixel brighter than its greatest value {deepest}"),
            )
        };
        values
            .map(|v| {
                if v <= deepest {
                    Ok(v as f32 / deepest as f32)
                } else {
                    Err(too_bright())
                }
            })
            .collect()
    }
}
