//! How an export can be made to fail. It changes no value; `instance::export_faults` does.

use std::fmt;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};
use jde_board::{Nanos, value};

const ONE_SECOND: Nanos = 1_000_000_000;
/// How late an export may be at most: what was measured meanwhile is kept.
const MOST_LATE: Nanos = 60 * ONE_SECOND;
/// The field of range sensors with their measurements.
const RANGES: &str = "ranges";
/// The fields with the least and the greatest distance that a range sensor measures.
const LIMITS: [[&str; 2]; 2] = [["range_min", "range_max"], ["min_range", "max_range"]];

/// How an export fails. The schema that publishes it does not notice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorFault {
    /// The value is retracted, and none is published.
    Silent,
    /// Each publication repeats the last value before the failure, bit by bit, with a new sequence number and a
    /// new time. Nothing is published if there was none.
    Frozen,
    /// Normal noise on every number: on the ranges of a type with a sequence `ranges`, which stay at 0 or more,
    /// and otherwise on all fields of type f32 and f64. Numbers that are not finite stay. The seed of the
    /// application determines the noise.
    Noise {
        /// The standard deviation, in the unit of the numbers: 0 or more.
        sigma: f64,
    },
    /// Some beams of a type with a sequence `ranges` measure something on the sensor.
    Blocked {
        /// The first beam, from 0.
        first: u32,
        /// The last beam. Beams that the sensor does not have are left out.
        last: u32,
        /// What they measure, in m; positive infinity for no echo.
        range: f32,
    },
    /// The least and the greatest distance of a range sensor are exchanged.
    Contradictory,
    /// Each publication is what was measured this long before, with its time of measurement. Nothing is published
    /// until something is as old.
    Late {
        /// How old it is, ns.
        by: Nanos,
    },
}

impl SensorFault {
    /// Checks that an export of that type can fail so.
    pub(crate) fn check(&self, value_type: &Type) -> Result<(), String> {
        match *self {
            Self::Silent | Self::Frozen => Ok(()),
            Self::Late { by } if by <= MOST_LATE => Ok(()),
            Self::Late { by } => Err(format!(
                "it is {} s late: expected at most {} s",
                by / ONE_SECOND,
                MOST_LATE / ONE_SECOND
            )),
            Self::Contradictory => match limits(value_type) {
                Some(_) => Ok(()),
                None => Err(format!("a {} states no limits of its distances", value_type.name)),
            },
            Self::Noise { sigma } => {
                if !sigma.is_finite() || sigma < 0.0 {
                    return Err(format!("sigma is {sigma}: expected 0 or more"));
                }
                let has_floats = value::has_floats(&value_type.fields);
                has_floats
                    .then_some(())
                    .ok_or_else(|| format!("a {} has no numbers with a fraction", value_type.name))
            }
            Self::Blocked { first, last, range } => {
                if ranges(value_type).is_none() {
                    return Err(format!("a {} has no beams", value_type.name));
                }
                if first > last || range.is_nan() {
                    return Err(format!(
                        "beams {first} to {last} cannot measure {range} m: expected beams in order, and a range"
                    ));
                }
                Ok(())
            }
        }
    }

    /// Encodes it for a turn.
    pub(crate) fn words(&self) -> [u32; 4] {
        match *self {
            Self::Silent => [1, 0, 0, 0],
            Self::Frozen => [2, 0, 0, 0],
            Self::Noise { sigma } => {
                let bits = sigma.to_bits();
                [3, (bits >> 32) as u32, bits as u32, 0]
            }
            Self::Blocked { first, last, range } => [4, first, last, range.to_bits()],
            Self::Contradictory => [5, 0, 0, 0],
            Self::Late { by } => [6, (by >> 32) as u32, by as u32, 0],
        }
    }

