//! Reads tables, texts and lists from a TOML document, and reports values of an unexpected shape. It does not know what
//! they mean.

use std::fmt;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::fault::{Fault, suggestion};
use crate::report::{FaultReport, quote, quote_all};

/// The most texts of one list: more than an application has schemas.
const MAX_TEXTS: usize = 10_000;

/// A value and its position.
pub type Node<'a> = Spanned<DeValue<'a>>;

/// A text and its position.
#[derive(Clone, Debug)]
pub struct Text<'a> {
    /// The text.
    pub text: &'a str,
    /// Bytes from the start of the file.
    pub span: Range<usize>,
}

/// What is wrong with a value, and where.
#[derive(Clone, Debug)]
pub struct WrongValue {
    /// The position of the value, or of the part of it that is wrong.
    pub span: Range<usize>,
    /// What is wrong: the rest of a sentence that begins with the name of the value.
    pub message: String,
    /// How to correct it.
    pub help: Option<String>,
}

/// The result of a reader of values, which does not know their names.
pub type Checked<T> = Result<T, WrongValue>;

/// A table and its name in messages: "schema `goon`".
#[derive(Clone)]
pub struct Section<'a> {
    /// Its name in messages.
    pub label: String,
    /// The position of its name.
    pub span: Range<usize>,
    entries: &'a DeTable<'a>,
}

