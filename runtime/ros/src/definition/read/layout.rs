//! The types of fields, and their places in memory.

use jde_abi::describe::{Field, FieldKind, Form, RosNotation, Scalar, Type};

use super::super::TEXT;
use super::section::FieldLine;
use super::{MAX_BYTES, ReadError};

/// The elements of a field.
pub(super) enum Element<'a> {
    Number(Scalar),
    /// A structure of this name.
    Structure(&'a str),
    /// A text, in a list.
    Text(Bound),
}

/// The most elements, and whether that is a bound in ROS 2.
#[derive(Clone, Copy)]
pub(super) struct Bound {
    pub(super) capacity: usize,
    pub(super) is_of_ros: bool,
}

/// The most elements or bytes of a field without a bound.
pub(super) type Capacity<'a> = dyn Fn(&str) -> usize + 'a;

/// The number of elements, before the field has a place.
pub(super) enum ElementCount {
    One,
    Array(usize),
    Sequence(Bound),
    Text(Bound),
}

/// Types of fields that ROS 2 has no more.
pub(in super::super) const OF_ROS_1: [&str; 2] = ["time", "duration"];

/// Returns a field's elements, and their number. Without capacities, each text and each sequence must have a bound, which is
/// none in ROS 2.
pub(super) fn shape<'a>(
    line: &FieldLine<'a>,
    capacities: Option<&Capacity<'_>>,
) -> Result<(Element<'a>, ElementCount), ReadError> {
    let error = |reason| ReadError::Kind {
        line: line.number,
        kind: line.kind.to_owned(),
        reason,
    };
    let number = |text: &str| {
        text.parse::<u32>()
            .ok()
            .filter(|number| *number > 0)
            .map(|number| number as usize)
            .ok_or_else(|| error("its number of elements is 1 to 4294967295"))
    };
    let stated = |text: &str| {
        let capacity = number(text)?;
        Ok(Bound {
            capacity,
            is_of_ros: capacities.is_some(),
        })
    };
    let unbounded = |advice| {
        let capacity = capacities.ok_or_else(|| error(advice))?(line.name);
        Ok(Bound {
            capacity,
            is_of_ros: false,
        })
    };
    let (element, bracket) = match line.kind.split_once('[') {
        Some((element, rest)) => (
            element,
            Some(rest.strip_suffix(']').ok_or_else(|| error("a `]` is missing"))?),
        ),
        None => (line.kind, None),
    };
    let text = match element.split_once("<=") {
        Some(("string", limit)) => Some(stated(limit)?),
        None if element == "string" && bracket.is_some() => {
            Some(unbounded("give its texts a bound, as in `string<=64[<=8]`")?)
        }
        None if element == "string" => Some(unbounded("give it a bound, as in `string<=64`")?),
        Some(_) | None => None,
    };
    let count = match bracket {
        Some("") => ElementCount::Sequence(unbounded("give it a bound, as in `float32[<=64]`")?),
        Some(count) => match count.strip_prefix("<=") {
            Some(limit) => ElementCount::Sequence(stated(limit)?),
            None => ElementCount::Array(number(count)?),
        },
        None => ElementCount::One,
    };
    match (text, count) {
        (Some(bound), ElementCount::One) => Ok((Element::Number(Scalar::U8), ElementCount::Text(bound))),
        (Some(bound), count) => Ok((Element::Text(bound), count)),
        (None, _) if element.starts_with("wstring") => Err(error("texts are UTF-8, as in `string<=64`")),
        (None, _) if OF_ROS_1.contains(&element) => Err(error(
            "it is of ROS 1; ROS 2 has `builtin_interfaces/Time` and `builtin_interfaces/Duration`",
        )),
        (None, count) => Ok((
            scalar(element).map_or(Element::Structure(element), Element::Number),
            count,
        )),
    }
}

/// Returns the structure of a text, as an element of a list. `None` if it is too large.
pub(super) fn text(bound: Bound) -> Option<Type> {
    let line = FieldLine {
        number: 0,
        kind: "",
        name: "data",
        doc: "The text.".to_owned(),
        unit: String::new(),
    };
    let mut layout = Layout::default();
    layout.push(&line, FieldKind::Scalar(Scalar::U8), ElementCount::Text(bound))?;
    let doc = "A text in a list: a list of these is a `string[]` of ROS 2.";
    Some(layout.finish(TEXT.to_owned(), doc.to_owned()))
}

/// The number of this name; `None` for a structure or a text.
#[must_use]
pub fn scalar(element: &str) -> Option<Scalar> {
    Some(match element {
        "bool" => Scalar::Bool,
        "uint8" | "byte" | "char" => Scalar::U8,
        "uint16" => Scalar::U16,
        "uint32" => Scalar::U32,
        "uint64" => Scalar::U64,
        "int8" => Scalar::I8,
        "int16" => Scalar::I16,
        "int32" => Scalar::I32,
        "int64" => Scalar::I64,
        "float32" => Scalar::F32,
        "float64" => Scalar::F64,
        _ => return None,
    })
}

/// Fields with their places.
pub(super) struct Layout {
    fields: Vec<Field>,
    end: usize,
    align: usize,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            fields: Vec::new(),
            end: 0,
            align: 1,
        }
    }
}

impl Layout {
    /// Adds a field. Returns `None` if the value would exceed its maximum size.
    pub(super) fn push(&mut self, line: &FieldLine<'_>, kind: FieldKind, shape: ElementCount) -> Option<()> {
        // A sequence begins with its length and a spare word, a text with its length in bytes.
        let (head, align, capacity) = match shape {
            ElementCount::One => (0, kind.align(), 1),
            ElementCount::Array(count) => (0, kind.align(), count),
            ElementCount::Sequence(bound) => (8, kind.align().max(4), bound.capacity),
            ElementCount::Text(bound) => (4, kind.align().max(4), bound.capacity),
        };
        let is_bounded =
            matches!(&shape, ElementCount::Sequence(bound) | ElementCount::Text(bound) if bound.is_of_ros);
        let start = self.end.next_multiple_of(align);
        let form = match shape {
            ElementCount::One => Form::One,
            ElementCount::Array(count) => Form::Array(count),
            ElementCount::Sequence(Bound { capacity, .. }) => Form::Sequence {
                capacity,
                length_offset: start,
            },
            ElementCount::Text(Bound { capacity, .. }) => Form::Text {
                capacity,
                length_offset: start,
            },
        };
        let length = kind.bytes().checked_mul(capacity)?;
        let end = (start + head).checked_add(length)?;
        if end > MAX_BYTES {
            return None;
        }
        self.end = end.next_multiple_of(align);
        self.align = self.align.max(align);
        self.fields.push(Field {
            name: line.name.to_owned(),
            doc: line.doc.clone(),
            unit: line.unit.clone(),
            kind,
            form,
            offset: start + head,
            notation: RosNotation {
                is_byte: line.kind.split('[').next() == Some("byte"),
                is_bounded,
            },
        });
        Some(())
    }

    pub(super) fn finish(self, name: String, doc: String) -> Type {
        Type {
            name,
            doc,
            // A value has at least one byte.
            bytes: self.end.next_multiple_of(self.align).max(1),
            align: self.align,
            fields: self.fields,
        }
    }
}
