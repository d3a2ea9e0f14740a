//! Collects the faults of one file and of the options given with it, and finds their positions in the text.
//! Judges nothing.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::fault::{Excerpt, Fault, FaultLocation, Faults, MAX_FAULTS, MAX_SHOWN};

/// The longest piece of a file that is repeated in a message, in characters.
const MAX_QUOTE_LENGTH: usize = 60;

/// The text under examination and its faults.
pub struct FaultReport<'a> {
    file: &'a Path,
    text: &'a str,
    lines: Vec<usize>,
    option: Option<String>,
    faults: Vec<Fault>,
    /// Findings that do not prevent the use of the file.
    concerns: Vec<Fault>,
    /// Those of files that this one names.
    others: Vec<Fault>,
    /// The last fault that was only counted.
    last_counted: Option<Fault>,
    omitted: usize,
}

impl<'a> FaultReport<'a> {
    /// Begins the examination of a text; `file` names it in messages.
    #[must_use]
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self {
            file,
            text,
            lines: std::iter::once(0).chain(breaks.map(|(at, _)| at + 1)).collect(),
            option: None,
            faults: Vec::new(),
            concerns: Vec::new(),
            others: Vec::new(),
            last_counted: None,
            omitted: 0,
        }
    }

    /// Returns the file that is named in messages.
    #[must_use]
    pub fn file(&self) -> &'a Path {
        self.file
    }

    /// Adds a fault at a position in the text, or at the option under examination.
    pub fn fault(&mut self, span: &Range<usize>, message: impl Into<String>) -> &mut Fault {
        let place = match self.faults.len() {
            MAX_FAULTS => FaultLocation::File(PathBuf::new()),
            _ => self.location(span),
        };
        self.push(place, message.into())
    }

    /// Adds the faults of a file that this one names.
    pub fn include(&mut self, faults: Faults) {
        let (list, omitted) = faults.into_parts();
        self.others.extend(list);
        self.omitted += omitted;
    }

    /// Adds a fault of the file as a whole.
    pub fn file_fault(&mut self, message: impl Into<String>) -> &mut Fault {
        self.push(FaultLocation::File(PathBuf::from(self.file)), message.into())
    }

    /// Runs `work` on behalf of an option: spans have no meaning then, and faults refer to the option.
    pub fn in_option<T>(&mut self, option: String, work: impl FnOnce(&mut Self) -> T) -> T {
        self.option = Some(option);
        let done = work(self);
        self.option = None;
        done
    }

    /// Converts a range of characters, in which readers of YAML state positions, to bytes; any range once faults are only
    /// counted.
    #[must_use]
    pub fn in_bytes(&self, characters: &Range<usize>) -> Range<usize> {
        if self.faults.len() == MAX_FAULTS {
            return 0..0;
        }
        let at = |count| {
            self.text
                .char_indices()
                .nth(count)
                .map_or(self.text.len(), |(at, _)| at)
        };
        at(characters.start)..at(characters.end)
    }

    /// Returns the line of a position, from 1.
    #[must_use]
    pub fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at)
    }

    /// Adds a finding that does not prevent the use of the file, at a position in the text or at the option under
    /// examination.
    pub fn concern(&mut self, span: &Range<usize>, message: impl Into<String>) {
        let concern = Fault::new(self.location(span), message.into());
        if self.concerns.len() < MAX_FAULTS && !self.concerns.contains(&concern) {
            self.concerns.push(concern);
        }
    }

    /// Returns the findings so far that do not prevent the use of the file.
    #[must_use]
    pub fn concerns(&self) -> &[Fault] {
        &self.concerns
    }

    /// Returns the number of faults so far.
    #[must_use]
    pub fn count(&self) -> usize {
        self.faults.len() + self.others.len() + self.omitted
    }

    /// Returns the findings that do not prevent the use of the file.
    ///
    /// # Errors
    /// All faults, if there are any.
    pub fn finish(self) -> Result<Option<Faults>, Faults> {
        if self.count() == 0 {
            let any = !self.concerns.is_empty();
            return Ok(any.then(|| Faults::new(self.concerns, Vec::new(), 0)));
        }
        Err(self.into_faults())
    }

    /// Returns all faults, together with the findings that do not prevent the use of the file. There must be a fault.
    #[must_use]
    pub fn into_faults(mut self) -> Faults {
        debug_assert!(self.count() > 0, "there is no fault");
        self.faults.append(&mut self.concerns);
        Faults::new(self.faults, self.others, self.omitted)
    }

    /// Returns the position in the text, or the option under examination.
    fn location(&self, span: &Range<usize>) -> FaultLocation {
        match &self.option {
            Some(option) => FaultLocation::Option(option.clone()),
            None => self.text_location(span),
        }
    }

    fn text_location(&self, span: &Range<usize>) -> FaultLocation {
        let line = self.line(span.start);
        let start = self.lines[line - 1];
        let before = self.text.get(start..span.start).unwrap_or_default();
        FaultLocation::Text {
            file: PathBuf::from(self.file),
            line,
            column: before.chars().count() + 1,
            span: span.clone(),
            excerpt: Box::new(Excerpt::new(self.text, start, span)),
        }
    }

    fn push(&mut self, place: FaultLocation, message: String) -> &mut Fault {
        let fault = Fault {
            suggests: self.faults.len() < MAX_SHOWN,
            ..Fault::new(place, message)
        };
        if self.faults.len() == MAX_FAULTS {
            self.omitted += 1;
            return self.last_counted.insert(fault);
        }
        self.faults.push_mut(fault)
    }
}

/// Quotes a piece of the file for messages: in backquotes, on one line, shortened if necessary.
#[must_use]
pub fn quote(text: &str) -> String {
    let mut shown: String = text
        .chars()
        .take(MAX_QUOTE_LENGTH)
        .flat_map(char::escape_debug)
        .collect();
    if text.chars().nth(MAX_QUOTE_LENGTH).is_some() {
        shown.push_str("...");
    }
    format!("`{shown}`")
}

/// Quotes several: "`a`, `b` and `c`".
#[must_use]
pub fn quote_all<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    let names: Vec<_> = names.into_iter().map(quote).collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
