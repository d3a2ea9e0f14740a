//! The table of contents: the tables of docs/README.md, with the pages that they link to.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};

use super::{Chapter, pages_below};
use crate::tidy::links::{resolve, targets};

/// The page whose tables list all others.
const LIST: &str = "docs/README.md";

/// Returns the parts of the book: the title of each table, and its pages.
pub(super) fn parts(source: &Path) -> Result<Vec<(String, Vec<Chapter>)>> {
    let list = fs::read_to_string(source.join(LIST))?;
    let first = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", LIST].map(|path| chapter(source, path));
    let first = first.into_iter().collect::<Result<_>>()?;
    let mut parts = vec![("jde".to_owned(), first)];
    for (title, paths) in tables(&list) {
        let mut chapters = Vec::new();
        for path in paths {
            chapters.push(chapter(source, &path)?);
        }
        if !chapters.is_empty() {
            parts.push((title, chapters));
        }
    }
    Ok(parts)
}

/// Returns the title of each table, and the pages to which it links.
fn tables(list: &str) -> Vec<(String, Vec<String>)> {
    let mut tables: Vec<(String, Vec<String>)> = Vec::new();
    let mut before = "";
    for line in list.lines() {
        if line.starts_with('|') && !before.starts_with('|') {
            let title = line
                .trim_matches('|')
                .split('|')
                .next()
                .unwrap_or_default()
                .trim();
            tables.push((title.to_owned(), Vec::new()));
        } else if line.starts_with('|')
            && let Some((_, pages)) = tables.last_mut()
        {
            let linked = targets(line).into_iter().filter(|target| target.ends_with(".md"));
            pages.extend(linked.map(|target| resolve(LIST, target)));
        }
        before = line;
    }
    tables
}

/// Returns a page by its path. A page that is the README of a folder of docs has the other pages of that folder below it.
fn chapter(source: &Path, path: &str) -> Result<Chapter> {
    let file = source.join(path);
    let text = fs::read_to_string(&file)?;
    let title = text.lines().find_map(|line| line.strip_prefix("# "));
    let title = title.with_context(|| format!("{path} has no title"))?.to_owned();
    let mut pages = Vec::new();
    if path != LIST && path.starts_with("docs/") && path.ends_with("/README.md") {
        for page in pages_below(file.parent().unwrap_or(source))? {
            if page != file {
                pages.push(chapter(source, &page.strip_prefix(source)?.to_string_lossy())?);
            }
        }
    }
    Ok(Chapter {
        title,
        path: path.to_owned(),
        pages,
    })
}

/// Returns the table of contents in the form of mdBook.
pub(super) fn text(parts: &[(String, Vec<Chapter>)]) -> String {
    let mut text = String::new();
    for (title, chapters) in parts {
        let _ = write!(text, "# {title}\n\n");
        chapters.iter().for_each(|chapter| push(chapter, 0, &mut text));
        text.push('\n');
    }
    text
}

fn push(chapter: &Chapter, depth: usize, text: &mut String) {
    let indent = "  ".repeat(depth);
    let _ = writeln!(text, "{indent}- [{}]({})", chapter.title, chapter.path);
    chapter.pages.iter().for_each(|page| push(page, depth + 1, text));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_of_a_page_are_parts_with_pages() {
        let page = "# D\n\n| a b | |\n|---|---|\n| [X](x.md), [Y](y/README.md) | z [W](../w.toml) |\n\n| c |\n|---|\n";
        let pages = vec!["docs/x.md".to_owned(), "docs/y/README.md".to_owned()];
        assert_eq!(
            tables(page),
            [("a b".to_owned(), pages), ("c".to_owned(), vec![])]
        );
    }

    #[test]
    fn pages_of_a_folder_are_below_its_first() {
        let page = |path: &str| Chapter {
            title: "T".to_owned(),
            path: path.to_owned(),
            pages: Vec::new(),
        };
        let first = Chapter {
            pages: vec![page("b.md")],
            ..page("a.md")
        };
        assert_eq!(
            text(&[("P".to_owned(), vec![first])]),
            "# P\n\n- [T](a.md)\n  - [T](b.md)\n\n"
        );
    }
}
