//! Faults of a file: what is wrong, where, and how to correct it. Formats text; prints nothing.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use jde_board::nearest;

use super::report::{quote, quote_all};

/// The most names that are listed if none is similar.
pub const MAX_LISTED: usize = 12;

/// The most faults in one text; the others are counted.
pub(super) const MAX_SHOWN: usize = 40;

/// One fault.
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
    },
    /// An option, as it was given.
    Option(String),
}

/// The faults of a file and its options: those of the file in its order, then those of the options. Never
/// empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faults {
    list: Vec<Fault>,
    /// Faults that were found and are not in the list.
    omitted: usize,
}

impl Faults {
    /// Sorts the faults.
    pub(super) fn new(mut list: Vec<Fault>, more: usize) -> Self {
        list.sort_by_key(|fault| match &fault.location {
            FaultLocation::File(_) => (0, 0),
            FaultLocation::Text { span, .. } => (1, span.start),
            FaultLocation::Option(_) => (2, 0),
        });
        Self { list, omitted: more }
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
}

impl Fault {
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
            FaultLocation::Text { line, .. } => Some(*line),
            FaultLocation::File(_) | FaultLocation::Option(_) => None,
        }
    }

    /// Adds how to correct it.
    pub fn advise(&mut self, help: impl Into<String>) -> &mut Self {
        self.help = Some(help.into());
        self
    }

    /// Adds how to correct it, which takes a search.
    pub fn suggest_by(&mut self, help: impl FnOnce() -> Option<String>) {
        if self.suggests {
            self.help = help();
        }
    }

    /// Suggests the most similar known name; if there is none and the names are few, all of them.
    pub fn suggest<'n>(&mut self, name: &str, what: &str, known: impl IntoIterator<Item = &'n str>) {
        if !self.suggests {
            return;
        }
        let known: Vec<_> = known.into_iter().collect();
        if let Some(near) = nearest(name, known.iter().copied()) {
            self.advise(format!("did you mean {}?", quote(near)));
        } else if (1..=MAX_LISTED).contains(&known.len()) {
            self.advise(format!("{what}: {}", quote_all(known)));
        }
    }
}

impl fmt::Display for FaultLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Text {
                file, line, column, ..
            } => write!(f, "{}:{line}:{column}", file.display()),
            Self::Option(option) => f.write_str(option),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.message)?;
        if let Some(help) = &self.help {
            write!(f, "\n    help: {help}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.list.iter().take(MAX_SHOWN).enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{fault}")?;
        }
        match self.count().saturating_sub(MAX_SHOWN) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for Faults {}
