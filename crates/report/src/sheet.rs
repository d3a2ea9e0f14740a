//! A sheet of paper with all that a recording shows: where the robot went or how numbers were, and below on one axis of time who was
//! in which state.

use crate::analysis::Analysis;
use crate::chart::{self, Area, Bands, SMALL};
use crate::drawing::{Align, ColorRole, Drawing};
use crate::map::{self, Palette};
use crate::picture::Picture;

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

/// How a picture shows an analysis.
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

/// How the paper is shared out.
struct Layout<'t> {
    scale: f32,
    width: f32,
    height: f32,
    bands: Bands<'t>,
    /// Where the bands are, over the axis of time.
    times: Area,
    remarks: Vec<String>,
    /// Where the remarks begin.
    foot: f32,
    has_lines: bool,
    has_map: bool,
}

impl<'t> Layout<'t> {
    fn new(analysis: &'t Analysis, size: Size) -> Self {
        let scale = size.scale();
        let (width, height) = (size.width as f32 / scale, size.height as f32 / scale);
        let remarks = remarks(analysis);
        let foot = height - MARGIN / 2.0 - remarks.len() as f32 * REMARK;
        let has_lines = !analysis.traces.is_empty();
        let has_map = !has_lines && analysis.ending.drive.has_way();
        let most = if has_lines || has_map {
            foot * BANDS
        } else {
            foot - HEADING - TIMES
        };
        let bands = Bands::new(analysis, most);
        let (left, right) = if bands.height() > 0.0 {
            (MARGIN + chart::NAMES, chart::NUMBERS + MARGIN)
        } else {
            (AXIS, MARGIN)
        };
        Self {
            scale,
            width,
            height,
            times: Area {
                left,
                top: foot - TIMES - bands.height(),
                width: (width - left - right).max(40.0),
                height: bands.height(),
            },
            bands,
            remarks,
            foot,
            has_lines,
            has_map,
        }
    }
}

impl Picture {
    /// What a recording shows: its numbers if any were asked for, else where the robot went; and below who was in which state.
    #[must_use]
    pub fn of_tale(analysis: &Analysis, size: Size) -> Self {
        let layout = Layout::new(analysis, size);
        let (times, drive) = (layout.times, &analysis.ending.drive);
        let mut drawing = Drawing::new(layout.width, layout.height);
        if layout.has_map {
            map::draw_within(&mut drawing, drive, layout.width, times.top);
        } else {
            heading(&mut drawing, analysis, MARGIN);
        }
        if layout.has_lines {
            let area = Area {
                top: HEADING,
                height: (times.top - HEADING).max(40.0),
                ..times
            };
            chart::charts(&mut drawing, area, analysis.columns, &analysis.traces);
        }
        chart::time_grid(&mut drawing, times, analysis.columns);
        layout.bands.draw(&mut drawing, times, &Palette::of(drive));
        if layout.has_lines || layout.bands.height() > 0.0 {
            chart::time_axis(&mut drawing, times, analysis.columns);
        }
        for (number, remark) in layout.remarks.iter().enumerate() {
            let y = layout.foot + (number as f32 + 0.5) * REMARK;
            let text = drawing.fitted(remark, SMALL, layout.width - 2.0 * MARGIN);
            drawing.label(&text, SMALL, (MARGIN, y), Align::Left, ColorRole::Soft);
        }
        Self::new(drawing, layout.scale)
    }
}

/// Where the bands of a picture are.
#[cfg(test)]
pub(crate) fn times(analysis: &Analysis, size: Size) -> Area {
    Layout::new(analysis, size).times
}

fn heading(drawing: &mut Drawing, analysis: &Analysis, left: f32) {
    drawing.text(&analysis.title, 32.0, (left, 52.0), Align::Left, ColorRole::Ink);
    let switches: u64 = analysis.groups.iter().map(|statistics| statistics.switches).sum();
    let mut parts = vec![chart::seconds(analysis.columns.seconds())];
    parts.extend(analysis.begun());
    if switches > 0 {
        parts.push(format!("{switches} switches"));
    }
    drawing.text(
        &parts.join("  ·  "),
        18.0,
        (left, 84.0),
        Align::Left,
        ColorRole::Soft,
    );
}

/// What a picture lacks, and why.
fn remarks(analysis: &Analysis) -> Vec<String> {
    let mut remarks = analysis.remarks();
    if analysis.traces.is_empty() && !analysis.ending.drive.has_way() {
        remarks.push("the recording does not say where the robot was".to_owned());
    }
    if !analysis.bands.iter().any(crate::analysis::Band::was_awake) {
        remarks.push("it does not say who was in which state: it holds no selections".to_owned());
    }
    remarks
}
