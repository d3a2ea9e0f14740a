//! The fixed things of a world file: walls, boxes, tables and circles. `movers` reads the things that move on their
//! own, `loose` those that can be pushed.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one.

use super::loose;
use super::values::{self, between};
use crate::color::Color;
use crate::geometry::Pose2;
use crate::loose::LooseBody;
use crate::scene::Fixture;
use crate::shape::Outline;
use crate::solid::{REFLECTIVITY, Surface};
use jde_document::{FaultReport, Section};

/// The appearance of a thing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Appearance {
    pub(crate) color: Color,
    /// Metres above the floor.
    pub(crate) height: f64,
}

/// The default appearance of walls and of the blocks of a map: plaster, up to an invisible ceiling.
pub(crate) const WALL: Appearance = Appearance {
    color: Color::new(226, 221, 208),
    height: 2.5,
};
/// The default appearance of boxes: a desk.
pub(crate) const BOX: Appearance = Appearance {
    color: Color::new(176, 136, 92),
    height: 0.75,
};
/// The default appearance of circles: a painted thing.
const CIRCLE: Appearance = Appearance {
    color: Color::new(96, 134, 128),
    height: 0.75,
};

/// A fixed or a movable box.
pub(crate) enum BoxPlan {
    /// With the legs of a table.
    Fixed(Fixture, Vec<Fixture>),
    Loose(LooseBody),
}

/// The surfaces that a file can name.
const SURFACES: [(&str, Surface); 3] = [
    ("opaque", Surface::Opaque),
    ("glass", Surface::Glass),
    ("black", Surface::Black),
];

/// The keys of a box.
pub(super) const BOX_KEYS: [&str; 11] = [
    "name",
    "center",
    "size",
    "angle_deg",
    "color",
    "height",
    "movable",
    "mass",
    "reflectivity",
    "surface",
    "legs",
];

/// Reads the fixed things, and the boxes that are movable.
pub(crate) fn read(
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
) -> Option<(Vec<Fixture>, Vec<loose::PlacedBody>)> {
    let keys = [
        "name",
        "points",
        "closed",
        "color",
        "height",
        "reflectivity",
        "surface",
    ];
    let walls = each(report, root, "walls", "wall", &keys, wall);
    let boxes = each(report, root, "boxes", "box", &BOX_KEYS, |report, table, name| {
        Some((rectangular(report, table, name)?, table.span.clone()))
    });
    let keys = [
        "name",
        "center",
        "centers",
        "radius",
        "color",
        "height",
        "reflectivity",
        "surface",
    ];
    let circles = each(report, root, "circles", "circle", &keys, circles_of);
    let (mut fixtures, mut movable) = (walls?.concat(), Vec::new());
    for (plan, span) in boxes? {
        match plan {
            BoxPlan::Fixed(fixture, legs) => {
                fixtures.push(fixture);
                fixtures.extend(legs);
            }
            BoxPlan::Loose(body) => movable.push((body, span)),
        }
    }
    fixtures.extend(circles?.concat());
    Some((fixtures, movable))
}

/// Reads a box, fixed or movable.
pub(super) fn rectangular(
    report: &mut FaultReport<'_>,
    table: &Section<'_>,
    name: String,
) -> Option<BoxPlan> {
    match table.optional(report, "movable", false, values::flag)? {
        true => loose::movable(report, table, name).map(BoxPlan::Loose),
        false => fixed(report, table, name),
    }
}

/// Reads the `color` and the `height` of a thing.
pub(crate) fn read_appearance(
    report: &mut FaultReport<'_>,
    table: &Section<'_>,
    default: Appearance,
) -> Option<Appearance> {
    let color = table.optional(report, "color", default.color, values::color);
    let height = table.optional(report, "height", default.height, values::positive);
    Some(Appearance {
        color: color?,
        height: height?,
    })
}

/// Reads how bright a fixed thing is to a laser, up to 1000 times a white surface, as a retroreflector may be; and its
/// surface.
fn read_finish(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<(f64, Surface)> {
    let reflectivity = table.optional(report, "reflectivity", REFLECTIVITY, between(0.0, 1000.0, ""));
    let surface = table.optional(report, "surface", Surface::Opaque, |node| {
        values::one_of(node, "a surface", &SURFACES)
    });
    Some((reflectivity?, surface?))
}

/// Reads every table of a list, each with its name; `None` if any has a fault.
pub(crate) fn each<'a, T>(
    report: &mut FaultReport<'_>,
    root: &Section<'a>,
    key: &str,
    kind: &str,
    known: &[&str],
    read: impl Fn(&mut FaultReport<'_>, &Section<'a>, String) -> Option<T>,
) -> Option<Vec<T>> {
    let tables = root.tables(report, key, kind)?;
    let things: Vec<_> = (1..)
        .zip(tables)
        .map(|(number, table)| {
            let table = table?;
            table.refuse_unknown(report, known);
            let name = table.optional(report, "name", format!("{kind} {number}"), values::text);
            let thing = read(report, &table, name.clone().unwrap_or_default());
            name.and(thing)
        })
        .collect();
    things.into_iter().collect()
}

