//! Modulations that differ from the application's file, for every tool: which ones, how to set one back, and how to write
//! them to the file. What a father modulates is no difference. It writes only files of this machine.

use std::io;
use std::path::Path;

use jde_app::Faults;
use jde_app::tuning::{self, Tuning, is_same};
use jde_board::value::Value;

use crate::message::{Action, Schemas, VariableInfo};
use crate::{Remote, Sample, value, whoami};

/// The key of a schema's period, which has an action of its own.
const PERIOD: &str = "period";
/// How values of operators are marked; those of the start have no writer.
const OPERATOR: &str = "operator";

/// A modulation whose value differs from the application's file as it was when the run began, or was set back to that.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The modulation.
    pub info: VariableInfo,
    /// What the file stated when the run began, or the default of the type.
    pub file: Value,
    /// What holds now.
    pub now: Value,
}

impl Tuned {
    /// Compares the newest value of a variable with what the file stated when the run began. `None` if they are the same, if
    /// the variable is no modulation, or if a schema has written it.
    #[must_use]
    pub fn of(info: &VariableInfo, newest: &Sample) -> Option<Self> {
        Self::by_hand(info, newest).filter(|tuned| !tuned.is_back())
    }

    /// As [`of`](Self::of), and also what an operator has set back: the file may state another value now.
    #[must_use]
    pub fn with_back(info: &VariableInfo, newest: &Sample) -> Option<Self> {
        Self::by_hand(info, newest).filter(|tuned| newest.writer == OPERATOR || !tuned.is_back())
    }

    fn by_hand(info: &VariableInfo, newest: &Sample) -> Option<Self> {
        let file = value::from_json(info.stated.as_ref()?).ok()?;
        let now = newest.value()?.into_only_field_of(&newest.value_type);
        let by_hand = newest.writer.is_empty() || newest.writer == OPERATOR;
        by_hand.then(|| Self {
            info: info.clone(),
            file: file.into_only_field_of(&newest.value_type),
            now,
        })
    }

    /// Whether the value of the run's start holds.
    fn is_back(&self) -> bool {
        is_same(&self.file, &self.now)
    }

    /// The action of an operator that sets it back to the value of the run's start.
    #[must_use]
    pub fn back(&self) -> Action {
        let schema = self.info.owner.clone();
        match (self.info.variable.as_str(), self.file.as_number()) {
            (PERIOD, Some(period_s)) => Action::Period { schema, period_s },
            (variable, _) => Action::Modulate {
                schema,
                variable: variable.to_owned(),
                value: value::to_json(&self.file),
            },
        }
    }
}

/// Why nothing is written.
#[derive(Debug, thiserror::Error)]
pub enum NotSaved {
    /// The file is on another machine.
    #[error("{file} is on {host}; write it there: ssh {host} jde tuned --save")]
    Elsewhere {
        /// The file.
        file: String,
        /// The machine.
        host: String,
    },
    /// The folder in which the application was started is not known, and its file is stated relative to it.
    #[error("the folder of {file} is not known, because {link} cannot be read: {error}")]
    Folder {
        /// The file.
        file: String,
        /// The link to the folder.
        link: String,
        /// Why it cannot be read.
        error: io::Error,
    },
    /// The type of a modulation cannot be read.
    #[error("the type of {0}")]
    Type(String),
    /// The file cannot be read or written, or was changed since.
    #[error("{0}")]
    File(Faults),
}

/// Writes values to the application's file, which keeps its comments. Returns what is written, in lines. With `overwrite`,
/// also over what somebody has changed in the file since the run began. Waits for the disk.
///
/// # Errors
/// [`NotSaved`]; then nothing is written.
pub fn save(
    remote: &Remote,
    schemas: &Schemas,
    tuned: &[Tuned],
    overwrite: bool,
) -> Result<Vec<String>, NotSaved> {
    let about = remote.about();
    // Two machines may have one name, and a container of this machine has other files.
    if !remote.is_local() || about.host != whoami::host() {
        return Err(NotSaved::Elsewhere {
            file: about.file.clone(),
            host: about.host.clone(),
        });
    }
    let mut file = Path::new(&about.file).to_owned();
    if file.is_relative() {
        // It starts where the application was started.
        let link = format!("/proc/{}/cwd", about.pid);
        let folder = std::fs::read_link(&link).map_err(|error| NotSaved::Folder {
            file: about.file.clone(),
            link,
            error,
        })?;
        file = folder.join(file);
    }
    let tunings = tuned.iter().map(|tuned| tuning_of(tuned, schemas, overwrite));
    let tunings = tunings.collect::<Result<Vec<_>, _>>()?;
    tuning::save(&file, &tunings).map_err(NotSaved::File)
}

fn tuning_of(tuned: &Tuned, schemas: &Schemas, overwrite: bool) -> Result<Tuning, NotSaved> {
    let info = &tuned.info;
    let value_type = info
        .value_type()
        .map_err(|error| NotSaved::Type(format!("{}: {error}", info.name)))?;
    let schema = schemas.schemas.iter().find(|schema| schema.name == info.owner);
    let port = schema.and_then(|schema| schema.ports.iter().find(|port| port.name == info.variable));
    Ok(Tuning {
        schema: info.owner.clone(),
        name: info.variable.clone(),
        former_name: port.and_then(|port| port.former_name.clone()),
        value_type,
        unit: info.unit.clone(),
        choices: info.range.choices.clone(),
        before: (!overwrite).then(|| tuned.file.clone()),
        now: tuned.now.clone(),
        is_back: tuned.is_back(),
    })
}
