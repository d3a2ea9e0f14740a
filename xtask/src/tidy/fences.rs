//! Fenced blocks of the pages at least parse: Rust as tokens, commands as shell, and `cargo xtask` with its
//! own parser. It does not check that they do what the page states.

use clap::CommandFactory as _;

use super::tree::{File, Tree, Violation};
use crate::{Cli, shell};

/// A fenced block of a page.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// The line of the opening fence, from 1.
    pub(crate) line: usize,
    /// The language on the fence, up to the first comma or blank.
    pub(crate) language: String,
    pub(crate) text: String,
}

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.with_extension(&["md"]).flat_map(check_page).collect()
}

fn check_page(page: &File) -> Vec<Violation> {
    let (blocks, open) = blocks(&page.text);
    let mut found: Vec<Violation> = Vec::new();
    if let Some(line) = open {
        found.push(Violation::new(
            page.path.as_str(),
            line,
            "a fence that never closes",
            "close it with ```",
        ));
    }
    for block in &blocks {
        let fault = match block.language.as_str() {
            "rust" => rust_fault(&block.text),
            "sh" | "bash" | "shell" => shell_fault(&block.text),
            "console" => shell_fault(&commands(&block.text)),
            _ => None,
        };
        if let Some(what) = fault {
            let help = "correct the block, or name its language rightly on the fence";
            found.push(Violation::new(page.path.as_str(), block.line, what, help));
        }
    }
    found
}

fn rust_fault(text: &str) -> Option<String> {
    // Shows the lines that rustdoc hides.
    let shown: Vec<&str> = text
        .lines()
        .map(|line| line.strip_prefix("# ").unwrap_or(line))
        .collect();
    let parsed = shown.join("\n").parse::<proc_macro2::TokenStream>();
    parsed
        .err()
        .map(|error| format!("this Rust does not parse: {error}"))
}

fn shell_fault(text: &str) -> Option<String> {
    if !shell::succeeds(std::process::Command::new("bash").args(["-n", "-c", text])) {
        return Some("these commands do not parse".to_owned());
    }
    text.lines().find_map(verb_fault)
}

/// Returns what is wrong with a call of this program.
fn verb_fault(line: &str) -> Option<String> {
    let call = line.split_once("cargo xtask")?.1;
    let arguments = call
        .split_whitespace()
        .take_while(|argument| !argument.starts_with(['#', '|', '&', ';', '>']));
    let parsed = Cli::command().try_get_matches_from(["xtask"].into_iter().chain(arguments));
    let error = parsed.err().filter(clap::Error::use_stderr)?;
    Some(format!(
        "`cargo xtask{call}`: {}",
        error.to_string().lines().next().unwrap_or_default()
    ))
}

/// Returns the commands of a console block. All other lines are output.
fn commands(text: &str) -> String {
    text.lines()
        .filter_map(|line| line.strip_prefix("$ "))
        .collect::<Vec<_>>()
        .join("\n")
}

/// Returns the blocks, and the line of a fence that never closes.
pub(crate) fn blocks(text: &str) -> (Vec<Block>, Option<usize>) {
    let mut done = Vec::new();
    let mut open: Option<Block> = None;
    for (index, line) in text.lines().enumerate() {
        let fence = line.trim_start().strip_prefix("```");
        match (fence, open.take()) {
            (Some(_), Some(block)) => done.push(block),
            (Some(info), None) => {
                let language = info
                    .trim()
                    .split([',', ' '])
                    .next()
                    .unwrap_or_default()
                    .to_owned();
                open = Some(Block {
                    line: index + 1,
                    language,
                    text: String::new(),
                });
            }
            (None, Some(mut block)) => {
                block.text.push_str(line);
                block.text.push('\n');
                open = Some(block);
            }
            (None, None) => {}
        }
    }
    (done, open.map(|block| block.line))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<(usize, String)> {
        let found = check_page(&File::new("README.md", text));
        found
            .into_iter()
            .map(|violation| (violation.line, violation.message))
            .collect()
    }

    #[test]
    fn blocks_that_parse_pass() {
        let text = "```rust,no_run\n# use a::b;\nfn c() -> d { e!(\"}\") }\n```\n\
            ```sh\ncargo xtask tidy   # the gate\ncd a && cargo xtask test --only fmt\n```\n\
            ```console\n$ cargo xtask --help\n(what it says\n```\n```text\n(\n```\n";
        assert_eq!(found(text), []);
    }

    #[test]
    fn blocks_that_do_not_parse_fail() {
        assert_eq!(found("a\n```rust\nfn c( {}\n```\n")[0].0, 2);
        assert_eq!(
            found("```sh\nif true\n```\n"),
            [(1, "these commands do not parse".to_owned())]
        );
        assert_eq!(found("```console\n$ echo (\n```\n").len(), 1);
    }

    #[test]
    fn verbs_that_do_not_exist_fail() {
        let found = found("```sh\ncargo xtask tidi\n```\n");
        assert_eq!(
            found,
            [(
                1,
                "`cargo xtask tidi`: error: unrecognized subcommand 'tidi'".to_owned()
            )]
        );
    }

    #[test]
    fn a_fence_that_never_closes_fails() {
        assert_eq!(found("a\n```sh\n"), [(2, "a fence that never closes".to_owned())]);
    }
}
