//! The results of an experiment on their way to files and to the terminal.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use jde_experiment::Experiment;
use jde_experiment::result::{DriveResult, Outcome};
use jde_experiment::summary::{self, Summary};

use crate::failure::display_path;

/// The results, in any order.
pub(super) struct Results<'e> {
    pub(super) experiment: &'e Experiment,
    pub(super) folder: PathBuf,
    pub(super) results: Vec<DriveResult>,
}

impl<'e> Results<'e> {
    pub(super) fn new(experiment: &'e Experiment, folder: &Path, results: Vec<DriveResult>) -> Self {
        Self {
            experiment,
            folder: folder.to_owned(),
            results,
        }
    }

    /// Writes all files.
    ///
    /// # Errors
    /// One of them cannot be written.
    pub(super) fn write(&self) -> io::Result<()> {
        let file = display_path(&self.experiment.file);
        let command = |drive: usize| format!("jde experiment {file} --drive {drive}");
        let summary = Summary {
            name: &self.experiment.name,
            doc: &self.experiment.doc,
            columns: &self.experiment.columns,
            results: &self.results,
            world: &|result| self.experiment.world_of(result.drive),
            robot: self.experiment.robot.as_ref(),
            command: &command,
        };
        summary::write_all(&self.folder, &summary)
    }

    /// Returns the number of drives by outcome, and of all.
    pub(super) fn counts(&self) -> BTreeMap<&'static str, usize> {
        let mut counts: BTreeMap<_, _> = Outcome::ALL.map(|outcome| (outcome.word(), 0)).into();
        for result in &self.results {
            *counts.entry(result.outcome.word()).or_default() += 1;
        }
        counts.insert("drives", self.results.len());
        counts
    }
}
