//! A picture of a recording: the robots' paths or numbers over time, and below them the schemas' states on
//! one time axis.

use jde_core::Nanos;
use jde_drawing::Picture;
use jde_drawing::map::{self, Palette};
use jde_drawing::{Align, ColorRole, Drawing};

use crate::analysis::{Analysis, Columns, Series, Trace};
use crate::chart::{self, Area, Bands, SMALL};

/// Area of the usual picture, units. A larger picture shows the same content at a larger scale, not more.
const USUAL_AREA: f32 = 1600.0 * 1067.0;
/// Margin at the edges, units.
const EDGE_MARGIN: f32 = 36.0;
/// Height above charts for the title, units.
const HEADING_HEIGHT: f32 = 104.0;
/// Height above charts for a title alone, units.
const TITLE_HEIGHT: f32 = 72.0;
/// Width left of charts without row names for numbers, units.
const AXIS_WIDTH: f32 = 84.0;
/// Height below the bands for the times, units.
const TIMES_HEIGHT: f32 = 34.0;
/// Height of a line of remarks, units.
const REMARK_HEIGHT: f32 = 20.0;
/// Largest share of the height for the bands when there is a map or a chart.
const MAX_BANDS_SHARE: f32 = 0.42;

/// Smallest and largest side of a picture, pixels.
pub const SIDES: std::ops::RangeInclusive<u32> = 200..=8000;

/// The size of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels, within [`SIDES`].
    pub width: u32,
    /// Pixels, within [`SIDES`].
    pub height: u32,
}

impl Size {
    /// The number of time columns that a picture of this size can show.
    #[must_use]
    pub fn columns(self) -> usize {
        self.width as usize
    }

    /// Returns the pixels per unit, and the width and the height in units.
    fn units(self) -> (f32, f32, f32) {
        let (width, height) = (self.width as f32, self.height as f32);
        let scale = (width * height / USUAL_AREA).sqrt();
        (scale, width / scale, height / scale)
    }
}

/// A number over time: its name, and its values in the order of their times.
pub type Numbers = (String, Vec<(Nanos, f64)>);

/// The layout of a picture.
struct Layout<'t> {
    scale: f32,
    width: f32,
    height: f32,
    bands: Bands<'t>,
    /// The area of the bands, above the time axis.
    times: Area,
    remarks: Vec<String>,
    /// The top of the remarks.
    remarks_top: f32,
    has_lines: bool,
    has_map: bool,
}

impl<'t> Layout<'t> {
    fn new(analysis: &'t Analysis, size: Size) -> Self {
        let (scale, width, height) = size.units();
        let remarks = remarks(analysis);
        let remarks_top = height - EDGE_MARGIN / 2.0 - remarks.len() as f32 * REMARK_HEIGHT;
        let has_lines = !analysis.traces.is_empty();
        let has_map = !has_lines && analysis.ending.drive.has_path();
        let max_height = if has_lines || has_map {
            remarks_top * MAX_BANDS_SHARE
        } else {
            remarks_top - HEADING_HEIGHT - TIMES_HEIGHT
        };
        let bands = Bands::new(analysis, max_height);
        let (left, right) = if bands.height() > 0.0 {
            (EDGE_MARGIN + chart::NAMES, chart::NUMBERS + EDGE_MARGIN)
        } else {
            (AXIS_WIDTH, EDGE_MARGIN)
        };
        Self {
            scale,
            width,
            height,
            times: Area {
                left,
                top: remarks_top - TIMES_HEIGHT - bands.height(),
                width: (width - left - right).max(40.0),
                height: bands.height(),
            },
            bands,
            remarks,
            remarks_top,
            has_lines,
            has_map,
        }
    }
}

