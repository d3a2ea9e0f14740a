//! Does what the pages of docs/tutorial say: writes the files that they show, applies their changes, runs their
//! commands, and compares the output.
//!
//! All pages share one folder, and each begins there. A page that exists in several languages is followed in one of
//! them, and all pages are followed once for each language. In the output that a page shows, a line `...` stands for any
//! lines, and `...` in a line for any text. A command fails if and only if its output begins with an error.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};

use crate::pytest::Python;
use crate::step::StepOutcome;
use crate::test::Context;
use crate::tidy::fences::{Block, blocks};
use crate::{project_files, shell};

const FOLDER: &str = "docs/tutorial";
/// The languages, as the names of pages end with them: `03-a-schema-in-rust.md`.
const LANGUAGES: &[&str] = &["rust", "python", "cpp"];
/// The limit of each command: ten times what the slowest takes, a build.
const COMMAND_TIMEOUT: Duration = Duration::from_secs(600);
/// What stands for any lines or any text.
const ANY_TEXT: &str = "...";

/// Something that a page tells the reader to do.
#[derive(Debug, PartialEq, Eq)]
enum Action<'p> {
    Write { file: &'p str, text: &'p str },
    Change(&'p str),
    Run { command: &'p str, output: Vec<&'p str> },
}

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    let mut pages: Vec<PathBuf> = fs::read_dir(context.root.join(FOLDER))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    pages.sort();
    let Some(python) = Python::new(context)? else {
        return Python::missing(context);
    };
    for language in LANGUAGES {
        let reader = TutorialReader::new(context, language, &python)?;
        for page in pages.iter().filter(|page| is_for(page, language)) {
            println!("{language}: {}", page.display());
            reader.follow(page)?;
        }
    }
    Ok(StepOutcome::Passed)
}

/// Whether those who use a language read a page.
fn is_for(page: &Path, language: &str) -> bool {
    let name = page.file_stem().unwrap_or_default().to_string_lossy();
    name.rsplit_once("-in-").is_none_or(|(_, only)| only == language)
}

/// Returns what a block of a page tells the reader to do.
fn actions<'b>(page: &'b str, block: &'b Block) -> Result<Vec<Action<'b>>> {
    Ok(match block.language.as_str() {
        "console" => commands(&block.text),
        "diff" => vec![Action::Change(&block.text)],
        _ => {
            let before = page.lines().take(block.line - 1);
            let before = before.filter(|line| !line.is_empty()).last().unwrap_or_default();
            let named = before.trim_end().strip_suffix("`:");
            let file = named.and_then(|before| Some(before.rsplit_once('`')?.1));
            let file = file
                .context("the line before this block does not end with the name of a file, as `app.toml`:")?;
            vec![Action::Write {
                file,
                text: &block.text,
            }]
        }
    })
}

/// Returns the commands of a block, each with the output that the page shows.
fn commands(text: &str) -> Vec<Action<'_>> {
    let mut commands = Vec::new();
    for line in text.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            commands.push(Action::Run {
                command,
                output: Vec::new(),
            });
        } else if let Some(Action::Run { output, .. }) = commands.last_mut() {
            output.push(line);
        }
    }
    commands
}

/// Does what pages say, in a folder of its own, with the development build.
struct TutorialReader {
    folder: PathBuf,
    variables: Vec<(&'static str, OsString)>,
}

impl TutorialReader {
    fn new(context: &Context, language: &str, python: &Python) -> Result<Self> {
        let folder = context.target.join("tutorial").join(language);
        project_files::empty(&folder)?;
        // Git applies a change to a folder of a project only if that is a project of its own.
        shell::read(Command::new("git").args(["init", "--quiet"]).current_dir(&folder))?;
        let programs = context.target.join("debug");
        let tests = python.interpreter.parent().map(Path::to_owned);
        let path = env::var_os("PATH").unwrap_or_default();
        let path = tests
            .into_iter()
            .chain([programs.clone()])
            .chain(env::split_paths(&path));
        let variables = vec![
            ("PATH", env::join_paths(path)?),
            ("PYTHONPATH", python.packages.clone().into()),
            ("JDE_PLUGIN_PATH", programs.into()),
            ("CARGO_NET_OFFLINE", "true".into()),
        ];
        Ok(Self { folder, variables })
    }

    /// Does what a page says.
    fn follow(&self, page: &Path) -> Result<()> {
        let text = fs::read_to_string(page)?;
        let mut folder = self.folder.clone();
        for block in &blocks(&text).0 {
            let place = || format!("{}:{}", page.display(), block.line);
            for action in actions(&text, block).with_context(place)? {
                self.act(&action, &mut folder).with_context(place)?;
            }
        }
        Ok(())
    }

