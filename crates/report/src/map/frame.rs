//! Where everything stands on the paper: how metres become units, and the room for title, labels and legend.
//!
//! It refuses to draw.

use jde_sim::{Bounds, Outline};
use tiny_skia::Rect;

use super::Drive;
use super::legend::Entry;
use crate::chart::round_up;
use crate::drawing::Font;

/// Units of the whole width, unless the world is too high for it: fills a page at 200 dots an inch.
const WIDTH: f64 = 1600.0;
/// Units that the map is high at most, so that the picture fits a screen turned upright.
const MAP_HEIGHT: f64 = 1200.0;
/// Units that the picture is wide at least, for its title.
const LEAST_WIDTH: f64 = 760.0;
/// White paper at the edges, units.
const MARGIN: f64 = 36.0;
/// Units above the map, with the title.
const TOP: f64 = 104.0;
/// Units left of the map, with the labels.
const LEFT: f64 = 84.0;
/// Units below the map, with the labels and the scale bar.
const BELOW: f64 = 70.0;
/// Units from one row of the legend to the next.
const ROW: f64 = 34.0;
/// Units between two entries of the legend in a row, and between the map and a legend beside it.
const GAP: f64 = 28.0;
/// From this width for a height of 1 on, the legend goes below the map.
const WIDE: f64 = 1.15;
/// A map is at most so many times as wide as high, or as high as wide: a thin one gets some ground beside it.
const THINNEST: f64 = 10.0;
/// A map shows at least so many metres, so that a robot that stood still has a place.
const LEAST_METRES: f64 = 2.0;
/// Units of a map at least, however little room there is.
const LEAST: f64 = 40.0;
/// Units between two lines of the grid at least.
const GRID: f64 = 80.0;

/// The layout of one map.
#[derive(Debug)]
pub(crate) struct Frame {
    /// Units of all of it.
    pub(super) width: f32,
    /// Units of all of it.
    pub(super) height: f32,
    /// The map on the paper.
    pub(super) map: Rect,
    /// What the map shows, metres.
    pub(super) shown: Bounds,
    /// Units of a metre.
    pub(super) scale: f64,
    /// Metres from one line of the grid to the next: 1, 2 or 5 of a power of ten.
    pub(super) grid: f64,
    /// The left ends of the legend's entries, at half their height.
    pub(super) legend: Vec<(f32, f32)>,
}

/// What there is to share out.
struct Sheet {
    shown: Bounds,
    /// Units above the map.
    top: f64,
    /// Widths of the legend's entries.
    entries: Vec<f64>,
}

impl Frame {
    /// Shares the paper for a drive and the entries of its legend; `heading` if there is one above the map.
    pub(super) fn of(drive: &Drive, entries: &[Entry], heading: bool) -> Self {
        let sheet = Sheet::new(drive, entries, heading);
        let [wide, high] = size(&sheet.shown);
        let below = wide / high >= WIDE;
        let scale = ((WIDTH - LEFT - MARGIN) / wide).min(MAP_HEIGHT / high);
        let room = below.then_some(wide * scale);
        let mut frame = sheet.frame(scale, room);
        frame.width = frame.width.max(LEAST_WIDTH as f32);
        frame
    }

    /// Shares a part of the paper, so wide and high. The legend goes where it leaves the map more.
    pub(super) fn within(drive: &Drive, entries: &[Entry], width: f32, height: f32) -> Self {
        let sheet = Sheet::new(drive, entries, true);
        let [wide, high] = size(&sheet.shown);
        let [width, height] = [
            f64::from(width) - LEFT - MARGIN,
            f64::from(height) - sheet.top - BELOW - MARGIN / 2.0,
        ];
        let scale = |width: f64, height: f64| (width.max(LEAST) / wide).min(height.max(LEAST) / high);
        let (_, rows) = flow(&sheet.entries, width);
        let beside = scale(width - sheet.beside(), height);
        let below = scale(width, height - rows as f64 * ROW);
        if below > beside {
            sheet.frame(below, Some(width))
        } else {
            sheet.frame(beside, None)
        }
    }

    /// Gives the pixel of a place in metres.
    pub(super) fn at(&self, x: f64, y: f64) -> (f32, f32) {
        let right = (x - self.shown.min[0]) * self.scale;
        let up = (y - self.shown.min[1]) * self.scale;
        (self.map.left() + right as f32, self.map.bottom() - up as f32)
    }

    /// Gives the units of a length in metres.
    pub(super) fn pixels(&self, metres: f64) -> f32 {
        (metres * self.scale) as f32
    }

    /// Gives the places of the grid's lines along an axis, 0 for x and 1 for y, in metres.
    pub(super) fn grid_lines(&self, axis: usize) -> impl Iterator<Item = f64> {
        let step = self.grid;
        let first = (self.shown.min[axis] / step).ceil() as i64;
        let last = (self.shown.max[axis] / step).floor() as i64;
        (first..=last).map(move |line| line as f64 * step)
    }
}

impl Sheet {
    fn new(drive: &Drive, entries: &[Entry], heading: bool) -> Self {
        let font = Font::new();
        let width = |entry: &Entry| f64::from(entry.width(&font));
        Self {
            shown: shown(drive),
            top: if heading { TOP } else { MARGIN },
            entries: entries.iter().map(width).collect(),
        }
    }

    /// Units that a legend beside the map takes.
    fn beside(&self) -> f64 {
        GAP + self.entries.iter().copied().fold(0.0, f64::max)
    }

