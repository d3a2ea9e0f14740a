//! The recording of a run. It begins before the run, so that a file that cannot be written is discovered
//! early, and ends with it. `jde-recorder` writes the files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Args;
use jde_app::Application;
use jde_conditions::{BadCondition, Condition, Names, Triggers};
use jde_core::Nanos;
use jde_host::{Handle, StartError, StartHook, StartHookError};
use jde_loader::Plugins;
use jde_log::Selection;
use jde_log::log_line;
use jde_log::part::Gap;
use jde_recorder::{
    Error, FileEvent, OnTrouble, Origin, Recorder, RecorderOptions, SplitOptions, Stamps, Status,
    TriggerOptions, TriggeredFile, Trouble,
};
use jde_records::event::Observer;
use jde_records::turn::OnTurn;
use jde_session::log::{LineObserver, Log};
use jde_session::run::{
    Extension, PartLeft, PreparedExtension, RecordedFile, RecordedGap, RecordedParts, RecordingSummary,
    RunContext,
};
use parking_lot::Mutex;

use super::panels::{PanelOptions, PanelRecording, PanelSelection};
use super::ros::severity;
use crate::failure::{Failure, display_path};
use crate::quantity;

/// What to record, and where.
pub(crate) struct RecordOptions {
    /// The file.
    pub(crate) file: PathBuf,
    /// Patterns of the variables to record; an empty list records all.
    pub(crate) patterns: Vec<String>,
    /// Whether to overwrite an existing file.
    pub(crate) overwrite: bool,
    /// The panels to record; `None` records none.
    pub(crate) panels: Option<PanelOptions>,
    /// Record only the time around the moments at which a condition becomes true; `None` records everything.
    pub(crate) trigger: Option<TriggerWindow>,
    /// Split the recording into consecutive files; `None` writes one file.
    pub(crate) split: Option<SplitOptions>,
    /// The log whose lines of schemas are recorded.
    pub(crate) log: Option<Log>,
}

/// Recording around chosen moments only. The verb has an argument `file`, the recording to write.
#[derive(Args)]
pub(crate) struct TriggerWindow {
    /// Record only around the moments at which this condition becomes true, to FILE-001, FILE-002 and so on
    /// (repeatable). Conditions: conflict, absence or chatter>N, each also with :GROUP; overrun or fault,
    /// each also with :SCHEMA; refused; operator; or an expression over variables, as in
    /// 'pioneer.odometry.twist.twist.linear.x > 0.4'.
    #[arg(long, value_name = "CONDITION", requires = "file")]
    pub(crate) when: Vec<String>,
    /// The time to keep before the condition.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time,
          default_value = "60s", requires = "when")]
    pub(crate) before: Nanos,
    /// The time to record after a condition last became true.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time,
          default_value = "10s", requires = "when")]
    pub(crate) after: Nanos,
    /// The most memory for the time before the condition. When it is full, the oldest data is dropped.
    #[arg(long, value_name = "SIZE", value_parser = quantity::size, default_value = "256MB", requires = "when")]
    pub(crate) memory: usize,
}

/// A recording in progress.
struct RunRecording {
    recorder: Arc<Recorder>,
    selection: Selection,
    on_turn: Option<OnTurn>,
    panels: Option<PanelSelection>,
    panel_recording: Arc<Mutex<Option<PanelRecording>>>,
    log: Option<Log>,
    file: PathBuf,
    /// Whether files are written only when conditions become true.
    is_triggered: bool,
}

