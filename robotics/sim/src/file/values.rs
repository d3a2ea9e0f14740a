//! The values of a world file: numbers, points, sizes, texts and flags.
//!
//! Each reader returns the value, or its span and what was expected there. No reader depends on its key.

use std::ops::Range;

use toml::de::DeValue;

use super::document::Item;
use crate::color::{self, Color};

/// The result of a reader: the value, or its span and what is wrong with it.
pub(crate) type Read<T> = Result<T, (Range<usize>, String)>;

/// Greatest coordinate or length, in metres: a larger number is most likely a typing error.
const MAX_COORDINATE: f64 = 1e5;

/// A smaller number counts as 0: the reciprocal of a subnormal one is infinite, and trees of shapes divide by widths.
const TINY: f64 = 1e-100;

/// Least distance of consecutive points, in metres: rounding at the end of a long way would lose a shorter
/// one.
const MIN_LEG: f64 = 1e-6;

/// Greatest speed of a mover, in m/s: the same as that of robots.
const MAX_SPEED: f64 = 20.0;

/// Reads a number within [`MAX_COORDINATE`]; one below [`TINY`] is 0.
pub(crate) fn number(item: &Item<'_>) -> Read<f64> {
    let parsed = match item.get_ref() {
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .map(|n| n as f64),
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => return Err((item.span(), format!("is {}: expected a number", describe(item)))),
    };
    match parsed {
        Some(number) if number.abs() < TINY => Ok(0.0),
        Some(number) if number.abs() <= MAX_COORDINATE => Ok(number),
        Some(number) if !number.is_finite() => {
            Err((item.span(), format!("is {number}: expected a finite number")))
        }
        Some(_) | None => Err((
            item.span(),
            format!("is out of range: expected at most {MAX_COORDINATE} either way"),
        )),
    }
}

pub(crate) fn positive(item: &Item<'_>) -> Read<f64> {
    match number(item)? {
        number if number > 0.0 => Ok(number),
        number => Err((item.span(), format!("is {number}: expected more than 0"))),
    }
}

pub(crate) fn not_negative(item: &Item<'_>) -> Read<f64> {
    match number(item)? {
        number if number >= 0.0 => Ok(number),
        number => Err((item.span(), format!("is {number}: expected 0 or more"))),
    }
}

/// Returns a reader of numbers within limits.
pub(crate) fn between(low: f64, high: f64, unit: &'static str) -> impl Fn(&Item<'_>) -> Read<f64> + Copy {
    move |item| match number(item)? {
        number if (low..=high).contains(&number) => Ok(number),
        number => Err((
            item.span(),
            format!("is {number}: expected {low} to {high} {unit}")
                .trim_end()
                .to_owned(),
        )),
    }
}

/// Reads a place `[x, y, z]`.
pub(crate) fn place(item: &Item<'_>) -> Read<[f64; 3]> {
    match item.get_ref().as_array().map(|items| &items[..]) {
        Some([x, y, z]) => Ok([number(x)?, number(y)?, number(z)?]),
        Some(_) | None => Err((
            item.span(),
            format!("is {}: expected a place [x, y, z]", describe(item)),
        )),
    }
}

/// Reads a speed in m/s. At the greatest speed a thing moves 0.2 m in one step, and so cannot get past a
/// robot that it must halt for.
pub(crate) fn speed(item: &Item<'_>) -> Read<f64> {
    positive(item).and_then(|speed| limited(item, speed))
}

/// Reads a speed in m/s, which may be 0.
pub(crate) fn speed_or_rest(item: &Item<'_>) -> Read<f64> {
    not_negative(item).and_then(|speed| limited(item, speed))
}

fn limited(item: &Item<'_>, speed: f64) -> Read<f64> {
    if speed <= MAX_SPEED {
        return Ok(speed);
    }
    Err((
        item.span(),
        format!("is {speed}: expected at most {MAX_SPEED} m/s"),
    ))
}

/// Returns whether two points are far enough apart for a leg of a way.
pub(crate) fn are_apart(from: [f64; 2], to: [f64; 2]) -> bool {
    libm::hypot(to[0] - from[0], to[1] - from[1]) >= MIN_LEG
}

/// Reads a point `[x, y]`.
pub(crate) fn point(item: &Item<'_>) -> Read<[f64; 2]> {
    pair(item, "a point [x, y]", number)
}

/// Reads a size `[along x, along y]`.
pub(crate) fn size(item: &Item<'_>) -> Read<[f64; 2]> {
    pair(item, "a size [along x, along y]", positive)
}

/// Reads one or more points.
pub(crate) fn centers(item: &Item<'_>) -> Read<Vec<[f64; 2]>> {
    match item.get_ref().as_array() {
        Some(items) if !items.is_empty() => items.iter().map(point).collect(),
        _ => Err((
            item.span(),
            format!("is {}: expected points [[x, y], ...]", describe(item)),
        )),
    }
}

/// Reads two or more points, each at a distance from the one before it.
pub(crate) fn points(item: &Item<'_>) -> Read<Vec<[f64; 2]>> {
    let Some(items) = item.get_ref().as_array() else {
        return Err((
            item.span(),
            format!("is {}: expected points [[x, y], ...]", describe(item)),
        ));
    };
    let points = items.iter().map(point).collect::<Read<Vec<_>>>()?;
    if points.len() < 2 {
        return Err((
            item.span(),
            format!("has {} points: expected two or more", points.len()),
        ));
    }
    match points.windows(2).position(|pair| !are_apart(pair[0], pair[1])) {
        Some(index) => Err((
            items[index + 1].span(),
            format!("has point {} on the one before it: move or drop it", index + 2),
        )),
        None => Ok(points),
    }
}

pub(crate) fn color(item: &Item<'_>) -> Read<Color> {
    let text = text(item)?;
    Color::parse(&text).ok_or_else(|| {
        let names: Vec<&str> = color::NAMES.iter().map(|(name, _)| *name).collect();
        let known = match super::nearest(&text, names.iter().copied()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("one of `{}`", names.join("`, `")),
        };
        (
            item.span(),
            format!("is `{text}`: expected \"#rrggbb\", or the name of a colour; {known}"),
        )
    })
}

pub(crate) fn text(item: &Item<'_>) -> Read<String> {
    match item.get_ref().as_str() {
        Some("") => Err((item.span(), "is empty: expected a text".to_owned())),
        Some(text) => Ok(text.to_owned()),
        None => Err((item.span(), format!("is {}: expected a text", describe(item)))),
    }
}

pub(crate) fn flag(item: &Item<'_>) -> Read<bool> {
    item.get_ref().as_bool().ok_or_else(|| {
        (
            item.span(),
            format!("is {}: expected true or false", describe(item)),
        )
    })
}

fn pair(item: &Item<'_>, expected: &str, read: fn(&Item<'_>) -> Read<f64>) -> Read<[f64; 2]> {
    match item.get_ref().as_array().map(|items| &items[..]) {
        Some([first, second]) => Ok([read(first)?, read(second)?]),
        Some(items) => Err((
            item.span(),
            format!("has {} values: expected {expected}", items.len()),
        )),
        None => Err((item.span(), format!("is {}: expected {expected}", describe(item)))),
    }
}

/// Returns the kind of a value, with its article.
pub(crate) fn describe(item: &Item<'_>) -> String {
    let kind = item.get_ref().type_str();
    if kind.starts_with(['a', 'i', 'o']) {
        format!("an {kind}")
    } else {
        format!("a {kind}")
    }
}
