//! The layout of a map: its scale, and the room for title, labels and legend.
//!
//! It draws nothing.

use jde_sim::{Bounds, Footprint, Outline};
use tiny_skia::Rect;

use super::DriveMap;
use super::legend::LegendEntry;
use crate::Font;
use crate::round::round_up;

/// Usual width of a map with its margins, units: fills a page at 200 dots per inch.
const USUAL_WIDTH: f64 = 1600.0;
/// Greatest height of the map, units, so that the picture fits a screen in portrait format.
const MAP_HEIGHT: f64 = 1200.0;
/// Least width of the picture for its title, units.
const LEAST_WIDTH: f64 = 760.0;
/// Margin at the edges, units.
const EDGE_MARGIN: f64 = 36.0;
/// Height above the map for the title, units.
const TITLE_HEIGHT: f64 = 104.0;
/// Width left of the map for the labels, units.
const LABELS_WIDTH: f64 = 84.0;
/// Height below the map for the labels and the scale bar, units.
const SCALE_BAR_HEIGHT: f64 = 70.0;
/// Distance between rows of the legend, units.
const LEGEND_ROW: f64 = 34.0;
/// Distance between entries of the legend in a row, and between the map and a legend beside it, units.
const LEGEND_GAP: f64 = 28.0;
/// Least ratio of width to height at which the legend is placed below the map.
const WIDE_RATIO: f64 = 1.15;
/// Greatest ratio between the sides of a map; a thinner one is extended.
const MAX_SIDE_RATIO: f64 = 10.0;
/// Least side of a map, metres, so that a robot that did not move is visible.
const LEAST_METRES: f64 = 2.0;
/// Least side of a map on paper, units, however little room there is.
const MIN_SIDE: f64 = 40.0;
/// Least distance between two grid lines, units.
const MIN_GRID_DISTANCE: f64 = 80.0;

/// The layout of one map.
#[derive(Debug)]
pub(crate) struct Frame {
    /// The whole width, units.
    pub(super) width: f32,
    /// The whole height, units.
    pub(super) height: f32,
    /// The map's rectangle.
    pub(super) map: Rect,
    /// The area that the map shows, metres.
    pub(super) shown: Bounds,
    /// Units per metre.
    pub(super) scale: f64,
    /// Distance between grid lines, metres: 1, 2 or 5 times a power of ten.
    pub(super) grid: f64,
    /// The left ends of the legend's entries, at half their height.
    pub(super) legend: Vec<(f32, f32)>,
}

/// What a layout has to place.
struct Sheet {
    shown: Bounds,
    /// Height above the map, units.
    top: f64,
    /// Widths of the legend's entries.
    entries: Vec<f64>,
}

impl Frame {
    /// Lays out a drive and the entries of its legend; with `heading`, reserves room for a title above the
    /// map.
    pub(super) fn of(drive: &DriveMap, entries: &[LegendEntry], heading: bool) -> Self {
        let sheet = Sheet::new(drive, entries, heading);
        let [width_m, height_m] = size(&sheet.shown);
        let below = width_m / height_m >= WIDE_RATIO;
        let scale = ((USUAL_WIDTH - LABELS_WIDTH - EDGE_MARGIN) / width_m).min(MAP_HEIGHT / height_m);
        let row_width = below.then_some(width_m * scale);
        let mut frame = sheet.frame(scale, row_width);
        frame.width = frame.width.max(LEAST_WIDTH as f32);
        frame
    }

    /// Lays out a map within a given size; with `heading`, reserves room for a title above the map. The legend
    /// is placed where it leaves the map larger.
    pub(super) fn within(
        drive: &DriveMap,
        entries: &[LegendEntry],
        heading: bool,
        width: f32,
        height: f32,
    ) -> Self {
        let sheet = Sheet::new(drive, entries, heading);
        let [width_m, height_m] = size(&sheet.shown);
        let [width, height] = [
            f64::from(width) - LABELS_WIDTH - EDGE_MARGIN,
            f64::from(height) - sheet.top - SCALE_BAR_HEIGHT - EDGE_MARGIN / 2.0,
        ];
        let scale =
            |width: f64, height: f64| (width.max(MIN_SIDE) / width_m).min(height.max(MIN_SIDE) / height_m);
        let (_, rows) = arrange(&sheet.entries, width);
        let beside = scale(width - sheet.beside(), height);
        let below = scale(width, height - rows as f64 * LEGEND_ROW);
        if below > beside {
            sheet.frame(below, Some(width))
        } else {
            sheet.frame(beside, None)
        }
    }

    /// The position of a place in metres.
    pub(super) fn at(&self, x: f64, y: f64) -> (f32, f32) {
        let right = (x - self.shown.min[0]) * self.scale;
        let up = (y - self.shown.min[1]) * self.scale;
        (self.map.left() + right as f32, self.map.bottom() - up as f32)
    }

    /// The length in units of a length in metres.
    pub(super) fn pixels(&self, metres: f64) -> f32 {
        (metres * self.scale) as f32
    }

