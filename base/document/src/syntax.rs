//! Parses TOML, and reports the syntax errors of a file that is not TOML. One mistake often causes many
//! errors of the parser, so consequential errors are left out.

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

use super::file::MAX_BYTES;
use super::report::{FaultReport, quote};

/// The most errors that are reported: in binary data every byte is one.
const MAX_ERRORS: usize = 10;
/// The parser's message for a repeated key.
const DUPLICATE: &str = "duplicate key";
/// The parser's terms for an error inside a list or an inline table.
const NOT_CLOSED: [&str; 2] = ["array", "inline table"];

/// The most entries of one table. A thousand light schemas occupy a processor, so more than this is a fault of the
/// program that wrote the file.
const MAX_ENTRIES: usize = 10_000;

/// Parses a text. Reports the syntax errors and returns `None` if it is not TOML, because the recovered
/// document is not the intended one, and faults in it would be misleading. The same for tables that are too long. The
/// parser limits how deep values contain each other.
pub fn parse<'t>(report: &mut FaultReport, text: &'t str) -> Option<Spanned<DeTable<'t>>> {
    // The text may be one that a recording contains.
    if text.len() as u64 > MAX_BYTES {
        report.file_fault(format!("it has more than {} MiB", MAX_BYTES >> 20));
        return None;
    }
    let (document, errors) = DeTable::parse_recoverable(text);
    report_errors(report, text, &errors);
    let complete = errors.is_empty() && !refuse_long(report, document.get_ref(), ("the file", 0));
    complete.then_some(document)
}

/// Reports the first table with too many entries. Returns whether there is one.
fn refuse_long(report: &mut FaultReport, table: &DeTable, (name, at): (&str, usize)) -> bool {
    if table.len() > MAX_ENTRIES {
        let message = format!(
            "{name} has {} entries, and one table may have {MAX_ENTRIES}",
            table.len()
        );
        report.fault(&(at..at), message);
        return true;
    }
    let mut tables = table.iter().filter_map(|(key, value)| match value.get_ref() {
        DeValue::Table(inner) => Some((inner, quote(key.get_ref()), key.span().start)),
        _ => None,
    });
    tables.any(|(inner, name, at)| refuse_long(report, inner, (&name, at)))
}

/// Reports the parser's errors.
fn report_errors(report: &mut FaultReport, text: &str, errors: &[Error]) {
    // Every key of a repeated table is a duplicate: up to this position they are one fault.
    let mut twice_until = 0;
    for error in errors.iter().take(MAX_ERRORS) {
        let span = error.span().unwrap_or(0..0);
        if error.message() != DUPLICATE {
            report.fault(&span, format!("this is not TOML: {}", error.message()));
            // An unclosed list or table swallows what follows, and everything in it looks wrong.
            if NOT_CLOSED.iter().any(|inside| error.message().contains(inside)) {
                return;
            }
            continue;
        }
        if span.start < twice_until {
            continue;
        }
        let name = quote(text.get(span.clone()).unwrap_or_default());
        let line = text[..span.start].rfind('\n').map_or(0, |end| end + 1);
        if text[line..].starts_with('[') {
            let rest = text[span.start..].find("\n[");
            twice_until = rest.map_or(text.len(), |length| span.start + length);
            report
                .fault(&span, format!("there is a table {name} already"))
                .advise("give each its own name, or merge the two tables");
        } else {
            report
                .fault(&span, format!("there is a key {name} already"))
                .advise("keep one of the two");
        }
    }
}
