//! Values without their Rust types, for application files, tools and recordings. A description of the type
//! gives the meaning of the bytes. It converts no units and knows no file formats.

mod decode;
mod display;
mod encode;
mod floats;
mod path;

use jde_abi::describe::Type;

pub use decode::{decode, decode_scalar};
pub use encode::encode;
pub use floats::{change_floats, has_floats};
pub use path::get_path;

/// A value of any type.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// True or false.
    Bool(bool),
    /// A whole number of a signed type.
    Int(i64),
    /// A whole number of an unsigned type.
    UInt(u64),
    /// A floating-point number.
    Float(f64),
    /// Text.
    Text(String),
    /// Elements of an array or a sequence, or the fields of a structure of numbers, in order.
    List(Vec<Value>),
    /// Fields of a structure by name, in order.
    Map(Vec<(String, Value)>),
}

/// Why a value does not fit a type, or a path names nothing. A path has the form `poses[2].position.x`; an
/// empty path is the whole value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ValueError {
    /// The field does not exist.
    #[error("{} has no field `{field}`{}", subject(.path), suggestion(.nearest, .known))]
    UnknownField {
        /// The value without such a field.
        path: String,
        /// The requested field.
        field: String,
        /// The nearest existing field.
        nearest: Option<String>,
        /// All existing fields.
        known: Vec<String>,
    },
    /// The value has the wrong kind.
    #[error("{} must be {expected}, not {got}", subject(.path))]
    Kind {
        /// Where.
        path: String,
        /// The expected kind.
        expected: String,
        /// The value that was given.
        got: String,
    },
    /// A number that the field's type cannot hold.
    #[error("{} is a {scalar} and cannot hold {got}; give {least} to {greatest}", subject(.path))]
    Range {
        /// Where.
        path: String,
        /// The type of the field.
        scalar: &'static str,
        /// The value that was given.
        got: String,
        /// The least number that it can hold.
        least: String,
        /// The greatest number that it can hold.
        greatest: String,
    },
    /// More elements, or bytes of text, than the capacity.
    #[error("{} has room for {capacity} {what}, and {got} were given", subject(.path))]
    TooLong {
        /// Where.
        path: String,
        /// Elements or bytes.
        what: &'static str,
        /// The capacity.
        capacity: usize,
        /// The number that was given.
        got: usize,
    },
    /// The number of elements differs from a fixed one.
    #[error("{} needs exactly {expected} values, and {got} were given", subject(.path))]
    Count {
        /// Where.
        path: String,
        /// The number that is required.
        expected: usize,
        /// The number that was given.
        got: usize,
    },
    /// The index of an element is past the end.
    #[error("{} has {length} elements, counted from 0; there is no [{index}]", subject(.path))]
    NoElement {
        /// The list.
        path: String,
        /// The requested index.
        index: usize,
        /// The number of elements.
        length: usize,
    },
    /// A path that cannot be parsed, or that continues below a value without fields.
    #[error("path `{path}`: {wrong}")]
    Path {
        /// The whole path.
        path: String,
        /// What is wrong.
        wrong: String,
    },
    /// The size of the bytes differs from that of the type.
    #[error("a `{value_type}` has {expected} bytes, not {got}")]
    Size {
        /// The type.
        value_type: String,
        /// Its size in bytes.
        expected: usize,
        /// The number of bytes that were given.
        got: usize,
    },
}

impl Value {
    /// Returns a number of any type as a float; `None` for other values, also true and false.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Float(number) => Some(*number),
            Self::Int(number) => Some(*number as f64),
            Self::UInt(number) => Some(*number as f64),
            Self::Bool(_) | Self::Text(_) | Self::List(_) | Self::Map(_) => None,
        }
    }

    /// Replaces a structure with one field by that field.
    #[must_use]
    pub fn into_only_field(self) -> Self {
        match self {
            Self::Map(mut fields) if fields.len() == 1 => fields.remove(0).1,
            other => other,
        }
    }

    /// As [`into_only_field`](Self::into_only_field) if the type has one field: a value may leave out others.
    #[must_use]
    pub fn into_only_field_of(self, value_type: &Type) -> Self {
        match value_type.fields.as_slice() {
            [_] => self.into_only_field(),
            _ => self,
        }
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Self::Int(value)
    }
}

impl From<u64> for Value {
    fn from(value: u64) -> Self {
        Self::UInt(value)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Float(value)
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

fn subject(path: &str) -> String {
    if path.is_empty() {
        "the value".to_owned()
    } else {
        format!("`{path}`")
    }
}

fn suggestion(nearest: &Option<String>, known: &[String]) -> String {
    match nearest {
        Some(near) => format!("; did you mean `{near}`?"),
        None => format!("; it has {}", known.join(", ")),
    }
}
