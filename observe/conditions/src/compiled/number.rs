//! A number or a bool, and what operators and functions make of it: exactly what CEL makes of it. `None` is
//! CEL's error: kinds that do not fit, an overflow, a division by zero, an order with a NaN.

use std::cmp::Ordering;

use cel::common::ast::operators;
use jde_abi::describe::Scalar;

/// A value of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Number {
    Bool(bool),
    Int(i64),
    UInt(u64),
    Double(f64),
}

/// A function of one number.
pub(super) type Unary = fn(Number) -> Option<Number>;
/// A function of two numbers.
pub(super) type Binary = fn(Number, Number) -> Option<Number>;

impl Number {
    /// Decodes a scalar at the beginning of bytes; `None` if there are too few.
    pub(crate) fn decode(scalar: Scalar, bytes: &[u8]) -> Option<Self> {
        Some(match scalar {
            Scalar::Bool => Self::Bool(*bytes.first()? != 0),
            Scalar::U8 => Self::UInt((*bytes.first()?).into()),
            Scalar::U16 => Self::UInt(u16::from_ne_bytes(*bytes.first_chunk()?).into()),
            Scalar::U32 => Self::UInt(u32::from_ne_bytes(*bytes.first_chunk()?).into()),
            Scalar::U64 => Self::UInt(u64::from_ne_bytes(*bytes.first_chunk()?)),
            Scalar::I8 => Self::Int(i8::from_ne_bytes(*bytes.first_chunk()?).into()),
            Scalar::I16 => Self::Int(i16::from_ne_bytes(*bytes.first_chunk()?).into()),
            Scalar::I32 => Self::Int(i32::from_ne_bytes(*bytes.first_chunk()?).into()),
            Scalar::I64 => Self::Int(i64::from_ne_bytes(*bytes.first_chunk()?)),
            Scalar::F32 => Self::Double(f32::from_ne_bytes(*bytes.first_chunk()?).into()),
            Scalar::F64 => Self::Double(f64::from_ne_bytes(*bytes.first_chunk()?)),
        })
    }

    /// Returns the number; a bool counts as 0 or 1.
    pub(crate) fn as_f64(self) -> f64 {
        match self {
            Self::Bool(value) => value.into(),
            Self::Int(value) => value as f64,
            Self::UInt(value) => value as f64,
            Self::Double(value) => value,
        }
    }

    /// Compares numbers of any kind, or two bools.
    pub(super) fn compare(self, other: Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Double(one), Self::Double(other)) => one.partial_cmp(&other),
            (Self::Bool(one), Self::Bool(other)) => Some(one.cmp(&other)),
            (Self::Int(one), Self::Int(other)) => Some(one.cmp(&other)),
            (Self::UInt(one), Self::UInt(other)) => Some(one.cmp(&other)),
            // A negative number is less than any unsigned one.
            (Self::Int(one), Self::UInt(other)) => {
                Some(u64::try_from(one).map_or(Ordering::Less, |one| one.cmp(&other)))
            }
            (Self::UInt(_), Self::Int(_)) => other.compare(self).map(Ordering::reverse),
            (Self::Bool(_), _) | (_, Self::Bool(_)) => None,
            (Self::Double(_), _) | (_, Self::Double(_)) => self.as_f64().partial_cmp(&other.as_f64()),
        }
    }
}

/// Returns the operator or function of one number with this name in CEL.
pub(super) fn unary(name: &str) -> Option<Unary> {
    use Number::{Bool, Double, Int, UInt};
    Some(match name {
        operators::LOGICAL_NOT => |number| match number {
            Bool(value) => Some(Bool(!value)),
            Int(_) | UInt(_) | Double(_) => None,
        },
        operators::NEGATE => |number| match number {
            Int(value) => value.checked_neg().map(Int),
            Double(value) => Some(Double(-value)),
            Bool(_) | UInt(_) => None,
        },
        "double" => |number| match number {
            Int(_) | UInt(_) | Double(_) => Some(Double(number.as_f64())),
            Bool(_) => None,
        },
        "math.abs" => |number| match number {
            Int(value) => value.checked_abs().map(Int),
            UInt(value) => Some(UInt(value)),
            Double(value) => Some(Double(value.abs())),
            Bool(_) => None,
        },
        "math.sqrt" => |number| match number {
            Int(_) | UInt(_) | Double(_) => Some(Double(number.as_f64().sqrt())),
            Bool(_) => None,
        },
        _ => return None,
    })
}

/// Returns the operator of two numbers with this name in CEL.
pub(super) fn binary(name: &str) -> Option<Binary> {
    Some(match name {
        operators::EQUALS => |one, other| Some(Number::Bool(one.compare(other) == Some(Ordering::Equal))),
        operators::NOT_EQUALS => |one, other| Some(Number::Bool(one.compare(other) != Some(Ordering::Equal))),
        operators::LESS => |one, other| one.compare(other).map(|order| Number::Bool(order.is_lt())),
        operators::LESS_EQUALS => |one, other| one.compare(other).map(|order| Number::Bool(order.is_le())),
        operators::GREATER => |one, other| one.compare(other).map(|order| Number::Bool(order.is_gt())),
        operators::GREATER_EQUALS => |one, other| one.compare(other).map(|order| Number::Bool(order.is_ge())),
        operators::ADD => |one, other| {
            arithmetic(one, other, i64::checked_add, u64::checked_add, |one, other| {
                Some(one + other)
            })
        },
        operators::SUBSTRACT => |one, other| {
            arithmetic(one, other, i64::checked_sub, u64::checked_sub, |one, other| {
                Some(one - other)
            })
        },
        operators::MULTIPLY => |one, other| {
            arithmetic(one, other, i64::checked_mul, u64::checked_mul, |one, other| {
                Some(one * other)
            })
        },
        operators::DIVIDE => |one, other| {
            arithmetic(one, other, i64::checked_div, u64::checked_div, |one, other| {
                Some(one / other)
            })
        },
        operators::MODULO => {
            |one, other| arithmetic(one, other, i64::checked_rem, u64::checked_rem, |_, _| None)
        }
        "math.@min" => |one, other| extreme(one, other, Ordering::Less),
        "math.@max" => |one, other| extreme(one, other, Ordering::Greater),
        _ => return None,
    })
}

/// Both numbers must be of one kind.
fn arithmetic(
    one: Number,
    other: Number,
    ints: fn(i64, i64) -> Option<i64>,
    uints: fn(u64, u64) -> Option<u64>,
    doubles: fn(f64, f64) -> Option<f64>,
) -> Option<Number> {
    match (one, other) {
        (Number::Int(one), Number::Int(other)) => ints(one, other).map(Number::Int),
        (Number::UInt(one), Number::UInt(other)) => uints(one, other).map(Number::UInt),
        (Number::Double(one), Number::Double(other)) => doubles(one, other).map(Number::Double),
        _ => None,
    }
}

/// Returns the greatest or least of two; the first of two that are equal.
fn extreme(one: Number, other: Number, wanted: Ordering) -> Option<Number> {
    let order = one.compare(other)?;
    Some(if order == wanted.reverse() { other } else { one })
}
