//! Where drives fail: cells whose colour is stronger the more drives failed in them, and a dot for each drive.

use tiny_skia::Rect;

use super::frame::Frame;
use jde_timeline::is_placed;

use super::{DriveMap, PathPoint, RobotPath, finite, ground};
use crate::round::round_up;
use crate::{ColorRole, Drawing, LineStyle};

/// Cells along the longer side of the map, about: as large as a robot in a room.
const CELLS_ALONG_SIDE: f64 = 40.0;
/// Radius of a dot, units.
const DOT_RADIUS: f32 = 5.0;
/// More drives have no dots of their own, since those would hide the map.
const MAX_DOTS: usize = 2_000;

/// Where a drive failed.
#[derive(Clone, Debug, PartialEq)]
pub struct FailurePlace {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// What is shown where one points at it.
    pub label: String,
}

/// Draws the ground of a drive, and where drives failed on it, in at most `width` by `height` units. A place
/// without a valid position is left out.
#[must_use]
pub fn draw_failures(drive: &DriveMap, places: &[FailurePlace], width: f32, height: f32) -> Drawing {
    let placed = |place: &&FailurePlace| is_placed(&[place.x, place.y]);
    let places: Vec<&FailurePlace> = places.iter().filter(placed).collect();
    let paths = places.iter().map(|place| RobotPath {
        points: vec![PathPoint {
            time: 0.0,
            x: place.x,
            y: place.y,
            heading: 0.0,
            winner: None,
        }],
        ..RobotPath::default()
    });
    // The map shows all paths, so that a place outside of the world is shown too.
    let drive = finite(&DriveMap {
        paths: paths.collect(),
        ..drive.clone()
    });
    let frame = Frame::within(&drive, &[], false, width, height);
    let mut drawing = Drawing::new(frame.width, frame.height);
    ground::draw(&mut drawing, &frame, &drive);
    drawing.clip(Some(frame.map));
    cells(&mut drawing, &frame, &places);
    if places.len() <= MAX_DOTS {
        dots(&mut drawing, &frame, &places);
    }
    drawing.clip(None);
    ground::edge(&mut drawing, &frame);
    drawing
}

fn cells(drawing: &mut Drawing, frame: &Frame, places: &[&FailurePlace]) {
    let longest = f64::from(frame.map.width().max(frame.map.height())) / frame.scale;
    let side = round_up(longest / CELLS_ALONG_SIDE);
    let mut counts = std::collections::BTreeMap::<(i64, i64), usize>::new();
    for place in places {
        let cell = [place.x, place.y].map(|along| (along / side).floor() as i64);
        *counts.entry((cell[0], cell[1])).or_default() += 1;
    }
    let most = counts.values().copied().max().unwrap_or(1);
    for ((column, row), count) in counts {
        let at = |column: i64, row: i64| frame.at(column as f64 * side, row as f64 * side);
        let ((left, bottom), (right, top)) = (at(column, row), at(column + 1, row + 1));
        let Some(cell) = Rect::from_ltrb(left, top, right, bottom) else {
            continue;
        };
        let shade = ColorRole::Bad.faded(0.15 + 0.5 * count as f32 / most as f32);
        drawing.note(Some(crate::text::counted(count as u64, "drive")));
        drawing.bar((cell.x(), cell.y()), cell.width(), cell.height(), shade);
    }
    drawing.note(None);
}

fn dots(drawing: &mut Drawing, frame: &Frame, places: &[&FailurePlace]) {
    for place in places {
        let at = frame.at(place.x, place.y);
        drawing.note(Some(place.label.clone()));
        drawing.disc(at, DOT_RADIUS, ColorRole::Bad);
        drawing.ring(at, DOT_RADIUS, LineStyle::new(ColorRole::Paper, 1.2));
    }
    drawing.note(None);
}
