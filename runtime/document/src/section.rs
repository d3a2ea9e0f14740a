//! Reads tables, texts and lists from a TOML document, and reports values of an unexpected shape. It has no
//! knowledge of schemas.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use jde_core::Nanos;

use crate::report::{FaultReport, quote};
use crate::time;

/// The most texts of one list, which names schemas: as many as an application has.
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

    /// Returns a time in ns.
    pub fn time(&self, report: &mut FaultReport, key: &str) -> Option<Nanos> {
        time::time(report, &self.key(key), self.get(key)?)
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
    report.fault(
        &found.span(),
        format!("{what} must be {expected}, not {}", shape(found.get_ref())),
    );
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
