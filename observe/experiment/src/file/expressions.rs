//! The expressions of an experiment, checked against the names of its application; equal ones are kept once.

use jde_app::Application;
use jde_conditions::{BadCondition, Expression, Names};
use jde_document::{FaultReport, Text};

use super::Subject;

/// The expressions so far.
pub(super) struct Expressions {
    names: Names,
    list: Vec<Expression>,
}

impl Expressions {
    pub(super) fn new(application: &Application) -> Self {
        Self {
            names: Names::of(application),
            list: Vec::new(),
        }
    }

    pub(super) fn into_list(self) -> Vec<Expression> {
        self.list
    }

    /// Adds an expression that is true or false. Returns its place.
    pub(super) fn condition(
        &mut self,
        report: &mut FaultReport,
        subject: &Subject<'_>,
        text: &Text,
    ) -> Option<usize> {
        self.add(report, subject, text, Expression::condition)
    }

    /// Adds an expression that is a number, or true or false. Returns its place.
    pub(super) fn any(
        &mut self,
        report: &mut FaultReport,
        subject: &Subject<'_>,
        text: &Text,
    ) -> Option<usize> {
        self.add(report, subject, text, Expression::new)
    }

    fn add(
        &mut self,
        report: &mut FaultReport,
        subject: &Subject<'_>,
        text: &Text,
        parse: impl Fn(&str, &Names) -> Result<Expression, BadCondition>,
    ) -> Option<usize> {
        match parse(text.text, &self.names) {
            Ok(expression) => {
                let known = self
                    .list
                    .iter()
                    .position(|known| known.text() == expression.text());
                Some(known.unwrap_or_else(|| {
                    self.list.push(expression);
                    self.list.len() - 1
                }))
            }
            Err(bad) => {
                let span = position(subject.text, text, bad.column);
                report.fault(&span, bad.reason.to_string());
                None
            }
        }
    }
}

/// Returns the position in the file of a column of an expression; of the whole expression if the file writes
/// it with escapes.
fn position(file: &str, text: &Text, column: usize) -> std::ops::Range<usize> {
    let span = text.span.clone();
    let source = file.get(span.clone()).unwrap_or_default();
    let Some(start) = source.find(text.text) else {
        return span;
    };
    let before: usize = text
        .text
        .chars()
        .take(column.saturating_sub(1))
        .map(char::len_utf8)
        .sum();
    let at = span.start + start + before;
    at..span.end.max(at)
}
