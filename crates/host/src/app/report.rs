//! Collects the faults of one file and of the options given with it, and knows where in the text each is.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::fault::{Fault, Faults, Place};

/// Most faults that are kept, each with what was meant and where it is, which may take long to find out: nobody mends more at once. The
/// others are counted.
const MOST: usize = 200;
/// Longest piece of a file that is repeated in a message, in characters.
const LONGEST_QUOTE: usize = 60;

/// The text under examination and what has been found wrong with it.
pub(super) struct Report<'a> {
    file: &'a Path,
    text: &'a str,
    lines: Vec<usize>,
    option: Option<String>,
    faults: Vec<Fault>,
    /// What is no reason not to start.
    concerns: Vec<Fault>,
    /// The last that was only counted.
    spare: Option<Fault>,
    more: usize,
}

impl<'a> Report<'a> {
    pub(super) fn new(file: &'a Path, text: &'a str) -> Self {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self {
            file,
            text,
            lines: std::iter::once(0).chain(breaks.map(|(at, _)| at + 1)).collect(),
            option: None,
            faults: Vec::new(),
            concerns: Vec::new(),
            spare: None,
            more: 0,
        }
    }

    /// Adds a fault at a piece of the text, or at the option under examination.
    pub(super) fn fault(&mut self, span: &Range<usize>, message: impl Into<String>) -> &mut Fault {
        let place = match self.faults.len() {
            MOST => Place::File(PathBuf::new()),
            _ => self.here(span),
        };
        self.push(place, message.into())
    }

    /// Adds a fault of the file as a whole.
    pub(super) fn whole(&mut self, message: impl Into<String>) -> &mut Fault {
        self.push(Place::File(PathBuf::from(self.file)), message.into())
    }

    /// Does something on behalf of an option: spans mean nothing then, and faults point to the option.
    pub(super) fn in_option<T>(&mut self, option: String, work: impl FnOnce(&mut Self) -> T) -> T {
        self.option = Some(option);
        let done = work(self);
        self.option = None;
        done
    }

    /// The line of a place, from 1.
    pub(super) fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at)
    }

    /// Adds what is no reason not to start, at a piece of the text or at the option under examination.
    pub(super) fn concern(&mut self, span: &Range<usize>, message: impl Into<String>) {
        if self.concerns.len() < MOST {
            let place = self.here(span);
            self.concerns.push(Fault::new(place, message.into()));
        }
    }

    /// How many faults were found.
    pub(super) fn count(&self) -> usize {
        self.faults.len() + self.more
    }

    /// What is no reason not to start, if that is all there is.
    pub(super) fn finish(self) -> Result<Option<Faults>, Faults> {
        if self.faults.is_empty() {
            let any = !self.concerns.is_empty();
            return Ok(any.then(|| Faults::new(self.concerns, 0)));
        }
        Err(self.into_faults())
    }

    /// What was found wrong, which is something, with the rest.
    pub(super) fn into_faults(mut self) -> Faults {
        debug_assert!(
            !self.faults.is_empty(),
            "faults are asked for where there are none"
        );
        self.faults.append(&mut self.concerns);
        Faults::new(self.faults, self.more)
    }

    /// A piece of the text, or the option under examination.
    fn here(&self, span: &Range<usize>) -> Place {
        match &self.option {
            Some(option) => Place::Option(option.clone()),
            None => self.place(span),
        }
    }

    fn place(&self, span: &Range<usize>) -> Place {
        let line = self.line(span.start);
        let before = self
            .text
            .get(self.lines[line - 1]..span.start)
            .unwrap_or_default();
        Place::Text {
            file: PathBuf::from(self.file),
            line,
            column: before.chars().count() + 1,
            span: span.clone(),
        }
    }

    fn push(&mut self, place: Place, message: String) -> &mut Fault {
        let counted = self.faults.len() == MOST;
        let fault = Fault {
            counted,
            ..Fault::new(place, message)
        };
        if counted {
            self.more += 1;
            return self.spare.insert(fault);
        }
        self.faults.push_mut(fault)
    }
}

/// A piece of the file as messages show it: between back-quotes, on one line, not too long.
pub(super) fn quote(text: &str) -> String {
    let mut shown: String = text
        .chars()
        .take(LONGEST_QUOTE)
        .flat_map(char::escape_debug)
        .collect();
    if text.chars().nth(LONGEST_QUOTE).is_some() {
        shown.push_str("...");
    }
    format!("`{shown}`")
}

/// Several of them: "`a`, `b` and `c`".
pub(super) fn quote_all<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    let names: Vec<_> = names.into_iter().map(quote).collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
