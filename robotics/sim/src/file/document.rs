//! A TOML text, read table by table. It collects the faults instead of stopping at the first; beyond many it only counts
//! them, so that the work is linear in the text whatever it contains.
//!
//! This module handles tables and keys. `values` checks values, and `fixtures` reads things.

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::values::{Read, describe};
use crate::error::{Fault, MAX_FAULTS, more};

pub(crate) type Item<'a> = Spanned<DeValue<'a>>;

pub(crate) struct Document<'a> {
    path: &'a Path,
    /// The ends of the lines, in bytes.
    line_ends: Vec<usize>,
    faults: RefCell<Vec<Fault>>,
    /// The number of faults beyond the most.
    others: Cell<usize>,
}

/// A table whose keys have been checked against the known ones.
pub(crate) struct Table<'a> {
    document: &'a Document<'a>,
    keys: &'a DeTable<'a>,
    span: Range<usize>,
    /// Its name in faults: "box `desk`".
    description: String,
}

impl<'a> Document<'a> {
    pub(crate) fn new(path: &'a Path, text: &'a str) -> Self {
        Self {
            path,
            line_ends: text.match_indices('\n').map(|(end, _)| end).collect(),
            faults: RefCell::default(),
            others: Cell::default(),
        }
    }

    pub(crate) fn path(&self) -> &'a Path {
        self.path
    }

    pub(crate) fn line(&self, span: &Range<usize>) -> usize {
        1 + self.line_ends.partition_point(|end| *end < span.start)
    }

    /// Records a fault at a place in the text.
    pub(crate) fn fault(&self, span: &Range<usize>, message: impl Into<String>) {
        self.push(self.fault_at(span, message));
    }

    /// Records a fault of another file.
    pub(crate) fn push(&self, fault: Fault) {
        if !self.count_if_full() {
            self.faults.borrow_mut().push(fault);
        }
    }

    /// Counts a fault if there are too many to tell it.
    pub(crate) fn count_if_full(&self) -> bool {
        let is_full = self.faults.borrow().len() >= MAX_FAULTS;
        self.others.update(|others| others + usize::from(is_full));
        is_full
    }

    /// Creates a fault without recording it.
    pub(crate) fn fault_at(&self, span: &Range<usize>, message: impl Into<String>) -> Fault {
        Fault {
            file: self.path.to_owned(),
            line: Some(self.line(span)),
            message: message.into(),
        }
    }

    /// Returns all faults: first those of this file, in the order of their lines.
    pub(crate) fn into_faults(self) -> Vec<Fault> {
        let mut faults = self.faults.into_inner();
        faults.sort_by_key(|fault| (fault.file != self.path, fault.line));
        let others = self.others.get();
        if others > 0 {
            faults.push(more(self.path.to_owned(), others));
        }
        faults
    }
}

impl<'a> Table<'a> {
    pub(crate) fn new(
        document: &'a Document<'a>,
        keys: &'a DeTable<'a>,
        span: Range<usize>,
        what: String,
        known: &[&str],
    ) -> Self {
        for key in keys.keys().filter(|key| !known.contains(&key.get_ref().as_ref())) {
            if document.count_if_full() {
                continue;
            }
            let hint = match super::nearest(key.get_ref(), known.iter().copied()) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("expected one of `{}`", known.join("`, `")),
            };
            document.fault(
                &key.span(),
                format!("{what}: unknown key `{}`; {hint}", key.get_ref()),
            );
        }
        Self {
            document,
            keys,
            span,
            description: what,
        }
    }

    /// Reads an item as a table. Faults name it by its `name`, or else by its number.
    pub(crate) fn item(
        document: &'a Document<'a>,
        item: &'a Item<'a>,
        kind: &str,
        number: usize,
        known: &[&str],
    ) -> Option<Self> {
        let Some(keys) = item.get_ref().as_table() else {
            document.fault(
                &item.span(),
                format!("{kind} {number} is {}: expected a table", describe(item)),
            );
            return None;
        };
        let what = match keys.get("name").and_then(|name| name.get_ref().as_str()) {
            Some(name) => format!("{kind} `{name}`"),
            None => format!("{kind} {number}"),
        };
        Some(Self::new(document, keys, item.span(), what, known))
    }

    /// Reads an item as a table that faults call `what`.
    pub(crate) fn nested(
        document: &'a Document<'a>,
        item: &'a Item<'a>,
        what: &str,
        known: &[&str],
    ) -> Option<Self> {
        let Some(keys) = item.get_ref().as_table() else {
            let message = format!(
                "`{what}` is {}: expected a table of `{}`",
                describe(item),
                known.join("`, `")
            );
            document.fault(&item.span(), message);
            return None;
        };
        Some(Self::new(document, keys, item.span(), what.to_owned(), known))
    }

    pub(crate) fn span(&self) -> &Range<usize> {
        &self.span
    }

    pub(crate) fn get(&self, key: &str) -> Option<&'a Item<'a>> {
        self.keys.get(key)
    }

    /// Returns the items of an array; none when the key is missing.
    pub(crate) fn array(&self, key: &str) -> &'a [Item<'a>] {
        let Some(item) = self.get(key) else { return &[] };
        match item.get_ref().as_array() {
            Some(items) => items,
            None => {
                self.fault(
                    &item.span(),
                    format!("`{key}` is {}: expected an array of tables", describe(item)),
                );
                &[]
            }
        }
    }

    /// Returns a value whose key is required.
    pub(crate) fn required<T>(&self, key: &str, read: impl Fn(&Item<'a>) -> Read<T>) -> Option<T> {
        match self.get(key) {
            Some(item) => self.recorded(key, read(item)),
            None => {
                self.fault(&self.span, format!("`{key}` is missing"));
                None
            }
        }
    }

    /// Returns a value, or its default when the key is missing; `None` when the value is invalid.
    pub(crate) fn optional<T>(
        &self,
        key: &str,
        default: T,
        read: impl Fn(&Item<'a>) -> Read<T>,
    ) -> Option<T> {
        self.get(key)
            .map_or(Some(default), |item| self.recorded(key, read(item)))
    }

    pub(crate) fn fault(&self, span: &Range<usize>, message: impl AsRef<str>) {
        self.document
            .fault(span, format!("{}: {}", self.description, message.as_ref()));
    }

    fn recorded<T>(&self, key: &str, read: Read<T>) -> Option<T> {
        read.map_err(|(span, message)| self.fault(&span, format!("`{key}` {message}")))
            .ok()
    }
}
