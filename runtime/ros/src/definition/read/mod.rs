//! Reads the type that a definition describes. Its layout is that of schemas' values: in the order of the
//! fields, each at the next multiple of its alignment, as in C. A field without a bound is refused, because a
//! shared value has a fixed size.
//!
//! The text is not trusted: its length, depth, bytes and number of fields are bounded.

mod layout;
mod section;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_abi::describe::{FieldKind, Type};

use super::{definition, full, parts};
pub(super) use layout::OF_ROS_1;
pub use layout::scalar;
use layout::{Capacity, Element, Layout, shape, text};
use section::{Comments, FieldLine, Section, sections};

/// The longest definition, in bytes; the standard types need 5 kB at most.
const MAX_TEXT: usize = 1 << 20;
/// The largest value, in bytes, and the maximum nesting of structures: the limits of a plugin.
const MAX_BYTES: usize = 256 << 20;
const MAX_DEPTH: usize = 16;
/// The maximum number of fields. Those of contained types count at each occurrence, so it bounds every walk
/// through a type.
const MAX_FIELDS: usize = 1 << 16;
/// The most fields of one structure. A plugin takes 4096 entries, and there may be a gap before each field.
const MAX_OWN_FIELDS: usize = 2048;
/// The longest part of a line in a message, in characters.
const SHOWN_CHARACTERS: usize = 80;

/// Why a text does not define a type that can be shared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// A line is neither a comment nor a field.
    #[error("line {line}: `{text}` is no field; expected a type and a name, as in `float64 x`")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// Its text.
        text: String,
    },
    /// The name of a field is too long.
    #[error("line {line}: the name of the field has {length} letters; at most 64 are possible")]
    Name {
        /// Its number, from 1.
        line: usize,
        /// The length of the name, bytes.
        length: usize,
    },
    /// The type of a field is not possible in a shared value.
    #[error("line {line}: a field of `{kind}` cannot be shared; {reason}")]
    Kind {
        /// Its number, from 1.
        line: usize,
        /// The type of the field.
        kind: String,
        /// What to use instead.
        reason: &'static str,
    },
    /// The text does not define a structure.
    #[error("line {line}: `{name}` is not defined; expected it behind a line `MSG: {name}`")]
    Unknown {
        /// The line that uses it.
        line: usize,
        /// Its name.
        name: String,
    },
    /// Two definitions, or two fields of one definition, have the same name.
    #[error("line {line}: there is a `{name}` already")]
    Duplicate {
        /// The line of the second one.
        line: usize,
        /// The name.
        name: String,
    },
    /// A type contains itself, or is nested too deeply.
    #[error("`{0}` nests deeper than {MAX_DEPTH}, or contains itself")]
    TooDeep(String),
    /// A type exceeds the limits of size or fields.
    #[error("`{0}` is too large; at most {MAX_BYTES} bytes and {MAX_FIELDS} fields are shared")]
    TooLarge(String),
    /// A structure has more fields than a plugin takes.
    #[error("`{0}` has more than {MAX_OWN_FIELDS} fields")]
    TooWide(String),
    /// The fault is in the definition of a type that another one contains. Its lines are counted from its own beginning.
    #[error("`{name}`: {error}")]
    Inside {
        /// The name of the type.
        name: String,
        /// The fault.
        error: Box<Self>,
    },
    /// The text has this many bytes, which is too long.
    #[error("the definition has {0} bytes; at most {MAX_TEXT} are read")]
    TooLong(usize),
}

impl ReadError {
    fn line(line: usize, text: &str) -> Self {
        Self::Line {
            line,
            text: text.chars().take(SHOWN_CHARACTERS).collect(),
        }
    }

    /// Returns the error of a line of a definition that `before` lines of others precede.
    fn inside(self, name: &str, before: usize) -> Self {
        match self {
            Self::TooDeep(_)
            | Self::TooLarge(_)
            | Self::TooWide(_)
            | Self::TooLong(_)
            | Self::Inside { .. } => self,
            error if before == 0 => error,
            error => Self::Inside {
                name: name.to_owned(),
                error: Box::new(error),
            },
        }
    }
}

