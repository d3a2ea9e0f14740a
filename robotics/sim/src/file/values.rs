//! The values of a world file: numbers, points, sizes, texts and flags. No reader depends on its key.

use jde_document::{Checked, Node, WrongValue, section};

use crate::color::{self, Color};

/// Greatest coordinate or length, in metres: a larger number is most likely a typing error.
const MAX_COORDINATE: f64 = 1e5;

/// A smaller number counts as 0: the reciprocal of a subnormal one is infinite, and trees of shapes divide by widths.
const TINY: f64 = 1e-100;

/// Least distance of consecutive points, in metres: rounding at the end of a long way would lose a shorter
/// one.
const MIN_LEG: f64 = 1e-6;

/// The form of a list of points.
const POINTS: &str = "points [[x, y], ...]";

/// Greatest speed of a mover, in m/s: the same as that of robots.
const MAX_SPEED: f64 = 20.0;

/// Reads a number within [`MAX_COORDINATE`]; one below [`TINY`] is 0.
pub(crate) fn number(node: &Node<'_>) -> Checked<f64> {
    match section::number(node.get_ref()) {
        Some(number) if number.abs() < TINY => Ok(0.0),
        Some(number) if number.abs() <= MAX_COORDINATE => Ok(number),
        Some(number) if !number.is_finite() => Err(WrongValue::new(
            node,
            format!("is {number}: expected a finite number"),
        )),
        None if !node.get_ref().is_integer() => Err(WrongValue::shape(node, "a number")),
        Some(_) | None => Err(WrongValue::new(
            node,
            format!("is out of range: expected at most {MAX_COORDINATE} either way"),
        )),
    }
}

pub(crate) fn positive(node: &Node<'_>) -> Checked<f64> {
    match number(node)? {
        number if number > 0.0 => Ok(number),
        number => Err(WrongValue::new(
            node,
            format!("is {number}: expected more than 0"),
        )),
    }
}

pub(crate) fn not_negative(node: &Node<'_>) -> Checked<f64> {
    match number(node)? {
        number if number >= 0.0 => Ok(number),
        number => Err(WrongValue::new(node, format!("is {number}: expected 0 or more"))),
    }
}

/// Returns a reader of numbers within limits.
pub(crate) fn between(low: f64, high: f64, unit: &'static str) -> impl Fn(&Node<'_>) -> Checked<f64> + Copy {
    move |node| match number(node)? {
        number if (low..=high).contains(&number) => Ok(number),
        number => {
            let message = format!("is {number}: expected {low} to {high} {unit}");
            Err(WrongValue::new(node, message.trim_end()))
        }
    }
}

/// Reads a place `[x, y, z]`.
pub(crate) fn place(node: &Node<'_>) -> Checked<[f64; 3]> {
    match node.get_ref().as_array().map(|items| &items[..]) {
        Some([x, y, z]) => Ok([number(x)?, number(y)?, number(z)?]),
        Some(items) => Err(wrong_count(node, items.len(), "a place [x, y, z]")),
        None => Err(WrongValue::shape(node, "a place [x, y, z]")),
    }
}

/// Reads a speed in m/s. At the greatest speed a thing moves 0.2 m in one step, and so cannot get past a
/// robot that it must halt for.
pub(crate) fn speed(node: &Node<'_>) -> Checked<f64> {
    positive(node).and_then(|speed| limited(node, speed))
}

/// Reads a speed in m/s, which may be 0.
pub(crate) fn speed_or_rest(node: &Node<'_>) -> Checked<f64> {
    not_negative(node).and_then(|speed| limited(node, speed))
}

fn limited(node: &Node<'_>, speed: f64) -> Checked<f64> {
    match speed <= MAX_SPEED {
        true => Ok(speed),
        false => Err(WrongValue::new(
            node,
            format!("is {speed}: expected at most {MAX_SPEED} m/s"),
        )),
    }
}

