//! Quantities with units, as people write them: "75 ms", "0.4 m/s", "90deg". Knows dimensions, so that a length is never
//! taken for an angle; does not know temperatures (their scales have different zeros) or money.

use std::f64::consts::PI;

/// Powers of metre, radian, second, kilogram and ampere. An angle has a dimension of its own here: where a radian is just
/// a number, "3 rad" would pass for a length of 3.
type Dimension = [i32; 5];

/// Largest power in a unit: beyond any that robots use, below any overflow.
const MOST_POWER: i32 = 9;

/// A unit: SI units each, as a quotient so that 700 mm is 0.7 m to the bit, and its dimension.
#[derive(Clone, Copy)]
struct Unit {
    number: f64,
    divisor: f64,
    dimension: Dimension,
}

/// Why a text is no quantity in the unit asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum QuantityError {
    /// It does not begin with a number.
    NotANumber,
    /// What follows the number is no unit that is known here.
    UnknownUnit(String),
    /// The unit is of another dimension.
    OtherDimension(String),
}

/// Reads a number with a unit and gives it in `unit`; without a unit the number is in `unit` already.
pub(super) fn quantity(text: &str, unit: &str) -> Result<f64, QuantityError> {
    let (number, written) = split(text.trim()).ok_or(QuantityError::NotANumber)?;
    if written.is_empty() || written == unit {
        return Ok(number);
    }
    let from = parse(written).ok_or_else(|| QuantityError::UnknownUnit(written.to_owned()))?;
    match parse(unit) {
        Some(to) if to.dimension == from.dimension => {
            Ok(number * (from.number * to.divisor) / (from.divisor * to.number))
        }
        Some(_) | None => Err(QuantityError::OtherDimension(written.to_owned())),
    }
}

/// Whether numbers in the two units may stand for each other unchanged.
pub(super) fn same(one: &str, other: &str) -> bool {
    one == other
        || match (parse(one), parse(other)) {
            (Some(one), Some(other)) => {
                one.dimension == other.dimension && one.number * other.divisor == other.number * one.divisor
            }
            _ => false,
        }
}

/// A number and what follows it.
fn split(text: &str) -> Option<(f64, &str)> {
    let digits = |from: usize| {
        let rest = &text.as_bytes()[from..];
        from + rest.iter().take_while(|byte| byte.is_ascii_digit()).count()
    };
    let sign = usize::from(text.starts_with(['+', '-']));
    let mut end = digits(sign);
    if text[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    let number = text[..end].parse().ok()?;
    Some((number, text[end..].trim()))
}

/// Reads a unit such as "m", "rad/s", "m/s2", "m/s^2" or "kg*m2".
fn parse(text: &str) -> Option<Unit> {
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
    fn units_turn_into_si_without_a_rounding_of_their_own() {
        let check =
            |text, unit, expected: f64| assert_eq!(quantity(text, unit), Ok(expected), "{text} in {unit}");
        check("75ms", "s", 0.075);
        check("0.3 m", "m", 0.3);
        check("30 cm", "m", 0.3);
        check("700 mm", "m", 0.7);
        check("90deg", "rad", PI / 2.0);
        check("-180 deg", "rad", -PI);
        check("50deg/s", "rad/s", 50.0 * PI / 180.0);
        check("200 mm/s", "m/s", 0.2);
        check("1.5e3 mm", "m", 1.5);
        check("36 km/h", "m/s", 10.0);
        check("60 rpm", "rad/s", 60.0 * PI / 30.0);
        check("300 mm/s^2", "m/s2", 0.3);
        check("300 mm/s²", "m/s^2", 0.3);
        check("25 %", "", 0.25);
        check("2 Hz", "1/s", 2.0);
        check("12 V", "V", 12.0);
        check("1 mrad", "deg", 180.0 / (1000.0 * PI));
    }

    #[test]
    fn a_number_without_a_unit_is_in_the_unit_asked_for() {
        assert_eq!(quantity("0.4", "m/s"), Ok(0.4));
        assert_eq!(quantity(" -2e-3 ", ""), Ok(-0.002));
    }

    #[test]
    fn a_unit_that_is_not_known_serves_numbers_written_in_it() {
        assert_eq!(quantity("3 pixel", "pixel"), Ok(3.0));
        assert_eq!(
            quantity("3 m", "pixel"),
            Err(QuantityError::OtherDimension("m".to_owned()))
        );
    }

    #[test]
    fn another_dimension_is_refused_by_name() {
        let check = |text, unit, written: &str| {
            assert_eq!(
                quantity(text, unit),
                Err(QuantityError::OtherDimension(written.to_owned()))
            );
        };
        check("10 deg", "m", "deg");
        check("3 rad", "", "rad");
        check("1 m/s", "m/s2", "m/s");
        check("2 Hz", "s", "Hz");
        check("2 Hz", "rad/s", "Hz");
    }

    #[test]
    fn what_is_no_quantity_is_refused() {
        for text in ["", "m", "fast", "-", ".", "inf", "nan m", "e5", "--1", "é"] {
            assert_eq!(quantity(text, "m"), Err(QuantityError::NotANumber), "{text}");
        }
        for unit in ["parsec", "em", "m//s", "/s", "m1000000", "m^", "m2s"] {
            assert_eq!(
                quantity(&format!("3 {unit}"), "m"),
                Err(QuantityError::UnknownUnit(unit.to_owned()))
            );
        }
    }

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
}