impl RunRecording {
    /// Begins a recording. In virtual time nothing is lost, because the run waits for the disk.
    ///
    /// # Errors
    /// The file cannot be written, a pattern matches no variable or no panel, or a condition cannot be read.
    /// Unless it was the writing that failed, no file is created or overfile.
    fn start(record: &RecordOptions, application: &Application, lockstep: bool) -> Result<Self, Failure> {
        let names = jde_log::variables(application);
        let selection = Selection::new(record.patterns.clone(), &names).map_err(|unknown| {
            Failure::usage(
                unknown.to_string(),
                "a pattern is a variable's full name, with `*` for any text: `pioneer.*`, `*.laser`",
            )
        })?;
        let panels = record.panels.as_ref();
        let panels = panels.map(|panels| panels.select(application)).transpose()?;
        let file = record.file.clone();
        let named = display_path(&file);
        let options = RecorderOptions {
            origin: Origin::of(application, lockstep),
            application: Some(application),
            overwrite: record.overwrite,
            lossless: lockstep,
            on_trouble: report_trouble(named),
        };
        let recorder = match (&record.trigger, record.split) {
            (Some(window), _) => {
                Recorder::create_triggered(&file, options, parse_triggers(window, Names::of(application))?)
            }
            (None, Some(split)) => Recorder::create_split(&file, options, split),
            (None, None) => Recorder::create(&file, options),
        };
        let recorder = recorder.map_err(|error| recording_failure(error, &file))?;
        Ok(Self {
            // A recording that begins during the run cannot be replayed, so it contains no turns.
            on_turn: record
                .trigger
                .is_none()
                .then(|| jde_recorder::turns(&recorder, application, lockstep)),
            recorder: Arc::new(recorder),
            selection,
            panels,
            panel_recording: Arc::default(),
            // Who names what is recorded wants nothing else.
            log: record.log.clone().filter(|_| record.patterns.is_empty()),
            file,
            is_triggered: record.trigger.is_some(),
        })
    }
}

impl Extension for RecordOptions {
    fn prepare(
        &self,
        context: &RunContext<'_>,
    ) -> Result<Option<Box<dyn PreparedExtension>>, StartHookError> {
        let recording = RunRecording::start(self, context.application, context.lockstep)?;
        Ok(Some(Box::new(recording)))
    }
}

impl PreparedExtension for RunRecording {
    fn observer(&self) -> Box<dyn Observer> {
        self.recorder.observer()
    }

    /// `jde replay` needs every turn. A recording around conditions has none.
    fn on_turn(&self) -> Option<OnTurn> {
        self.on_turn.clone()
    }

    /// The hook records the variables of an application from their first value on, and its panels. Variables
    /// that are not recorded can still be read by conditions.
    fn before_start(&self, _: &Arc<Plugins>) -> StartHook {
        let (recorder, selection) = (Arc::clone(&self.recorder), self.selection.clone());
        let (panels, panel_recording) = (self.panels.clone(), Arc::clone(&self.panel_recording));
        let log = self.log.clone();
        Box::new(move |handle| {
            for variable in handle.board().list() {
                let handle = handle.clone();
                let clock = Arc::new(move || handle.now());
                if selection.contains(&variable.describe().full_name()) {
                    recorder.watch(&variable, clock);
                } else {
                    recorder.watch_for_conditions(&variable, clock);
                }
            }
            if let Some(log) = log {
                log.observe(line_recorder(&recorder, handle.clone()));
            }
            if let Some(panels) = &panels {
                let started = PanelRecording::start(handle, &recorder, panels)?;
                *panel_recording.lock() = Some(started);
            }
            Ok(())
        })
    }

    /// Completes the recording.
    fn finish(&self) -> Option<RecordingSummary> {
        drop(self.panel_recording.lock().take());
        Some(recording_summary(
            &self.file,
            self.is_triggered,
            self.recorder.finish(),
        ))
    }
}

/// Records each line of a schema in the topic `/rosout`.
fn line_recorder(recorder: &Recorder, handle: Handle) -> LineObserver {
    let (topic, sequence) = (recorder.log(), AtomicU64::new(0));
    Arc::new(move |line| {
        let (now, schema) = (handle.now(), line.schema.as_deref().unwrap_or_default());
        let message = log_line::message(now, severity(line.level), schema, &line.message);
        let stamps = Stamps {
            published: now,
            measured: now,
            sequence: sequence.fetch_add(1, Ordering::Relaxed),
        };
        // What is lost is counted.
        topic.put_message(&message, stamps);
    })
}

