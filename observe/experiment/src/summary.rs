//! The files of an experiment's results. The same results give the same files, to the bit.

use std::io;
use std::path::{Path, PathBuf};

use jde_sim::Footprint;

use crate::result::{Columns, DriveResult};
use crate::store::{replace, sorted, write_results};
use crate::{csv, junit, page};

/// Everything that the files need.
pub struct Summary<'a> {
    /// The name of the experiment.
    pub name: &'a str,
    /// What it is for; may be empty.
    pub doc: &'a str,
    /// The columns of the results.
    pub columns: &'a Columns,
    /// The results, in any order.
    pub results: &'a [DriveResult],
    /// The world file of a drive; `None` if it has none.
    pub world: &'a dyn Fn(&DriveResult) -> Option<PathBuf>,
    /// The body of the robot, if it is known.
    pub robot: Option<&'a Footprint>,
    /// The command that repeats a drive, by its number.
    pub command: &'a dyn Fn(usize) -> String,
}

/// Writes `results.jsonl`, `results.csv`, `junit.xml` and `report.html` into a folder that exists. Each
/// replaces the old one as a whole.
///
/// # Errors
/// A file cannot be written; the ones before it are new then.
pub fn write_all(folder: &Path, summary: &Summary<'_>) -> io::Result<()> {
    let Summary {
        name,
        columns,
        command,
        ..
    } = summary;
    let results = sorted(summary.results);
    write_results(&folder.join("results.jsonl"), columns, summary.results)?;
    replace(&folder.join("results.csv"), |output| {
        csv::write(output, columns, &results)
    })?;
    replace(&folder.join("junit.xml"), |output| {
        junit::write(output, name, columns, &results, command)
    })?;
    replace(&folder.join("report.html"), |output| {
        output.write_all(page::html(summary).as_bytes())
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;

    use super::*;
    use crate::result::Outcome;

    #[test]
    fn the_files_do_not_depend_on_the_order_of_the_results() {
        let columns = Columns {
            axes: vec!["seed".into()],
            ..Columns::default()
        };
        let result = |drive: usize| DriveResult {
            drive,
            axes: vec![json!(drive + 1)],
            outcome: Outcome::Crashed,
            end: String::new(),
            seconds: 1.5,
            properties: Vec::new(),
            measures: Vec::new(),
            why: "signal 11".into(),
            failure: None,
        };
        let files = |results: &[DriveResult]| {
            let folder = tempfile::tempdir().unwrap();
            let summary = Summary {
                name: "safe",
                doc: "",
                columns: &columns,
                results,
                world: &|_| None,
                robot: None,
                command: &|drive| format!("jde experiment safe --drive {drive}"),
            };
            write_all(folder.path(), &summary).unwrap();
            let mut files: Vec<_> = fs::read_dir(folder.path())
                .unwrap()
                .map(|entry| entry.unwrap())
                .map(|entry| (entry.file_name(), fs::read_to_string(entry.path()).unwrap()))
                .collect();
            files.sort();
            files
        };
        let sorted = files(&[result(0), result(1), result(2)]);
        let names: Vec<_> = sorted.iter().map(|(name, _)| name.clone()).collect();
        assert_eq!(
            names,
            ["junit.xml", "report.html", "results.csv", "results.jsonl"]
        );
        assert!(
            sorted.iter().all(|(_, text)| text.contains("signal 11")),
            "{sorted:?}"
        );
        assert_eq!(files(&[result(2), result(0), result(1)]), sorted);
    }
}
