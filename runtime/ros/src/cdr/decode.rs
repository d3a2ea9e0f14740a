//! Decodes a message as the bytes of a value. Bytes outside of fields and elements past the end are not written.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::Error;
use super::pieces::{OnCut, Pieces};
use crate::definition::texts;

/// Returns the bytes of the value in a message. Bytes that no field has are zero.
///
/// # Errors
/// [`Error`]. For any input, it does not panic and allocates no more than a value.
pub fn decode(value_type: &Type, message: &[u8]) -> Result<Vec<u8>, Error> {
    let mut value = vec![0; value_type.bytes];
    decode_into(value_type, message, &mut value)?;
    Ok(value)
}

/// Replaces a value by that in a message. Elements past the end keep their bytes. It does not allocate.
///
/// # Errors
/// [`Error`]. The contents of `value` are unspecified then.
///
/// # Panics
/// If there are not as many bytes as the type has.
pub fn decode_into(value_type: &Type, message: &[u8], value: &mut [u8]) -> Result<(), Error> {
    decode_pieces(value_type, &[message], value)
}

/// As [`decode_into`], for a message that came in several pieces.
///
/// # Errors
/// As for that.
///
/// # Panics
/// As for that.
pub fn decode_pieces(value_type: &Type, pieces: &[&[u8]], value: &mut [u8]) -> Result<(), Error> {
    assert_eq!(
        value.len(),
        value_type.bytes,
        "the bytes of a `{}`",
        value_type.name
    );
    let mut reader = Pieces::new(pieces)?;
    structure(value_type, value, &mut reader)?;
    reader.finish()
}

/// As [`decode_into`], for a message of another program, which knows no capacities: texts that are longer than theirs are
/// cut between two characters, and `on_cut` is told of each.
///
/// # Errors
/// As for that.
///
/// # Panics
/// As for that.
pub fn decode_cutting<'a>(
    value_type: &Type,
    message: &'a [u8],
    value: &mut [u8],
    on_cut: &'a mut OnCut<'a>,
) -> Result<(), Error> {
    assert_eq!(
        value.len(),
        value_type.bytes,
        "the bytes of a `{}`",
        value_type.name
    );
    let pieces = [message];
    let mut reader = Pieces::new(&pieces)?;
    reader.on_cut = Some(on_cut);
    structure(value_type, value, &mut reader)?;
    reader.finish()
}

fn structure(value_type: &Type, value: &mut [u8], reader: &mut Pieces<'_>) -> Result<(), Error> {
    if value_type.fields.is_empty() {
        reader.fill(1, &mut [0], &value_type.name)?;
    }
    value_type
        .fields
        .iter()
        .try_for_each(|field| one_field(field, value, reader))
}

fn one_field(field: &Field, value: &mut [u8], reader: &mut Pieces<'_>) -> Result<(), Error> {
    let count = match field.form {
        Form::One | Form::Array(_) => field.form.capacity(),
        Form::Sequence {
            capacity,
            length_offset,
        } => {
            let count = reader.length(&field.name)?;
            fits(field, count, capacity)?;
            set_length(value, length_offset, count);
            count
        }
        Form::Text {
            capacity,
            length_offset,
        } => {
            let length = text(field, capacity, &mut value[field.offset..], reader)?;
            set_length(value, length_offset, length);
            return Ok(());
        }
    };
    let bytes = field.kind.bytes();
    let target = &mut value[field.offset..][..count * bytes];
    match &field.kind {
        FieldKind::Scalar(scalar) => scalars(*scalar, target, reader, &field.name),
        FieldKind::Struct(inner) => {
            let mut elements = target.chunks_exact_mut(bytes);
            let read = elements.try_for_each(|element| structure(inner, element, reader));
            match texts(field) {
                Some(_) => read.map_err(|error| error.in_list(&field.name)),
                None => read,
            }
        }
    }
}

/// Copies a text without its NUL. Returns its length.
fn text(field: &Field, capacity: usize, target: &mut [u8], reader: &mut Pieces<'_>) -> Result<usize, Error> {
    let is_none = || Error::Text(field.name.clone());
    let with_nul = reader.length(&field.name)?;
    reader.expect(with_nul, &field.name)?;
    let length = with_nul.checked_sub(1).ok_or_else(is_none)?;
    let kept = match &mut reader.on_cut {
        Some(on_cut) if length > capacity => {
            on_cut(&field.name, capacity);
            capacity
        }
        _ => {
            fits(field, length, capacity)?;
            length
        }
    };
    let mut nul = [0xff];
    reader.fill(1, &mut target[..kept], &field.name)?;
    reader.skip(length - kept, &field.name)?;
    reader.fill(1, &mut nul, &field.name)?;
    let end = match std::str::from_utf8(&target[..kept]) {
        Ok(_) => kept,
        // The cut is within a character.
        Err(error) if kept < length && error.error_len().is_none() => error.valid_up_to(),
        Err(_) => return Err(is_none()),
    };
    if nul != [0] {
        return Err(is_none());
    }
    Ok(end)
}

fn scalars(scalar: Scalar, target: &mut [u8], reader: &mut Pieces<'_>, field: &str) -> Result<(), Error> {
    if target.is_empty() {
        return Ok(());
    }
    reader.fill(scalar.bytes(), target, field)?;
    if cfg!(target_endian = "big") {
        target.chunks_exact_mut(scalar.bytes()).for_each(<[u8]>::reverse);
    }
    Ok(())
}

pub(super) fn fits(field: &Field, length: usize, capacity: usize) -> Result<(), Error> {
    if length <= capacity {
        return Ok(());
    }
    Err(Error::Capacity {
        field: field.name.clone(),
        capacity,
        got: length,
    })
}

fn set_length(value: &mut [u8], offset: usize, length: usize) {
    value[offset..][..4].copy_from_slice(&(length as u32).to_ne_bytes());
}