    fn act(&self, action: &Action<'_>, folder: &mut PathBuf) -> Result<()> {
        match action {
            Action::Write { file, text } => {
                let file = folder.join(file);
                fs::create_dir_all(file.parent().unwrap_or(folder))?;
                fs::write(file, text)?;
            }
            Action::Change(change) => {
                let file = self.folder.join("change.diff");
                fs::write(&file, change)?;
                let mut git = Command::new("git");
                shell::read(
                    git.args(["apply", "--unidiff-zero"])
                        .arg(&file)
                        .current_dir(folder),
                )?;
            }
            Action::Run { command, output } => match command.strip_prefix("cd ") {
                Some(to) => folder.push(to),
                None => self.run(command, output, folder)?,
            },
        }
        Ok(())
    }

    /// Runs a command, and compares what it prints with the output that the page shows, if it shows any.
    fn run(&self, command: &str, expected: &[&str], folder: &Path) -> Result<()> {
        println!("  $ {command}");
        let mut bash = Command::new("bash");
        bash.args(["-c", &format!("exec 2>&1; {command}")])
            .envs(self.variables.iter().cloned())
            .env_remove("CARGO_TARGET_DIR")
            .current_dir(folder);
        let (status, text) = shell::end_within(&mut bash, COMMAND_TIMEOUT)?;
        let shows_error = expected.first().is_some_and(|line| line.starts_with("error"));
        ensure!(
            status.success() != shows_error,
            "`{command}` ended with {status}:\n{text}"
        );
        let lines: Vec<&str> = text.trim_end().lines().collect();
        if !expected.is_empty() && !fits(expected, &lines) {
            bail!(
                "`{command}` printed\n{text}\nand the page shows\n{}",
                expected.join("\n")
            );
        }
        Ok(())
    }
}

/// Whether lines are those that a page shows.
fn fits(shown: &[&str], lines: &[&str]) -> bool {
    match (shown, lines) {
        ([], []) => true,
        ([ANY_TEXT, later @ ..], _) => (0..=lines.len()).any(|skipped| fits(later, &lines[skipped..])),
        ([first, later @ ..], [line, rest @ ..]) => line_fits(first, line) && fits(later, rest),
        _ => false,
    }
}

/// Whether a line is one that a page shows.
fn line_fits(shown: &str, line: &str) -> bool {
    let mut parts = shown.trim_end().split(ANY_TEXT);
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = line.trim_end().strip_prefix(first) else {
        return false;
    };
    let mut parts = parts.peekable();
    let is_open = parts.peek().is_some();
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        match rest.split_once(part) {
            Some((_, after)) => rest = after,
            None => return false,
        }
    }
    is_open || rest.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_names_files_and_shows_commands_with_their_output() {
        let page = "Text, `a/b.toml`:\n\n```toml\nx = 1\n```\n```console\n$ ls\na\n$ true\n```\n";
        let (blocks, _) = blocks(page);
        let write = Action::Write {
            file: "a/b.toml",
            text: "x = 1\n",
        };
        assert_eq!(actions(page, &blocks[0]).unwrap(), [write]);
        let run = |command, output| Action::Run { command, output };
        assert_eq!(
            actions(page, &blocks[1]).unwrap(),
            [run("ls", vec!["a"]), run("true", vec![])]
        );
        let page = "Text.\n\n```toml\nx = 1\n```\n";
        assert!(actions(page, &super::blocks(page).0[0]).is_err());
    }

    #[test]
    fn a_page_in_a_language_is_for_those_who_use_it() {
        assert!(is_for(Path::new("03-a-schema-in-cpp.md"), "cpp"));
        assert!(!is_for(Path::new("03-a-schema-in-cpp.md"), "rust"));
        assert!(is_for(Path::new("04-who-acts.md"), "rust"));
    }

    #[test]
    fn output_fits_what_a_page_shows() {
        let lines = ["one 1.5 s", "", "two"];
        for shown in [
            &["one 1.5 s", "", "two"][..],
            &["one ... s", ANY_TEXT],
            &[ANY_TEXT, "two"],
            &[ANY_TEXT, "", ANY_TEXT],
            &[ANY_TEXT],
        ] {
            assert!(fits(shown, &lines), "{shown:?}");
        }
        for shown in [
            &["one 1.5 s"][..],
            &["one ... m", ANY_TEXT],
            &[ANY_TEXT, "three"],
            &["two", ANY_TEXT],
            &[],
        ] {
            assert!(!fits(shown, &lines), "{shown:?}");
        }
    }
}
