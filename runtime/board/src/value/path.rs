//! One part of a value by its path: `pose.position.x`, `ranges[3]`, `poses[2].position`. It decodes that part
//! only.

use jde_abi::describe::{Field, FieldKind, Form, Type};

use super::decode::{decode, decode_element, decode_field};
use super::encode::{join, unknown_field};
use super::{Value, ValueError};

/// Returns the part of a value that a path names. The empty path names the whole value.
///
/// # Errors
/// A field or an element does not exist, the path cannot be parsed, or the size of the bytes differs from
/// that of the type.
pub fn get_path(value_type: &Type, bytes: &[u8], path: &str) -> Result<Value, ValueError> {
    if bytes.len() != value_type.bytes {
        return Err(ValueError::Size {
            value_type: value_type.name.clone(),
            expected: value_type.bytes,
            got: bytes.len(),
        });
    }
    if path.is_empty() {
        return Ok(decode(value_type, bytes));
    }
    let (mut value_type, mut bytes, mut parsed) = (value_type, bytes, 0);
    let steps: Vec<&str> = path.split('.').collect();
    for (number, step) in steps.iter().enumerate() {
        let last = number + 1 == steps.len();
        let parent = &path[..parsed];
        let (name, index) = parse(step).map_err(|wrong| path_error(path, wrong))?;
        let Some(field) = value_type.fields.iter().find(|field| field.name == name) else {
            let list = value_type.fields.iter().find(|field| is_list(field));
            if let ("", Some(_), Some(list)) = (name, index, list) {
                let wrong = format!(
                    "an index follows a field, as in `{}{step}`",
                    join(parent, &list.name)
                );
                return Err(path_error(path, wrong));
            }
            return Err(unknown_field(value_type, parent, name));
        };
        parsed += step.len() + usize::from(parsed > 0);
        let part = &path[..parsed];
        let element = match index {
            Some(index) => Some(element(field, bytes, part, index)?),
            None if field.form == Form::One => Some(0),
            None => None,
        };
        match (element, &field.kind) {
            (Some(index), FieldKind::Struct(inner)) if !last => {
                bytes = &bytes[field.offset + index * inner.bytes..];
                value_type = inner;
            }
            (Some(index), _) if last => return Ok(decode_element(field, bytes, index)),
            (None, _) if last => return Ok(decode_field(field, bytes)),
            (Some(_), _) => return Err(path_error(path, format!("`{part}` has no fields"))),
            (None, _) => {
                return Err(path_error(
                    path,
                    format!("`{part}` is a list; add an index, as in `{part}[0]`"),
                ));
            }
        }
    }
    unreachable!("a path that is not empty has a last step")
}

/// Parses `name` or `name[index]`.
fn parse(step: &str) -> Result<(&str, Option<usize>), String> {
    let Some((name, rest)) = step.split_once('[') else {
        return Ok((step, None));
    };
    let index = rest.strip_suffix(']').and_then(|index| index.parse().ok());
    let index = index.ok_or_else(|| format!("`{step}` does not have the form `{name}[3]`"))?;
    Ok((name, Some(index)))
}

fn element(field: &Field, bytes: &[u8], part: &str, index: usize) -> Result<usize, ValueError> {
    if !is_list(field) {
        return Err(path_error(part, "only lists have elements".to_owned()));
    }
    let length = field.length(bytes);
    if index >= length {
        let path = part.split('[').next().unwrap_or(part).to_owned();
        return Err(ValueError::NoElement { path, index, length });
    }
    Ok(index)
}

const fn is_list(field: &Field) -> bool {
    matches!(field.form, Form::Array(_) | Form::Sequence { .. })
}

fn path_error(path: &str, wrong: String) -> ValueError {
    ValueError::Path {
        path: path.to_owned(),
        wrong,
    }
}
