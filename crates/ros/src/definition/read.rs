//! From a definition to the type it describes, laid out as schemas lay their values out: in the order of the fields, each at
//! the next multiple of its alignment, as C does. What has no bound is refused, because a shared value has a fixed size.
//!
//! The text may come from anybody: what is read is bounded in length, depth, bytes and number of fields.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::parts;

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

/// One definition of the text.
#[derive(Default)]
struct Section<'a> {
    package: String,
    doc: String,
    fields: Vec<Line<'a>>,
}

/// A field as its line says it.
struct Line<'a> {
    number: usize,
    kind: &'a str,
    name: &'a str,
    doc: String,
    unit: String,
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

fn sections<'a>(name: &str, text: &'a str) -> Result<BTreeMap<String, Section<'a>>, ReadError> {
    let mut sections = BTreeMap::new();
    let mut title = short(name);
    let mut section = Section::of(name);
    let mut comments = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        let line = line.trim();
        if line.len() < 3 || line.bytes().any(|byte| byte != b'=') {
            section.line(index + 1, line, &mut comments)?;
            continue;
        }
        comments.clear();
        sections.insert(title, section);
        let (number, next) = lines.next().unwrap_or((index, line));
        let Some(next_name) = next.trim().strip_prefix("MSG:").map(str::trim) else {
            return Err(ReadError::Line {
                line: number + 1,
                text: next.to_owned(),
            });
        };
        title = short(next_name);
        section = Section::of(next_name);
        if sections.contains_key(&title) {
            return Err(ReadError::Twice {
                line: number + 1,
                name: title,
            });
        }
    }
    sections.insert(title, section);
    Ok(sections)
}

impl<'a> Section<'a> {
    fn of(name: &str) -> Self {
        Self {
            package: parts(name).0,
            ..Self::default()
        }
    }

    /// Takes one line; `comments` are those since the last field or empty line.
    fn line(&mut self, number: usize, line: &'a str, comments: &mut Vec<&'a str>) -> Result<(), ReadError> {
        if line.is_empty() {
            if self.fields.is_empty() && self.doc.is_empty() {
                self.doc = comments.join("\n");
            }
            comments.clear();
            return Ok(());
        }
        if let Some(comment) = line.strip_prefix('#') {
            comments.push(comment.trim());
            return Ok(());
        }
        let wrong = || ReadError::Line {
            line: number,
            text: line.to_owned(),
        };
        let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(wrong)?;
        let rest = rest.trim_start();
        let end = rest
            .find(|letter: char| letter.is_whitespace() || "=#".contains(letter))
            .unwrap_or(rest.len());
        let (name, rest) = rest.split_at(end);
        let rest = rest.trim_start();
        if rest.starts_with('=') {
            comments.clear();
            return Ok(());
        }
        let legal = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
        if name.is_empty() || name.len() > 64 || !name.chars().all(legal) {
            return Err(wrong());
        }
        if let Some(comment) = rest.strip_prefix('#')
            && comments.is_empty()
        {
            comments.push(comment.trim());
        }
        let unit = comments.last_mut().map_or("", take_unit);
        if comments.last() == Some(&"") {
            comments.pop();
        }
        self.fields.push(Line {
            number,
            kind,
            name,
            doc: comments.join("\n"),
            unit: unit.to_owned(),
        });
        comments.clear();
        Ok(())
    }
}

/// Takes the unit in brackets off the end of a comment.
fn take_unit<'a>(comment: &mut &'a str) -> &'a str {
    let Some((before, unit)) = comment.strip_suffix(']').and_then(|inner| inner.rsplit_once('[')) else {
        return "";
    };
    if unit.is_empty() || unit.contains(char::is_whitespace) || !(before.is_empty() || before.ends_with(' '))
    {
        return "";
    }
    *comment = before.trim_end();
    unit
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

/// How many elements, before they have a place.
enum Shape {
    One,
    Array(usize),
    Sequence(usize),
    Text(usize),
}

/// What a field is made of, and how many.
fn shape<'a>(line: &Line<'a>) -> Result<(&'a str, Shape), ReadError> {
    let refused = |why| ReadError::Kind {
        line: line.number,
        kind: line.kind.to_owned(),
        why,
    };
    let number = |text: &str| {
        text.parse::<u32>()
            .ok()
            .filter(|number| *number > 0)
            .map(|number| number as usize)
            .ok_or_else(|| refused("its number of elements is 1 to 4294967295"))
    };
    let (element, bracket) = match line.kind.split_once('[') {
        Some((element, rest)) => (
            element,
            Some(
                rest.strip_suffix(']')
                    .ok_or_else(|| refused("a `]` is missing"))?,
            ),
        ),
        None => (line.kind, None),
    };
    let text = match element.split_once("<=") {
        Some(("string", most)) => Some(Some(most)),
        None if element == "string" => Some(None),
        Some(_) | None => None,
    };
    match (text, bracket) {
        (Some(_), Some(_)) => Err(refused("give each text a field of its own")),
        (Some(None), None) => Err(refused("give it a bound, as in `string<=64`")),
        (Some(Some(most)), None) => Ok(("uint8", Shape::Text(number(most)?))),
        (None, Some("")) => Err(refused("give it a bound, as in `float32[<=64]`")),
        (None, Some(count)) => Ok((
            element,
            match count.strip_prefix("<=") {
                Some(most) => Shape::Sequence(number(most)?),
                None => Shape::Array(number(count)?),
            },
        )),
        (None, None) if element.starts_with("wstring") => Err(refused("texts are UTF-8: `string<=64`")),
        (None, None) => Ok((element, Shape::One)),
    }
}

fn scalar(element: &str) -> Option<Scalar> {
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

/// Fields that have their places.
struct Layout {
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
    /// None if that is more than a value may have.
    fn push(&mut self, line: &Line<'_>, kind: FieldKind, shape: Shape) -> Option<()> {
        // A sequence begins with its number and a spare word, a text with its number of bytes.
        let (head, align, capacity) = match shape {
            Shape::One => (0, kind.align(), 1),
            Shape::Array(count) => (0, kind.align(), count),
            Shape::Sequence(capacity) => (8, kind.align().max(4), capacity),
            Shape::Text(capacity) => (4, kind.align().max(4), capacity),
        };
        let start = self.end.next_multiple_of(align);
        let form = match shape {
            Shape::One => Form::One,
            Shape::Array(count) => Form::Array(count),
            Shape::Sequence(capacity) => Form::Sequence {
                capacity,
                length_offset: start,
            },
            Shape::Text(capacity) => Form::Text {
                capacity,
                length_offset: start,
            },
        };
        let length = kind.bytes().checked_mul(capacity)?;
        let end = (start + head).checked_add(length)?;
        if end > MOST_BYTES {
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
        });
        Some(())
    }

    fn finish(self, name: String, doc: String) -> Type {
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

fn short(name: &str) -> String {
    let (package, name) = parts(name);
    format!("{package}/{name}")
}

#[cfg(test)]
mod tests;
