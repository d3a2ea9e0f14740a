//! A recording of a run: begun before the run, so that nobody hears afterwards that nothing could be written, and ended with it.
//! How values reach the file is the business of `jde-log`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_host::app::Application;
use jde_host::event::Observer;
use jde_host::{BeforeStart, StartError};
use jde_log::{Error, Options, Origin, Recorder, Selection};
use serde::Serialize;

use crate::failure::{Failure, shown};

/// What to record, and where.
pub(crate) struct Record {
    /// The file.
    pub(crate) file: PathBuf,
    /// Patterns of the variables to keep; none for all.
    pub(crate) only: Vec<String>,
    /// Write over what is there.
    pub(crate) overwrite: bool,
}

/// What came of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Recorded {
    /// The file.
    pub(crate) file: String,
    /// Messages in it.
    pub(crate) kept: u64,
    /// Values and events that are not.
    pub(crate) lost: u64,
    /// Its bytes.
    pub(crate) bytes: u64,
    /// Why nothing was written any more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) trouble: Option<String>,
}

/// A recording under way.
pub(crate) struct Recording {
    recorder: Arc<Recorder>,
    selection: Selection,
    file: PathBuf,
}

impl Recording {
    /// Begins it. In virtual time nothing is lost: the run waits for the disk.
    ///
    /// # Errors
    /// The file cannot be written, or a pattern fits no variable.
    pub(crate) fn begin(record: &Record, application: &Application, lockstep: bool) -> Result<Self, Failure> {
        let names = jde_log::variables(application);
        let selection = Selection::new(record.only.clone(), &names).map_err(|unknown| {
            Failure::usage(
                unknown.to_string(),
                "a pattern is a variable's full name, with `*` for any letters: `pioneer.*`, `*.laser`",
            )
        })?;
        let file = record.file.clone();
        let named = shown(&file);
        let options = Options {
            origin: Origin::of(application),
            application: Some(application),
            overwrite: record.overwrite,
            lossless: lockstep,
            on_trouble: Box::new(move |trouble| {
                tracing::error!("the recording {named} ends here, and the run goes on: {trouble}");
            }),
        };
        let recorder = Recorder::create(&file, options).map_err(|error| failure(error, &file))?;
        Ok(Self {
            recorder: Arc::new(recorder),
            selection,
            file,
        })
    }

    /// Hears what happens.
    pub(crate) fn observer(&self) -> Box<dyn Observer> {
        self.recorder.observer()
    }

    /// Watches the variables of an application from their first value on.
    pub(crate) fn before_start(&self) -> BeforeStart {
        let (recorder, selection) = (Arc::clone(&self.recorder), self.selection.clone());
        Box::new(move |handle| {
            for variable in handle.board().list() {
                if selection.has(&variable.describe().full_name()) {
                    let handle = handle.clone();
                    recorder.watch(&variable, Arc::new(move || handle.now()));
                }
            }
        })
    }

    /// Writes the rest, and says what came of it.
    pub(crate) fn finish(&self) -> Recorded {
        let status = self.recorder.finish();
        Recorded {
            file: shown(&self.file),
            kept: status.kept,
            lost: status.lost,
            bytes: status.bytes,
            trouble: status.trouble,
        }
    }
}

fn failure(error: Error, file: &Path) -> Failure {
    match error {
        Error::Exists(_) => Failure::usage(
            format!("{} exists already", shown(file)),
            "give the recording another name, or add --overwrite",
        ),
        Error::Create { path, error } => Failure::File { path, error },
        Error::Thread(error) => Failure::Start(StartError::Thread(error)),
    }
}
