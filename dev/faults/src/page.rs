//! Writes the table of a campaign into a page of the documentation, between two marks. The rest of the page
//! is not changed.

use std::path::Path;

use anyhow::{Context as _, Result};

const BEGIN: &str = "<!-- table: cargo xtask faults --save -->\n";
const END: &str = "<!-- end of table -->\n";

/// Writes the table into a page with the marks.
pub(crate) fn save(file: &Path, table: &str, summary: &str) -> Result<()> {
    let page = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let page = replace_table(&page, &format!("{summary}\n\n{table}")).with_context(|| {
        format!(
            "{} has no place for the table: the lines `{}` and `{}`",
            file.display(),
            BEGIN.trim(),
            END.trim()
        )
    })?;
    std::fs::write(file, page).with_context(|| format!("cannot write {}", file.display()))
}

fn replace_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::{BEGIN, END, replace_table};

    #[test]
    fn only_the_text_between_the_marks_is_replaced() {
        let page = format!("before\n{BEGIN}old\n{END}after\n");
        assert_eq!(
            replace_table(&page, "new\n"),
            Some(format!("before\n{BEGIN}new\n{END}after\n"))
        );
        assert_eq!(replace_table("no marks", "new\n"), None);
    }
}
