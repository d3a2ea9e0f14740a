//! Conversion of numbers to the user's units. All other code uses SI units.

use serde::{Deserialize, Serialize};

/// Units of displayed numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub(crate) struct Units {
    /// Unit of angles.
    pub(crate) angle: Angle,
    /// Unit of lengths.
    pub(crate) length: Length,
}

/// Unit of angles and turn rates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Angle {
    /// Degrees.
    #[default]
    Degrees,
    /// Radians.
    Radians,
}

/// Unit of lengths and speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Length {
    /// Metres.
    #[default]
    Metres,
    /// Millimetres, as in jde-neoc (2007).
    Millimetres,
}

impl Units {
    /// Formats a number of an SI unit, in the user's unit: "0.400 m/s", "50.0 deg/s".
    pub(crate) fn show(self, number: f64, unit: &str) -> String {
        let (number, unit) = self.convert(number, unit);
        let size = number.abs();
        let digits = match size {
            _ if size >= 100.0 => 0,
            _ if size >= 10.0 => 1,
            _ if size >= 1.0 => 2,
            _ => 3,
        };
        if unit.is_empty() {
            format!("{number:.digits$}")
        } else {
            format!("{number:.digits$} {unit}")
        }
    }

    /// Converts a number of an SI unit. Returns the number in the user's unit, and that unit.
    pub(crate) fn convert(self, number: f64, unit: &str) -> (f64, String) {
        let (head, tail) = unit
            .split_once('/')
            .map_or((unit, None), |(head, tail)| (head, Some(tail)));
        let (factor, name) = match head {
            "rad" if self.angle == Angle::Degrees => (180.0 / std::f64::consts::PI, "deg"),
            "m" if self.length == Length::Millimetres => (1000.0, "mm"),
            head => (1.0, head),
        };
        let unit = tail.map_or_else(|| name.to_owned(), |tail| format!("{name}/{tail}"));
        (number * factor, unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_in_the_users_units() {
        let units = Units::default();
        assert_eq!(units.show(0.4, "m/s"), "0.400 m/s");
        assert_eq!(units.show(50_f64.to_radians(), "rad/s"), "50.0 deg/s");
        let old = Units {
            angle: Angle::Radians,
            length: Length::Millimetres,
        };
        assert_eq!(old.show(0.4, "m/s"), "400 mm/s");
        assert_eq!(old.show(2.0, "rad"), "2.00 rad");
        assert_eq!(old.show(0.25, ""), "0.250");
    }
}
