//! A recording of a run: begun before the run, so that nobody hears afterwards that nothing could be written, and ended with it.
//! How values reach the file is the business of `jde-log`.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use jde_core::Nanos;
use jde_host::app::Application;
use jde_host::event::Observer;
use jde_host::turn::OnTurn;
use jde_host::{BeforeStart, StartError};
use jde_log::trigger::{Condition, Names, Triggers};
use jde_log::{Error, Happened, Options, Origin, Recorder, Selection, Split, Status, When, Written};
use serde::Serialize;

use super::panels::{Chosen, Panels, Taking};
use crate::failure::{Failure, shown};

/// What to record, and where.
pub(crate) struct Record {
    /// The file.
    pub(crate) file: PathBuf,
    /// Patterns of the variables to keep; none for all.
    pub(crate) only: Vec<String>,
    /// Write over what is there.
    pub(crate) overwrite: bool,
    /// Panels to keep; none keeps none.
    pub(crate) panels: Option<Panels>,
    /// Write only what is around the moments at which a condition comes true; if not, everything.
    pub(crate) around: Option<Around>,
    /// Write one file after the other; if not, one.
    pub(crate) split: Option<Split>,
}

/// Which moments, and how much around them.
pub(crate) struct Around {
    /// The conditions, as they were written.
    pub(crate) conditions: Vec<String>,
    /// How much of what was before, ns.
    pub(crate) before: Nanos,
    /// How much of what comes after, ns.
    pub(crate) after: Nanos,
    /// Most bytes of the past in memory.
    pub(crate) memory: usize,
}

/// What came of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Recorded {
    /// The file; of the files that conditions asked for, the name before they are numbered.
    pub(crate) file: String,
    /// The files that conditions asked for; none if there are no conditions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) files: Option<Vec<RecordedFile>>,
    /// The files it is split into.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<RecordedParts>,
    /// Messages that had to go from memory before their time was up.
    #[serde(skip_serializing_if = "is_zero")]
    pub(crate) short: u64,
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

/// The files that a recording is split into.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordedParts {
    /// The name of the first.
    pub(crate) first: String,
    /// The name of the last.
    pub(crate) last: String,
    /// How many were written.
    pub(crate) count: u64,
    /// How many were deleted, those of recordings before included.
    pub(crate) deleted: u64,
    /// Those that were to be deleted and are there, because another recording writes them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) left: Vec<String>,
}

/// A file that a condition asked for.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordedFile {
    /// Its name.
    pub(crate) file: String,
    /// What came true.
    pub(crate) reason: String,
    /// When, s since the application's start.
    pub(crate) time_s: f64,
    /// How often conditions came true in its time.
    pub(crate) fired: u64,
    /// Messages in it.
    pub(crate) kept: u64,
    /// Messages of its time that are not.
    pub(crate) lost: u64,
    /// Its bytes.
    pub(crate) bytes: u64,
    /// Why it ends too soon.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) trouble: Option<String>,
}

/// A recording under way.
pub(crate) struct Recording {
    recorder: Arc<Recorder>,
    selection: Selection,
    on_turn: Option<OnTurn>,
    panels: Option<Chosen>,
    taking: Arc<Mutex<Option<Taking>>>,
    file: PathBuf,
    /// Files are written when conditions come true.
    waits: bool,
}

impl Recording {
    /// Begins it. In virtual time nothing is lost: the run waits for the disk.
    ///
    /// # Errors
    /// The file cannot be written, or a pattern fits no variable or no panel; then nothing is made or written over.
    pub(crate) fn begin(record: &Record, application: &Application, lockstep: bool) -> Result<Self, Failure> {
        let names = jde_log::variables(application);
        let selection = Selection::new(record.only.clone(), &names).map_err(|unknown| {
            Failure::usage(
                unknown.to_string(),
                "a pattern is a variable's full name, with `*` for any letters: `pioneer.*`, `*.laser`",
            )
        })?;
        let panels = record.panels.as_ref();
        let panels = panels.map(|panels| panels.of(application)).transpose()?;
        let file = record.file.clone();
        let named = shown(&file);
        let options = Options {
            origin: Origin::of(application, lockstep),
            application: Some(application),
            overwrite: record.overwrite,
            lossless: lockstep,
            on_trouble: Box::new(move |trouble| {
                tracing::error!("the recording {named} ends here, and the run goes on: {trouble}");
            }),
        };
        let recorder = match (&record.around, record.split) {
            (Some(around), _) => Recorder::wait(&file, options, when(around, Names::of(application))?),
            (None, Some(split)) => Recorder::split(&file, options, split),
            (None, None) => Recorder::create(&file, options),
        };
        let recorder = recorder.map_err(|error| no_recording(error, &file))?;
        Ok(Self {
            // What begins in the middle cannot be taken again.
            on_turn: record
                .around
                .is_none()
                .then(|| jde_log::turns(&recorder, application, lockstep)),
            recorder: Arc::new(recorder),
            selection,
            panels,
            taking: Arc::default(),
            file,
            waits: record.around.is_some(),
        })
    }