/// A value that a word abbreviates: `restart = "never"`, or `restart = { limit = 5 }`.
pub enum WordOrTable<'a> {
    /// The word.
    Word(Text<'a>),
    /// The table.
    Table(Section<'a>),
}

impl<'a> Section<'a> {
    /// Wraps a table. `what` is its name in messages.
    pub fn new(what: impl Into<String>, span: Range<usize>, entries: &'a DeTable<'a>) -> Self {
        Self {
            label: what.into(),
            span,
            entries,
        }
    }

    /// Returns all entries, in the file's order.
    pub fn entries(&self) -> impl Iterator<Item = (Text<'a>, &'a Node<'a>)> + use<'a> {
        self.entries.iter().map(|(key, value)| {
            let key = Text {
                text: key.get_ref(),
                span: key.span(),
            };
            (key, value)
        })
    }

    /// Returns the value of a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&'a Node<'a>> {
        self.entries.get(key)
    }

    /// Returns the position of a key, or of the section if the key is missing.
    #[must_use]
    pub fn key_span(&self, key: &str) -> Range<usize> {
        self.entries
            .get_key_value(key)
            .map_or_else(|| self.span.clone(), |(key, _)| key.span())
    }

    /// Returns the position of a value in the table at `key`, or of the section if the value is missing.
    #[must_use]
    pub fn entry_span(&self, key: &str, name: &str) -> Range<usize> {
        let entry = self.get(key).and_then(|node| node.get_ref().get(name));
        entry.map_or_else(|| self.span.clone(), Spanned::span)
    }

    /// Returns the name of a key in messages: "`period` of schema `goon`".
    #[must_use]
    pub fn key(&self, key: &str) -> String {
        format!("{} of {}", quote(key), self.label)
    }

    /// Returns a value whose key is required, as `read` returns it.
    pub fn required<T>(
        &self,
        report: &mut FaultReport,
        key: &str,
        read: impl FnOnce(&'a Node<'a>) -> Checked<T>,
    ) -> Option<T> {
        match self.get(key) {
            Some(node) => self.accept(report, key, read(node)),
            None => {
                report.fault(&self.span, format!("{} is missing", self.key(key)));
                None
            }
        }
    }

    /// Returns a value as `read` returns it, or its default if the key is missing; `None` if the value is wrong.
    pub fn optional<T>(
        &self,
        report: &mut FaultReport,
        key: &str,
        default: T,
        read: impl FnOnce(&'a Node<'a>) -> Checked<T>,
    ) -> Option<T> {
        self.get(key)
            .map_or(Some(default), |node| self.accept(report, key, read(node)))
    }

    fn accept<T>(&self, report: &mut FaultReport, key: &str, read: Checked<T>) -> Option<T> {
        read.map_err(|wrong| {
            let message = format!("{} {}", self.key(key), wrong.message);
            report.fault(&wrong.span, message).help = wrong.help;
        })
        .ok()
    }

    /// Reports a fault at a position in the section: the rest of a sentence that begins with its name.
    pub fn fault<'r>(
        &self,
        report: &'r mut FaultReport,
        span: &Range<usize>,
        message: impl fmt::Display,
    ) -> &'r mut Fault {
        report.fault(span, format!("{} {message}", self.label))
    }

    /// Returns the table at `key` with only known keys; `None` if it is missing, or if the value is no table.
    pub fn nested(&self, report: &mut FaultReport, key: &str, known: &[&str]) -> Option<Section<'a>> {
        let (what, node) = (self.key(key), self.get(key)?);
        let expected = format!("a table of {}", quote_all(known.iter().copied()));
        let entries = expect(report, &what, &expected, node, node.get_ref().as_table())?;
        let section = Section::new(what, node.span(), entries);
        section.refuse_unknown(report, known);
        Some(section)
    }

    /// Returns the tables of the list at `key`, none if the key is missing; `None` in it for what is no table, and as a
    /// whole if there is no list. Messages name each by its `name`, or else by its number.
    pub fn tables(
        &self,
        report: &mut FaultReport,
        key: &str,
        kind: &str,
    ) -> Option<Vec<Option<Section<'a>>>> {
        let Some(node) = self.get(key) else {
            return Some(Vec::new());
        };
        let expected = format!("a list of tables, each [[{key}]]");
        let list = expect(report, &self.key(key), &expected, node, node.get_ref().as_array())?;
        let tables = (1..).zip(list.iter());
        Some(
            tables
                .map(|(number, node)| table(report, node, kind, number))
                .collect(),
        )
    }

    /// Returns a text.
    pub fn text(&self, report: &mut FaultReport, key: &str) -> Option<Text<'a>> {
        text(report, &self.key(key), self.get(key)?)
    }

    /// Returns a list of texts.
    pub fn texts(&self, report: &mut FaultReport, key: &str) -> Option<Vec<Text<'a>>> {
        let (what, node) = (self.key(key), self.get(key)?);
        let list = expect(report, &what, "a list of texts", node, node.get_ref().as_array())?;
        if list.len() > MAX_TEXTS {
            let message = format!("{what} has {} texts, and may have {MAX_TEXTS}", list.len());
            report.fault(&node.span(), message);
            return None;
        }
        let what = format!("each of {what}");
        Some(
            list.iter()
                .filter_map(|entry| text(report, &what, entry))
                .collect(),
        )
    }

    /// Returns true or false; `None` if the key is missing.
    pub fn flag(&self, report: &mut FaultReport, key: &str) -> Option<bool> {
        let node = self.get(key)?;
        expect(
            report,
            &self.key(key),
            "true or false",
            node,
            node.get_ref().as_bool(),
        )
    }

    /// Returns a word, or the table that it abbreviates. `expected` names both in messages.
    pub fn word_or_table(
        &self,
        report: &mut FaultReport,
        key: &str,
        expected: &str,
    ) -> Option<WordOrTable<'a>> {
        let node = self.get(key)?;
        let found = match node.get_ref() {
            DeValue::String(text) => Some(WordOrTable::Word(Text {
                text,
                span: node.span(),
            })),
            DeValue::Table(entries) => {
                let section = Section::new(self.key(key), self.key_span(key), entries);
                Some(WordOrTable::Table(section))
            }
            _ => None,
        };
        expect(report, &self.key(key), expected, node, found)
    }

    /// Returns a table in this one.
    pub fn section(
        &self,
        report: &mut FaultReport,
        key: &str,
        what: impl Into<String>,
    ) -> Option<Section<'a>> {
        let node = self.get(key)?;
        let entries = expect(report, &self.key(key), "a table", node, node.get_ref().as_table())?;
        Some(Section::new(what, self.key_span(key), entries))
    }

    /// Returns a table of names, each with a text: `{ laser = "pioneer.laser" }`.
    pub fn pairs(&self, report: &mut FaultReport, key: &str) -> Vec<(Text<'a>, Text<'a>)> {
        let Some(section) = self.section(report, key, self.key(key)) else {
            return Vec::new();
        };
        section
            .entries()
            .filter_map(|(name, node)| Some((name.clone(), text(report, &section.key(name.text), node)?)))
            .collect()
    }

    /// Whether the table at `key` contains `name`, with any value. True for a value of another shape, which
    /// is reported elsewhere.
    #[must_use]
    pub fn is_set(&self, key: &str, name: &str) -> bool {
        self.get(key).is_some_and(|node| {
            node.get_ref()
                .as_table()
                .is_none_or(|table| table.contains_key(name))
        })
    }

    /// Returns the number of entries intended for the table at `key`; 1 for a value of another shape.
    #[must_use]
    pub fn entry_count(&self, key: &str) -> usize {
        self.get(key)
            .map_or(0, |node| node.get_ref().as_table().map_or(1, DeTable::len))
    }

    /// Reports every unknown key.
    pub fn refuse_unknown(&self, report: &mut FaultReport, known: &[&str]) {
        for (key, _) in self.entries().filter(|(key, _)| !known.contains(&key.text)) {
            report
                .fault(
                    &key.span,
                    format!("unknown key {} in {}", quote(key.text), self.label),
                )
                .suggest(key.text, "keys", known.iter().copied());
        }
    }
}

