//! Reads tables, texts and lists out of a TOML document, and reports what is of another shape than was expected. Knows
//! nothing of schemas.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::report::{Report, quote};

/// A value and where it is.
pub(super) type Node<'a> = Spanned<DeValue<'a>>;

/// A text and where it is.
#[derive(Clone, Debug)]
pub(super) struct Text<'a> {
    pub(super) text: &'a str,
    pub(super) span: Range<usize>,
}

/// A table and what messages call it: "schema `goon`".
#[derive(Clone)]
pub(super) struct Section<'a> {
    pub(super) what: String,
    pub(super) span: Range<usize>,
    entries: &'a DeTable<'a>,
}

impl<'a> Section<'a> {
    pub(super) fn new(what: impl Into<String>, span: Range<usize>, entries: &'a DeTable<'a>) -> Self {
        Self {
            what: what.into(),
            span,
            entries,
        }
    }

    /// All entries, in the file's order.
    pub(super) fn entries(&self) -> impl Iterator<Item = (Text<'a>, &'a Node<'a>)> + use<'a> {
        self.entries.iter().map(|(key, value)| {
            let key = Text {
                text: key.get_ref(),
                span: key.span(),
            };
            (key, value)
        })
    }

    pub(super) fn get(&self, key: &str) -> Option<&'a Node<'a>> {
        self.entries.get(key)
    }

    /// Where a key is written; the section itself if it is not.
    pub(super) fn key_span(&self, key: &str) -> Range<usize> {
        self.entries
            .get_key_value(key)
            .map_or_else(|| self.span.clone(), |(key, _)| key.span())
    }

    /// What messages call one of its keys: "`period` of schema `goon`".
    pub(super) fn key(&self, key: &str) -> String {
        format!("{} of {}", quote(key), self.what)
    }

    pub(super) fn text(&self, report: &mut Report, key: &str) -> Option<Text<'a>> {
        text(report, &self.key(key), self.get(key)?)
    }

    pub(super) fn texts(&self, report: &mut Report, key: &str) -> Option<Vec<Text<'a>>> {
        let (what, node) = (self.key(key), self.get(key)?);
        let Some(list) = node.get_ref().as_array() else {
            wrong(report, &what, "a list of texts", node);
            return None;
        };
        Some(
            list.iter()
                .filter_map(|entry| text(report, &format!("each of {what}"), entry))
                .collect(),
        )
    }

    /// A table in this one.
    pub(super) fn section(
        &self,
        report: &mut Report,
        key: &str,
        what: impl Into<String>,
    ) -> Option<Section<'a>> {
        let node = self.get(key)?;
        let Some(entries) = node.get_ref().as_table() else {
            wrong(report, &self.key(key), "a table", node);
            return None;
        };
        Some(Section::new(what, self.key_span(key), entries))
    }

    /// A table of names, each with a text: `{ laser = "pioneer.laser" }`.
    pub(super) fn pairs(&self, report: &mut Report, key: &str) -> Vec<(Text<'a>, Text<'a>)> {
        let Some(section) = self.section(report, key, self.key(key)) else {
            return Vec::new();
        };
        section
            .entries()
            .filter_map(|(name, node)| Some((name.clone(), text(report, &section.key(name.text), node)?)))
            .collect()
    }

    /// Whether a table in this one has the name, right or wrong. One of another shape may have any: what is wrong with it
    /// is reported.
    pub(super) fn is_given(&self, key: &str, name: &str) -> bool {
        self.get(key).is_some_and(|node| {
            node.get_ref()
                .as_table()
                .is_none_or(|table| table.contains_key(name))
        })
    }

    /// How many entries the file means a table in this one to have; of another shape it is one.
    pub(super) fn entry_count(&self, key: &str) -> usize {
        self.get(key)
            .map_or(0, |node| node.get_ref().as_table().map_or(1, DeTable::len))
    }

    /// Reports every key that is not among the known ones.
    pub(super) fn refuse_unknown(&self, report: &mut Report, known: &[&str]) {
        for (key, _) in self.entries().filter(|(key, _)| !known.contains(&key.text)) {
            report
                .fault(
                    &key.span,
                    format!("unknown key {} in {}", quote(key.text), self.what),
                )
                .suggest(key.text, "keys", known.iter().copied());
        }
    }
}

/// Reports a value of another shape.
pub(super) fn wrong(report: &mut Report, what: &str, expected: &str, found: &Node) {
    report.fault(
        &found.span(),
        format!("{what} must be {expected}, not {}", shape(found.get_ref())),
    );
}

fn text<'a>(report: &mut Report, what: &str, node: &'a Node<'a>) -> Option<Text<'a>> {
    let Some(text) = node.get_ref().as_str() else {
        wrong(report, what, "a text", node);
        return None;
    };
    Some(Text {
        text,
        span: node.span(),
    })
}

/// What a person calls a value of that kind.
pub(super) fn shape(value: &DeValue) -> &'static str {
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

/// The number that a value is, if it is one.
pub(super) fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(_) => whole(value).map(|whole| whole as f64),
        DeValue::String(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_)
        | DeValue::Array(_)
        | DeValue::Table(_) => None,
    }
}

/// The whole number that a value is, if it is one; TOML's are at most 64 bits, with a sign or without.
pub(super) fn whole(value: &DeValue) -> Option<i128> {
    let integer = value.as_integer()?;
    i128::from_str_radix(integer.as_str(), integer.radix()).ok()
}
