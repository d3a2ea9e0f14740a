//! The value of a variable as an expression reads it. A field is decoded when the expression reads it; no
//! other field is copied or decoded.

use std::fmt;

use cel::ExecutionError;
use cel::common::traits::Indexer;
use cel::common::types::{CelBool, CelDouble, CelInt, CelList, CelNull, CelString, CelUInt, Type as CelType};
use cel::common::value::{CowVal, Val};
use jde_abi::describe::{Field, FieldKind, Form, Type};

use crate::compiled::Number;

/// The result of `type(x)` for all structures. The check before the start distinguishes their types.
static STRUCTURE: CelType = CelType::new_unspecified_type("structure");

/// Wraps the bytes of a value for an expression.
pub(crate) fn of<'v>(value_type: &'v Type, bytes: &'v [u8]) -> Box<dyn Val + 'v> {
    match (value_type.as_number(), value_type.fields.first()) {
        (Some(_), Some(number)) => field(number, bytes),
        _ => Box::new(Structure { value_type, bytes }),
    }
}

#[derive(Clone)]
struct Structure<'v> {
    value_type: &'v Type,
    bytes: &'v [u8],
}

fn field<'v>(field: &'v Field, bytes: &'v [u8]) -> Box<dyn Val + 'v> {
    let size = field.kind.bytes();
    // A length beyond the capacity counts as the capacity.
    let count = field
        .form
        .length_offset()
        .map_or(field.form.capacity(), |offset| {
            let length = bytes[offset..]
                .first_chunk()
                .map_or(0, |length| u32::from_ne_bytes(*length)) as usize;
            length.min(field.form.capacity())
        });
    let elements = &bytes[field.offset..][..count * size];
    match field.form {
        Form::One => element(&field.kind, elements),
        Form::Array(_) | Form::Sequence { .. } => {
            let elements = elements.chunks_exact(size);
            Box::new(CelList::from(
                elements
                    .map(|bytes| element(&field.kind, bytes))
                    .collect::<Vec<_>>(),
            ))
        }
        Form::Text { .. } => match str::from_utf8(elements) {
            Ok(text) => Box::new(CelString::from(text)),
            Err(_) => Box::new(CelString::from(String::from_utf8_lossy(elements).into_owned())),
        },
    }
}

fn element<'v>(kind: &'v FieldKind, bytes: &'v [u8]) -> Box<dyn Val + 'v> {
    let scalar = match kind {
        FieldKind::Struct(value_type) => return Box::new(Structure { value_type, bytes }),
        FieldKind::Scalar(scalar) => *scalar,
    };
    match Number::decode(scalar, bytes) {
        Some(Number::Bool(value)) => Box::new(CelBool::from(value)),
        Some(Number::Int(value)) => Box::new(CelInt::from(value)),
        Some(Number::UInt(value)) => Box::new(CelUInt::from(value)),
        Some(Number::Double(value)) => Box::new(CelDouble::from(value)),
        // A value has all bytes of its type.
        None => Box::new(CelNull),
    }
}

impl fmt::Debug for Structure<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.value_type.name)
    }
}

impl Val for Structure<'_> {
    fn get_type(&self) -> &CelType {
        &STRUCTURE
    }

    fn cel_type() -> &'static CelType {
        &STRUCTURE
    }

    fn as_indexer<'b, 'w>(&'b self) -> Option<&'b (dyn Indexer + 'w)>
    where
        Self: 'w,
    {
        Some(self)
    }

    fn clone_as_boxed<'w>(&self) -> Box<dyn Val + 'w>
    where
        Self: 'w,
    {
        Box::new(self.clone())
    }
}

impl Indexer for Structure<'_> {
    fn get<'b, 'w>(&'b self, name: &dyn Val) -> Result<CowVal<'b, 'w>, ExecutionError>
    where
        Self: 'w,
    {
        let name = name.downcast_ref::<CelString>().map_or("", CelString::inner);
        let found = self.value_type.fields.iter().find(|field| field.name == name);
        let found = found.ok_or_else(|| ExecutionError::no_such_key(name))?;
        Ok(CowVal::Owned(field(found, self.bytes)))
    }

    fn steal<'w>(self: Box<Self>, name: &dyn Val) -> Result<Box<dyn Val + 'w>, ExecutionError>
    where
        Self: 'w,
    {
        self.get(name).map(CowVal::into_owned)
    }
}
