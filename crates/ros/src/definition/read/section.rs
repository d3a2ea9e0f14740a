//! The text of a definition, line by line: comments, fields and skipped lines. It refuses to know types.

use std::collections::BTreeMap;

use super::super::parts;
use super::{ReadError, short};

/// One definition of the text.
#[derive(Default)]
pub(super) struct Section<'a> {
    pub(super) package: String,
    pub(super) doc: String,
    pub(super) fields: Vec<Line<'a>>,
}

/// A field as its line states it.
pub(super) struct Line<'a> {
    pub(super) number: usize,
    pub(super) kind: &'a str,
    pub(super) name: &'a str,
    pub(super) doc: String,
    pub(super) unit: String,
}

pub(super) fn sections<'a>(name: &str, text: &'a str) -> Result<BTreeMap<String, Section<'a>>, ReadError> {
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
            return Err(ReadError::Duplicate {
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

    /// Returns the title of the definition of a structure that one of the fields names.
    pub(super) fn title(&self, element: &str) -> String {
        if element.contains('/') {
            short(element)
        } else {
            format!("{}/{element}", self.package)
        }
    }

    /// Processes one line. `comments` are those since the last field or empty line.
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
        let error = || ReadError::Line {
            line: number,
            text: line.to_owned(),
        };
        let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(error)?;
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
            return Err(error());
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

/// Removes the unit in brackets from the end of a comment and returns it.
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
