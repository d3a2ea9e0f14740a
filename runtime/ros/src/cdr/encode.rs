//! Encodes the bytes of a value as a message. It never fails: a length above the capacity counts as the
//! capacity, and every byte of a text that is not UTF-8 becomes `?`.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::Writer;

/// The least size of numbers that are not copied, bytes. A copy of less takes a few microseconds.
const MIN_BORROWED_BYTES: usize = 1 << 15;

/// Numbers that are the same bytes in a value and in its message.
#[derive(Clone, Copy, Debug)]
pub struct Uncopied<'v> {
    /// How many of the copied bytes are before them in the message.
    pub after: usize,
    /// Their place in the value.
    pub numbers: &'v [u8],
}

/// Where numbers stay that are not copied.
struct Uncopying<'a, 'v> {
    least: usize,
    found: &'a mut Vec<Uncopied<'v>>,
}

/// Replaces the contents of `message` by the message of a value. A reused vector is not reallocated once it
/// is large enough.
///
/// # Panics
/// If there are fewer bytes than the type has.
pub fn encode(value_type: &Type, value: &[u8], message: &mut Vec<u8>) {
    encode_with(value_type, value, message, &mut None);
}

/// As [`encode`], without copies of lists of numbers of 32 kB and more. The message consists of the bytes of
/// `copied` and, in between, of what is returned, in that order.
///
/// # Panics
/// As for that.
pub fn encode_in_place<'v>(value_type: &Type, value: &'v [u8], copied: &mut Vec<u8>) -> Vec<Uncopied<'v>> {
    encode_from(MIN_BORROWED_BYTES, value_type, value, copied)
}

/// As [`encode_in_place`], without copies of lists of at least so many bytes.
pub(super) fn encode_from<'v>(
    least: usize,
    value_type: &Type,
    value: &'v [u8],
    copied: &mut Vec<u8>,
) -> Vec<Uncopied<'v>> {
    let mut found = Vec::new();
    let uncopying = Uncopying {
        least,
        found: &mut found,
    };
    encode_with(value_type, value, copied, &mut Some(uncopying));
    found
}

fn encode_with<'v>(
    value_type: &Type,
    value: &'v [u8],
    message: &mut Vec<u8>,
    uncopying: &mut Option<Uncopying<'_, 'v>>,
) {
    assert!(
        value.len() >= value_type.bytes,
        "a `{}` has {} bytes, not {}",
        value_type.name,
        value_type.bytes,
        value.len()
    );
    structure(value_type, value, &mut Writer::new(message), uncopying);
}

fn structure<'v>(
    value_type: &Type,
    value: &'v [u8],
    writer: &mut Writer<'_>,
    uncopying: &mut Option<Uncopying<'_, 'v>>,
) {
    if value_type.fields.is_empty() {
        // In ROS 2, a structure without members has one member, a zero byte.
        writer.bytes(&[0]);
    }
    for field in &value_type.fields {
        one_field(field, value, writer, uncopying);
    }
}

fn one_field<'v>(
    field: &Field,
    value: &'v [u8],
    writer: &mut Writer<'_>,
    uncopying: &mut Option<Uncopying<'_, 'v>>,
) {
    let count = field.length(value);
    match field.form {
        Form::One | Form::Array(_) => {}
        Form::Sequence { .. } => writer.length(count),
        Form::Text { .. } => return writer.text(&value[field.offset..][..count]),
    }
    let bytes = field.kind.bytes();
    let elements = &value[field.offset..][..count * bytes];
    match &field.kind {
        FieldKind::Scalar(scalar) => scalars(*scalar, elements, writer, uncopying),
        FieldKind::Struct(inner) => elements
            .chunks_exact(bytes)
            .for_each(|element| structure(inner, element, writer, uncopying)),
    }
}

fn scalars<'v>(
    scalar: Scalar,
    elements: &'v [u8],
    writer: &mut Writer<'_>,
    uncopying: &mut Option<Uncopying<'_, 'v>>,
) {
    if elements.is_empty() {
        // An empty sequence has no alignment gap after its length.
        return;
    }
    writer.align(scalar.bytes());
    if scalar == Scalar::Bool {
        elements
            .iter()
            .for_each(|byte| writer.bytes(&[u8::from(*byte != 0)]));
    } else if cfg!(target_endian = "big") {
        let reversed = |byte: &u8| writer.bytes(&[*byte]);
        let elements = elements.chunks_exact(scalar.bytes());
        elements
            .flat_map(|element| element.iter().rev())
            .for_each(reversed);
    } else if let Some(uncopying) = uncopying.as_mut().filter(|of| elements.len() >= of.least) {
        uncopying.found.push(Uncopied {
            after: writer.written(),
            numbers: elements,
        });
        writer.leave_out(elements.len());
    } else {
        writer.bytes(elements);
    }
}
