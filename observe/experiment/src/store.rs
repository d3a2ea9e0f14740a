//! `results.jsonl`: read, also after an interruption, and written anew in the order of the drives. A file is
//! replaced as a whole: a reader finds the old one or the new one.
//!
//! It joins nothing and decides nothing about results that are there twice.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::result::{Columns, DriveResult};

/// Why results cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadResultsError {
    /// The file cannot be read.
    #[error("cannot read the results `{}`: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
    /// A line is not a result with these columns.
    #[error(
        "{}:{line}: this line is no result of this experiment; remove it, and `--resume` repeats its drive",
        path.display()
    )]
    Line {
        /// The file.
        path: PathBuf,
        /// The number of the line, from 1.
        line: usize,
    },
}

/// The largest file of results, bytes: hundreds of thousands of drives.
const MAX_RESULTS: u64 = 512 << 20;

/// Reads the results of an experiment with these columns, in the order of the file. The last line is left out
/// if it has no end: its writer was interrupted.
///
/// # Errors
/// [`ReadResultsError`].
pub fn read_results(path: &Path, columns: &Columns) -> Result<Vec<DriveResult>, ReadResultsError> {
    let bytes = jde_files::read(path, MAX_RESULTS).map_err(|error| ReadResultsError::File {
        path: path.to_owned(),
        error,
    })?;
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').unwrap_or(0);
    let lines = bytes[..whole].split(|byte| *byte == b'\n').enumerate();
    lines
        .filter(|(_, line)| !line.trim_ascii().is_empty())
        .map(|(number, line)| {
            let text = str::from_utf8(line).ok();
            let result = text.and_then(|text| DriveResult::from_json(text, columns));
            result.ok_or_else(|| ReadResultsError::Line {
                path: path.to_owned(),
                line: number + 1,
            })
        })
        .collect()
}

/// Writes the results in the order of their drives, and replaces the file as a whole.
///
/// # Errors
/// The file cannot be written; then the old one remains.
pub fn write_results(path: &Path, columns: &Columns, results: &[DriveResult]) -> io::Result<()> {
    replace(path, |output| {
        sorted(results)
            .iter()
            .try_for_each(|result| writeln!(output, "{}", result.to_line(columns)))
    })
}

/// The results in the order of their drives.
pub(crate) fn sorted(results: &[DriveResult]) -> Vec<&DriveResult> {
    let mut sorted: Vec<&DriveResult> = results.iter().collect();
    sorted.sort_by_key(|result| result.drive);
    sorted
}

/// Replaces a file by what `write` writes in small pieces, as a whole.
pub(crate) fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    jde_files::replace(path, |file| {
        let mut output = BufWriter::new(file);
        write(&mut output)?;
        output.flush()
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;

    use super::*;
    use crate::result::Outcome;

    fn columns() -> Columns {
        Columns {
            axes: vec!["seed".into()],
            ..Columns::default()
        }
    }

    fn result(drive: usize) -> DriveResult {
        DriveResult {
            drive,
            axes: vec![json!(drive + 1)],
            outcome: Outcome::Passed,
            end: "done".into(),
            seconds: 1.5,
            properties: Vec::new(),
            measures: Vec::new(),
            why: String::new(),
            failure: None,
        }
    }

    /// The lines of two results, as a file.
    fn file() -> (tempfile::TempDir, PathBuf, String) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.jsonl");
        write_results(&path, &columns(), &[result(1), result(0)]).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        (folder, path, text)
    }

    #[test]
    fn results_are_written_in_the_order_of_their_drives() {
        let (folder, path, _) = file();
        assert_eq!(read_results(&path, &columns()).unwrap(), [result(0), result(1)]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing remains");
    }

    #[test]
    fn a_torn_last_line_is_left_out() {
        let (_folder, path, text) = file();
        for end in [text.len() - 1, text.len() - 2, text.find('\n').unwrap() + 2] {
            fs::write(&path, &text[..end]).unwrap();
            assert_eq!(read_results(&path, &columns()).unwrap(), [result(0)], "{end}");
        }
        fs::write(&path, "").unwrap();
        assert_eq!(read_results(&path, &columns()).unwrap(), []);
    }

    #[test]
    fn a_damaged_line_is_named() {
        let (_folder, path, text) = file();
        for damage in ["{\"drive\":0}", "\u{0}\u{0}"] {
            fs::write(&path, format!("{text}\n{damage}\n{text}")).unwrap();
            let error = read_results(&path, &columns()).unwrap_err();
            assert!(
                matches!(&error, ReadResultsError::Line { line: 4, .. }),
                "{error}"
            );
            assert!(error.to_string().contains("results.jsonl:4: "), "{error}");
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = read_results(Path::new("no-such-folder/results.jsonl"), &columns()).unwrap_err();
        assert!(
            error.to_string().contains("no-such-folder/results.jsonl"),
            "{error}"
        );
    }
}
