//! The floor of a world file: its colour, painted areas and painted lines. Lines lie over areas, and of each
//! the later over the earlier.

use parry2d_f64::math::Vector;

use super::fixtures::{each, polyline, rectangle};
use super::values::{self, between};
use crate::color::Color;
use crate::floor::{Floor, Paint, PaintForm, PaintedArea, PaintedLine, Tiles};
use jde_document::{FaultReport, Section};

/// The default colour of the floor.
const FLOOR: Color = Color::new(150, 143, 131);
/// The default colour of a line: black tape.
const LINE: Color = Color::new(32, 33, 36);
/// The default width of a line in metres: that of insulating tape, rounded.
const LINE_WIDTH: f64 = 0.02;
/// The default colour of an area.
const AREA: Color = Color::new(245, 245, 242);
/// Most tiles of an area: more are most likely a typing error.
const MAX_TILES: f64 = 10_000.0;
/// The greatest turn between two pieces of a bend, in radians: its corners are then within a thousandth of
/// its radius from the arc.
const PIECE: f64 = 5.0 / 180.0 * std::f64::consts::PI;

const LINE_KEYS: [&str; 6] = ["name", "points", "closed", "bend", "width", "color"];
const AREA_KEYS: [&str; 7] = [
    "name",
    "center",
    "size",
    "angle_deg",
    "color",
    "tile",
    "tile_color",
];

pub(crate) fn read(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Floor> {
    let color = root.optional(report, "floor", FLOOR, values::color);
    let areas = each(report, root, "floor_areas", "floor area", &AREA_KEYS, area);
    let lines = each(report, root, "floor_lines", "floor line", &LINE_KEYS, line);
    let mut paints = areas?;
    paints.extend(lines?);
    Some(Floor {
        color: color?,
        paints,
    })
}

fn area(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<Paint> {
    let rectangle = rectangle(report, table);
    let color = table.optional(report, "color", AREA, values::color);
    let side = table.optional(report, "tile", None, |node| {
        between(0.001, 100.0, "m")(node).map(Some)
    });
    let second = table.optional(report, "tile_color", LINE, values::color);
    let ((center, size, angle), side, second) = (rectangle?, side?, second?);
    if let (None, Some(node)) = (side, table.get("tile_color")) {
        table.fault(
            report,
            &node.span(),
            "has a `tile_color` and no `tile`: add the side of a tile, or drop it",
        );
        return None;
    }
    let count = side.map_or(0.0, |side| size[0] / side * (size[1] / side));
    if count > MAX_TILES {
        table.fault(
            report,
            &table.span,
            format!("has {count:.0} tiles: expected at most {MAX_TILES}"),
        );
        return None;
    }
    let tiles = side.map(|side| Tiles { side, color: second });
    Some(Paint {
        name,
        color: color?,
        form: PaintForm::Area(PaintedArea {
            center,
            size,
            angle,
            tiles,
        }),
    })
}

fn line(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<Paint> {
    let points = polyline(report, table);
    let radius = table.optional(report, "bend", 0.0, between(0.0, 1e3, "m"));
    let width = table.optional(report, "width", LINE_WIDTH, between(0.001, 10.0, "m"));
    let color = table.optional(report, "color", LINE, values::color);
    let bent = bent(&points?, radius?)
        .map_err(|message| {
            table.fault(report, &table.span, message);
        })
        .ok()?;
    Some(Paint {
        name,
        color: color?,
        form: PaintForm::Line(PaintedLine::new(&bent, width?)),
    })
}

/// Returns the points of a line with its corners rounded by arcs of a radius. A line that ends at its start
/// is closed, and round there too.
///
/// # Errors
/// A leg that is too short for the arcs at its ends.
fn bent(points: &[[f64; 2]], radius: f64) -> Result<Vec<[f64; 2]>, String> {
    let legs: Vec<Vector> = points
        .windows(2)
        .map(|pair| Vector::from(pair[1]) - Vector::from(pair[0]))
        .collect();
    let closed = points.first() == points.last();
    let corners: Vec<Corner> = (0..points.len())
        .map(|index| {
            let end = index == 0 || index == legs.len();
            let before = legs[(index + legs.len() - 1) % legs.len()].normalize();
            let after = legs[index % legs.len()].normalize();
            let turn = libm::atan2(before.perp_dot(after), before.dot(after));
            Corner {
                point: points[index].into(),
                before,
                turn: if end && !closed { 0.0 } else { turn },
            }
        })
        .collect();
    for (index, leg) in legs.iter().enumerate() {
        let need = corners[index].tangent(radius) + corners[index + 1].tangent(radius);
        if need > leg.length() + 1e-9 {
            let (number, length) = (index + 1, leg.length());
            return Err(format!(
                "has a `bend` that needs {need:.3} m of the leg from point {number}, which has {length:.3} m: make it smaller"
            ));
        }
    }
    let corners = &corners[usize::from(closed)..];
    let mut bent: Vec<[f64; 2]> = corners.iter().flat_map(|corner| corner.arc(radius)).collect();
    bent.extend(closed.then(|| bent[0]));
    bent.dedup_by(|point, before| !values::are_apart(*before, *point));
    Ok(bent)
}

/// A point of a line, and how the line turns there.
struct Corner {
    point: Vector,
    /// The direction in which the line comes.
    before: Vector,
    /// To the left, in radians.
    turn: f64,
}

impl Corner {
    /// Returns how long before the corner an arc of a radius begins.
    fn tangent(&self, radius: f64) -> f64 {
        radius * libm::tan(self.turn.abs() / 2.0)
    }

    /// Returns the points of the arc: the corner itself without a turn or a radius.
    fn arc(&self, radius: f64) -> Vec<[f64; 2]> {
        let pieces = libm::ceil(self.turn.abs() / PIECE);
        if pieces == 0.0 || radius == 0.0 {
            return vec![self.point.into()];
        }
        let start = self.point - self.before * self.tangent(radius);
        let left = self.before.perp() * radius * self.turn.signum();
        let place = |piece: u32| {
            let (sin, cos) = libm::sincos(self.turn.abs() * f64::from(piece) / pieces);
            start + self.before * (radius * sin) + left * (1.0 - cos)
        };
        (0..=pieces as u32).map(|piece| place(piece).into()).collect()
    }
}
