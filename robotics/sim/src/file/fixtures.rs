//! The fixed things of a world file: walls, boxes and circles. `movers` reads the things that move on their
//! own, `loose` those that can be pushed.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one.

use super::document::{Document, Table};
use super::loose;
use super::values::{self, between};
use crate::color::Color;
use crate::loose::LooseBody;
use crate::scene::Fixture;
use crate::shape::Outline;
use crate::solid::REFLECTIVITY;

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
    Fixed(Fixture),
    Loose(LooseBody),
}

/// The keys of a box.
pub(super) const BOX_KEYS: [&str; 9] = [
    "name",
    "center",
    "size",
    "angle_deg",
    "color",
    "height",
    "movable",
    "mass",
    "reflectivity",
];

/// Reads the fixed things, and the boxes that are movable.
pub(crate) fn read(
    document: &Document<'_>,
    root: &Table<'_>,
) -> Option<(Vec<Fixture>, Vec<loose::PlacedBody>)> {
    let walls = each(
        document,
        root,
        "walls",
        "wall",
        &["name", "points", "closed", "color", "height", "reflectivity"],
        wall,
    );
    let boxes = each(document, root, "boxes", "box", &BOX_KEYS, |table, name| {
        Some((rectangular(table, name)?, table.span().clone()))
    });
    let circles = each(
        document,
        root,
        "circles",
        "circle",
        &[
            "name",
            "center",
            "centers",
            "radius",
            "color",
            "height",
            "reflectivity",
        ],
        circles_of,
    );
    let (mut fixtures, mut movable) = (walls?.concat(), Vec::new());
    for (plan, span) in boxes? {
        match plan {
            BoxPlan::Fixed(fixture) => fixtures.push(fixture),
            BoxPlan::Loose(body) => movable.push((body, span)),
        }
    }
    fixtures.extend(circles?.concat());
    Some((fixtures, movable))
}

/// Reads a box, fixed or movable.
pub(super) fn rectangular(table: &Table<'_>, name: String) -> Option<BoxPlan> {
    match table.optional("movable", false, values::flag)? {
        true => loose::movable(table, name).map(BoxPlan::Loose),
        false => fixed(table, name).map(BoxPlan::Fixed),
    }
}

/// Reads the `color` and the `height` of a thing.
pub(crate) fn read_appearance(table: &Table<'_>, default: Appearance) -> Option<Appearance> {
    let color = table.optional("color", default.color, values::color);
    let height = table.optional("height", default.height, values::positive);
    Some(Appearance {
        color: color?,
        height: height?,
    })
}

/// Reads how bright a fixed thing is to a laser: up to 1000 times a white surface, as a retroreflector may be.
fn read_reflectivity(table: &Table<'_>) -> Option<f64> {
    table.optional("reflectivity", REFLECTIVITY, between(0.0, 1000.0, ""))
}

/// Reads every item of an array of tables, each with its name; `None` if any has a fault.
pub(crate) fn each<'a, T>(
    document: &'a Document<'a>,
    root: &Table<'a>,
    key: &str,
    kind: &str,
    known: &[&str],
    read: impl Fn(&Table<'a>, String) -> Option<T>,
) -> Option<Vec<T>> {
    let is_faulty = root.get(key).is_some_and(|item| !item.get_ref().is_array());
    let things: Vec<_> = (1..)
        .zip(root.array(key))
        .map(|(number, item)| {
            let table = Table::item(document, item, kind, number, known)?;
            let name = table.optional("name", format!("{kind} {number}"), values::text);
            let thing = read(&table, name.clone().unwrap_or_default());
            name.and(thing)
        })
        .collect();
    if is_faulty {
        None
    } else {
        things.into_iter().collect()
    }
}

fn wall(table: &Table<'_>, name: String) -> Option<Vec<Fixture>> {
    let appearance = read_appearance(table, WALL);
    let (points, reflectivity) = (polyline(table), read_reflectivity(table));
    let (appearance, points, reflectivity) = (appearance?, points?, reflectivity?);
    let sides = points.windows(2).map(|pair| Outline::Segment {
        from: pair[0],
        to: pair[1],
    });
    Some(
        sides
            .map(|outline| Fixture {
                reflectivity,
                ..fixture(name.clone(), outline, appearance)
            })
            .collect(),
    )
}

/// Reads `points` and `closed`. A closed line ends with its first point.
pub(super) fn polyline(table: &Table<'_>) -> Option<Vec<[f64; 2]>> {
    let points = table.required("points", values::points);
    let closed = table.optional("closed", false, values::flag);
    let (mut points, closed) = (points?, closed?);
    if closed {
        if points.len() < 3 {
            table.fault(
                table.span(),
                "is `closed` with two points: expected three or more",
            );
            return None;
        }
        if points[0] == points[points.len() - 1] {
            table.fault(
                table.span(),
                "is `closed` and ends at its start: drop the last point",
            );
            return None;
        }
        points.push(points[0]);
    }
    Some(points)
}

fn fixed(table: &Table<'_>, name: String) -> Option<Fixture> {
    if let Some(mass) = table.get("mass") {
        table.fault(
            &mass.span(),
            "has a `mass` and is not `movable`: add `movable = true`, or drop it",
        );
        return None;
    }
    let (appearance, rectangle) = (read_appearance(table, BOX), rectangle(table));
    let reflectivity = read_reflectivity(table);
    let (center, size, angle) = rectangle?;
    Some(Fixture {
        reflectivity: reflectivity?,
        ..fixture(name, Outline::Box { center, size, angle }, appearance?)
    })
}

/// Reads the center, the size and the angle in radians of a box.
pub(crate) fn rectangle(table: &Table<'_>) -> Option<([f64; 2], [f64; 2], f64)> {
    let (center, size) = (
        table.required("center", values::point),
        table.required("size", values::size),
    );
    let angle = table.optional("angle_deg", 0.0, values::number);
    Some((center?, size?, angle?.to_radians()))
}

/// Reads one circle, or several equal ones.
fn circles_of(table: &Table<'_>, name: String) -> Option<Vec<Fixture>> {
    let appearance = read_appearance(table, CIRCLE);
    let radius = table.required("radius", values::positive);
    let centers = match (table.get("centers"), table.get("center")) {
        (Some(_), None) => table.required("centers", values::centers),
        (None, _) => table.required("center", values::point).map(|center| vec![center]),
        (Some(centers), Some(_)) => {
            table.fault(&centers.span(), "has `center` and `centers`: drop one");
            None
        }
    };
    let reflectivity = read_reflectivity(table);
    let (appearance, radius, reflectivity) = (appearance?, radius?, reflectivity?);
    let circle = |center| Fixture {
        reflectivity,
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
    }
}
