//! Faults of a file that is no TOML, in few words: one slip is often seen by a parser as many.

use toml::de::Error;

use super::report::{Report, quote};

/// Most that are reported: in noise, every byte is one.
const MOST: usize = 10;
/// What the parser says of a key that is there already.
const DUPLICATE: &str = "duplicate key";
/// What it speaks of in a list or an inline table.
const NOT_CLOSED: [&str; 2] = ["array", "inline table"];

/// Reports what the parser found.
pub(super) fn report(report: &mut Report, text: &str, errors: &[Error]) {
    // The keys of a table given twice are all there already: up to here they are one fault.
    let mut twice_until = 0;
    for error in errors.iter().take(MOST) {
        let span = error.span().unwrap_or(0..0);
        if error.message() != DUPLICATE {
            report.fault(&span, format!("this is no TOML: {}", error.message()));
            // A list or table that is not closed swallows what follows, all of which then looks wrong.
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
                .advise("give each a name of its own, or make one table of the two");
        } else {
            report
                .fault(&span, format!("there is a key {name} already"))
                .advise("keep one of the two");
        }
    }
}
