//! The limits of a modulation's value, for files, options, tools, fathers and operators. Structures, texts
//! and sequences have no limits.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::{Field, FieldKind, Form, Scalar, Type};

/// The allowed values of a modulation. Only plain numbers have limits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// The least number.
    pub least: Option<f64>,
    /// The greatest number.
    pub greatest: Option<f64>,
    /// The names of the numbers from 0 on, if the value is a choice. The limits are then the first and the
    /// last of them.
    pub choices: Vec<String>,
}

/// A number that is not allowed, and the allowed ones.
#[derive(Clone, Debug, PartialEq)]
pub struct NotAllowed {
    /// The number.
    pub number: f64,
    limits: Limits,
}

impl Limits {
    /// Returns whether a number is allowed. A NaN never is.
    #[must_use]
    pub fn holds(&self, number: f64) -> bool {
        !number.is_nan()
            && self.least.is_none_or(|least| number >= least)
            && self.greatest.is_none_or(|greatest| number <= greatest)
    }

    /// Returns whether all numbers are allowed.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.least.is_none() && self.greatest.is_none()
    }

    /// Refuses a plain number that is not allowed.
    ///
    /// # Errors
    /// [`NotAllowed`].
    pub fn check(&self, value_type: &Type, bytes: &[u8]) -> Result<(), NotAllowed> {
        match value_type.number_of(bytes) {
            Some(number) if !self.holds(number) => Err(NotAllowed {
                number,
                limits: self.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Returns the number of the choice with this name.
    #[must_use]
    pub fn choice(&self, name: &str) -> Option<usize> {
        self.choices.iter().position(|choice| choice == name)
    }
}

impl NotAllowed {
    /// Returns the message with a unit: "is -1 m, and at least 0 m is allowed".
    #[must_use]
    pub fn words(&self, unit: &str) -> String {
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" {unit}")
        };
        let Limits {
            least,
            greatest,
            choices,
        } = &self.limits;
        let allowed = if choices.is_empty() {
            match (least, greatest) {
                (Some(least), _) if self.number < *least => format!("at least {least}{unit}"),
                (_, Some(greatest)) if self.number > *greatest => format!("at most {greatest}{unit}"),
                _ => String::from("a number"),
            }
        } else {
            format!("one of {}", choices.join(", "))
        };
        format!("is {}{unit}, and {allowed} is allowed", self.number)
    }
}

impl fmt::Display for NotAllowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words(""))
    }
}

impl std::error::Error for NotAllowed {}

impl Type {
    /// Returns the number in these bytes, if the type is a plain number: one scalar as its only field.
    #[must_use]
    pub fn number_of(&self, bytes: &[u8]) -> Option<f64> {
        let [
            Field {
                kind: FieldKind::Scalar(scalar),
                form: Form::One,
                offset,
                ..
            },
        ] = self.fields.as_slice()
        else {
            return None;
        };
        scalar.number_of(bytes.get(*offset..)?)
    }
}

impl Scalar {
    /// Returns the number at the start of these bytes. `None` for a bool, and if there are too few bytes.
    #[must_use]
    pub fn number_of(self, bytes: &[u8]) -> Option<f64> {
        macro_rules! number {
            ($number:ty) => {
                <$number>::from_ne_bytes(*bytes.first_chunk()?) as f64
            };
        }
        Some(match self {
            Self::Bool => return None,
            Self::U8 => number!(u8),
            Self::U16 => number!(u16),
            Self::U32 => number!(u32),
            Self::U64 => number!(u64),
            Self::I8 => number!(i8),
            Self::I16 => number!(i16),
            Self::I32 => number!(i32),
            Self::I64 => number!(i64),
            Self::F32 => number!(f32),
            Self::F64 => number!(f64),
        })
    }
}
