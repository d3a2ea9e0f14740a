//! Links between the pages of the project have existing targets. External links are not followed.

use std::collections::HashMap;

use super::tree::{File, Tree, Violation};

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.with_extension(&["md"])
        .flat_map(|page| check_page(tree, page))
        .collect()
}

fn check_page(tree: &Tree, page: &File) -> Vec<Violation> {
    let mut found = Vec::new();
    for (number, line) in prose(&page.text) {
        for target in targets(line) {
            if let Some(what) = fault(tree, page, target) {
                let help = "correct the link; targets are relative to the page";
                found.push(Violation::new(page.path.as_str(), number, what, help));
            }
        }
    }
    found
}

/// Returns what is wrong with a link of a page.
fn fault(tree: &Tree, page: &File, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (path, anchor) = target
        .split_once('#')
        .map_or((target, None), |(path, anchor)| (path, Some(anchor)));
    if path.starts_with('/') {
        return Some(format!("the link {target} begins with a slash"));
    }
    let full = if path.is_empty() {
        page.path.clone()
    } else {
        resolve(&page.path, path)
    };
    let linked = tree.file(full.trim_end_matches('/'));
    if linked.is_none() && !tree.root.join(&full).exists() {
        return Some(format!("the link {target} leads to {full}, which is not there"));
    }
    let linked = linked.filter(|file| file.has_extension(&["md"]))?;
    let anchor = anchor?;
    (!anchors(&linked.text).iter().any(|known| known == anchor))
        .then(|| format!("the link {target} names a heading that {full} does not have"))
}

/// Resolves a relative path against the folder of a page.
pub(crate) fn resolve(page: &str, path: &str) -> String {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            other => parts.push(other),
        }
    }
    parts.join("/")
}

/// Returns the lines outside fenced blocks, with their numbers from 1.
pub(super) fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        (!fence && !fenced).then_some((index + 1, line))
    })
}

/// Returns the targets of `[text](target)`, of images, and of `[text]: target`.
pub(crate) fn targets(line: &str) -> Vec<&str> {
    let mut found = Vec::new();
    if let Some((label, target)) = line.split_once("]: ")
        && label.starts_with('[')
    {
        found.extend(target.split_whitespace().next());
    }
    // Text between backticks is no link.
    for piece in line.split('`').step_by(2) {
        let after = piece
            .match_indices("](")
            .map(|(at, mark)| &piece[at + mark.len()..]);
        let whole = after.filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
        found.extend(whole.filter_map(|target| target.split_whitespace().next()));
    }
    found
}

/// Returns the anchors of the headings of a page.
fn anchors(text: &str) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let headings = prose(text).filter(|(_, line)| line.starts_with('#'));
    headings
        .map(|(_, line)| {
            let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
            let title = line.trim_start_matches('#').trim().to_lowercase();
            let name: String = title.chars().filter(kept).collect::<String>().replace(' ', "-");
            let before = seen.entry(name.clone()).or_default();
            *before += 1;
            if *before == 1 {
                name
            } else {
                format!("{name}-{}", *before - 1)
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let other = (
            "docs/rules.md",
            "# The rules\n## R1 One winner.\n## Twice\n## Twice\n",
        );
        let tree = Tree::of(&[("docs/page.md", text), other, ("README.md", "# Top\n")]);
        check(&tree)
            .into_iter()
            .map(|violation| violation.message)
            .collect()
    }

    #[test]
    fn links_to_existing_targets_pass() {
        let text = "# Here\n[a](rules.md) [b](rules.md#r1-one-winner \"title\") ![c](../README.md#top)\n\
            [d](#here) [e](https://example.org/x.md) [f](rules.md#twice-1)\n[g]: ./rules.md\n";
        assert_eq!(found(text), [""; 0]);
    }

    #[test]
    fn links_to_missing_targets_fail() {
        assert_eq!(
            found("[a](gone.md)\n"),
            ["the link gone.md leads to docs/gone.md, which is not there"]
        );
        assert_eq!(
            found("[a]: ../gone\n"),
            ["the link ../gone leads to gone, which is not there"]
        );
        assert_eq!(
            found("[a](rules.md#r2)\n"),
            ["the link rules.md#r2 names a heading that docs/rules.md does not have"]
        );
        assert_eq!(
            found("[a](/rules.md)\n"),
            ["the link /rules.md begins with a slash"]
        );
    }

    #[test]
    fn code_is_no_link() {
        assert_eq!(
            found("`[a](gone.md)`\n```rust\nlet a = [b](gone);\n```\n"),
            [""; 0]
        );
    }
}
