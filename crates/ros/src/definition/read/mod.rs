//! From a definition to the type it describes, laid out as schemas lay their values out: in the order of the fields, each at
//! the next multiple of its alignment, as C does. What has no bound is refused, because a shared value has a fixed size.
//!
//! The text may come from anybody: what is read is bounded in length, depth, bytes and number of fields.

mod layout;
mod section;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_abi::describe::{FieldKind, Type};

use super::parts;
use layout::{Layout, scalar, shape};
use section::{Line, Section, sections};

/// Longest definition, bytes; the standard types need 5 kB at most.
const MOST_TEXT: usize = 1 << 20;
/// Largest value, bytes, and structures within structures: what a plugin may have.
const MOST_BYTES: usize = 256 << 20;
const DEEPEST: usize = 16;
/// Fields, those of parts counted wherever they occur: who walks through a type walks no further.
const MOST_FIELDS: usize = 1 << 16;

/// Why a text is no definition of a type that can be shared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// A line that is neither comment nor field.
    #[error("line {line}: `{text}` is no field; expected a type and a name, as in `float64 x`")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A kind that a shared value cannot have.
    #[error("line {line}: a field of `{kind}` cannot be shared; {why}")]
    Kind {
        /// Its number, from 1.
        line: usize,
        /// The kind.
        kind: String,
        /// What it may be instead.
        why: &'static str,
    },
    /// A structure that the text does not define.
    #[error("line {line}: `{name}` is not defined; expected it behind a line `MSG: {name}`")]
    Unknown {
        /// Where it is used.
        line: usize,
        /// Its name.
        name: String,
    },
    /// Two definitions, or two fields of one, share a name.
    #[error("line {line}: there is a `{name}` already")]
    Twice {
        /// Where the second is.
        line: usize,
        /// The name.
        name: String,
    },
    /// It contains itself, or nearly so.
    #[error("`{0}` nests deeper than {DEEPEST}, or contains itself")]
    Deep(String),
    /// More than anybody shares.
    #[error("`{0}` is too large; at most {MOST_BYTES} bytes and {MOST_FIELDS} fields are shared")]
    Large(String),
    /// A text of this many bytes.
    #[error("the definition has {0} bytes; at most {MOST_TEXT} are read")]
    Long(usize),
}

/// The type that a definition describes: what [`definition`](super::definition()) was given, but for its docs' white space, if
/// that was laid out as C does and has no padding beyond. `name` becomes the type's; those it is made of are `package/msg/Type`.
///
/// Constants and defaults are passed over; `byte` and `char` are `uint8`. A structure named without package is of the package of
/// the definition it stands in.
///
/// # Errors
/// [`ReadError`], with the line; whatever the text, it ends after time in proportion to its length.
pub fn read(name: &str, text: &str) -> Result<Type, ReadError> {
    if text.len() > MOST_TEXT {
        return Err(ReadError::Long(text.len()));
    }
    let sections = sections(name, text)?;
    let root = short(name);
    let mut reader = Reader {
        sections: &sections,
        made: BTreeMap::new(),
    };
    let made = reader.structure(&root, 0)?;
    Ok(Type {
        name: name.to_owned(),
        ..(*made.value_type).clone()
    })
}

/// A finished type, what it nests and how many fields it has with those of its parts.
#[derive(Clone)]
struct Made {
    value_type: Arc<Type>,
    height: usize,
    fields: usize,
}

struct Reader<'a> {
    sections: &'a BTreeMap<String, Section<'a>>,
    made: BTreeMap<String, Made>,
}

impl Reader<'_> {
    fn structure(&mut self, title: &str, depth: usize) -> Result<Made, ReadError> {
        if let Some(made) = self.made.get(title) {
            return Ok(made.clone());
        }
        if depth > DEEPEST {
            return Err(ReadError::Deep(title.to_owned()));
        }
        let sections = self.sections;
        let section = &sections[title];
        let mut layout = Layout::default();
        let mut names = BTreeSet::new();
        let (mut height, mut count) = (0, 0_usize);
        for line in &section.fields {
            if !names.insert(line.name) {
                return Err(ReadError::Twice {
                    line: line.number,
                    name: line.name.to_owned(),
                });
            }
            let (element, shape) = shape(line)?;
            let kind = match scalar(element) {
                Some(scalar) => FieldKind::Scalar(scalar),
                None => {
                    let inner = self.inner(section, line, element, depth)?;
                    height = height.max(inner.height + 1);
                    count = count.saturating_add(inner.fields);
                    FieldKind::Struct(inner.value_type)
                }
            };
            count = count.saturating_add(1);
            layout
                .push(line, kind, shape)
                .ok_or_else(|| ReadError::Large(title.to_owned()))?;
        }
        if height > DEEPEST {
            return Err(ReadError::Deep(title.to_owned()));
        }
        if count > MOST_FIELDS {
            return Err(ReadError::Large(title.to_owned()));
        }
        let (package, name) = parts(title);
        let made = Made {
            value_type: Arc::new(layout.finish(format!("{package}/msg/{name}"), section.doc.clone())),
            height,
            fields: count,
        };
        self.made.insert(title.to_owned(), made.clone());
        Ok(made)
    }

    /// The structure that a field is made of.
    fn inner(
        &mut self,
        section: &Section<'_>,
        line: &Line<'_>,
        element: &str,
        depth: usize,
    ) -> Result<Made, ReadError> {
        let title = if element.contains('/') {
            short(element)
        } else {
            format!("{}/{element}", section.package)
        };
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
