//! The numbers of a value, by the names of its fields: `pose.pose.position.x`, `ranges`, `poses[0]`.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

/// Numbers of one type, in the bytes of a value. Offsets count from the start of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Their type.
    pub scalar: Scalar,
    /// The first one, bytes.
    pub offset: usize,
    /// How many there are.
    pub form: Form,
}

impl Numbers {
    /// Returns how many there are in a value.
    ///
    /// # Panics
    /// If the value has fewer bytes than its type.
    #[must_use]
    pub fn count(&self, bytes: &[u8]) -> usize {
        let capacity = self.form.capacity();
        self.form.length_offset().map_or(capacity, |offset| {
            let mut length = [0; 4];
            length.copy_from_slice(&bytes[offset..][..4]);
            capacity.min(u32::from_ne_bytes(length) as usize)
        })
    }

    /// Returns them; a bool is 0 or 1.
    ///
    /// # Panics
    /// If the value has fewer bytes than its type.
    pub fn read<'b>(&self, bytes: &'b [u8]) -> impl Iterator<Item = f64> + use<'b> {
        let (scalar, offset, size) = (self.scalar, self.offset, self.scalar.bytes());
        let number = move |index| {
            let place = &bytes[offset + index * size..][..size];
            scalar
                .number_of(place)
                .unwrap_or_else(|| f64::from(u8::from(place[0] != 0)))
        };
        (0..self.count(bytes)).map(number)
    }
}

/// Collects the numbers of a structure that a path names, in their order; of an empty path, all.
///
/// # Errors
/// The path names none.
pub fn collect(value_type: &Type, path: &str) -> Result<Vec<Numbers>, String> {
    let mut found = Vec::new();
    structure(value_type, path, 0, &mut found)?;
    Ok(found)
}

fn structure(value_type: &Type, path: &str, base: usize, found: &mut Vec<Numbers>) -> Result<(), String> {
    if path.is_empty() {
        let mut fields = value_type.fields.iter();
        return fields.try_for_each(|field| of_field(field, None, "", base, found));
    }
    let (step, rest) = path.split_once('.').unwrap_or((path, ""));
    let (name, index) = match step.split_once('[') {
        None => (step, None),
        Some((name, index)) => {
            let index = index.strip_suffix(']').and_then(|index| index.parse().ok());
            (
                name,
                Some(index.ok_or_else(|| format!("`{step}` does not have the form `{name}[3]`"))?),
            )
        }
    };
    let field = value_type.fields.iter().find(|field| field.name == name);
    let known = || Vec::from_iter(value_type.fields.iter().map(|field| field.name.as_str())).join(", ");
    let field =
        field.ok_or_else(|| format!("a {} has no field `{name}`, but {}", value_type.name, known()))?;
    of_field(field, index, rest, base, found)
}

fn of_field(
    field: &Field,
    index: Option<usize>,
    rest: &str,
    base: usize,
    found: &mut Vec<Numbers>,
) -> Result<(), String> {
    let (name, capacity) = (&field.name, field.form.capacity());
    let of = |index: usize| base + field.offset + index * field.kind.bytes();
    if index.is_some_and(|index| field.form == Form::One || index >= capacity) {
        return Err(format!("`{name}` has no such element"));
    }
    match (&field.kind, field.form, index) {
        (_, Form::Text { .. }, _) => Err(format!("`{name}` is a text")),
        (FieldKind::Scalar(_), ..) if !rest.is_empty() => Err(format!("`{name}` has no fields")),
        (FieldKind::Scalar(scalar), form, index) => {
            let form = match (index, form) {
                (Some(_), _) => Form::One,
                (
                    None,
                    Form::Sequence {
                        capacity,
                        length_offset,
                    },
                ) => Form::Sequence {
                    capacity,
                    length_offset: base + length_offset,
                },
                (None, other) => other,
            };
            let offset = of(index.unwrap_or_default());
            found.push(Numbers {
                scalar: *scalar,
                offset,
                form,
            });
            Ok(())
        }
        (FieldKind::Struct(_), Form::Sequence { .. }, None) => Err(format!(
            "the number of `{name}` varies; name one, such as `{name}[0]`"
        )),
        (FieldKind::Struct(inner), _, Some(index)) => structure(inner, rest, of(index), found),
        (FieldKind::Struct(inner), _, None) => {
            (0..capacity).try_for_each(|index| structure(inner, rest, of(index), found))
        }
    }
}
