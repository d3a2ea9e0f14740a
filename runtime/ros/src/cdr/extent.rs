//! The most elements that messages have in each sequence and text. A type with just that room takes the memory of what
//! is in its values, and not of its capacity.

use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, Type};

use super::decode::fits;
use super::{Error, Reader};

/// The extent of the messages that were read.
pub struct Extent<'t> {
    value_type: &'t Type,
    /// Of each field, the most elements, and the extent of these.
    fields: Vec<(usize, Option<Self>)>,
}

impl<'t> Extent<'t> {
    /// Returns that of no message.
    #[must_use]
    pub fn new(value_type: &'t Type) -> Self {
        let fields = value_type.fields.iter().map(|field| match &field.kind {
            FieldKind::Struct(inner) => (0, Some(Self::new(inner))),
            FieldKind::Scalar(_) => (0, None),
        });
        Self {
            fields: fields.collect(),
            value_type,
        }
    }

    /// Includes a message. It does not allocate.
    ///
    /// # Errors
    /// [`Error`], as of [`decode`](super::decode()), except that of a text, whose bytes are not read.
    pub fn include(&mut self, message: &[u8]) -> Result<(), Error> {
        let mut reader = Reader::new(message)?;
        self.structure(&mut reader)?;
        reader.finish()
    }

    fn structure(&mut self, reader: &mut Reader<'_>) -> Result<(), Error> {
        if self.value_type.fields.is_empty() {
            reader.take(1, 1, &self.value_type.name)?;
        }
        for (field, (most, inner)) in self.value_type.fields.iter().zip(&mut self.fields) {
            let capacity = field.form.capacity();
            let count = match field.form {
                Form::One | Form::Array(_) => capacity,
                Form::Sequence { .. } => reader.length(&field.name)?,
                // The NUL at its end takes no room.
                Form::Text { .. } => {
                    let with_nul = reader.length(&field.name)?;
                    reader.take(1, with_nul, &field.name)?;
                    with_nul.saturating_sub(1)
                }
            };
            fits(field, count, capacity)?;
            *most = count.max(*most);
            match (&field.kind, inner, field.form) {
                (_, _, Form::Text { .. }) => {}
                (FieldKind::Struct(_), Some(inner), _) => {
                    (0..count).try_for_each(|_| inner.structure(reader))?;
                }
                (kind, _, _) if count > 0 => {
                    reader.take(kind.bytes(), count * kind.bytes(), &field.name)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the type with room for the messages that were included, and no more.
    #[must_use]
    pub fn into_type(self) -> Type {
        let (mut end, mut align): (usize, usize) = (0, 1);
        let fields = self.value_type.fields.iter().zip(self.fields);
        let fields = fields.map(|(field, (most, inner))| {
            let kind = match inner {
                Some(inner) => FieldKind::Struct(Arc::new(inner.into_type())),
                None => field.kind.clone(),
            };
            let (capacity, length_offset) = (most.max(1), end.next_multiple_of(4));
            let form = match field.form {
                Form::One => Form::One,
                Form::Array(count) => Form::Array(count),
                Form::Sequence { .. } => Form::Sequence {
                    capacity,
                    length_offset,
                },
                Form::Text { .. } => Form::Text {
                    capacity,
                    length_offset,
                },
            };
            let start = form.length_offset().map_or(end, |offset| offset + 4);
            let offset = start.next_multiple_of(kind.align());
            align = align.max(kind.align()).max(form.length_offset().map_or(1, |_| 4));
            end = offset + kind.bytes() * form.capacity();
            Field {
                kind,
                form,
                offset,
                ..field.clone()
            }
        });
        let fields = fields.collect();
        Type {
            name: self.value_type.name.clone(),
            doc: self.value_type.doc.clone(),
            // A structure without fields has a byte, as in a message.
            bytes: end.next_multiple_of(align).max(1),
            align,
            fields,
        }
    }
}
