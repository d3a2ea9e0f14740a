//! Units of numbers: those of SI in the usual notation, and a few others that robots need. Distinguishes
//! dimensions, so that a length is never taken for an angle. Does not convert temperatures, whose scales have
//! different zeros.

use std::f64::consts::PI;

/// Powers of metre, radian, second, kilogram and ampere. An angle has its own dimension: if a radian were
/// only a number, "3 rad" could be taken for a plain 3.
pub type Dimension = [i32; 5];

/// The largest power in a unit: above any that robots use, and far below an overflow.
const MOST_POWER: i32 = 9;

/// The known prefixes and symbols, for messages.
pub const KNOWN: &str = "m, km, cm, mm, um, rad, mrad, deg, rev, s, ms, us, ns, min, h, Hz, kHz, rpm, kg, g, A, mA, Ah, N, J, W, Wh, V, \
                         mV, Pa, %, 1, with * and / between them and powers behind (m/s2, kg*m2)";

/// Units without a dimension, of numbers and texts. Nothing is converted to or from them.
pub const OTHERS: &[&str] = &[
    "path", "file", "model", "px", "pixel", "cell", "voxel", "bit", "byte", "degC", "K", "dB", "lx",
];

/// A unit: its size in SI units and its dimension. The size is a quotient, so that 700 mm is exactly 0.7 m.
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    /// The dividend of the size in SI units.
    pub number: f64,
    /// The divisor of the size in SI units.
    pub divisor: f64,
    /// Its dimension.
    pub dimension: Dimension,
}

/// Refuses a text that is not a unit. An empty text means no unit and is accepted.
///
/// # Errors
/// A message with the known units.
pub fn check(text: &str) -> Result<(), String> {
    if parse(text).is_some() || OTHERS.contains(&text) {
        return Ok(());
    }
    Err(format!(
        "`{text}` is no unit; use {KNOWN}, or one of {}",
        OTHERS.join(", ")
    ))
}

/// Returns whether a number has the same meaning in both units.
#[must_use]
pub fn same(one: &str, other: &str) -> bool {
    one == other
        || match (parse(one), parse(other)) {
            (Some(one), Some(other)) => {
                one.dimension == other.dimension && one.number * other.divisor == other.number * one.divisor
            }
            _ => false,
        }
}

/// Parses a unit such as "m", "rad/s", "m/s2", "m/s^2" or "kg*m2".
#[must_use]
pub fn parse(text: &str) -> Option<Unit> {
    let mut unit = Unit {
        number: 1.0,
        divisor: 1.0,
        dimension: [0; 5],
    };
    if text.is_empty() {
        return Some(unit);
    }
    for (place, quotient) in text.split('/').enumerate() {
        for factor in quotient.split(['*', '·']) {
            let (atom, power) = power(factor.trim())?;
            let mut atom = atom_of(atom)?;
            if place > 0 {
                atom = atom.inverse();
            }
            for _ in 0..power {
                unit = unit.times(atom);
            }
        }
    }
    Some(unit)
}

/// Splits a factor into a symbol and its power: "s2" and "s^2" are `s` with the power 2.
fn power(factor: &str) -> Option<(&str, i32)> {
    if let Some(atom) = factor.strip_suffix('²') {
        return Some((atom, 2));
    }
    let atom = factor.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &factor[atom.len()..];
    if atom.is_empty() || digits.is_empty() {
        return Some((factor, 1));
    }
    let power = digits
        .parse()
        .ok()
        .filter(|power| (1..=MOST_POWER).contains(power))?;
    Some((atom.strip_suffix('^').unwrap_or(atom), power))
}

fn atom_of(name: &str) -> Option<Unit> {
    const M: Dimension = [1, 0, 0, 0, 0];
    const RAD: Dimension = [0, 1, 0, 0, 0];
    const S: Dimension = [0, 0, 1, 0, 0];
    const HZ: Dimension = [0, 0, -1, 0, 0];
    const KG: Dimension = [0, 0, 0, 1, 0];
    const A: Dimension = [0, 0, 0, 0, 1];
    let (number, divisor, dimension) = match name {
        "1" => (1.0, 1.0, [0; 5]),
        "%" => (1.0, 100.0, [0; 5]),
        "m" => (1.0, 1.0, M),
        "km" => (1e3, 1.0, M),
        "cm" => (1.0, 1e2, M),
        "mm" => (1.0, 1e3, M),
        "um" | "µm" => (1.0, 1e6, M),
        "rad" => (1.0, 1.0, RAD),
        "mrad" => (1.0, 1e3, RAD),
        "deg" | "°" => (PI, 180.0, RAD),
        "rev" => (2.0 * PI, 1.0, RAD),
        "s" => (1.0, 1.0, S),
        "ms" => (1.0, 1e3, S),
        "us" | "µs" => (1.0, 1e6, S),
        "ns" => (1.0, 1e9, S),
        "min" => (60.0, 1.0, S),
        "h" => (3600.0, 1.0, S),
        "Hz" => (1.0, 1.0, HZ),
        "kHz" => (1e3, 1.0, HZ),
        "rpm" => (PI, 30.0, [0, 1, -1, 0, 0]),
        "kg" => (1.0, 1.0, KG),
        "g" => (1.0, 1e3, KG),
        "A" => (1.0, 1.0, A),
        "mA" => (1.0, 1e3, A),
        "Ah" => (3600.0, 1.0, [0, 0, 1, 0, 1]),
        "Wh" => (3600.0, 1.0, [2, 0, -2, 1, 0]),
        "N" => (1.0, 1.0, [1, 0, -2, 1, 0]),
        "J" => (1.0, 1.0, [2, 0, -2, 1, 0]),
        "W" => (1.0, 1.0, [2, 0, -3, 1, 0]),
        "V" => (1.0, 1.0, [2, 0, -3, 1, -1]),
        "mV" => (1.0, 1e3, [2, 0, -3, 1, -1]),
        "Pa" => (1.0, 1.0, [-1, 0, -2, 1, 0]),
        _ => return None,
    };
    Some(Unit {
        number,
        divisor,
        dimension,
    })
}

impl Unit {
    fn times(self, other: Self) -> Self {
        Self {
            number: self.number * other.number,
            divisor: self.divisor * other.divisor,
            dimension: std::array::from_fn(|index| {
                self.dimension[index].saturating_add(other.dimension[index])
            }),
        }
    }

    fn inverse(self) -> Self {
        Self {
            number: self.divisor,
            divisor: self.number,
            dimension: self.dimension.map(|power| -power),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_units_in_different_notations_are_the_same() {
        assert!(same("rad/s", "rad / s"));
        assert!(same("m/s2", "m/s^2"));
        assert!(same("pixel", "pixel"));
        assert!(same("Hz", "1/s"));
        assert!(!same("m", "mm"));
        assert!(!same("m", ""));
        assert!(!same("pixel", "voxel"));
    }

    #[test]
    fn known_units_are_accepted_and_others_are_refused() {
        for unit in ["", "m", "rad/s2", "kg*m2", "1/s", "%", "path", "px", "Ah", "degC"] {
            assert_eq!(check(unit), Ok(()), "{unit}");
        }
        for unit in ["metre", "meters", "M", "sec", "m s", "m//s", "paths"] {
            let message = check(unit).expect_err(unit);
            assert!(
                message.starts_with(&format!("`{unit}` is no unit; use m, km")),
                "{message}"
            );
        }
        for known in KNOWN.split(", with").next().unwrap_or_default().split(", ") {
            assert!(parse(known.trim()).is_some(), "{known}");
        }
    }
}
