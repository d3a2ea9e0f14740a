//! The kind of value of a part of an expression, as far as it is known before there are values.

use std::fmt;
use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

/// A kind of value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ValueKind {
    /// Known only at evaluation.
    Any,
    Bool,
    Int,
    UInt,
    Double,
    Text,
    List(Box<ValueKind>),
    Struct(Arc<Type>),
}

impl ValueKind {
    /// Returns the kind of a variable. A type with a single number as its only field counts as that number.
    pub(crate) fn of(value_type: &Arc<Type>) -> Self {
        match value_type.as_number() {
            Some(scalar) => Self::scalar(scalar),
            None => Self::Struct(Arc::clone(value_type)),
        }
    }

    /// Returns the kind of a field.
    pub(crate) fn field(field: &Field) -> Self {
        let element = match &field.kind {
            FieldKind::Scalar(scalar) => Self::scalar(*scalar),
            FieldKind::Struct(inner) => Self::Struct(Arc::clone(inner)),
        };
        match field.form {
            Form::One => element,
            Form::Array(_) | Form::Sequence { .. } => Self::List(Box::new(element)),
            Form::Text { .. } => Self::Text,
        }
    }

    fn scalar(scalar: Scalar) -> Self {
        match scalar {
            Scalar::Bool => Self::Bool,
            Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => Self::UInt,
            Scalar::I8 | Scalar::I16 | Scalar::I32 | Scalar::I64 => Self::Int,
            Scalar::F32 | Scalar::F64 => Self::Double,
        }
    }

    pub(crate) fn is_number(&self) -> bool {
        matches!(self, Self::Int | Self::UInt | Self::Double)
    }
}

/// The kind with its article: "a double", "a list".
impl fmt::Display for ValueKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("a value"),
            Self::Bool => f.write_str("a bool"),
            Self::Int => f.write_str("an int"),
            Self::UInt => f.write_str("a uint"),
            Self::Double => f.write_str("a double"),
            Self::Text => f.write_str("a text"),
            Self::List(_) => f.write_str("a list"),
            Self::Struct(value_type) => write!(f, "a {}", value_type.name),
        }
    }
}
