//! Replays a recorded drive with the present schemas: loads the application, shows the progress, and prints
//! the comparison.

mod report;

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use jde_app::Override;
use jde_core::Nanos;
use jde_decide::{AttachedApplication, ReplayError, ReplayedDrive, Span, Tolerance, ToleranceEntry};
use jde_session::cli::print_json;
use jde_session::load::{self, LoadedApplication, Trust};
use jde_session::log::Log;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::{self as terminal, ProgressLine};

use crate::failure::{Failure, RunFailure, display_path};

/// What to replay, and options.
pub(crate) struct DecideOptions {
    /// The recording.
    pub(crate) file: PathBuf,
    /// The application to run instead of the one in the recording.
    pub(crate) application: Option<PathBuf>,
    /// Whether plugins are loaded from the folders that the recording names.
    pub(crate) trust: Trust,
    /// Modulations that differ from the recording.
    pub(crate) sets: Vec<Override>,
    /// The times that are compared.
    pub(crate) span: Span,
    /// How far apart two numbers may be and still count as equal.
    pub(crate) tolerance: Vec<ToleranceEntry>,
    /// Whether the output ends with a line of JSON.
    pub(crate) json: bool,
}

/// Replays a drive and prints what differs.
///
/// # Errors
/// [`Failure::Mismatch`] if a selection or a value differs, otherwise the reason why the replay failed.
pub(crate) fn run(
    options: DecideOptions,
    log: impl FnOnce(&LoadedApplication) -> Result<Log, Failure>,
) -> Result<(), Failure> {
    let drive = ReplayedDrive::open(&options.file)?;
    let loaded = match &options.application {
        Some(application) => load::load_application(application, &options.sets),
        None => {
            let AttachedApplication { name, text, folder } = drive.application()?;
            load::load_attached(&name, &text, folder.as_deref(), &options.sets, options.trust)
        }
    };
    // A recorded application ran once, so a missing plugin counts as an unusable one, also in the exit status.
    let mut loaded = loaded.map_err(|mut failure| {
        if let RunFailure::Application {
            unusable, missing, ..
        } = &mut failure
        {
            *unusable |= *missing;
        }
        failure
    })?;
    let is_set = |name: &str| {
        let mut sets = options.sets.iter();
        sets.any(|set| format!("{}.{}", set.schema, set.variable) == name)
    };
    if options.application.is_none() {
        // The values given by --set at the original start are in the recording, not in the application's
        // file.
        drive.restore(&mut loaded.application, is_set);
    }
    if let Some(seed) = drive.seed() {
        loaded.application.seed = seed;
    }
    let tolerance = Tolerance::new(&options.tolerance, &loaded.application)?;
    let _log = log(&loaded)?;
    let mut output = terminal::text_out(options.json);
    let name = display_path(&options.file);
    let differences = drive.differences(&loaded.application);
    report::print_header(&mut output, &name, &drive, &loaded.application.name, &differences)?;
    report::print_plugins(&mut output, &loaded, options.trust)?;
    output.flush()?;

    let (stopped, _interrupts) = SignalListener::flag(|| {})?;
    let mut progress = ProgressLine::default();
    let LoadedApplication {
        application, plugins, ..
    } = loaded;
    let progress_callback = |time: Nanos| {
        progress.update(|| format!("{:8.1} s", time as f64 / 1e9));
        !stopped.load(Ordering::Relaxed)
    };
    let verdict = jde_decide::replay_and_compare(
        &drive,
        application,
        &plugins,
        options.span,
        &tolerance,
        progress_callback,
    );
    progress.clear();
    let verdict = verdict?;
    report::print_verdict(&mut output, &verdict, stopped.load(Ordering::Relaxed))?;
    output.flush()?;
    if options.json {
        print_json(&report::json(&name, &drive, &differences, &verdict))?;
    }
    if verdict.is_same() {
        Ok(())
    } else {
        Err(Failure::Mismatch)
    }
}

impl From<ReplayError> for Failure {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::Read(error) => Self::Recording(error),
            ReplayError::Start(error) => error.into(),
            error @ ReplayError::Tolerance { .. } => Self::usage(
                error.to_string(),
                "`jde vars` and `jde info` show the types of values",
            ),
            ReplayError::Incomplete { path, what } => Self::usage(
                format!("{path} cannot be replayed: {what}"),
                "a recording of a whole run has all that is needed: `jde run APP --record FILE`",
            ),
        }
    }
}
