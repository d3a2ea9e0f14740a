//! Every link of the book leads to a file and a heading of the book. Links to other sites are not followed.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Result, bail};

use super::files_below;
use crate::tidy::links::resolve;

/// Pages that mdBook makes for itself.
const OWN_PAGES: &[&str] = &["404.html", "toc.html"];

/// Checks all pages. Prints each link that leads nowhere; any is an error.
pub(super) fn check(book: &Path) -> Result<()> {
    let mut pages = BTreeMap::new();
    for file in files_below(book, "html")? {
        let name = file.strip_prefix(book)?.to_string_lossy().into_owned();
        pages.insert(name, fs::read_to_string(&file)?);
    }
    let mut broken = 0;
    for (name, text) in pages
        .iter()
        .filter(|(name, _)| !OWN_PAGES.contains(&name.as_str()))
    {
        for link in attributes(text, "href").chain(attributes(text, "src")) {
            if !leads_somewhere(link, name, &pages, book) {
                println!("{name}: the link {link} leads nowhere");
                broken += 1;
            }
        }
    }
    if broken > 0 {
        bail!("{broken} links of the manual lead nowhere");
    }
    Ok(())
}

fn leads_somewhere(link: &str, page: &str, pages: &BTreeMap<String, String>, book: &Path) -> bool {
    if link.contains(':') || link.is_empty() {
        return true;
    }
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = if path.is_empty() {
        page.to_owned()
    } else {
        resolve(page, path)
    };
    match pages.get(&target) {
        Some(text) => anchor.is_empty() || attributes(text, "id").any(|id| id == anchor),
        None => book.join(target).exists(),
    }
}

/// Returns the values of an attribute of HTML.
fn attributes<'t>(text: &'t str, name: &str) -> impl Iterator<Item = &'t str> {
    let mark = format!(" {name}=\"");
    let mut rest = text;
    std::iter::from_fn(move || {
        let (_, after) = rest.split_once(&mark)?;
        let (value, after) = after.split_once('"')?;
        rest = after;
        Some(value)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_leads_to_a_page_a_heading_or_a_file() {
        let book = tempfile::tempdir().unwrap();
        fs::create_dir_all(book.path().join("a")).unwrap();
        fs::write(book.path().join("x.png"), "").unwrap();
        fs::write(book.path().join("b.html"), "<h1 id=\"top\">").unwrap();
        let page = |link: &str| {
            fs::write(
                book.path().join("a/c.html"),
                format!("<a class=\"d\" href=\"{link}\">"),
            )
            .unwrap()
        };
        for link in [
            "../b.html",
            "../b.html#top",
            "../x.png",
            "https://example.org",
            "c.html",
        ] {
            page(link);
            check(book.path()).unwrap();
        }
        for link in ["b.html", "../b.html#end", "#top", "../y.png"] {
            page(link);
            assert!(check(book.path()).is_err(), "{link}");
        }
    }
}
