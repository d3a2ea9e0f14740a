//! Reads the tables of value types. Every byte of a value must belong to exactly one field. Gaps of C are
//! refused, unless a field of padding covers them. Padding is checked and then omitted from the description.

use std::sync::Arc;

use super::Refusal;
use super::place::Place;
use crate::describe::{Field, FieldKind, Form, RosNotation, Scalar, Type};
use crate::{raw, unit};

/// The largest value: eight images of 4K.
const MOST_BYTES: u64 = 256 << 20;
/// The deepest nesting of structures.
const DEEPEST: usize = 16;

/// The bytes of a value that one field occupies.
struct Span {
    offset: usize,
    bytes: usize,
    align: usize,
    field: String,
}

/// A field of a table: its description, unless it is padding, and the bytes that it occupies.
struct Part {
    field: Option<Field>,
    spans: Vec<Span>,
}

pub(super) unsafe fn value_type(
    outer: &Place,
    table: *const raw::Type,
    depth: usize,
) -> Result<Type, Refusal> {
    if depth > DEEPEST {
        return outer.wrong(format!(
            "its type nests deeper than {DEEPEST}, or contains itself"
        ));
    }
    // SAFETY: the caller's table follows the rules of `raw`, and so does all it points to.
    unsafe {
        let table = outer.table(table)?;
        let name = outer.text("a type's name", table.name)?;
        if name.is_empty() {
            return outer.wrong("a type has no name");
        }
        let place = outer.inner("type", &name);
        if table.bytes == 0 || table.bytes > MOST_BYTES {
            return place.wrong(format!("{} bytes; a value has 1 to {MOST_BYTES}", table.bytes));
        }
        if !table.align.is_power_of_two() || table.align > 16 || table.bytes % table.align != 0 {
            return place.wrong(format!(
                "alignment {} for {} bytes; it must be 1, 2, 4, 8 or 16 and divide the size",
                table.align, table.bytes
            ));
        }
        let fields = place.array("fields", table.fields, table.field_count)?;
        let mut spans = Vec::new();
        let mut described = Vec::new();
        for field in fields {
            let part = self::field(&place, &table, &field, depth)?;
            spans.extend(part.spans);
            described.extend(part.field);
        }
        let fields = described;
        place.distinct("fields", fields.iter().map(|field| field.name.clone()))?;
        cover(&place, spans, table.bytes as usize)?;
        if let Some(field) = fields
            .iter()
            .find(|field| field.kind.align() > table.align as usize)
        {
            return place.wrong(format!(
                "field `{}` needs alignment {}, the type has {}",
                field.name,
                field.kind.align(),
                table.align
            ));
        }
        let doc = place.text("doc", table.doc)?;
        Ok(Type {
            name,
            doc,
            bytes: table.bytes as usize,
            align: table.align as usize,
            fields,
        })
    }
}

