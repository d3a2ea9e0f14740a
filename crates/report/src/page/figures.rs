//! The drawings of a page: the path and the bands of states.

use maud::{Markup, html};

use super::Page;
use crate::chart::{self, Area, Bands};
use crate::drawing::Drawing;
use crate::map;

/// Width of the bands' drawing, units: that of the page at its widest.
const WIDTH: f32 = 1200.0;
/// Greatest height of all bands, units.
const MOST: f32 = 6000.0;
/// Height below the bands for the times, units.
const TIMES: f32 = 28.0;

pub(super) fn path(page: &Page<'_>) -> Option<Markup> {
    let drive = &page.analysis.ending.drive;
    if !drive.has_way() {
        return None;
    }
    let drawing = map::draw(drive, false);
    let label = format!(
        "The way of the robot of {}, in the colours of who acted",
        page.analysis.title
    );
    Some(html! {
        p.note { "From above, in the colours of who acted; a ring where the winner changed." }
        figure.map { (drawing.svg(&label, "m")) }
    })
}

pub(super) fn bands(page: &Page<'_>) -> Option<Markup> {
    let analysis = page.analysis;
    let bands = Bands::new(analysis, MOST);
    if bands.height() == 0.0 {
        return None;
    }
    let area = Area {
        left: chart::NAMES,
        top: 0.0,
        width: WIDTH - chart::NAMES - chart::NUMBERS,
        height: bands.height(),
    };
    let mut drawing = Drawing::new(WIDTH, area.height + TIMES);
    chart::time_grid(&mut drawing, area, analysis.columns);
    bands.draw(&mut drawing, area, &page.palette);
    chart::time_axis(&mut drawing, area, analysis.columns);
    let seconds = |time: u64| time as f64 / 1e9;
    let (from, to) = (seconds(analysis.columns.from), seconds(analysis.columns.to));
    Some(html! {
        p.note {
            "High and in colour: WINNER; half as high: READY; low: CHECKING; nothing: SLEPT. Of a group, who won it, and a mark at every "
            "switch. At the right the share of time as WINNER."
            @if bands.left_out > 0 { " " (bands.left_out) " rows are left out: schemas that never were awake, and what is beyond a page." }
        }
        figure id="bands" data-from=(from) data-to=(to) data-left=(area.left / WIDTH) data-right=(area.right() / WIDTH) {
            (drawing.svg("States of all schemas over time", "b"))
        }
    })
}
