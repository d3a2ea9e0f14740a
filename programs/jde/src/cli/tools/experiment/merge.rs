//! `jde experiment merge`: joins the results of parts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_experiment::folder::{Existing, FolderState, ResultsFolder};
use jde_experiment::store::read_results;

use super::results::Results;
use super::{conclude, folder_failure, read};
use crate::failure::{Failure, display_path};

/// Join the results of the parts of an experiment, as if one machine had run all drives.
///
/// The folders hold what `jde experiment FILE --shard K/N --out DIR` wrote, on any machine. The experiment
/// and what it names must be here too, and unchanged.
#[derive(Args)]
#[command(after_help = "Example:
  jde experiment merge part-* --out results")]
pub(super) struct Merge {
    /// The folders of the parts.
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath, required = true)]
    parts: Vec<PathBuf>,
    /// The folder of the joined results.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    out: PathBuf,
    /// Replace results that the folder holds.
    #[arg(long = "replace")]
    replace: bool,
}

impl Merge {
    /// Runs the verb.
    pub(super) fn run(self) -> Result<(), Failure> {
        let first = &self.parts[0];
        let state = FolderState::read(first).map_err(folder_failure)?;
        let (experiment, mut applications) = read(&state.file, None)?;
        let whole = FolderState::new(&experiment, &mut applications, BTreeSet::new())?;
        let mut results = BTreeMap::new();
        for part in &self.parts {
            let mut state = FolderState::read(part).map_err(folder_failure)?;
            state.shards = BTreeSet::new();
            state.expect_same(&whole, part).map_err(folder_failure)?;
            let read = read_results(&part.join("results.jsonl"), &experiment.columns);
            let read = read.map_err(|error| Failure::broken(error.to_string()))?;
            results.extend(read.into_iter().map(|result| (result.drive, result)));
        }
        let existing = if self.replace {
            Existing::Replace
        } else {
            Existing::Refuse
        };
        let (folder, _) =
            ResultsFolder::prepare(&self.out, &whole, &experiment, existing).map_err(folder_failure)?;
        let missing = experiment.drives() - results.len();
        let results = Results::new(&experiment, folder.path(), results.into_values().collect());
        results.write().map_err(Failure::file(folder.path()))?;
        if missing > 0 {
            let parts: Vec<_> = self.parts.iter().map(|part| display_path(part)).collect();
            return Err(Failure::broken(format!(
                "{missing} drives are in none of {}: run the parts that are missing, or --resume those that were interrupted",
                parts.join(", ")
            )));
        }
        conclude(&results, &experiment.file, false, 0)
    }
}
