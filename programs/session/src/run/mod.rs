//! One run of an application, from the start until everything is at rest: in real time with the oscilloscope
//! or with lines of output, or in lockstep.

mod collector;
mod digest;
mod extension;
mod local_application;
mod pending_file;
mod progress;
mod recording_summary;
mod sampler;
mod service;
mod watch;

use std::io::{self, ErrorKind};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use jde_app::Application;
use jde_core::Nanos;
use jde_host::{Handle, Lockstep, Options, Running, StartError};
use jde_loader::Plugins;
use jde_records::event::Outcome;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::{self as terminal, TextWriter};
use parking_lot::Mutex;

use crate::failure::Failure;
use crate::load::LoadedApplication;
use crate::log::Log;
use crate::summary::RunSummary;
use crate::{summary, top};
use collector::{Collector, SAMPLE_INTERVAL};
use digest::DigestWriter;
use local_application::LocalApplication;
use pending_file::PendingFile;
use progress::ProgressPrinter;
use service::ServiceNotifier;
use watch::PluginWatcher;

pub use collector::RunData;
pub use extension::{Extension, PreparedExtension, RunContext};
pub use local_application::{robot_view, terminal_operator};
pub use progress::{ProgressMode, format_progress};
pub use recording_summary::{PartLeft, RecordedFile, RecordedGap, RecordedParts, RecordingSummary};

/// How to run an application.
pub struct RunOptions {
    /// Whether to run in virtual time.
    pub lockstep: bool,
    /// End the run at this application time, ns.
    pub limit: Option<Nanos>,
    /// Seconds of application time per second of the machine; real time only.
    pub speed: f64,
    /// What is shown during the run.
    pub view: RunView,
    /// The stream for text output.
    pub output: TextWriter,
    /// The file for the decisions.
    pub decisions: Option<PathBuf>,
    /// The file for the picture of the drive.
    pub picture: Option<PathBuf>,
    /// What accompanies the run.
    pub extensions: Vec<Box<dyn Extension>>,
    /// Whether everything is stopped at the start, until an operator releases it; real time only.
    pub stopped: bool,
    /// Whether schemas are reloaded when the files of their plugins change; real time only.
    pub watch: bool,
}

/// What is shown while an application runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunView {
    /// The oscilloscope; real time only.
    Screen,
    /// Lines.
    Lines(ProgressMode),
}

/// What accompanies a run in real time.
struct RealTimeOptions {
    view: RunView,
    watch: bool,
}

/// A run that has ended.
pub struct Finished {
    /// Its result.
    pub summary: RunSummary,
    /// The stream for text output.
    pub output: TextWriter,
}

/// Runs an application until it ends or is stopped, and brings it to rest.
///
/// # Errors
/// The application did not start, or output could not be written.
pub fn run(loaded: LoadedApplication, options: RunOptions, log: &Log) -> Result<Finished, Failure> {
    let LoadedApplication {
        application, plugins, ..
    } = loaded;
    let plugins = Arc::new(plugins);
    // Opened before the start, so that a file that cannot be written is not discovered after a long run.
    let decisions = options
        .decisions
        .as_deref()
        .map(PendingFile::prepare)
        .transpose()?;
    let picture = options.picture.as_deref().map(PendingFile::prepare).transpose()?;
    let world = summary::world_file(&application);
    let has_scans = options.picture.is_some() && world.is_none();
    let mode = match options.view {
        RunView::Screen => ProgressMode::Nothing,
        RunView::Lines(mode) => mode,
    };
    log.hide_events(mode != ProgressMode::Nothing);
    let progress = ProgressPrinter::new(&application, options.output, mode);
    let digest_writer = DigestWriter::new(decisions);
    let (mut recorder, observer) =
        Collector::new(&application, digest_writer, has_scans, progress, options.lockstep);
    let context = RunContext {
        application: &application,
        lockstep: options.lockstep,
        speed: options.speed,
    };
    let mut extensions = Vec::new();
    for extension in &options.extensions {
        extensions.extend(extension.prepare(&context).map_err(StartError::HookFailed)?);
    }
    let mut host_options = Options {
        observers: vec![observer],
        limit: options.limit,
        speed: options.speed,
        may_stand_still: extensions.iter().any(|extension| extension.may_stand_still()),
        on_turn: extensions.iter().find_map(|extension| extension.on_turn()),
        isolation_program: Some(crate::child::program()),
        ..Options::default()
    };
    host_options
        .observers
        .extend(extensions.iter().map(|extension| extension.observer()));
    let hooks: Vec<_> = extensions
        .iter()
        .map(|extension| extension.before_start(&plugins))
        .collect();
    let interrupts = Arc::new(Mutex::new(None));
    let listener = Arc::clone(&interrupts);
    host_options.start_hook = Some(Box::new(move |handle| {
        // Before the link opens: whoever finds the application by it may send a signal.
        *listener.lock() = Some(stop_on_signal(handle)?);
        if options.stopped {
            terminal_operator(handle).stop_all()?;
        }
        hooks.into_iter().try_for_each(|hook| hook(handle))
    }));

    let started = Instant::now();
    let result = if options.lockstep {
        run_lockstep(application, &plugins, host_options, &mut recorder, log)
    } else {
        let real_time = RealTimeOptions {
            view: options.view,
            watch: options.watch,
        };
        run_real_time(application, &plugins, host_options, real_time, &mut recorder, log)
    };
    let wall = started.elapsed();
    interrupts.lock().take();
    // The link ends before the recording, which it was prepared after.
    let recorded = finish(&extensions);
    log.clear_clock();
    log.hide_events(false);
    let (outcome, handle) = result?;

    let (data, digest, failed) = recorder.finish()?;
    let mut summary = RunSummary::new(&handle, &data, &outcome, wall, digest, recorded);
    // The run has a result, whether its files can be written or not.
    if let (Some(file), Some(error)) = (&options.decisions, failed) {
        summary.add_unwritten(file, &error);
    }
    if let Some(file) = &options.picture {
        drop(picture);
        if let Err(error) = summary::draw(
            handle.application(),
            data.drive,
            &data.timeline,
            world.as_deref(),
            file,
        ) {
            summary.unwritten.push(error.to_string());
        }
    }
    Ok(Finished {
        summary,
        output: data.output,
    })
}

