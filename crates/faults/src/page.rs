//! Writes the table of a campaign into a page of the documentation, between two marks. The rest of the page
//! is not changed.

use std::path::Path;

use anyhow::{Context as _, Result};

const BEGIN: &str = "<!-- table: cargo xtask faults --save -->\n";
const END: &str = "<!-- end of table -->\n";

/// Writes the table into a page with the marks.
pub(crate) fn save(file: &Path, table: &str, words: &str) -> Result<()> {
    let page = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let page = with(&page, &format!("{words}\n\n{table}")).with_context(|| {
        format!(
            "{} has no place for the table: the lines `{}` and `{}`",
            file.display(),
            BEGIN.trim(),
            END.trim()
        )
    })?;
    std::fs::write(file, page).with_context(|| format!("cannot write {}", file.display()))
}

fn with(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::{BEGIN, END, with};

    #[test]
    fn only_what_is_between_the_marks_is_written_anew() {
        let page = format!("before\n{BEGIN}old\n{END}after\n");
        assert_eq!(
            with(&page, "new\n"),
            Some(format!("before\n{BEGIN}new\n{END}after\n"))
        );
        assert_eq!(with("no marks", "new\n"), None);
    }
}
