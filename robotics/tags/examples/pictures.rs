//! Prints the tags of tag36h11 in pictures: number, wrong bits, margin, and column and row of each corner, px. Then the
//! time, the best of ten.
//!
//! `cargo run --release -p jde-tags --example pictures -- STEP PICTURE.pgm...` (binary PGM, `P5`)

use std::error::Error;
use std::time::Instant;

use jde_tags::{Detector, Gray};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [step, pictures @ ..] = arguments.as_slice() else {
        return Err("usage: pictures STEP PICTURE.pgm...".into());
    };
    let mut detector = Detector::default();
    detector.step = step.parse()?;
    for name in pictures {
        let bytes = std::fs::read(name)?;
        let picture = read(&bytes).ok_or_else(|| format!("{name}: not a binary PGM of one byte a pixel"))?;
        let tags = detector.detect(&picture);
        let times = (0..10).map(|_| {
            let start = Instant::now();
            detector.detect(&picture);
            start.elapsed()
        });
        let time = times.min().unwrap_or_default();
        for tag in &tags {
            let corners = tag.corners.as_flattened().iter();
            let corners: String = corners.map(|place| format!(" {place:.4}")).collect();
            println!("{} {} {:.2}{corners}", tag.id, tag.hamming, tag.margin);
        }
        println!("{name}: {} tags in {time:?}", tags.len());
    }
    Ok(())
}

/// Reads a picture without comments: `P5`, columns, rows, 255, and the pixels.
fn read(bytes: &[u8]) -> Option<Gray<'_>> {
    let mut rest = bytes;
    let mut word = || {
        let text = rest.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace)?;
        rest = &text[end..];
        str::from_utf8(&text[..end]).ok()
    };
    let [format, columns, rows, most] = [word()?, word()?, word()?, word()?];
    if (format, most) != ("P5", "255") {
        return None;
    }
    Gray::new([columns.parse().ok()?, rows.parse().ok()?], rest.get(1..)?)
}
