//! The drawings of a page: the path and the bands of states.

use jde_drawing::Drawing;
use jde_drawing::map;
use maud::{Markup, PreEscaped, html};

use super::Page;
use crate::chart::{self, Area, Bands};

/// Width of the bands' drawing, units: that of the page at its widest.
const BANDS_WIDTH: f32 = 1200.0;
/// Greatest height of all bands, units.
const MAX_HEIGHT: f32 = 6000.0;
/// Height below the bands for the times, units.
const TIMES_HEIGHT: f32 = 28.0;

pub(super) fn path(page: &Page<'_>) -> Option<Markup> {
    let drive = &page.analysis.ending.drive;
    if !drive.has_path() {
        return None;
    }
    let drawing = map::draw(drive, false);
    let label = format!(
        "The path of the robot of {}, in the colours of the acting schemas",
        page.analysis.title
    );
    Some(html! {
        p.note { "Seen from above, in the colours of the acting schemas. A ring marks a change of the winner." }
        figure.map { (PreEscaped(drawing.svg(&label, "m"))) }
    })
}

pub(super) fn bands(page: &Page<'_>) -> Option<Markup> {
    let analysis = page.analysis;
    let bands = Bands::new(analysis, MAX_HEIGHT);
    if bands.height() == 0.0 {
        return None;
    }
    let area = Area {
        left: chart::NAMES,
        top: 0.0,
        width: BANDS_WIDTH - chart::NAMES - chart::NUMBERS,
        height: bands.height(),
    };
    let mut drawing = Drawing::new(BANDS_WIDTH, area.height + TIMES_HEIGHT);
    chart::time_grid(&mut drawing, area, analysis.columns);
    bands.draw(&mut drawing, area, &page.palette);
    chart::time_axis(&mut drawing, area, analysis.columns);
    let seconds = |time: u64| time as f64 / 1e9;
    let (from, to) = (seconds(analysis.columns.from), seconds(analysis.columns.to));
    Some(html! {
        p.note {
            "High and in colour: WINNER; half as high: READY; low: CHECKING; empty: SLEPT. The row of a group shows its winner, with a mark at every "
            "switch. The numbers on the right are the share of time as WINNER."
            @if bands.left_out > 0 { " " (bands.left_out) " rows are not shown: schemas that were never awake, and rows beyond the height of a page." }
        }
        div.scroll { figure.bands id="bands" data-from=(from) data-to=(to) data-left=(area.left / BANDS_WIDTH) data-right=(area.right() / BANDS_WIDTH) {
            (PreEscaped(drawing.svg("States of all schemas over time", "b")))
        } }
    })
}