/// Draws a recording: its selected numbers if there are any, otherwise the robots' paths; and below the
/// schemas' states.
#[must_use]
pub fn draw_recording(analysis: &Analysis, size: Size) -> Picture {
    let layout = Layout::new(analysis, size);
    let (times, drive) = (layout.times, &analysis.ending.drive);
    let mut drawing = Drawing::new(layout.width, layout.height);
    if layout.has_map {
        map::draw_within(&mut drawing, drive, layout.width, times.top);
    } else {
        heading(&mut drawing, analysis, EDGE_MARGIN);
    }
    if layout.has_lines {
        let area = Area {
            top: HEADING_HEIGHT,
            height: (times.top - HEADING_HEIGHT).max(40.0),
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
        let y = layout.remarks_top + (number as f32 + 0.5) * REMARK_HEIGHT;
        let text = drawing.fitted(remark, SMALL, layout.width - 2.0 * EDGE_MARGIN);
        drawing.label(&text, SMALL, (EDGE_MARGIN, y), Align::Left, ColorRole::Soft);
    }
    Picture::new(drawing, layout.scale)
}

/// Draws numbers over time. A value holds until the next.
#[must_use]
pub fn draw_numbers(title: &str, numbers: Vec<Numbers>, size: Size) -> Picture {
    let (scale, width, height) = size.units();
    let values = numbers.iter().flat_map(|(_, values)| values);
    let (from, to) = values.fold((Nanos::MAX, 0), |(from, to), (time, _)| {
        (from.min(*time), to.max(*time))
    });
    let columns = Columns::new(from.min(to), to, size.columns());
    let traces = numbers.into_iter().map(|(name, values)| {
        let mut trace = Trace::new(columns);
        for (time, value) in values {
            trace.add(columns, time, Some(value));
        }
        trace.finish(columns);
        let in_no_recording = Series {
            topic: String::new(),
            variable: String::new(),
            name,
            unit: String::new(),
            number: Box::new(|_| Ok(None)),
        };
        (in_no_recording, trace)
    });
    let mut drawing = Drawing::new(width, height);
    drawing.text(title, 32.0, (EDGE_MARGIN, 52.0), Align::Left, ColorRole::Ink);
    let area = Area {
        left: AXIS_WIDTH,
        top: TITLE_HEIGHT,
        width: (width - AXIS_WIDTH - EDGE_MARGIN).max(40.0),
        height: (height - TITLE_HEIGHT - TIMES_HEIGHT).max(40.0),
    };
    chart::charts(&mut drawing, area, columns, &Vec::from_iter(traces));
    chart::time_axis(&mut drawing, area, columns);
    Picture::new(drawing, scale)
}

/// The area of the bands of a picture.
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

/// Notes on what the picture lacks, and why.
fn remarks(analysis: &Analysis) -> Vec<String> {
    let mut remarks = analysis.remarks();
    if analysis.traces.is_empty() && !analysis.ending.drive.has_path() {
        remarks.push("the recording does not contain the robot's pose".to_owned());
    }
    if !analysis.bands.iter().any(crate::analysis::Band::was_awake) {
        remarks.push(
            "it does not contain the states of the schemas, because no selections were recorded".to_owned(),
        );
    }
    remarks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_a_program_has_are_drawn_over_their_time() {
        let size = Size {
            width: 800,
            height: 400,
        };
        let step = |time: u64| (time * 1_000_000_000, if time < 10 { 0.0 } else { 1.0 });
        let numbers = vec![("speed".to_owned(), (5..=15).map(step).collect())];
        let pixels = draw_numbers("a step", numbers, size).png().unwrap();
        let pixels = tiny_skia::Pixmap::decode_png(&pixels).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (800, 400));
        let height_at = |share: f32| {
            let (scale, width, _) = size.units();
            let x = ((AXIS_WIDTH + share * (width - AXIS_WIDTH - EDGE_MARGIN)) * scale) as u32;
            // The legend above the chart has the colour too.
            let mut column = (TITLE_HEIGHT * scale) as u32 + 30..400;
            column.find(|y| {
                let pixel = pixels.pixel(x, *y).unwrap();
                pixel.blue() > pixel.red().saturating_add(60)
            })
        };
        let (before, after) = (height_at(0.25).unwrap(), height_at(0.75).unwrap());
        assert!(before > after + 200, "{before} and {after}");
        let empty = draw_numbers("nothing", Vec::new(), size).png().unwrap();
        assert_ne!(empty, draw_numbers("else", Vec::new(), size).png().unwrap());
    }
}
