//! The folder of an experiment's results: what it belongs to, and the drives that are done. Each result is
//! written and synced when it is known, so nothing is lost if the machine stops.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Read as _, Write};
use std::path::{Path, PathBuf};

use jde_abi::describe::Role;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::applications::Applications;
use crate::experiment::{AxisValues, Experiment};
use crate::result::DriveResult;
use crate::store::{ReadResultsError, read_results, replace};

/// The file of the results.
const RESULTS: &str = "results.jsonl";

/// The file that states what a folder belongs to.
const STATE: &str = "experiment.json";
/// The largest file of the state, bytes.
const MAX_STATE: u64 = 1 << 20;

/// What a folder of results belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FolderState {
    /// The version of jde that made the results.
    #[serde(default)]
    pub version: String,
    /// The experiment's file.
    pub file: PathBuf,
    /// The fingerprint of the experiment, its application, its worlds and its plugins.
    pub fingerprint: String,
    /// The number of drives of the experiment.
    pub drives: usize,
    /// The parts of the experiment that the folder is for, `[number, of]`; all drives if it is empty.
    pub shards: BTreeSet<[usize; 2]>,
}

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// It holds results already.
    #[error("{} holds results already", .0.display())]
    Occupied(PathBuf),
    /// It holds no results of an experiment.
    #[error("{} holds no results of an experiment", .0.display())]
    Empty(PathBuf),
    /// Its results are those of another experiment.
    #[error("the results in {} are those of {what}", folder.display())]
    Other {
        /// The folder.
        folder: PathBuf,
        /// What differs.
        what: String,
    },
    /// Its results are damaged.
    #[error(transparent)]
    Damaged(#[from] ReadResultsError),
}

/// A folder that receives results.
pub struct ResultsFolder {
    path: PathBuf,
    lines: File,
    /// The folder that has the results of before, if they were set aside.
    pub before: Option<PathBuf>,
}

/// How to treat results that a folder holds already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Refuse the folder.
    Refuse,
    /// Delete them.
    Replace,
    /// Keep them in the folder beside it that has its name and [`ResultsFolder::BEFORE`], in place of older ones.
    SetAside,
    /// Keep them if they are of the same experiment, and go on.
    Resume,
}

impl ResultsFolder {
    /// The end of the name of a folder with the results of before.
    pub const BEFORE: &str = ".before";

    /// Prepares a folder. Returns it with the results that it holds and that are kept.
    ///
    /// # Errors
    /// [`FolderError`]
    pub fn prepare(
        path: &Path,
        state: &FolderState,
        experiment: &Experiment,
        existing: Existing,
    ) -> Result<(Self, Vec<DriveResult>), FolderError> {
        let results = path.join(RESULTS);
        let is_occupied = is_occupied(path);
        let before = match existing {
            Existing::SetAside if is_occupied => Some(set_aside(path)?),
            Existing::SetAside | Existing::Refuse | Existing::Replace | Existing::Resume => None,
        };
        fs::create_dir_all(path).map_err(file_error(path))?;
        let kept = match existing {
            Existing::Refuse if is_occupied => return Err(FolderError::Occupied(path.to_owned())),
            Existing::Resume if is_occupied => {
                let found = FolderState::read(path)?;
                found.expect_same(state, path)?;
                // There are none if the call that wrote the state was killed at once.
                if results.exists() {
                    read_results(&results, &experiment.columns)?
                } else {
                    Vec::new()
                }
            }
            Existing::Refuse | Existing::Replace | Existing::SetAside | Existing::Resume => Vec::new(),
        };
        let text = serde_json::to_string_pretty(state).expect("it has texts and numbers");
        let state_file = path.join(STATE);
        replace(&state_file, |output| writeln!(output, "{text}")).map_err(file_error(&state_file))?;
        // A torn last line is left out. As a whole: if this is interrupted, the results before remain, and if another call
        // still writes to the folder, its lines go to the file that it opened and not between these.
        replace(&results, |output| {
            kept.iter()
                .try_for_each(|result| writeln!(output, "{}", result.to_line(&experiment.columns)))
        })
        .map_err(file_error(&results))?;
        let lines = File::options()
            .append(true)
            .open(&results)
            .map_err(file_error(&results))?;
        let path = path.to_owned();
        Ok((Self { path, lines, before }, kept))
    }

    /// Adds a result.
    ///
    /// # Errors
    /// The disk refuses it.
    pub fn add(&mut self, result: &DriveResult, experiment: &Experiment) -> io::Result<()> {
        self.lines
            .write_all((result.to_line(&experiment.columns) + "\n").as_bytes())?;
        self.lines.sync_data()
    }