/// Returns the result of a finished recording; file by file if conditions trigger it.
pub(crate) fn recording_summary(file: &Path, is_triggered: bool, status: Status) -> RecordingSummary {
    let Status {
        written: kept,
        lost,
        bytes,
        error: trouble,
        files,
        evicted: short,
        parts,
        ..
    } = status;
    RecordingSummary {
        file: display_path(file),
        parts: parts.map(|parts| RecordedParts {
            first: display_path(&parts.first),
            last: display_path(&parts.last),
            count: parts.count,
            deleted: parts.deleted,
            left: parts
                .undeleted
                .into_iter()
                .map(|(part, reason)| PartLeft {
                    file: display_path(&part),
                    reason,
                })
                .collect(),
            gaps: parts.gaps.iter().map(recorded_gap).collect(),
            more_gaps: parts.more_gaps,
        }),
        files: is_triggered.then(|| files.into_iter().map(recorded_file).collect()),
        short,
        kept,
        lost,
        bytes,
        trouble,
    }
}

fn recorded_gap(gap: &Gap) -> RecordedGap {
    RecordedGap {
        from: gap.from,
        until: gap.until,
        lost: gap.lost,
        reason: gap.reason.clone(),
        text: gap.to_string(),
    }
}

/// Logs what hinders a recording of this name.
pub(crate) fn report_trouble(named: String) -> OnTrouble {
    Box::new(move |trouble| match trouble {
        Trouble::Ended { .. } | Trouble::Interrupted { .. } => {
            tracing::error!("the recording {named} {trouble}");
        }
        Trouble::Resumed(_) | Trouble::Undeleted { .. } => {
            tracing::warn!("the recording {named} {trouble}");
        }
    })
}

/// Reads the conditions, and logs the start and end of each file.
pub(crate) fn parse_triggers(window: &TriggerWindow, names: Names) -> Result<TriggerOptions, Failure> {
    let conditions = window.when.iter().map(|text| Condition::new(text, &names));
    let conditions = conditions.collect::<Result<_, _>>().map_err(condition_failure)?;
    Ok(TriggerOptions {
        triggers: Triggers::new(names, conditions),
        before: window.before,
        after: window.after,
        memory: window.memory,
        on_file: Box::new(|event, file| {
            let (path, reason) = (display_path(&file.path), &file.reason);
            let at = file.time as f64 / 1e9;
            match event {
                FileEvent::Started => tracing::warn!("recording {path}: {reason} at {at:.3} s"),
                FileEvent::Extended => tracing::info!("recording {path} for longer"),
                FileEvent::Ended => tracing::info!("recorded {path}"),
                FileEvent::Failed => {
                    let error = file.error.as_deref().unwrap_or_default();
                    tracing::error!(
                        "{path} ends early, and the run continues; the next condition starts a new file: {error}"
                    );
                }
            }
        }),
    })
}

/// Returns the failure of a condition that cannot be read.
pub(crate) fn condition_failure(error: BadCondition) -> Failure {
    Failure::usage(
        error.to_string(),
        "conditions are conflict, absence, chatter>N (of any group, or with :GROUP), overrun, fault (or with :SCHEMA),\n        \
         refused, operator, and expressions such as 'vff.won and clearance < 0.2' or\n        \
         'pioneer.laser.ranges.exists(r, r < 0.3)'",
    )
}

fn recorded_file(file: TriggeredFile) -> RecordedFile {
    RecordedFile {
        file: display_path(&file.path),
        reason: file.reason,
        time_s: file.time as f64 / 1e9,
        fired: file.fired,
        kept: file.written,
        lost: file.lost,
        bytes: file.bytes,
        trouble: file.error,
    }
}

/// Returns the failure for a recording that cannot be begun.
pub(crate) fn recording_failure(error: Error, file: &Path) -> Failure {
    match error {
        Error::Exists(_) => Failure::usage(
            format!("{} exists already", display_path(file)),
            "give the recording another name, or add --overwrite",
        ),
        Error::Written(path) => Failure::usage(
            format!("{} is being written by another recording", display_path(&path)),
            "give this recording another name, or end the other",
        ),
        Error::Create { path, error } => Failure::file(&path)(error),
        Error::Thread(error) => StartError::Thread(error).into(),
    }
}
