//! Changes the floats of a value in place, at any depth. It checks nothing.

use jde_abi::describe::{Field, FieldKind, Scalar};

/// Replaces every float of these fields of the structure at the start of `bytes`, in order. `change` receives
/// the place of the float in its own field, and the float. Of a sequence, only the present elements count.
///
/// # Panics
/// If there are fewer bytes than the fields have.
pub fn change_floats(fields: &[Field], bytes: &mut [u8], change: &mut dyn FnMut(usize, f64) -> f64) {
    for field in fields {
        let size = field.kind.bytes();
        for index in 0..field.length(bytes) {
            let element = &mut bytes[field.offset + index * size..][..size];
            match &field.kind {
                FieldKind::Struct(inner) => change_floats(&inner.fields, element, change),
                FieldKind::Scalar(Scalar::F32) => replace(element, |bytes| {
                    let changed = change(index, f64::from(f32::from_ne_bytes(bytes)));
                    (changed as f32).to_ne_bytes()
                }),
                FieldKind::Scalar(Scalar::F64) => replace(element, |bytes| {
                    change(index, f64::from_ne_bytes(bytes)).to_ne_bytes()
                }),
                FieldKind::Scalar(_) => break,
            }
        }
    }
}

/// Returns whether these fields contain a float.
#[must_use]
pub fn has_floats(fields: &[Field]) -> bool {
    fields.iter().any(|field| match &field.kind {
        FieldKind::Struct(inner) => has_floats(&inner.fields),
        FieldKind::Scalar(scalar) => matches!(scalar, Scalar::F32 | Scalar::F64),
    })
}

fn replace<const N: usize>(element: &mut [u8], change: impl FnOnce([u8; N]) -> [u8; N]) {
    let element: &mut [u8; N] = element.try_into().expect("an element has the size of its kind");
    *element = change(*element);
}