fn wall(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<Vec<Fixture>> {
    let appearance = read_appearance(report, table, WALL);
    let (points, finish) = (polyline(report, table), read_finish(report, table));
    let (appearance, points, (reflectivity, surface)) = (appearance?, points?, finish?);
    let sides = points.windows(2).map(|pair| Outline::Segment {
        from: pair[0],
        to: pair[1],
    });
    Some(
        sides
            .map(|outline| Fixture {
                reflectivity,
                surface,
                ..fixture(name.clone(), outline, appearance)
            })
            .collect(),
    )
}

/// Reads `points` and `closed`. A closed line ends with its first point.
pub(super) fn polyline(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Vec<[f64; 2]>> {
    let points = table.required(report, "points", values::points);
    let closed = table.optional(report, "closed", false, values::flag);
    let (mut points, closed) = (points?, closed?);
    if closed {
        if points.len() < 3 {
            table.fault(
                report,
                &table.span,
                "is `closed` with two points: expected three or more",
            );
            return None;
        }
        if points[0] == points[points.len() - 1] {
            table.fault(
                report,
                &table.span,
                "is `closed` and ends at its start: drop the last point",
            );
            return None;
        }
        points.push(points[0]);
    }
    Some(points)
}

fn fixed(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<BoxPlan> {
    if let Some(mass) = table.get("mass") {
        table.fault(
            report,
            &mass.span(),
            "has a `mass` and is not `movable`: add `movable = true`, or drop it",
        );
        return None;
    }
    let (appearance, rectangle) = (read_appearance(report, table, BOX), rectangle(report, table));
    let (finish, legs) = (read_finish(report, table), legs(report, table));
    let ((center, size, angle), (reflectivity, surface)) = (rectangle?, finish?);
    let (appearance, legs) = (appearance?, legs?);
    let whole = Fixture {
        reflectivity,
        surface,
        ..fixture(name, Outline::Box { center, size, angle }, appearance)
    };
    let Some(radius) = legs else {
        return Some(BoxPlan::Fixed(whole, Vec::new()));
    };
    let [x, y] = size.map(|size| size / 2.0 - radius);
    if x < radius || y < radius {
        let message = format!("has `legs` of radius {radius} m, which overlap: make them thinner");
        table.fault(report, &table.key_span("legs"), message);
        return None;
    }
    let middle = Pose2::new(center[0], center[1], angle);
    let legs = [[x, y], [-x, y], [-x, -y], [x, -y]].map(|[x, y]| {
        let leg = middle.compose(Pose2::new(x, y, 0.0));
        let outline = Outline::Circle {
            center: [leg.x, leg.y],
            radius,
        };
        Fixture {
            outline,
            ..whole.clone()
        }
    });
    let top = Fixture {
        surface: Surface::Tabletop,
        ..whole
    };
    Some(BoxPlan::Fixed(top, legs.into()))
}

/// Reads the radius of the legs of a table; `None` for a box that is none.
fn legs(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Option<f64>> {
    table.optional(report, "legs", None, |node| values::positive(node).map(Some))
}

/// Reads the center, the size and the angle in radians of a box.
pub(crate) fn rectangle(
    report: &mut FaultReport<'_>,
    table: &Section<'_>,
) -> Option<([f64; 2], [f64; 2], f64)> {
    let (center, size) = (
        table.required(report, "center", values::point),
        table.required(report, "size", values::size),
    );
    let angle = table.optional(report, "angle_deg", 0.0, values::number);
    Some((center?, size?, angle?.to_radians()))
}

/// Reads one circle, or several equal ones.
fn circles_of(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<Vec<Fixture>> {
    let appearance = read_appearance(report, table, CIRCLE);
    let radius = table.required(report, "radius", values::positive);
    let centers = match (table.get("centers"), table.get("center")) {
        (Some(_), None) => table.required(report, "centers", values::centers),
        (None, _) => table
            .required(report, "center", values::point)
            .map(|center| vec![center]),
        (Some(centers), Some(_)) => {
            table.fault(report, &centers.span(), "has `center` and `centers`: drop one");
            None
        }
    };
    let finish = read_finish(report, table);
    let (appearance, radius, (reflectivity, surface)) = (appearance?, radius?, finish?);
    let circle = |center| Fixture {
        reflectivity,
        surface,
        ..fixture(name.clone(), Outline::Circle { center, radius }, appearance)
    };
    Some(centers?.into_iter().map(circle).collect())
}

pub(crate) fn fixture(name: String, outline: Outline, Appearance { color, height }: Appearance) -> Fixture {
    Fixture {
        name,
        outline,
        color,
        height,
        reflectivity: REFLECTIVITY,
        surface: Surface::Opaque,
    }
}
