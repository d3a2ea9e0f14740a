//! The text of a definition, line by line: comments, fields and skipped lines. It refuses to know types.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use jde_abi::describe::Scalar;
use jde_abi::unit;

use super::super::{lines, parts};
use super::{ReadError, scalar, short};

/// One definition of the text.
#[derive(Default)]
pub(super) struct Section<'a> {
    pub(super) package: String,
    /// The number of lines before it, 0 for that of the root.
    pub(super) before: usize,
    pub(super) doc: String,
    pub(super) fields: Vec<FieldLine<'a>>,
}

/// A field as its line states it.
pub(super) struct FieldLine<'a> {
    /// Its number within the definition, from 1.
    pub(super) number: usize,
    pub(super) kind: &'a str,
    pub(super) name: &'a str,
    pub(super) doc: String,
    pub(super) unit: String,
}

/// Whose comments a definition has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comments {
    /// Those of a type of jde, which end with the unit.
    Own,
    /// Those of a person, who may put anything into brackets.
    Foreign,
}

pub(super) fn sections<'a>(
    name: &str,
    text: &'a str,
    whose: Comments,
) -> Result<BTreeMap<String, Section<'a>>, ReadError> {
    let mut sections = BTreeMap::new();
    let mut title = short(name);
    let mut section = Section::of(name);
    // The number of lines before it.
    let mut before = 0;
    let mut comments = Vec::new();
    let mut lines = lines(text).enumerate();
    while let Some((index, line)) = lines.next() {
        let line = line.trim();
        if line.len() < 3 || line.bytes().any(|byte| byte != b'=') {
            let read = section.line(index + 1 - before, line, &mut comments, whose);
            read.map_err(|error| error.inside(&title, before))?;
            continue;
        }
        comments.clear();
        insert(&mut sections, title, section)?;
        let (number, next) = lines.next().unwrap_or((index, line));
        let Some(next_name) = next.trim().strip_prefix("MSG:").map(str::trim) else {
            return Err(ReadError::line(number + 1, next));
        };
        title = short(next_name);
        section = Section::of(next_name);
        section.before = number + 1;
        before = section.before;
    }
    insert(&mut sections, title, section)?;
    Ok(sections)
}

/// Adds a definition. Recorders list a message again for each message that contains it: what says the same is one.
fn insert<'a>(
    sections: &mut BTreeMap<String, Section<'a>>,
    title: String,
    section: Section<'a>,
) -> Result<(), ReadError> {
    match sections.entry(title) {
        Entry::Vacant(place) => {
            place.insert(section);
        }
        Entry::Occupied(first) if first.get().is_like(&section) => {}
        Entry::Occupied(first) => {
            return Err(ReadError::Duplicate {
                line: section.before,
                name: first.key().clone(),
            });
        }
    }
    Ok(())
}

impl<'a> Section<'a> {
    fn of(name: &str) -> Self {
        Self {
            package: parts(name).0,
            ..Self::default()
        }
    }

    /// Returns whether the messages of both have the same fields, whatever the comments say.
    fn is_like(&self, other: &Self) -> bool {
        let fields = |section: &Self| {
            section
                .fields
                .iter()
                .map(|line| (line.kind, line.name))
                .collect::<Vec<_>>()
        };
        fields(self) == fields(other)
    }

    /// Returns the title of the definition of a structure that one of the fields names.
    pub(super) fn title(&self, element: &str) -> String {
        if element.contains('/') {
            short(element)
        } else {
            format!("{}/{element}", self.package)
        }
    }

    /// Processes one line. `comments` are those since the last field or empty line.
    fn line(
        &mut self,
        number: usize,
        line: &'a str,
        comments: &mut Vec<&'a str>,
        whose: Comments,
    ) -> Result<(), ReadError> {
        if line.is_empty() {
            if self.fields.is_empty() && self.doc.is_empty() {
                self.doc = comments.join("\n");
            }
            comments.clear();
            return Ok(());
        }
        // As in ROS 2, `#` begins a comment even within a text.
        let (code, comment) = match line.split_once('#') {
            Some((code, comment)) => (code.trim_end(), Some(comment.trim())),
            None => (line, None),
        };
        if code.is_empty() {
            comments.extend(comment);
            return Ok(());
        }
        let error = || ReadError::line(number, line);
        let (kind, rest) = code.split_once(char::is_whitespace).ok_or_else(error)?;
        let rest = rest.trim_start();
        let end = rest
            .find(|letter: char| letter.is_whitespace() || letter == '=')
            .unwrap_or(rest.len());
        let (name, rest) = rest.split_at(end);
        if rest.trim_start().starts_with('=') {
            comments.clear();
            return Ok(());
        }
        let legal = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
        if name.is_empty() || !name.chars().all(legal) {
            return Err(error());
        }
        if name.len() > MAX_NAME {
            return Err(ReadError::Name {
                line: number,
                length: name.len(),
            });
        }
        if comments.is_empty() {
            comments.extend(comment);
        }
        let unit = comments
            .last_mut()
            .map_or("", |comment| take_unit(comment, kind, whose));
        if comments.last() == Some(&"") {
            comments.pop();
        }
        self.fields.push(FieldLine {
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

/// The longest name of a field, bytes.
const MAX_NAME: usize = 64;

/// Removes the unit in brackets from the end of a comment on a field of a type, and returns it. What is no unit that jde
/// knows stays a part of the comment.
fn take_unit<'a>(comment: &mut &'a str, kind: &str, whose: Comments) -> &'a str {
    let Some((before, stated)) = comment.strip_suffix(']').and_then(|inner| inner.rsplit_once('[')) else {
        return "";
    };
    let is_of_number = || {
        let element = kind.split('[').next().and_then(scalar);
        // `[1]` is a reference.
        element.is_some_and(|scalar| scalar != Scalar::Bool) && stated != "1"
    };
    if stated.is_empty()
        || !(before.is_empty() || before.ends_with(' '))
        || unit::check(stated).is_err()
        || whose == Comments::Foreign && !is_of_number()
    {
        return "";
    }
    *comment = before.trim_end();
    stated
}