    /// Returns the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl FolderState {
    /// Returns the state of a folder for these parts of an experiment.
    ///
    /// # Errors
    /// A file of the experiment cannot be read.
    pub fn new(
        experiment: &Experiment,
        applications: &mut Applications,
        shards: BTreeSet<[usize; 2]>,
    ) -> io::Result<Self> {
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            file: experiment.file.clone(),
            fingerprint: fingerprint(experiment, applications)?,
            drives: experiment.drives(),
            shards,
        })
    }

    /// Reads the state of a folder.
    ///
    /// # Errors
    /// It holds no results.
    pub fn read(folder: &Path) -> Result<Self, FolderError> {
        let path = folder.join(STATE);
        match jde_files::read_text(&path, MAX_STATE) {
            Ok(text) => serde_json::from_str(&text).map_err(|error| FolderError::File {
                error: io::Error::other(error),
                path,
            }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(FolderError::Empty(folder.to_owned()))
            }
            Err(error) => Err(FolderError::File { path, error }),
        }
    }

    /// Returns the drives of these parts, in order.
    #[must_use]
    pub fn own_drives(&self) -> Vec<usize> {
        let is_own = |drive: &usize| {
            let mut shards = self.shards.iter();
            self.shards.is_empty() || shards.any(|[number, of]| drive % of == number - 1)
        };
        (0..self.drives).filter(is_own).collect()
    }

    /// Checks that results in `folder`, which has this state, belong to the experiment of another state.
    ///
    /// # Errors
    /// What differs.
    pub fn expect_same(&self, other: &Self, folder: &Path) -> Result<(), FolderError> {
        let what = if self.version != other.version {
            // The first results have no version.
            let made_by = match &*self.version {
                "" => "an earlier jde".to_owned(),
                version => format!("jde {version}"),
            };
            format!("{made_by}, and this is jde {}", other.version)
        } else if self.fingerprint != other.fingerprint {
            "another experiment, or its application, a world or a plugin has changed since".to_owned()
        } else if self.shards != other.shards {
            "another part of the experiment".to_owned()
        } else {
            return Ok(());
        };
        let folder = folder.to_owned();
        Err(FolderError::Other { folder, what })
    }
}

/// Whether a folder holds results.
fn is_occupied(folder: &Path) -> bool {
    folder.join(RESULTS).exists() || folder.join(STATE).exists()
}

/// Renames a folder of results. Older ones of that name are deleted, and nothing else is. Returns the new path.
fn set_aside(folder: &Path) -> Result<PathBuf, FolderError> {
    let mut name = folder.as_os_str().to_owned();
    name.push(ResultsFolder::BEFORE);
    let before = PathBuf::from(name);
    if is_occupied(&before) {
        fs::remove_dir_all(&before).map_err(file_error(&before))?;
    }
    fs::rename(folder, &before).map_err(file_error(&before))?;
    Ok(before)
}

fn file_error(path: &Path) -> impl FnOnce(io::Error) -> FolderError {
    let path = path.to_owned();
    |error| FolderError::File { path, error }
}

/// Returns a digest of everything that determines the results: this program's version, and the content of
/// [`files`].
///
/// # Errors
/// One of the files cannot be read.
pub fn fingerprint(experiment: &Experiment, applications: &mut Applications) -> io::Result<String> {
    let mut digest = Sha256::new();
    digest.update(env!("CARGO_PKG_VERSION"));
    for file in files(experiment, applications)? {
        digest.update(digest_of(&file)?);
    }
    let hex = digest
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    Ok(hex)
}

/// Returns the digest of a file, which may be longer than the memory.
fn digest_of(path: &Path) -> io::Result<impl AsRef<[u8]>> {
    let (mut file, mut digest) = (jde_files::open(path)?, Sha256::new());
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(digest.finalize()),
            length => digest.update(&piece[..length]),
        }
    }
}

/// Returns the files that determine the results: the experiment, the application, the plugins, and the files
/// that modulations name.
///
/// # Errors
/// The application cannot be read any more.
pub fn files(experiment: &Experiment, applications: &mut Applications) -> io::Result<BTreeSet<PathBuf>> {
    let mut files = BTreeSet::from([experiment.file.clone(), experiment.application.clone()]);
    files.extend(experiment.recordings.iter().cloned());
    for variant in &experiment.variants {
        let plugins = applications.plugins(variant);
        let application = applications
            .load(&experiment.set, variant)
            .map_err(|faults| io::Error::other(faults.to_string()))?;
        files.extend(
            application
                .plugins
                .iter()
                .filter_map(|plugin| plugins.file_of(plugin)),
        );
        for instance in &application.instances {
            let modulations = instance.schema.ports.iter().zip(&instance.bindings);
            files.extend(modulations.filter_map(|(port, binding)| named_file(port, binding)));
        }
    }
    for axis in &experiment.axes {
        let AxisValues::Choices(choices) = &axis.values else {
            continue;
        };
        let values = choices.iter().flat_map(|choice| &choice.overrides);
        let paths = values.filter_map(|set| {
            serde_json::from_str::<PathBuf>(&set.value)
                .ok()
                .map(|path| set.folder.join(path))
        });
        files.extend(paths.filter(|path| path.is_file()));
    }
    Ok(files)
}

/// Returns the file that a modulation names, if there is one.
fn named_file(port: &jde_abi::describe::Port, binding: &jde_app::Binding) -> Option<PathBuf> {
    let jde_app::Binding::Modulation { initial, .. } = binding else {
        return None;
    };
    if !matches!(port.role, Role::Modulation { .. }) {
        return None;
    }
    let jde_board::value::Value::Text(path) =
        jde_board::value::decode(&port.value_type, initial).into_only_field()
    else {
        return None;
    };
    let is_path = jde_app::is_path(&port.unit, &path);
    is_path.then(|| PathBuf::from(path)).filter(|path| path.is_file())
}
