//! Numbers within a value, found by the path of their fields, as in `pose.pose.position.x` or `ranges[90]`,
//! and read from the bytes.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

/// Maximum number of names offered for one type: enough for the largest standard message.
const MAX_OFFERED: usize = 400;

/// The location of a number in the bytes of a value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FieldPath {
    offset: usize,
    scalar: Scalar,
    /// The sequences on the path: the offset of the length, and the element. Each must be long enough.
    lists: Vec<(usize, usize)>,
    /// The unit; empty for none.
    pub(super) unit: String,
}

/// Finds a number by its path. The empty path is for types with a single number.
///
/// # Errors
/// What is wrong with the path, with the nearest existing name.
pub(crate) fn find(of: &Type, path: &str) -> Result<FieldPath, String> {
    let mut value_type = of;
    let mut place = FieldPath {
        offset: 0,
        scalar: Scalar::F64,
        lists: Vec::new(),
        unit: String::new(),
    };
    let whole = if path.is_empty() {
        match of.fields.as_slice() {
            [only] if of.as_number().is_some() => only.name.as_str(),
            _ => return Err(format!("a {} is not a number: name one of its fields", of.name)),
        }
    } else {
        path
    };
    let mut parts = whole.split('.').peekable();
    while let Some(part) = parts.next() {
        let (name, element) = split(part)?;
        let field = value_type.fields.iter().find(|field| field.name == name);
        let field = field.ok_or_else(|| {
            let names = value_type.fields.iter().map(|field| field.name.as_str());
            let nearest = jde_nearest::nearest(name, names)
                .map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            format!("a {} has no field `{name}`{nearest}", value_type.name)
        })?;
        let base = place.offset;
        place.offset += field.offset;
        match (field.form, element) {
            (Form::One, None) => {}
            (Form::Array(capacity) | Form::Sequence { capacity, .. }, Some(element))
                if element < capacity =>
            {
                place.offset += element * field.kind.bytes();
                if let Some(length) = field.form.length_offset() {
                    place.lists.push((base + length, element));
                }
            }
            (Form::Array(capacity) | Form::Sequence { capacity, .. }, Some(_)) => {
                return Err(format!("`{name}` has {capacity} elements, from 0"));
            }
            (Form::Array(_) | Form::Sequence { .. }, None) => {
                return Err(format!("`{name}` is a list: name an element, as in `{name}[0]`"));
            }
            (Form::One, Some(_)) => return Err(format!("`{name}` is not a list")),
            (Form::Text { .. }, _) => return Err(format!("`{name}` is a text, not a number")),
        }
        match &field.kind {
            FieldKind::Scalar(scalar) if parts.peek().is_none() => {
                (place.scalar, place.unit) = (*scalar, field.unit.clone());
                return Ok(place);
            }
            FieldKind::Scalar(_) => return Err(format!("`{name}` is a number and has no fields")),
            FieldKind::Struct(inner) => value_type = inner,
        }
        // A structure with a single number is treated as that number.
        if let (None, Some(scalar), [only]) =
            (parts.peek(), value_type.as_number(), value_type.fields.as_slice())
        {
            place.offset += only.offset;
            (place.scalar, place.unit) = (scalar, field.unit.clone());
            return Ok(place);
        }
    }
    Err(format!(
        "`{whole}` is a {}: name one of its fields",
        value_type.name
    ))
}

/// The paths of the numbers of a type. Lists are represented by their first element.
pub(super) fn list(of: &Type) -> Vec<String> {
    let mut found = Vec::new();
    if of.as_number().is_some() {
        found.push(String::new());
    } else {
        collect_below(of, "", &mut found);
    }
    found
}

fn collect_below(of: &Type, before: &str, found: &mut Vec<String>) {
    for field in &of.fields {
        if found.len() >= MAX_OFFERED {
            return;
        }
        let Field { name, form, kind, .. } = field;
        let path = match form {
            Form::One => format!("{before}{name}"),
            Form::Array(_) | Form::Sequence { .. } => format!("{before}{name}[0]"),
            Form::Text { .. } => continue,
        };
        match kind {
            FieldKind::Scalar(_) => found.push(path),
            FieldKind::Struct(inner) => collect_below(inner, &format!("{path}."), found),
        }
    }
}

impl FieldPath {
    /// Reads the number from a value. `None` if a list is too short.
    pub(crate) fn read(&self, bytes: &[u8]) -> Option<f64> {
        for &(length, element) in &self.lists {
            let length = Scalar::U32.number_of(bytes.get(length..)?)?;
            if length <= element as f64 {
                return None;
            }
        }
        match self.scalar {
            Scalar::Bool => Some(f64::from(*bytes.get(self.offset)?)),
            scalar => scalar.number_of(bytes.get(self.offset..)?),
        }
    }
}

/// Splits an element's name: `ranges[90]` into `ranges` and 90.
fn split(part: &str) -> Result<(&str, Option<usize>), String> {
    let Some((name, rest)) = part.split_once('[') else {
        return Ok((part, None));
    };
    let element = rest.strip_suffix(']').and_then(|element| element.parse().ok());
    match element {
        Some(element) => Ok((name, Some(element))),
        None => Err(format!("`{part}` has no element number: write `{name}[0]`")),
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{Bumpers, Flag, LaserScan, Odometry, Value};

    use super::*;

    #[test]
    fn a_number_is_found_by_its_path_and_read_from_the_bytes() {
        let mut odometry = Odometry::zeroed();
        odometry.pose.pose.position.x = 1.25;
        odometry.pose.covariance[7] = 4.0;
        let of = Odometry::describe();
        let read = |path: &str| find(&of, path).expect(path).read(odometry.as_bytes());
        assert_eq!(read("pose.pose.position.x"), Some(1.25));
        assert_eq!(read("pose.covariance[7]"), Some(4.0));
        assert_eq!(
            find(&of, "pose.pose.position.x").expect("the field exists").unit,
            "m"
        );
        let mut bumpers = Bumpers::zeroed();
        bumpers.front.push(Flag::TRUE).expect("the sequence has room");
        let place = find(&Bumpers::describe(), "front[0]").expect("the path is valid");
        assert_eq!(place.read(bumpers.as_bytes()), Some(1.0));
        let period = f64::describe();
        assert_eq!(
            find(&period, "")
                .expect("the type is a number")
                .read(0.075.as_bytes()),
            Some(0.075)
        );
    }

    #[test]
    fn an_element_past_the_end_of_a_list_has_no_value() {
        let of = LaserScan::describe();
        let place = find(&of, "ranges[3]").expect("the path is valid");
        assert_eq!(place.read(LaserScan::zeroed().as_bytes()), None);
    }

    #[test]
    fn a_path_that_is_not_a_number_is_refused_with_the_nearest_name() {
        let of = Odometry::describe();
        for (path, reason) in [
            ("pose.pose.positon.x", "did you mean `position`?"),
            ("pose.pose", "name one of its fields"),
            ("pose.covariance", "is a list"),
            ("pose.covariance[36]", "36 elements"),
            ("pose.covariance[a]", "has no element number"),
            ("child_frame_id", "is a text"),
            ("", "is not a number"),
        ] {
            let refused = find(&of, path).unwrap_err();
            assert!(refused.contains(reason), "{path}: {refused}");
        }
    }

    #[test]
    fn every_offered_path_is_found() {
        for of in [Odometry::describe(), LaserScan::describe(), f64::describe()] {
            let offered = list(&of);
            assert!(!offered.is_empty());
            for path in offered {
                assert!(find(&of, &path).is_ok(), "{path}");
            }
        }
    }
}