/// Ends the extensions of a run, the last first. Returns the result of its recording.
fn finish(extensions: &[Box<dyn PreparedExtension>]) -> Option<RecordingSummary> {
    let results = extensions.iter().rev().map(|extension| extension.finish());
    results.fold(None, Option::or)
}

/// Runs in virtual time on the calling thread.
fn run_lockstep(
    application: Application,
    plugins: &Plugins,
    options: Options,
    recorder: &mut Collector,
    log: &Log,
) -> Result<(Outcome, Handle), Failure> {
    let mut lockstep = Lockstep::start(application, plugins, options)?;
    let handle = lockstep.handle();
    log.set_clock(&handle);
    recorder.start_sampling(&handle);
    recorder.process_pending(0)?;
    let mut then = 0;
    let outcome = loop {
        then += SAMPLE_INTERVAL;
        let mut outcome = lockstep.run_until(then);
        recorder.process_pending(handle.now())?;
        while outcome.is_none() && handle.standstill().is_some() {
            outcome = lockstep.wait_while_still();
            outcome = outcome.or_else(|| lockstep.run_until(then));
            recorder.process_pending(handle.now())?;
        }
        if let Some(outcome) = outcome {
            break outcome;
        }
    };
    drop(lockstep);
    recorder.process_pending(handle.now())?;
    Ok((outcome, handle))
}

/// Runs in real time on threads of the application. The calling thread draws the oscilloscope, if it is
/// shown.
fn run_real_time(
    application: Application,
    plugins: &Arc<Plugins>,
    options: Options,
    RealTimeOptions { view, watch }: RealTimeOptions,
    recorder: &mut Collector,
    log: &Log,
) -> Result<(Outcome, Handle), Failure> {
    let wait = Duration::from_nanos((SAMPLE_INTERVAL as f64 / options.speed) as u64);
    let title = application.name.clone();
    // Until everything is at rest, no thread that prints waits for a reader.
    let _no_waiting = terminal::never_block();
    let running = Running::start(application, plugins, options)?;
    let handle = running.handle();
    log.set_clock(&handle);
    recorder.start_sampling(&handle);
    let _watch = watch
        .then(|| PluginWatcher::start(handle.clone(), Arc::clone(plugins)))
        .transpose()?;
    let _service = ServiceNotifier::start(handle.clone())?;
    let (outcome, collected, shown) = thread::scope(|scope| {
        // Stops the application on every way out of this scope, a panic included. The scope joins the other
        // threads, so the robot is at rest before a panic continues.
        let stop = StopRunOnDrop(&handle);
        let waiter = scope.spawn(move || running.wait());
        // The last thread of the run: a line of its output says that all have started.
        let collecting = scope.spawn(|| recorder.process_until_end(&handle, wait));
        let mut shown = Ok(top::ExitReason::Ended);
        if view == RunView::Screen {
            log.set_buffered(true);
            shown = treat_loss_as_quit(top::run(&LocalApplication::new(handle.clone(), log), &title));
            log.set_buffered(false);
            handle.stop();
        }
        let outcome = waiter.join();
        let collected = collecting.join();
        drop(stop);
        (outcome, collected, shown)
    });
    let outcome = outcome.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    collected.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    shown?;
    Ok((outcome, handle))
}

/// Treats a lost terminal as the operator leaving: the run is stopped and its results are kept.
fn treat_loss_as_quit(shown: io::Result<top::ExitReason>) -> io::Result<top::ExitReason> {
    match shown {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(top::ExitReason::Quit),
        shown => shown,
    }
}

/// Stops the application at the first signal.
fn stop_on_signal(handle: &Handle) -> io::Result<SignalListener> {
    let handle = handle.clone();
    SignalListener::on_first(move || handle.stop())
}

struct StopRunOnDrop<'h>(&'h Handle);

impl Drop for StopRunOnDrop<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}
