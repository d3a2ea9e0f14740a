//! Faults of files: what is wrong, where, and how to correct it. Formats text; prints nothing.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use jde_nearest::nearest;

use super::report::{quote, quote_all};

/// The most names that are listed if none is similar.
pub const MAX_LISTED: usize = 20;

/// The most faults in one text; the others are counted.
pub(super) const MAX_SHOWN: usize = 40;

/// The most faults that are kept with a message and a position, which may take long to compute. Further
/// ones are only counted, because users correct few at once.
pub(super) const MAX_FAULTS: usize = 200;

/// One fault, or one doubtful statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Its place.
    pub location: FaultLocation,
    /// What is wrong, and what was expected.
    pub message: String,
    /// How to correct it.
    pub help: Option<String>,
    /// Whether similar names are searched for, which takes long in long lists.
    pub(super) suggests: bool,
}

/// The place of a fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaultLocation {
    /// The file as a whole.
    File(PathBuf),
    /// A line of a file that another program wrote.
    Line {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
    },
    /// A position in the file.
    Text {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, in characters from 1.
        column: usize,
        /// Bytes from the start of the file.
        span: Range<usize>,
        /// The line as it was read.
        excerpt: Box<Excerpt>,
    },
    /// An option, as it was given.
    Option(String),
}

/// A line of a file, or the part of a long one around a fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// The text, without its end.
    pub text: String,
    /// The faulty part of it, in bytes.
    pub marked: Range<usize>,
}

/// The faults of a file, of the files that it names and of its options, in this order, and those of one file in its
/// order. Never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faults {
    list: Vec<Fault>,
    /// Faults that were found and are not in the list.
    omitted: usize,
}

impl Faults {
    /// Sorts the faults of one file and its options. Those of `others`, files that it names, follow its own.
    pub(super) fn new(mut list: Vec<Fault>, others: Vec<Fault>, omitted: usize) -> Self {
        list.sort_by_key(|fault| match &fault.location {
            FaultLocation::File(_) => (0, 0),
            FaultLocation::Line { line, .. } => (1, *line),
            FaultLocation::Text { span, .. } => (1, span.start),
            FaultLocation::Option(_) => (2, 0),
        });
        let options = list.partition_point(|fault| !matches!(fault.location, FaultLocation::Option(_)));
        list.splice(options..options, others);
        Self { list, omitted }
    }

    /// Returns the faults, in order; if there are very many, the first ones found.
    #[must_use]
    pub fn list(&self) -> &[Fault] {
        &self.list
    }

    /// Returns the number of all faults.
    #[must_use]
    pub fn count(&self) -> usize {
        self.list.len() + self.omitted
    }

    pub(super) fn into_parts(self) -> (Vec<Fault>, usize) {
        (self.list, self.omitted)
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Self::from(vec![fault])
    }
}

impl From<Vec<Fault>> for Faults {
    /// Keeps the order. There must be a fault.
    fn from(mut list: Vec<Fault>) -> Self {
        debug_assert!(!list.is_empty(), "there is no fault");
        let omitted = list.len().saturating_sub(MAX_FAULTS);
        list.truncate(MAX_FAULTS);
        Self { list, omitted }
    }
}

impl Fault {
    /// Creates a fault of a file as a whole.
    #[must_use]
    pub fn of_file(file: &Path, message: impl Into<String>) -> Self {
        Self::new(FaultLocation::File(file.to_owned()), message.into())
    }

    /// Creates a fault in a line of a file that another program wrote.
    #[must_use]
    pub fn at_line(file: &Path, line: usize, message: impl Into<String>) -> Self {
        let file = file.to_owned();
        Self::new(FaultLocation::Line { file, line }, message.into())
    }

    pub(super) fn new(place: FaultLocation, message: String) -> Self {
        Self {
            location: place,
            message,
            help: None,
            suggests: true,
        }
    }

    /// Returns the line, from 1; `None` for a whole file or an option.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        match &self.location {
            FaultLocation::Line { line, .. } | FaultLocation::Text { line, .. } => Some(*line),
            FaultLocation::File(_) | FaultLocation::Option(_) => None,
        }
    }

    /// Adds how to correct it.
    pub fn advise(&mut self, help: impl Into<String>) -> &mut Self {
        self.help = Some(help.into());
        self
    }

    /// Adds how to correct it, which takes a search. If nothing is found, earlier advice stays.
    pub fn suggest_by(&mut self, help: impl FnOnce() -> Option<String>) {
        if self.suggests
            && let Some(help) = help()
        {
            self.help = Some(help);
        }
    }

    /// Suggests the most similar known name; if there is none and the names are few, all of them.
    pub fn suggest<'n>(&mut self, name: &str, what: &str, known: impl IntoIterator<Item = &'n str>) {
        self.suggest_by(|| suggestion(name, what, known));
    }
}

