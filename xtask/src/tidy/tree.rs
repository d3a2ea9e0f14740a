//! The files that tidy reads, and the violations that it reports. Each file is read once; nothing is written.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::rust::{self, SourceLine};
use crate::metadata::folder;

/// A violation of one check.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Violation {
    /// The file, relative to the root of the workspace.
    pub(crate) path: String,
    /// The line, from 1.
    pub(crate) line: usize,
    /// What is wrong.
    pub(crate) message: String,
    /// What to do about it.
    pub(crate) help: String,
}

/// A text file of the workspace.
#[derive(Debug)]
pub(crate) struct File {
    /// Relative to the root of the workspace, with `/` between its parts.
    pub(crate) path: String,
    pub(crate) text: String,
    /// The lines of a Rust file, split into code, comments and literals; empty for other files.
    pub(crate) lines: Vec<SourceLine>,
}

/// All files that a check may read.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) root: PathBuf,
    pub(crate) files: Vec<File>,
}

impl Violation {
    pub(crate) fn new(
        path: impl Into<String>,
        line: usize,
        what: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            line,
            message: what.into(),
            help: help.into(),
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}:{}: {}\n    help: {}",
            self.path, self.line, self.message, self.help
        )
    }
}

impl File {
    pub(crate) fn new(path: impl Into<String>, text: impl Into<String>) -> Self {
        let (path, text) = (path.into(), text.into());
        let mut lines = if path.ends_with(".rs") {
            rust::scan(&text)
        } else {
            Vec::new()
        };
        if is_test(&path) {
            lines.iter_mut().for_each(|line| line.test = true);
        }
        Self { path, text, lines }
    }

    pub(crate) fn has_extension(&self, extensions: &[&str]) -> bool {
        let extension = Path::new(&self.path)
            .extension()
            .and_then(|extension| extension.to_str());
        extension.is_some_and(|extension| extensions.contains(&extension))
    }

    /// Returns the lines of a Rust file with their numbers, from 1.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (usize, &SourceLine)> {
        self.lines
            .iter()
            .enumerate()
            .map(|(index, line)| (index + 1, line))
    }
}

impl Tree {
    /// Reads the text files below `root`. Skips hidden folders, build output, and files of other types.
    pub(crate) fn read(root: &Path) -> Result<Self> {
        let mut files = Vec::new();
        walk(root, root, &mut files)?;
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(Self {
            root: root.to_owned(),
            files,
        })
    }

    pub(crate) fn with_extension<'a>(&'a self, extensions: &'a [&'a str]) -> impl Iterator<Item = &'a File> {
        self.files
            .iter()
            .filter(move |file| file.has_extension(extensions))
    }

    pub(crate) fn rust(&self) -> impl Iterator<Item = &File> {
        self.with_extension(&["rs"])
    }

    /// Returns the file at a path relative to the root.
    pub(crate) fn file(&self, path: &str) -> Option<&File> {
        self.files.iter().find(|file| file.path == path)
    }

    /// Makes a tree of the given files without a disk.
    #[cfg(test)]
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        let files = files.iter().map(|(path, text)| File::new(*path, *text)).collect();
        Self {
            root: PathBuf::from("no-such-root"),
            files,
        }
    }
}

/// The types of files that tidy reads; all others are data.
const EXTENSIONS: &[&str] = &["rs", "toml", "lock", "md", "sh", "c", "h", "cpp", "hpp", "cmake"];

fn walk(root: &Path, folder_path: &Path, files: &mut Vec<File>) -> Result<()> {
    let reading = || format!("cannot read {}", folder_path.display());
    for entry in std::fs::read_dir(folder_path).with_context(reading)? {
        let entry = entry.with_context(reading)?;
        let path = entry.path();
        let name = entry.file_name();
        let kind = entry.file_type().with_context(reading)?;
        if kind.is_dir() {
            let hidden = name.to_string_lossy().starts_with('.');
            let is_built = name == "target" || path.join("CMakeCache.txt").exists();
            if !hidden && !is_built {
                walk(root, &path, files)?;
            }
        } else if kind.is_file()
            && path
                .extension()
                .is_some_and(|extension| EXTENSIONS.iter().any(|known| extension == *known))
        {
            let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
            // A file that is not UTF-8 is a fixture of a test.
            if let Ok(text) = String::from_utf8(bytes) {
                files.push(File::new(folder(root, &path), text));
            }
        }
    }
    Ok(())
}

fn is_test(path: &str) -> bool {
    let mut parts = path.split('/').rev();
    parts.next().is_some_and(|name| name == "tests.rs") || parts.any(|folder| folder == "tests")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_tests_are_tests_to_the_last_line() {
        let tests = |path: &str| File::new(path, "fn a() {}\n").lines[0].test;
        assert!(tests("runtime/host/tests/app/faults.rs"));
        assert!(tests("runtime/host/src/app/tests.rs"));
        assert!(tests("runtime/host/src/app/tests/mod.rs"));
        assert!(!tests("runtime/host/src/tests_of_life.rs"));
    }

    #[test]
    fn a_violation_has_its_place_the_fault_and_the_remedy() {
        let violation = Violation::new("a.rs", 3, "a tab", "use spaces");
        assert_eq!(violation.to_string(), "a.rs:3: a tab\n    help: use spaces");
    }
}