/// Returns the type that a definition describes. This inverts [`definition`](super::definition()), apart from
/// white space in docs, if that type has the layout of C without further padding. `name` becomes the name of
/// the type; contained types are `package/msg/Type`, or parts of services and actions.
///
/// Constants and defaults are skipped; `byte` and `char` are `uint8`. A structure without a package has the
/// package of the definition that uses it.
///
/// # Errors
/// [`ReadError`], with the line. For any text, the time is proportional to its length.
pub fn read(name: &str, text: &str) -> Result<Type, ReadError> {
    read_with(name, text, None, |_| None)
}

/// As [`read`], for a definition of ROS 2: its bounds are part of the type there. `capacity` returns the most elements or
/// bytes of the field of that name if it has no bound. Its comments are those of a person: only a unit that jde knows, behind the
/// comment on a number, is one. `known` returns types that need no definition, by names as
/// `std_msgs/msg/Header`.
///
/// # Errors
/// As for that.
pub fn read_interface(
    name: &str,
    text: &str,
    capacity: impl Fn(&str) -> usize,
    known: impl Fn(&str) -> Option<Arc<Type>>,
) -> Result<Type, ReadError> {
    read_with(name, text, Some(&capacity), known)
}

fn read_with(
    name: &str,
    text: &str,
    capacities: Option<&Capacity<'_>>,
    known: impl Fn(&str) -> Option<Arc<Type>>,
) -> Result<Type, ReadError> {
    if text.len() > MAX_TEXT {
        return Err(ReadError::TooLong(text.len()));
    }
    let whose = match capacities {
        None => Comments::Own,
        Some(_) => Comments::Foreign,
    };
    let sections = sections(name, text, whose)?;
    let root = short(name);
    let mut reader = DefinitionReader {
        sections: &sections,
        capacities,
        known: &known,
        parsed: BTreeMap::new(),
    };
    let parsed = reader.structure(&root, 0)?;
    Ok(Type {
        name: name.to_owned(),
        ..(*parsed.value_type).clone()
    })
}

/// Returns whether a definition has the fields of a type, and of each type that it contains, in their order. Bounds
/// of sequences and texts may differ: they are no part of a message.
#[must_use]
pub fn has_fields(text: &str, value_type: &Type) -> bool {
    let ours = definition(value_type);
    let [ours, theirs] = [&ours, text].map(|text| sections(&value_type.name, text, Comments::Foreign));
    let (Ok(ours), Ok(theirs)) = (ours, theirs) else {
        return false;
    };
    ours.iter().all(|(title, section)| {
        let same = |other| fields(section) == fields(other);
        theirs.get(title).is_some_and(same)
    })
}

/// Returns the types and names of the fields of a definition.
fn fields<'a>(section: &Section<'a>) -> Vec<(String, &'a str)> {
    let lines = section.fields.iter();
    lines.map(|line| (unbounded(section, line), line.name)).collect()
}

/// Returns the type of a field without bounds, and with the package of its structure.
fn unbounded(section: &Section<'_>, line: &FieldLine<'_>) -> String {
    let (element, brackets) = line.kind.split_at(line.kind.find('[').unwrap_or(line.kind.len()));
    let brackets = if brackets.starts_with("[<=") {
        "[]"
    } else {
        brackets
    };
    let element = match element.split("<=").next().unwrap_or(element) {
        "byte" | "char" => "uint8".to_owned(),
        element if element == "string" || scalar(element).is_some() => element.to_owned(),
        element => section.title(element),
    };
    element + brackets
}

/// A finished type, its nesting depth, and the number of its fields with those of contained types.
#[derive(Clone)]
struct ParsedType {
    value_type: Arc<Type>,
    height: usize,
    fields: usize,
}

