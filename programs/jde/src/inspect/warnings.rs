//! The warnings about an application in the form of faults, with the line of its file that each is about.

use std::fs;

use jde_app::{Application, Fault, FaultLocation, Faults};
use jde_document::Excerpt;

/// Returns the warnings; `None` if there are none.
pub(crate) fn warnings(application: &Application) -> Option<Faults> {
    let warnings = application.warnings();
    if warnings.is_empty() {
        return None;
    }
    // Without the file, the warnings have no excerpts.
    let text = fs::read_to_string(&application.path).unwrap_or_default();
    let located = warnings
        .iter()
        .map(|warning| located(application, &text, warning));
    Some(Faults::from(located.collect::<Vec<_>>()))
}

/// Gives a warning its place: the line that it begins with, or that of the key that it is about.
fn located(application: &Application, text: &str, warning: &str) -> Fault {
    let file = &application.path;
    let parts = warning
        .strip_prefix("line ")
        .and_then(|rest| rest.split_once(": "));
    let number = parts.and_then(|(number, _)| number.parse::<usize>().ok());
    let (Some((_, message)), Some(table)) = (parts, number) else {
        return Fault::of_file(file, warning);
    };
    let number = line_of_key(text, table, message);
    let mut fault = Fault::at_line(file, number, message);
    let before = number.saturating_sub(1);
    if let Some(line) = text.lines().nth(before) {
        let start: usize = text.split_inclusive('\n').take(before).map(str::len).sum();
        let indent = line.len() - line.trim_start().len();
        let marked = indent..line.trim_end().len().max(indent);
        fault.location = FaultLocation::Text {
            file: file.clone(),
            line: number,
            column: line[..indent].chars().count() + 1,
            span: start + marked.start..start + marked.end,
            excerpt: Box::new(Excerpt {
                text: line.to_owned(),
                marked,
            }),
        };
    }
    fault
}

/// Returns the line of the key that a message names first, if the table that begins at line `table` has it, or else
/// that of the table.
fn line_of_key(text: &str, table: usize, message: &str) -> usize {
    let named = message.split('`').nth(1).unwrap_or_default();
    let key = named.rsplit('.').next().unwrap_or_default();
    let lines = text.lines().enumerate().skip(table);
    let is_key = |line: &str| {
        let rest = line.trim_start().strip_prefix(key);
        rest.is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    let mut own = lines.take_while(|(_, line)| !line.trim_start().starts_with('['));
    own.find(|(_, line)| is_key(line))
        .map_or(table, |(before, _)| before + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_at_the_key_that_it_names_first_or_else_at_its_table() {
        let text =
            "[schemas.goon]\ntype = \"goon\"\n  period = \"75 s\"\n[schemas.stop]\nperiod = 1\nwidth = 2\n";
        let line = |table, message| line_of_key(text, table, message);
        assert_eq!(line(1, "`period` of schema `goon` is 75 s"), 3);
        assert_eq!(line(4, "`period` of schema `stop` is 1 s"), 5);
        assert_eq!(line(4, "`stop.width` is 2 m"), 6);
        assert_eq!(line(1, "`goon.width` is 2 m"), 1);
        assert_eq!(line(9, "nothing is named"), 9);
    }
}