    /// The positions of the grid lines on an axis, 0 for x and 1 for y, in metres.
    pub(super) fn grid_lines(&self, axis: usize) -> impl Iterator<Item = f64> {
        let step = self.grid;
        let first = (self.shown.min[axis] / step).ceil() as i64;
        let last = (self.shown.max[axis] / step).floor() as i64;
        (first..=last).map(move |line| line as f64 * step)
    }
}

impl Sheet {
    fn new(drive: &DriveMap, entries: &[LegendEntry], heading: bool) -> Self {
        let font = Font::default();
        let width = |entry: &LegendEntry| f64::from(entry.width(&font));
        Self {
            shown: shown(drive),
            top: if heading { TITLE_HEIGHT } else { EDGE_MARGIN },
            entries: entries.iter().map(width).collect(),
        }
    }

    /// Width of a legend beside the map, units.
    fn beside(&self) -> f64 {
        LEGEND_GAP + self.entries.iter().copied().fold(0.0, f64::max)
    }

    /// Places everything: the legend below the map in rows of the width `below`, or beside it.
    fn frame(self, scale: f64, below: Option<f64>) -> Frame {
        let top = self.top;
        let [map_width, map_height] = size(&self.shown).map(|metres| metres * scale);
        let legend_top = top + map_height + SCALE_BAR_HEIGHT;
        let beside = self.beside();
        let (legend, width, height): (Vec<_>, f64, f64) = match below {
            Some(row_width) => {
                let (places, rows) = arrange(&self.entries, row_width);
                let at =
                    |(x, row): (f64, usize)| (LABELS_WIDTH + x, legend_top + (row as f64 + 0.5) * LEGEND_ROW);
                (
                    places.into_iter().map(at).collect(),
                    0.0,
                    legend_top + rows as f64 * LEGEND_ROW,
                )
            }
            None => {
                let at = |row: usize| {
                    (
                        LABELS_WIDTH + map_width + LEGEND_GAP,
                        top + (row as f64 + 0.5) * LEGEND_ROW,
                    )
                };
                let rows = self.entries.len();
                let column = top + rows as f64 * LEGEND_ROW + EDGE_MARGIN / 2.0;
                ((0..rows).map(at).collect(), beside, legend_top.max(column))
            }
        };
        Frame {
            width: (LABELS_WIDTH + map_width + width + EDGE_MARGIN).round() as f32,
            height: (height + EDGE_MARGIN / 2.0).round() as f32,
            map: Rect::from_xywh(
                LABELS_WIDTH as f32,
                top as f32,
                map_width as f32,
                map_height as f32,
            )
            .expect("a map has a finite size that is not 0"),
            shown: self.shown,
            scale,
            grid: round_up(MIN_GRID_DISTANCE / scale),
            legend: legend.into_iter().map(|(x, y)| (x as f32, y as f32)).collect(),
        }
    }
}

/// The area that the map shows: all places of the drive, its bounds or else its shapes and scans, and a
/// margin.
fn shown(drive: &DriveMap) -> Bounds {
    let mut points: Vec<[f64; 2]> = drive
        .bounds
        .iter()
        .flat_map(|bounds| [bounds.min, bounds.max])
        .collect();
    for path in &drive.paths {
        let radius = path.body.as_ref().map_or(0.0, Footprint::radius);
        for at in &path.points {
            points.extend([[at.x - radius, at.y - radius], [at.x + radius, at.y + radius]]);
        }
    }
    points.extend(drive.targets.iter().map(|target| [target.x, target.y]));
    if drive.bounds.is_none() {
        drive
            .shapes
            .iter()
            .for_each(|thing| points.extend(corners(&thing.outline)));
        points.extend(central_bounds(&drive.scans));
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
    let [width_m, height_m] = size(&shown);
    let longest = width_m.max(height_m);
    let least = LEAST_METRES.max(longest / MAX_SIDE_RATIO);
    let margin = longest * 0.02;
    grow(&mut shown, 0, ((least - width_m) / 2.0).max(margin));
    grow(&mut shown, 1, ((least - height_m) / 2.0).max(margin));
    shown
}

/// The bounding box of the points without the outermost hundredth on each side, so that a single beam through
/// a door does not shrink the map.
fn central_bounds(points: &[(f64, f64)]) -> Vec<[f64; 2]> {
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

/// The corners of a rectangle, counter-clockwise.
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

fn grow(bounds: &mut Bounds, axis: usize, margin: f64) {
    bounds.min[axis] -= margin;
    bounds.max[axis] += margin;
}

/// Arranges entries in rows; returns the x and row of each, and the number of rows.
fn arrange(widths: &[f64], row_width: f64) -> (Vec<(f64, usize)>, usize) {
    let (mut x, mut row) = (0.0, 0);
    let mut places = Vec::new();
    for width in widths {
        if x > 0.0 && x + width > row_width {
            (x, row) = (0.0, row + 1);
        }
        places.push((x, row));
        x += width + LEGEND_GAP;
    }
    (places, row + 1)
}
