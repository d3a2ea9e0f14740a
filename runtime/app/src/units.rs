//! Quantities with units, as people write them: "75 ms", "0.4 m/s", "90deg". The units are defined in
//! [`jde_abi::unit`].

use jde_abi::unit::parse;

/// Why a text is no quantity in the requested unit.
#[derive(Clone, Debug, PartialEq)]
pub enum QuantityError {
    /// It does not begin with a number.
    NotANumber,
    /// The text after the number is no known unit.
    UnknownUnit(String),
    /// The unit has another dimension.
    OtherDimension(String),
}

/// Parses a number with a unit and converts it to `unit`; a number without a unit is in `unit` already.
///
/// # Errors
/// [`QuantityError`]
pub fn quantity(text: &str, unit: &str) -> Result<f64, QuantityError> {
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

/// Splits a text into a number and the rest.
pub(super) fn split(text: &str) -> Option<(f64, &str)> {
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

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn units_convert_without_additional_rounding() {
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
    fn a_number_without_a_unit_is_in_the_requested_unit() {
        assert_eq!(quantity("0.4", "m/s"), Ok(0.4));
        assert_eq!(quantity(" -2e-3 ", ""), Ok(-0.002));
    }

    #[test]
    fn a_number_in_the_same_unknown_unit_is_accepted() {
        assert_eq!(quantity("3 pixel", "pixel"), Ok(3.0));
        assert_eq!(
            quantity("3 m", "pixel"),
            Err(QuantityError::OtherDimension("m".to_owned()))
        );
    }

    #[test]
    fn a_unit_of_another_dimension_is_refused_with_its_name() {
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
    fn a_text_that_is_not_a_quantity_is_refused() {
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
}