    /// Hears what happens.
    pub(crate) fn observer(&self) -> Box<dyn Observer> {
        self.recorder.observer()
    }

    /// Is told of every turn, so that `jde replay` can take it again.
    pub(crate) fn on_turn(&self) -> Option<OnTurn> {
        self.on_turn.clone()
    }

    /// Watches the variables of an application from their first value on.
    pub(crate) fn before_start(&self) -> BeforeStart {
        let (recorder, selection) = (Arc::clone(&self.recorder), self.selection.clone());
        let (panels, taking) = (self.panels.clone(), Arc::clone(&self.taking));
        Box::new(move |handle| {
            for variable in handle.board().list() {
                let handle = handle.clone();
                let clock = Arc::new(move || handle.now());
                if selection.has(&variable.describe().full_name()) {
                    recorder.watch(&variable, clock);
                } else {
                    recorder.look(&variable, clock);
                }
            }
            if let Some(panels) = &panels {
                let begun = Taking::begin(handle, &recorder, panels).map_err(Box::new)?;
                *taking.lock().unwrap_or_else(PoisonError::into_inner) = Some(begun);
            }
            Ok(())
        })
    }

    /// Writes the rest, and says what came of it.
    pub(crate) fn finish(&self) -> Recorded {
        drop(self.taking.lock().unwrap_or_else(PoisonError::into_inner).take());
        Recorded::of(&self.file, self.waits, self.recorder.finish())
    }
}

impl Recorded {
    /// What came of a recording that is finished; if it waited for conditions, file by file.
    pub(crate) fn of(file: &Path, waited: bool, status: Status) -> Self {
        let Status {
            kept,
            lost,
            bytes,
            trouble,
            files,
            short,
            parts,
            ..
        } = status;
        Self {
            file: shown(file),
            parts: parts.map(|parts| RecordedParts {
                first: shown(&parts.first),
                last: shown(&parts.last),
                count: parts.count,
                deleted: parts.deleted,
                left: parts.left.iter().map(|part| shown(part)).collect(),
            }),
            files: waited.then(|| files.into_iter().map(recorded).collect()),
            short,
            kept,
            lost,
            bytes,
            trouble,
        }
    }

    /// Whether all that was written can be read.
    ///
    /// # Errors
    /// The disk failed or was full.
    pub(crate) fn whole(self) -> Result<(), Failure> {
        let file = self.file;
        self.trouble.map_or(Ok(()), |trouble| {
            Err(Failure::Broken(format!("{file} ends too soon: {trouble}")))
        })
    }
}

/// Reads the conditions, and says on the log what comes of them.
pub(crate) fn when(around: &Around, names: Names) -> Result<When, Failure> {
    let conditions = around.conditions.iter().map(|text| Condition::new(text, &names));
    let conditions = conditions.collect::<Result<_, _>>().map_err(|bad| {
        Failure::usage(
            bad.to_string(),
            "conditions are collision, absence, chatter>N (of any group, or with :GROUP), overrun, fault (or with :SCHEMA),\n        \
             refused, operator, and expressions such as 'pioneer.odometry.twist.twist.linear.x > 0.4' or\n        \
             'pioneer.laser.ranges.exists(r, r < 0.3)'",
        )
    })?;
    Ok(When {
        triggers: Triggers::new(names, conditions),
        before: around.before,
        after: around.after,
        memory: around.memory,
        on_file: Box::new(|happened, written| {
            let (file, reason) = (shown(&written.path), &written.reason);
            let at = written.time as f64 / 1e9;
            match happened {
                Happened::Began => tracing::warn!("recording {file}: {reason} at {at:.3} s"),
                Happened::FiredAgain => tracing::info!("recording {file} for longer"),
                Happened::Ended => tracing::info!("recorded {file}"),
                Happened::Failed => {
                    let trouble = written.trouble.as_deref().unwrap_or_default();
                    tracing::error!(
                        "{file} ends here, and the run goes on; the next condition tries again: {trouble}"
                    );
                }
            }
        }),
    })
}

fn recorded(written: Written) -> RecordedFile {
    RecordedFile {
        file: shown(&written.path),
        reason: written.reason,
        time_s: written.time as f64 / 1e9,
        fired: written.fired,
        kept: written.kept,
        lost: written.lost,
        bytes: written.bytes,
        trouble: written.trouble,
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// A recording that cannot be begun.
pub(crate) fn no_recording(error: Error, file: &Path) -> Failure {
    match error {
        Error::Exists(_) => Failure::usage(
            format!("{} exists already", shown(file)),
            "give the recording another name, or add --overwrite",
        ),
        Error::Written(path) => Failure::usage(
            format!("{} is being written by another recording", shown(&path)),
            "give this one another name, or end the other",
        ),
        Error::Create { path, error } => Failure::File { path, error },
        Error::Thread(error) => Failure::Start(StartError::Thread(error)),
    }
}