/// Returns whether two points are far enough apart for a leg of a way.
pub(crate) fn are_apart(from: [f64; 2], to: [f64; 2]) -> bool {
    libm::hypot(to[0] - from[0], to[1] - from[1]) >= MIN_LEG
}

/// Reads a point `[x, y]`.
pub(crate) fn point(node: &Node<'_>) -> Checked<[f64; 2]> {
    pair(node, "a point [x, y]", number)
}

/// Reads a size `[along x, along y]`.
pub(crate) fn size(node: &Node<'_>) -> Checked<[f64; 2]> {
    pair(node, "a size [along x, along y]", positive)
}

/// Reads one or more points.
pub(crate) fn centers(node: &Node<'_>) -> Checked<Vec<[f64; 2]>> {
    match node.get_ref().as_array() {
        Some(items) if !items.is_empty() => items.iter().map(point).collect(),
        Some(_) => Err(WrongValue::new(node, format!("is empty: expected {POINTS}"))),
        None => Err(WrongValue::shape(node, POINTS)),
    }
}

/// Reads two or more points, each at a distance from the one before it.
pub(crate) fn points(node: &Node<'_>) -> Checked<Vec<[f64; 2]>> {
    let items = node.get_ref().as_array();
    let items = items.ok_or_else(|| WrongValue::shape(node, POINTS))?;
    let points = items.iter().map(point).collect::<Checked<Vec<_>>>()?;
    if points.len() < 2 {
        let message = format!("has {} points: expected two or more", points.len());
        return Err(WrongValue::new(node, message));
    }
    match points.windows(2).position(|pair| !are_apart(pair[0], pair[1])) {
        Some(index) => Err(WrongValue::new(
            &items[index + 1],
            format!("has point {} on the one before it: move or drop it", index + 2),
        )),
        None => Ok(points),
    }
}

pub(crate) fn color(node: &Node<'_>) -> Checked<Color> {
    let text = text(node)?;
    Color::parse(&text).ok_or_else(|| {
        let names = color::NAMES.iter().map(|(name, _)| *name);
        WrongValue::unknown(node, &text, "\"#rrggbb\" or the name of a colour", names)
    })
}

pub(crate) fn text(node: &Node<'_>) -> Checked<String> {
    match node.get_ref().as_str() {
        Some("") => Err(WrongValue::new(node, "is empty: expected a text")),
        Some(text) => Ok(text.to_owned()),
        None => Err(WrongValue::shape(node, "a text")),
    }
}

/// Reads a whole number from 0.
pub(crate) fn whole(node: &Node<'_>) -> Checked<u64> {
    let number = section::integer(node.get_ref()).and_then(|number| u64::try_from(number).ok());
    number.ok_or_else(|| WrongValue::new(node, "must be a whole number from 0"))
}

pub(crate) fn flag(node: &Node<'_>) -> Checked<bool> {
    let flag = node.get_ref().as_bool();
    flag.ok_or_else(|| WrongValue::shape(node, "true or false"))
}

/// Reads a name of a list as what it stands for; `what` is what was expected.
pub(crate) fn one_of<T: Copy>(node: &Node<'_>, what: &str, known: &[(&'static str, T)]) -> Checked<T> {
    let text = text(node)?;
    let found = known.iter().find(|(name, _)| *name == text);
    found
        .map(|(_, value)| *value)
        .ok_or_else(|| WrongValue::unknown(node, &text, what, known.iter().map(|(name, _)| *name)))
}

fn pair(node: &Node<'_>, expected: &str, read: fn(&Node<'_>) -> Checked<f64>) -> Checked<[f64; 2]> {
    match node.get_ref().as_array().map(|items| &items[..]) {
        Some([first, second]) => Ok([read(first)?, read(second)?]),
        Some(items) => Err(wrong_count(node, items.len(), expected)),
        None => Err(WrongValue::shape(node, expected)),
    }
}

fn wrong_count(node: &Node<'_>, count: usize, expected: &str) -> WrongValue {
    WrongValue::new(node, format!("has {count} values: expected {expected}"))
}
