//! Units of numbers: SI's, as people write them, and a few words that are none of SI's and mean something on robots. Knows
//! dimensions, so that a length is never taken for an angle; does not know temperatures (their scales have different zeros).

use std::f64::consts::PI;

/// Powers of metre, radian, second, kilogram and ampere. An angle has a dimension of its own here: where a radian is just
/// a number, "3 rad" would pass for a length of 3.
pub type Dimension = [i32; 5];

/// Largest power in a unit: beyond any that robots use, below any overflow.
const MOST_POWER: i32 = 9;

/// The prefixes and symbols that are known, for messages.
pub const KNOWN: &str = "m, km, cm, mm, um, rad, mrad, deg, rev, s, ms, us, ns, min, h, Hz, kHz, rpm, kg, g, A, mA, Ah, N, J, W, Wh, V, \
                         mV, Pa, %, 1, with * and / between them and powers behind (m/s2, kg*m2)";

/// What a number or a text may be that has no dimension: nothing is converted to or from it.
pub const OTHERS: &[&str] = &[
    "path", "file", "px", "pixel", "cell", "voxel", "bit", "byte", "degC", "K", "dB", "lx",
];

/// A unit: SI units each, as a quotient so that 700 mm is 0.7 m to the bit, and its dimension.
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    /// SI units, times the divisor.
    pub number: f64,
    /// See there.
    pub divisor: f64,
    /// Its dimension.
    pub dimension: Dimension,
}

/// Refuses what is no unit; an empty one is none and right.
///
/// # Errors
/// In words, with what is known.
pub fn check(text: &str) -> Result<(), String> {
    if parse(text).is_some() || OTHERS.contains(&text) {
        return Ok(());
    }
    Err(format!(
        "`{text}` is no unit; use {KNOWN}, or one of {}",
        OTHERS.join(", ")
    ))
}

/// Whether numbers in the two units may stand for each other unchanged.
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

/// Reads a unit such as "m", "rad/s", "m/s2", "m/s^2" or "kg*m2".
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

/// "s2" and "s^2" are `s` twice.
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
    fn units_are_the_same_however_they_are_spelt() {
        assert!(same("rad/s", "rad / s"));
        assert!(same("m/s2", "m/s^2"));
        assert!(same("pixel", "pixel"));
        assert!(same("Hz", "1/s"));
        assert!(!same("m", "mm"));
        assert!(!same("m", ""));
        assert!(!same("pixel", "voxel"));
    }

    #[test]
    fn what_is_no_unit_is_refused_and_what_is_one_is_not() {
        for unit in ["", "m", "rad/s2", "kg*m2", "1/s", "%", "path", "px", "Ah", "degC"] {
            assert_eq!(check(unit), Ok(()), "{unit}");
        }
        for unit in ["metre", "meters", "M", "sec", "m s", "m//s", "paths"] {
            let said = check(unit).expect_err(unit);
            assert!(
                said.starts_with(&format!("`{unit}` is no unit; use m, km")),
                "{said}"
            );
        }
        for known in KNOWN.split(", with").next().unwrap_or_default().split(", ") {
            assert!(parse(known.trim()).is_some(), "{known}");
        }
    }
}
