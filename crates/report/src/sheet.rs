//! A sheet of paper with all that a recording shows: where the robot went or how numbers were, and below on one axis of time who was
//! in which state.

use crate::chart::{self, Area, Bands, SMALL};
use crate::drawing::{Align, Drawing, Tone};
use crate::map::{self, Palette};
use crate::picture::Picture;
use crate::tale::Tale;

/// Units of an area like that of the usual sheet: a larger picture shows the same larger, not more.
const UNITS: f32 = 1600.0 * 1067.0;
/// White paper at the edges, units.
const MARGIN: f32 = 36.0;
/// Units above charts, with the title.
const HEADING: f32 = 104.0;
/// Units left of charts without names of rows, for numbers.
const AXIS: f32 = 84.0;
/// Units below the bands, with the times.
const TIMES: f32 = 34.0;
/// Units of a line of remarks.
const REMARK: f32 = 20.0;
/// Bands take so much of the height at most, and a map or charts so much of it at least.
const BANDS: f32 = 0.42;

/// Pixels that a side of a picture has at least and at most.
pub const SIDES: std::ops::RangeInclusive<u32> = 200..=8000;

/// How a picture shows a tale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels, within [`SIDES`].
    pub width: u32,
    /// Pixels, within [`SIDES`].
    pub height: u32,
}

impl Size {
    /// Columns of time that a picture of this size can show.
    #[must_use]
    pub fn columns(self) -> usize {
        self.width as usize
    }

    fn scale(self) -> f32 {
        let pixels = self.width as f32 * self.height as f32;
        (pixels / UNITS).sqrt()
    }
}

impl Picture {
    /// What a recording shows: its numbers if any were asked for, else where the robot went; and below who was in which state.
    #[must_use]
    pub fn of_tale(tale: &Tale, size: Size) -> Self {
        let scale = size.scale();
        let (width, height) = (size.width as f32 / scale, size.height as f32 / scale);
        let mut drawing = Drawing::new(width, height);
        let remarks = remarks(&drawing, tale, width - 2.0 * MARGIN);
        let foot = height - MARGIN / 2.0 - remarks.len() as f32 * REMARK;
        for (number, remark) in remarks.iter().enumerate() {
            let y = foot + (number as f32 + 0.5) * REMARK;
            drawing.label(remark, SMALL, (MARGIN, y), Align::Left, Tone::Soft);
        }
        let drive = &tale.ending.drive;
        let has_lines = !tale.traces.is_empty();
        let has_map = !has_lines && !drive.path.is_empty();
        let most = if has_lines || has_map {
            foot * BANDS
        } else {
            foot - HEADING - TIMES
        };
        let bands = Bands::new(tale, most);
        let top = foot - TIMES - bands.height();
        let left = if bands.height() > 0.0 {
            MARGIN + chart::NAMES
        } else {
            AXIS
        };
        let right = if bands.height() > 0.0 {
            chart::NUMBERS + MARGIN
        } else {
            MARGIN
        };
        let times = Area {
            left,
            top,
            width: (width - left - right).max(40.0),
            height: bands.height(),
        };
        if has_map {
            map::draw_within(&mut drawing, drive, width, top);
        } else {
            heading(&mut drawing, tale, MARGIN);
        }
        if has_lines {
            let area = Area {
                top: HEADING,
                height: (top - HEADING).max(40.0),
                ..times
            };
            chart::charts(&mut drawing, area, tale.columns, &tale.traces);
        }
        chart::time_grid(&mut drawing, times, tale.columns);
        bands.draw(&mut drawing, times, &Palette::of(drive));
        if has_lines || bands.height() > 0.0 {
            chart::time_axis(&mut drawing, times, tale.columns);
        }
        Self::new(drawing, scale)
    }
}

fn heading(drawing: &mut Drawing, tale: &Tale, left: f32) {
    drawing.text(&tale.title, 32.0, (left, 52.0), Align::Left, Tone::Ink);
    let switches: u64 = tale.contests.iter().map(|contest| contest.switches).sum();
    let mut parts = vec![chart::seconds(tale.columns.seconds())];
    parts.extend(tale.begun());
    if switches > 0 {
        parts.push(format!("{switches} switches"));
    }
    drawing.text(&parts.join("  ·  "), 18.0, (left, 84.0), Align::Left, Tone::Soft);
}

/// What a picture lacks and why, in lines that fit.
fn remarks(drawing: &Drawing, tale: &Tale, width: f32) -> Vec<String> {
    let mut remarks = tale.remarks();
    if tale.traces.is_empty() && tale.ending.drive.path.is_empty() {
        remarks.push("the recording does not say where the robot was".to_owned());
    }
    if !tale.bands.iter().any(crate::tale::Band::was_awake) {
        remarks.push("it does not say who was in which state: it holds no selections".to_owned());
    }
    remarks
        .into_iter()
        .map(|remark| drawing.fitted(&remark, SMALL, width))
        .collect()
}