    /// Puts everything in its place, the legend below the map in rows of that width, or beside it.
    fn frame(self, scale: f64, below: Option<f64>) -> Frame {
        let top = self.top;
        let [map_width, map_height] = size(&self.shown).map(|metres| metres * scale);
        let foot = top + map_height + BELOW;
        let beside = self.beside();
        let (legend, width, height): (Vec<_>, f64, f64) = match below {
            Some(room) => {
                let (places, rows) = flow(&self.entries, room);
                let at = |(x, row): (f64, usize)| (LEFT + x, foot + (row as f64 + 0.5) * ROW);
                (
                    places.into_iter().map(at).collect(),
                    0.0,
                    foot + rows as f64 * ROW,
                )
            }
            None => {
                let at = |row: usize| (LEFT + map_width + GAP, top + (row as f64 + 0.5) * ROW);
                let rows = self.entries.len();
                let column = top + rows as f64 * ROW + MARGIN / 2.0;
                ((0..rows).map(at).collect(), beside, foot.max(column))
            }
        };
        Frame {
            width: (LEFT + map_width + width + MARGIN).round() as f32,
            height: (height + MARGIN / 2.0).round() as f32,
            map: Rect::from_xywh(LEFT as f32, top as f32, map_width as f32, map_height as f32)
                .expect("a map has a finite size that is not 0"),
            shown: self.shown,
            scale,
            grid: round_up(GRID / scale),
            legend: legend.into_iter().map(|(x, y)| (x as f32, y as f32)).collect(),
        }
    }
}

/// What the map shows: the bounds, all that the robot met, and a little ground around.
fn shown(drive: &Drive) -> Bounds {
    let mut points: Vec<[f64; 2]> = drive
        .bounds
        .iter()
        .flat_map(|bounds| [bounds.min, bounds.max])
        .collect();
    let reach = drive.robot_radius;
    for at in drive.places() {
        points.extend([[at.x - reach, at.y - reach], [at.x + reach, at.y + reach]]);
    }
    points.extend(drive.targets.iter().map(|target| [target.x, target.y]));
    if drive.bounds.is_none() {
        drive
            .shapes
            .iter()
            .for_each(|thing| points.extend(corners(&thing.outline)));
        points.extend(core(&drive.scans));
    }
    let mut shown = points.first().map_or(
        Bounds {
            min: [0.0; 2],
            max: [0.0; 2],
        },
        |first| Bounds {
            min: *first,
            max: *first,
        },
    );
    for [x, y] in points {
        shown.min = [shown.min[0].min(x), shown.min[1].min(y)];
        shown.max = [shown.max[0].max(x), shown.max[1].max(y)];
    }
    let [wide, high] = size(&shown);
    let longest = wide.max(high);
    let least = LEAST_METRES.max(longest / THINNEST);
    let around = longest * 0.02;
    grow(&mut shown, 0, ((least - wide) / 2.0).max(around));
    grow(&mut shown, 1, ((least - high) / 2.0).max(around));
    shown
}

/// The rectangle that holds all but the outermost hundredth of the points on each side: one beam through a door must
/// not shrink the rest.
fn core(points: &[(f64, f64)]) -> Vec<[f64; 2]> {
    let side = |numbers: &mut dyn Iterator<Item = f64>| {
        let mut numbers: Vec<f64> = numbers.collect();
        numbers.sort_by(f64::total_cmp);
        let left_out = numbers.len() / 100;
        Some((
            *numbers.get(left_out)?,
            *numbers.get(numbers.len() - 1 - left_out)?,
        ))
    };
    let x = side(&mut points.iter().map(|point| point.0));
    let y = side(&mut points.iter().map(|point| point.1));
    x.zip(y)
        .map(|((left, right), (low, high))| vec![[left, low], [right, high]])
        .unwrap_or_default()
}

fn corners(outline: &Outline) -> Vec<[f64; 2]> {
    match *outline {
        Outline::Segment { from, to } => vec![from, to],
        Outline::Box { center, size, angle } => box_corners(center, size, angle).to_vec(),
        Outline::Circle {
            center: [x, y],
            radius,
        } => vec![[x - radius, y - radius], [x + radius, y + radius]],
    }
}

/// Gives the corners of a rectangle, counter-clockwise.
pub(super) fn box_corners(center: [f64; 2], size: [f64; 2], angle: f64) -> [[f64; 2]; 4] {
    let (sin, cos) = angle.sin_cos();
    [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(along, across)| {
        let (x, y) = (along * size[0], across * size[1]);
        [center[0] + cos * x - sin * y, center[1] + sin * x + cos * y]
    })
}

fn size(bounds: &Bounds) -> [f64; 2] {
    [bounds.max[0] - bounds.min[0], bounds.max[1] - bounds.min[1]]
}

fn grow(bounds: &mut Bounds, axis: usize, by: f64) {
    bounds.min[axis] -= by;
    bounds.max[axis] += by;
}

/// Sets entries in rows; gives each its x and row, and how many rows there are.
fn flow(widths: &[f64], room: f64) -> (Vec<(f64, usize)>, usize) {
    let (mut x, mut row) = (0.0, 0);
    let mut places = Vec::new();
    for width in widths {
        if x > 0.0 && x + width > room {
            (x, row) = (0.0, row + 1);
        }
        places.push((x, row));
        x += width + GAP;
    }
    (places, row + 1)
}