/// Returns a table of a list.
pub fn table<'a>(
    report: &mut FaultReport,
    node: &'a Node<'a>,
    kind: &str,
    number: usize,
) -> Option<Section<'a>> {
    let what = format!("{kind} {number}");
    let entries = expect(report, &what, "a table", node, node.get_ref().as_table())?;
    let label = match entries.get("name").and_then(|name| name.get_ref().as_str()) {
        Some(name) => format!("{kind} {}", quote(name)),
        None => what,
    };
    Some(Section::new(label, node.span(), entries))
}

/// Returns the value of the expected shape; reports the value if there is none.
pub fn expect<T>(
    report: &mut FaultReport,
    what: &str,
    expected: &str,
    node: &Node,
    found: Option<T>,
) -> Option<T> {
    if found.is_none() {
        report_wrong_shape(report, what, expected, node);
    }
    found
}

/// Reports a value of another shape.
pub fn report_wrong_shape(report: &mut FaultReport, what: &str, expected: &str, found: &Node) {
    let wrong = WrongValue::shape(found, expected);
    report.fault(&wrong.span, format!("{what} {}", wrong.message));
}

impl WrongValue {
    /// Says what is wrong with a value, for instance "is 0: expected more than 0".
    pub fn new(node: &Node, message: impl Into<String>) -> Self {
        Self {
            span: node.span(),
            message: message.into(),
            help: None,
        }
    }

    /// Says that a value has another shape than the expected one.
    #[must_use]
    pub fn shape(node: &Node, expected: &str) -> Self {
        Self::new(node, format!("must be {expected}, not {}", shape(node.get_ref())))
    }

    /// Says that a text is none of the known names, and suggests the most similar one.
    #[must_use]
    pub fn unknown<'n>(
        node: &Node,
        name: &str,
        expected: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) -> Self {
        Self {
            help: suggestion(name, "known", known),
            ..Self::new(node, format!("is {}, which is not {expected}", quote(name)))
        }
    }
}

/// Returns the text of a value; reports a value of another shape. `what` names it in messages.
pub fn text<'a>(report: &mut FaultReport, what: &str, node: &'a Node<'a>) -> Option<Text<'a>> {
    let text = expect(report, what, "a text", node, node.get_ref().as_str())?;
    Some(Text {
        text,
        span: node.span(),
    })
}

/// Returns the name of a value's shape for messages.
#[must_use]
pub fn shape(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// Returns the number, if the value is one.
#[must_use]
pub fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(_) => integer(value).map(|whole| whole as f64),
        _ => None,
    }
}

/// Returns the whole number, if the value is one. TOML's have at most 64 bits, signed or unsigned.
#[must_use]
pub fn integer(value: &DeValue) -> Option<i128> {
    let integer = value.as_integer()?;
    i128::from_str_radix(integer.as_str(), integer.radix()).ok()
}
