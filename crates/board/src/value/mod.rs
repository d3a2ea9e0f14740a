//! Values without their Rust types: for application files, tools and recordings. A description of the type says what the
//! bytes are. No units are converted here, and no file format is known.

mod decode;
mod encode;
mod path;
mod show;

pub use decode::decode;
pub use encode::encode;
pub use path::get_path;

/// A value of any type.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Yes or no.
    Bool(bool),
    /// A whole number of a signed type.
    Int(i64),
    /// A whole number of an unsigned type.
    UInt(u64),
    /// A number.
    Float(f64),
    /// Text.
    Text(String),
    /// Elements of an array or a sequence; or the fields of a structure of numbers, in their order.
    List(Vec<Value>),
    /// Fields of a structure by name, in their order.
    Map(Vec<(String, Value)>),
}

/// Why a value does not fit a type, or a path leads nowhere. A path is like `poses[2].position.x`; empty for the whole.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ValueError {
    /// No such field.
    #[error("{} has no field `{field}`{}", whole(.path), hint(.nearest, .known))]
    UnknownField {
        /// What has no such field.
        path: String,
        /// The field asked for.
        field: String,
        /// The nearest there is.
        nearest: Option<String>,
        /// All there are.
        known: Vec<String>,
    },
    /// Another kind of value.
    #[error("{} must be {expected}, not {got}", whole(.path))]
    Kind {
        /// Where.
        path: String,
        /// What belongs there.
        expected: String,
        /// What was given.
        got: String,
    },
    /// A number that the field's type cannot hold.
    #[error("{} is a {scalar} and cannot hold {got}; give {least} to {greatest}", whole(.path))]
    Range {
        /// Where.
        path: String,
        /// The type of the field.
        scalar: &'static str,
        /// What was given.
        got: String,
        /// Least it can hold.
        least: String,
        /// Greatest it can hold.
        greatest: String,
    },
    /// More elements, or bytes of text, than there is room for.
    #[error("{} has room for {capacity} {what}, and {got} were given", whole(.path))]
    TooLong {
        /// Where.
        path: String,
        /// Elements or bytes.
        what: &'static str,
        /// Room.
        capacity: usize,
        /// Given.
        got: usize,
    },
    /// Another number of elements than a fixed one.
    #[error("{} needs exactly {expected} values, and {got} were given", whole(.path))]
    Count {
        /// Where.
        path: String,
        /// Needed.
        expected: usize,
        /// Given.
        got: usize,
    },
    /// An element past the end.
    #[error("{} has {length} elements, counted from 0; there is no [{index}]", whole(.path))]
    NoElement {
        /// What has too few.
        path: String,
        /// The one asked for.
        index: usize,
        /// How many there are.
        length: usize,
    },
    /// A path that cannot be read, or that goes on where there is nothing below.
    #[error("path `{path}`: {wrong}")]
    Path {
        /// The whole path.
        path: String,
        /// What is wrong.
        wrong: String,
    },
    /// Bytes that are not a value of the type.
    #[error("a `{value_type}` has {expected} bytes, not {got}")]
    Size {
        /// The type.
        value_type: String,
        /// Its bytes.
        expected: usize,
        /// Given.
        got: usize,
    },
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

fn whole(path: &str) -> String {
    if path.is_empty() {
        "the value".to_owned()
    } else {
        format!("`{path}`")
    }
}

fn hint(nearest: &Option<String>, known: &[String]) -> String {
    match nearest {
        Some(near) => format!("; did you mean `{near}`?"),
        None => format!("; it has {}", known.join(", ")),
    }
}