/// Returns the advice about an unknown name: the most similar known one; if there is none and the names are few, all of
/// them.
pub(super) fn suggestion<'n>(
    name: &str,
    what: &str,
    known: impl IntoIterator<Item = &'n str>,
) -> Option<String> {
    let known: Vec<_> = known.into_iter().collect();
    match nearest(name, known.iter().copied()) {
        Some(near) => Some(format!("did you mean {}?", quote(near))),
        None if (1..=MAX_LISTED).contains(&known.len()) => Some(format!("{what}: {}", quote_all(known))),
        None => None,
    }
}

impl FaultLocation {
    /// Returns the file; `None` for an option.
    #[must_use]
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::File(file) | Self::Line { file, .. } | Self::Text { file, .. } => Some(file),
            Self::Option(_) => None,
        }
    }
}

impl fmt::Display for FaultLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Line { file, line } => write!(f, "{}:{line}", file.display()),
            Self::Text {
                file, line, column, ..
            } => write!(f, "{}:{line}:{column}", file.display()),
            Self::Option(option) => f.write_str(option),
        }
    }
}

impl fmt::Display for Fault {
    /// Writes the place, the message and the help; with `#` also the line of the file with the faulty part marked.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.message)?;
        if let FaultLocation::Text { line, excerpt, .. } = &self.location
            && f.alternate()
        {
            write!(
                f,
                "\n{line:5} | {}\n      | {}",
                excerpt.plain(),
                excerpt.carets()
            )?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n    help: {help}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Faults {
    /// Writes the first faults, and how many more there are; `#` as for one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.list.iter().take(MAX_SHOWN).enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            fault.fmt(f)?;
        }
        match self.count().saturating_sub(MAX_SHOWN) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for Faults {}

impl Excerpt {
    /// The most bytes before the faulty part, and of the text from its start on: a line that a person writes is whole.
    const MAX_LENGTH: (usize, usize) = (1000, 200);

    /// Cuts a line out of a text that begins at byte `start` of it.
    pub(super) fn new(text: &str, start: usize, span: &Range<usize>) -> Self {
        let at = text.floor_char_boundary(span.start.min(text.len()));
        let start = text.floor_char_boundary(start.max(at.saturating_sub(Self::MAX_LENGTH.0)));
        let end = text.floor_char_boundary(text.len().min(at + Self::MAX_LENGTH.1));
        let line = text[start..end].lines().next().unwrap_or_default();
        // A fault may be between `\r` and `\n`, which the line does not have.
        let last = start + line.len();
        let marked = at.min(last) - start..text.floor_char_boundary(span.end.max(at).min(last)) - start;
        Self {
            text: line.to_owned(),
            marked,
        }
    }

    /// Returns the text with each character as wide as another.
    fn plain(&self) -> String {
        self.text.replace(char::is_control, " ")
    }

    /// Returns the mark under the faulty part.
    fn carets(&self) -> String {
        let width = |part: &str| part.chars().count();
        let Range { start, end } = self.marked;
        let count = width(&self.text[start..end]).max(1);
        " ".repeat(width(&self.text[..start])) + &"^".repeat(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str, start: usize, span: Range<usize>) -> String {
        let excerpt = Excerpt::new(text, start, &span);
        format!("{}|{}", excerpt.plain(), excerpt.carets())
    }

    #[test]
    fn the_faulty_part_of_a_line_is_marked() {
        assert_eq!(shown("one = 1\ntwo = é\n", 8, 14..16), "two = é|      ^");
        assert_eq!(shown("one = 1\r\n", 0, 0..3), "one = 1|^^^");
        assert_eq!(shown("one\ntwo", 0, 0..7), "one|^^^");
        assert_eq!(shown("a\tb", 0, 2..3), "a b|  ^");
        assert_eq!(shown("", 0, 0..0), "|^");
        assert_eq!(shown("one\n", 4, 4..5), "|^");
        assert_eq!(shown("a = \"b\r\nc", 0, 7..8), "a = \"b|      ^");
    }

    #[test]
    fn of_a_long_line_the_part_around_the_fault_is_kept() {
        let text = "é".repeat(1 << 20);
        let excerpt = Excerpt::new(&text, 0, &(3001..3003));
        assert_eq!(excerpt.text.len(), 1200);
        assert_eq!(excerpt.marked, 1000..1002);
    }

    #[test]
    fn the_long_form_has_the_line() {
        let location = FaultLocation::Text {
            file: "app.toml".into(),
            line: 7,
            column: 3,
            span: 2..5,
            excerpt: Box::new(Excerpt::new("a bcd", 0, &(2..5))),
        };
        let mut fault = Fault::new(location, "this is wrong".to_owned());
        fault.advise("correct it");
        assert_eq!(
            fault.to_string(),
            "app.toml:7:3: this is wrong\n    help: correct it"
        );
        assert_eq!(
            format!("{fault:#}"),
            "app.toml:7:3: this is wrong\n    7 | a bcd\n      |   ^^^\n    help: correct it"
        );
    }
}