unsafe fn field(outer: &Place, whole: &raw::Type, table: &raw::Field, depth: usize) -> Result<Part, Refusal> {
    // SAFETY: the caller's table follows the rules of `raw`, and so does all it points to.
    unsafe {
        let name = outer.name("a field's name", table.name)?;
        let place = outer.inner("field", &name);
        let kind = match table.kind {
            raw::BOOL => FieldKind::Scalar(Scalar::Bool),
            raw::U8 => FieldKind::Scalar(Scalar::U8),
            raw::U16 => FieldKind::Scalar(Scalar::U16),
            raw::U32 => FieldKind::Scalar(Scalar::U32),
            raw::U64 => FieldKind::Scalar(Scalar::U64),
            raw::I8 => FieldKind::Scalar(Scalar::I8),
            raw::I16 => FieldKind::Scalar(Scalar::I16),
            raw::I32 => FieldKind::Scalar(Scalar::I32),
            raw::I64 => FieldKind::Scalar(Scalar::I64),
            raw::F32 => FieldKind::Scalar(Scalar::F32),
            raw::F64 => FieldKind::Scalar(Scalar::F64),
            raw::STRUCT => {
                let part = place.table(table.value_type)?;
                // A part is smaller than the whole, or its only field. This check stops a type that contains
                // itself several times.
                if part.bytes > whole.bytes || (part.bytes == whole.bytes && whole.field_count > 1) {
                    return place.wrong(format!(
                        "a part of {} bytes in a type of {}",
                        part.bytes, whole.bytes
                    ));
                }
                FieldKind::Struct(Arc::new(value_type(&place, table.value_type, depth + 1)?))
            }
            other => return place.wrong(format!("kind is {other}, and only 0 to 11 exist")),
        };
        if table.offset > MOST_BYTES || table.length_offset > MOST_BYTES {
            return place.wrong(format!(
                "offset {} or {} is past any value",
                table.offset, table.length_offset
            ));
        }
        let (capacity, length_offset) = (table.capacity as usize, table.length_offset as usize);
        if capacity == 0 {
            return place.wrong("capacity is 0");
        }
        let length = kind
            .bytes()
            .saturating_mul(if table.form == raw::ONE { 1 } else { capacity });
        let span = |offset, bytes, align| Span {
            offset,
            bytes,
            align,
            field: name.clone(),
        };
        let mut spans = vec![span(table.offset as usize, length, kind.align())];
        let form = match table.form {
            raw::ONE => Form::One,
            raw::ARRAY => Form::Array(capacity),
            raw::SEQUENCE => {
                let spare = table.offset == table.length_offset + 8;
                spans.push(span(length_offset, if spare { 8 } else { 4 }, 4));
                Form::Sequence {
                    capacity,
                    length_offset,
                }
            }
            raw::TEXT | raw::PADDING if kind != FieldKind::Scalar(Scalar::U8) => {
                return place.wrong("a text and padding are made of bytes (U8)");
            }
            raw::TEXT => {
                spans.push(span(length_offset, 4, 4));
                Form::Text {
                    capacity,
                    length_offset,
                }
            }
            raw::PADDING => return Ok(Part { field: None, spans }),
            other => return place.wrong(format!("form is {other}, and only 0 to 4 exist")),
        };
        let unit = place.text("unit", table.unit)?;
        if let Err(wrong) = unit::check(&unit) {
            return place.wrong(wrong);
        }
        let field = Field {
            doc: place.text("doc", table.doc)?,
            unit,
            name,
            kind,
            form,
            offset: table.offset as usize,
            notation: RosNotation {
                is_byte: table.flags & raw::BYTE != 0,
                is_bounded: table.flags & raw::BOUNDED != 0,
            },
        };
        Ok(Part {
            field: Some(field),
            spans,
        })
    }
}

/// Checks that the fields, with the lengths of sequences, cover every byte of a value exactly once.
fn cover(place: &Place, mut spans: Vec<Span>, bytes: usize) -> Result<(), Refusal> {
    spans.sort_by_key(|span| span.offset);
    let mut reached = 0;
    for Span {
        offset,
        bytes: length,
        align,
        field: name,
    } in spans
    {
        if offset % align != 0 {
            return place.wrong(format!(
                "field `{name}` at byte {offset} is not aligned to {align}"
            ));
        }
        if offset < reached {
            return place.wrong(format!(
                "field `{name}` at byte {offset} overlaps the one before it, which ends at {reached}"
            ));
        }
        if offset > reached {
            return place.wrong(format!(
                "bytes {reached} to {offset} before field `{name}` belong to no field"
            ));
        }
        reached = offset.saturating_add(length);
        if reached > bytes {
            return place.wrong(format!(
                "field `{name}` ends at byte {reached}, the type has {bytes}"
            ));
        }
    }
    if reached != bytes {
        return place.wrong(format!("the fields end at byte {reached}, the type has {bytes}"));
    }
    Ok(())
}