    /// Decodes it from a turn; `None` if no failure is encoded so.
    pub(crate) fn from_words(words: &[u32]) -> Option<Self> {
        let &[kind, first, second, third] = words.first_chunk()?;
        Some(match kind {
            1 => Self::Silent,
            2 => Self::Frozen,
            3 => Self::Noise {
                sigma: f64::from_bits(u64::from(first) << 32 | u64::from(second)),
            },
            4 => Self::Blocked {
                first,
                last: second,
                range: f32::from_bits(third),
            },
            5 => Self::Contradictory,
            6 => Self::Late {
                by: u64::from(first) << 32 | u64::from(second),
            },
            _ => return None,
        })
    }
}

/// For people: "frozen", "noise of 0.05".
impl fmt::Display for SensorFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => f.write_str("silent"),
            Self::Frozen => f.write_str("frozen"),
            Self::Noise { sigma } => write!(f, "noise of {sigma}"),
            Self::Blocked { first, last, range } => {
                write!(f, "beams {first} to {last} blocked at {range} m")
            }
            Self::Contradictory => f.write_str("contradictory"),
            Self::Late { by } => write!(f, "{} ms late", by / 1_000_000),
        }
    }
}

/// Returns the measurements of a range sensor's type.
pub(crate) fn ranges(value_type: &Type) -> Option<&Field> {
    value_type.fields.iter().find(|field| {
        field.name == RANGES
            && matches!(field.form, Form::Sequence { .. })
            && matches!(field.kind, FieldKind::Scalar(Scalar::F32))
    })
}

/// Returns where a range sensor's type has the least and the greatest distance, both f32.
pub(crate) fn limits(value_type: &Type) -> Option<[usize; 2]> {
    let find = |name: &str| {
        let mut fields = value_type.fields.iter();
        let field = fields.find(|field| field.name == name)?;
        let is_number =
            matches!(field.form, Form::One) && matches!(field.kind, FieldKind::Scalar(Scalar::F32));
        is_number.then_some(field.offset)
    };
    let [laser, others] = LIMITS.map(|[least, greatest]| Some([find(least)?, find(greatest)?]));
    laser.or(others)
}

#[cfg(test)]
mod tests {
    use jde_types::{LaserScan, Value as _};

    use super::*;

    #[test]
    fn a_failure_that_is_encoded_for_a_turn_is_decoded_again() {
        for fault in [
            SensorFault::Silent,
            SensorFault::Frozen,
            SensorFault::Noise { sigma: 0.05 },
            SensorFault::Blocked {
                first: 3,
                last: 90,
                range: f32::INFINITY,
            },
            SensorFault::Contradictory,
            SensorFault::Late { by: 5_000_000_000 },
        ] {
            assert_eq!(SensorFault::from_words(&fault.words()), Some(fault));
        }
        assert_eq!(SensorFault::from_words(&[7, 0, 0, 0]), None);
        assert_eq!(SensorFault::from_words(&[1]), None);
    }

    #[test]
    fn failures_that_a_type_cannot_have_are_refused() {
        let blocked = |first, last, range| SensorFault::Blocked { first, last, range };
        for (fault, value_type, expected) in [
            (SensorFault::Noise { sigma: -1.0 }, f64::describe(), "sigma is -1"),
            (
                SensorFault::Noise { sigma: f64::NAN },
                f64::describe(),
                "sigma is NaN",
            ),
            (SensorFault::Noise { sigma: 1.0 }, u32::describe(), "no numbers"),
            (blocked(0, 1, 1.0), f64::describe(), "has no beams"),
            (blocked(2, 1, 1.0), LaserScan::describe(), "beams 2 to 1"),
            (blocked(0, 1, f32::NAN), LaserScan::describe(), "measure NaN m"),
        ] {
            let reason = fault.check(&value_type).unwrap_err();
            assert!(reason.contains(expected), "{reason}");
        }
        assert_eq!(blocked(0, 9, f32::INFINITY).check(&LaserScan::describe()), Ok(()));
    }
}