impl ParsedType {
    fn of(value_type: Arc<Type>) -> Self {
        let inner = value_type.fields.iter().filter_map(|field| match &field.kind {
            FieldKind::Struct(inner) => Some(Self::of(Arc::clone(inner))),
            FieldKind::Scalar(_) => None,
        });
        let own = (0, value_type.fields.len());
        let (height, fields) = inner.fold(own, |(height, fields), inner| {
            (height.max(inner.height + 1), fields + inner.fields)
        });
        Self {
            value_type,
            height,
            fields,
        }
    }
}

struct DefinitionReader<'a> {
    sections: &'a BTreeMap<String, Section<'a>>,
    capacities: Option<&'a Capacity<'a>>,
    known: &'a dyn Fn(&str) -> Option<Arc<Type>>,
    parsed: BTreeMap<String, ParsedType>,
}

impl DefinitionReader<'_> {
    fn structure(&mut self, title: &str, depth: usize) -> Result<ParsedType, ReadError> {
        if let Some(parsed) = self.parsed.get(title) {
            return Ok(parsed.clone());
        }
        if depth > MAX_DEPTH {
            return Err(ReadError::TooDeep(title.to_owned()));
        }
        let sections = self.sections;
        let section = &sections[title];
        let parsed = self.fields(title, section, depth);
        let parsed = parsed.map_err(|error| error.inside(title, section.before))?;
        self.parsed.insert(title.to_owned(), parsed.clone());
        Ok(parsed)
    }

    fn fields(&mut self, title: &str, section: &Section<'_>, depth: usize) -> Result<ParsedType, ReadError> {
        let mut layout = Layout::default();
        let mut names = BTreeSet::new();
        let (mut height, mut count) = (0, 0_usize);
        let too_large = || ReadError::TooLarge(title.to_owned());
        for line in &section.fields {
            if !names.insert(line.name) {
                return Err(ReadError::Duplicate {
                    line: line.number,
                    name: line.name.to_owned(),
                });
            }
            let (element, shape) = shape(line, self.capacities)?;
            let kind = match element {
                Element::Number(scalar) => FieldKind::Scalar(scalar),
                Element::Structure(element) => {
                    let inner = self.inner(section, line, element, depth)?;
                    height = height.max(inner.height + 1);
                    count = count.saturating_add(inner.fields);
                    FieldKind::Struct(inner.value_type)
                }
                Element::Text(bound) => {
                    height = height.max(1);
                    count = count.saturating_add(1);
                    FieldKind::Struct(Arc::new(text(bound).ok_or_else(too_large)?))
                }
            };
            count = count.saturating_add(1);
            layout.push(line, kind, shape).ok_or_else(too_large)?;
        }
        if section.fields.len() > MAX_OWN_FIELDS {
            return Err(ReadError::TooWide(title.to_owned()));
        }
        if height > MAX_DEPTH {
            return Err(ReadError::TooDeep(title.to_owned()));
        }
        if count > MAX_FIELDS {
            return Err(too_large());
        }
        let (package, name) = parts(title);
        Ok(ParsedType {
            value_type: Arc::new(layout.finish(full(&package, &name), section.doc.clone())),
            height,
            fields: count,
        })
    }

    /// Returns the structure that is the type of a field.
    fn inner(
        &mut self,
        section: &Section<'_>,
        line: &FieldLine<'_>,
        element: &str,
        depth: usize,
    ) -> Result<ParsedType, ReadError> {
        let title = section.title(element);
        let (package, own) = parts(&title);
        if let Some(value_type) = (self.known)(&full(&package, &own)) {
            return Ok(ParsedType::of(value_type));
        }
        if !self.sections.contains_key(&title) {
            return Err(ReadError::Unknown {
                line: line.number,
                name: title,
            });
        }
        self.structure(&title, depth + 1)
    }
}

fn short(name: &str) -> String {
    let (package, name) = parts(name);
    format!("{package}/{name}")
}

#[cfg(test)]
mod tests;
