//! Finds NaNs and infinities in values. It checks the present elements of a sequence, not its capacity.

use crate::describe::{Field, FieldKind, Form, Scalar, Type};

/// The floats of a type, collected once.
#[derive(Clone, Debug)]
pub struct Finite {
    checks: Vec<Check>,
}

/// A field that is, or contains, floats.
#[derive(Clone, Debug)]
struct Check {
    name: String,
    /// From the start of the value or of the element that contains it.
    offset: usize,
    count: Count,
    element: Element,
}

#[derive(Clone, Debug)]
enum Count {
    One,
    Fixed(usize),
    /// The number of elements is a `u32` in the value.
    Dynamic {
        offset: usize,
        capacity: usize,
    },
}

#[derive(Clone, Debug)]
enum Element {
    F32,
    F64,
    Struct { bytes: usize, checks: Vec<Check> },
}

impl Finite {
    /// Collects the floats of a type.
    #[must_use]
    pub fn new(value_type: &Type) -> Self {
        Self {
            checks: checks(value_type),
        }
    }

    /// Returns the path of the first float that is a NaN or an infinity, such as `pose.position.x` or
    /// `ranges[3]`.
    ///
    /// # Panics
    /// If there are fewer bytes than the type has.
    #[must_use]
    pub fn first_not_finite(&self, bytes: &[u8]) -> Option<String> {
        first_not_finite(&self.checks, bytes)
    }
}

/// Returns the fields of a type that are, or contain, floats.
fn checks(value_type: &Type) -> Vec<Check> {
    value_type.fields.iter().filter_map(check).collect()
}

fn check(field: &Field) -> Option<Check> {
    let element = match &field.kind {
        FieldKind::Scalar(Scalar::F32) => Element::F32,
        FieldKind::Scalar(Scalar::F64) => Element::F64,
        FieldKind::Scalar(_) => return None,
        FieldKind::Struct(inner) => {
            let checks = checks(inner);
            if checks.is_empty() {
                return None;
            }
            Element::Struct {
                bytes: inner.bytes,
                checks,
            }
        }
    };
    Some(Check {
        name: field.name.clone(),
        offset: field.offset,
        count: match field.form {
            Form::One => Count::One,
            Form::Array(count) => Count::Fixed(count),
            Form::Sequence {
                capacity,
                length_offset,
            }
            | Form::Text {
                capacity,
                length_offset,
            } => Count::Dynamic {
                offset: length_offset,
                capacity,
            },
        },
        element,
    })
}

fn first_not_finite(checks: &[Check], bytes: &[u8]) -> Option<String> {
    checks.iter().find_map(|check| check.run(bytes))
}

impl Check {
    fn run(&self, bytes: &[u8]) -> Option<String> {
        let count = match self.count {
            Count::One => 1,
            Count::Fixed(count) => count,
            Count::Dynamic { offset, capacity } => {
                (u32::from_ne_bytes(array(bytes, offset)) as usize).min(capacity)
            }
        };
        (0..count).find_map(|index| {
            let inner = match &self.element {
                Element::F32 if f32::from_ne_bytes(array(bytes, self.offset + index * 4)).is_finite() => {
                    return None;
                }
                Element::F64 if f64::from_ne_bytes(array(bytes, self.offset + index * 8)).is_finite() => {
                    return None;
                }
                Element::F32 | Element::F64 => None,
                Element::Struct {
                    bytes: stride,
                    checks,
                } => Some(first_not_finite(checks, &bytes[self.offset + index * stride..])?),
            };
            Some(self.path(index, inner))
        })
    }

    fn path(&self, index: usize, inner: Option<String>) -> String {
        let mut path = self.name.clone();
        if !matches!(self.count, Count::One) {
            path += &format!("[{index}]");
        }
        if let Some(inner) = inner {
            path += ".";
            path += &inner;
        }
        path
    }
}

fn array<const N: usize>(bytes: &[u8], offset: usize) -> [u8; N] {
    *bytes[offset..]
        .first_chunk()
        .expect("a value has all bytes of its type")
}
