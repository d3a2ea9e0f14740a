//! The things of a world file that move on their own: movers and people.
//!
//! Each reader reports every fault of its things, and returns `None` if there is one.

use std::ops::Range;

use super::fixtures::{self, Appearance, each};
use super::values;
use crate::color::Color;
use crate::mover::{self, EndBehavior, MoverShape};
use jde_document::{FaultReport, Section};

/// The default clearance of a mover to robots, in metres: an arm's length.
const CLEARANCE: f64 = 0.5;
/// The default time that a mover waits before it turns back, in seconds.
const WAIT: f64 = 3.0;

/// The default appearance of movers: a painted cart.
const MOVER: Appearance = Appearance {
    color: Color::new(74, 116, 168),
    height: 1.0,
};
/// The default appearance of people: the colour of their clothing, and their height.
const PERSON: Appearance = Appearance {
    color: Color::new(46, 86, 140),
    height: 1.72,
};
/// The default height of a person who sits, in metres.
const SEATED: f64 = 1.3;
/// The default colour that a person raises: orange.
const SIGNAL: Color = Color::new(240, 130, 30);
/// The default radius of a person, in metres.
const SHOULDERS: f64 = 0.25;

pub(crate) fn read(
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
) -> Option<Vec<(mover::MoverConfig, Range<usize>)>> {
    let known = [
        "name",
        "color",
        "height",
        "radius",
        "size",
        "way",
        "speed",
        "loop",
        "clearance",
        "wait",
    ];
    let movers = each(report, root, "movers", "mover", &known, |report, table, name| {
        Some((mover(report, table, name)?, table.span.clone()))
    });
    let known = [
        "name",
        "color",
        "signal",
        "height",
        "radius",
        "way",
        "speed",
        "pause",
        "sits",
        "loop",
        "clearance",
        "wait",
    ];
    let people = each(report, root, "people", "person", &known, |report, table, name| {
        Some((person(report, table, name)?, table.span.clone()))
    });
    Some(movers?.into_iter().chain(people?).collect())
}

fn mover(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<mover::MoverConfig> {
    let body = match (table.get("radius"), table.get("size")) {
        (Some(_), None) => table
            .required(report, "radius", values::positive)
            .map(|radius| MoverShape::Circle { radius }),
        (None, Some(_)) => table
            .required(report, "size", values::size)
            .map(|size| MoverShape::Box { size }),
        (Some(_), Some(_)) | (None, None) => {
            table.fault(
                report,
                &table.span,
                "needs a `radius` for a round body or a `size` for a box, and only one",
            );
            None
        }
    };
    let appearance = fixtures::read_appearance(report, table, MOVER);
    let speed = table.required(report, "speed", values::speed);
    walk(report, table, name, body, appearance, (speed, Some(0.0)))
}

fn person(report: &mut FaultReport<'_>, table: &Section<'_>, name: String) -> Option<mover::MoverConfig> {
    let radius = table.optional(report, "radius", SHOULDERS, values::positive);
    let sits = table.optional(report, "sits", false, values::flag);
    let speed = if sits == Some(false) {
        table.required(report, "speed", values::speed_or_rest)
    } else {
        table.optional(report, "speed", 0.0, values::speed_or_rest)
    };
    let walks = table
        .get("speed")
        .filter(|_| speed.is_some_and(|speed| speed > 0.0));
    let default = if sits == Some(true) {
        Appearance {
            height: SEATED,
            ..PERSON
        }
    } else {
        PERSON
    };
    let appearance = fixtures::read_appearance(report, table, default);
    let pause = table.optional(report, "pause", 0.0, values::not_negative);
    let signal = table.optional(report, "signal", SIGNAL, values::color);
    let body = if let (Some(true), Some(speed)) = (sits, walks) {
        table.fault(report, &speed.span(), "sits and walks: drop `sits` or `speed`");
        None
    } else {
        radius
            .zip(sits)
            .zip(signal)
            .map(|((radius, sits), signal)| MoverShape::Person { radius, sits, signal })
    };
    walk(report, table, name, body, appearance, (speed, pause))
}

/// Reads the keys that movers and people share.
fn walk(
    report: &mut FaultReport<'_>,
    table: &Section<'_>,
    name: String,
    body: Option<MoverShape>,
    appearance: Option<Appearance>,
    (speed, pause): (Option<f64>, Option<f64>),
) -> Option<mover::MoverConfig> {
    let way = table.required(report, "way", values::points);
    let closed = table.optional(report, "loop", false, values::flag);
    let clearance = table.optional(report, "clearance", CLEARANCE, values::positive);
    let patience = table.optional(report, "wait", WAIT, values::not_negative);
    let (way, at_end) = (
        way?,
        if closed? {
            EndBehavior::Loop
        } else {
            EndBehavior::TurnBack
        },
    );
    if at_end == EndBehavior::Loop && !values::are_apart(way[way.len() - 1], way[0]) {
        table.fault(
            report,
            &table.span,
            "is a `loop` whose `way` ends where it starts: drop the last point",
        );
        return None;
    }
    let Appearance { color, height } = appearance?;
    Some(mover::MoverConfig {
        name,
        body: body?,
        path: way,
        at_end,
        speed: speed?,
        clearance: clearance?,
        patience: patience?,
        pause: pause?,
        color,
        height,
    })
}
