//! One run of an application, from the start until everything is at rest: in real time with the oscilloscope
//! or with lines of output, or in lockstep.

mod digest;
mod extension;
#[cfg(feature = "tools")]
mod link;
mod live;
#[cfg(feature = "tools")]
mod panels;
mod progress;
mod promised;
#[cfg(feature = "tools")]
mod record;
mod recorded;
mod recorder;
mod sight;
mod tally;
mod trace;
mod watch;

use std::io::{self, ErrorKind};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_host::app::Application;
use jde_host::event::Outcome;
use jde_host::plugin::Plugins;
use jde_host::{Handle, Lockstep, Options, Running, StartError};

use crate::failure::Failure;
use crate::interrupt::Interrupts;
use crate::load::Loaded;
use crate::log::Log;
use crate::summary::Summary;
use crate::terminal::{self, Words};
use crate::{summary, top};
use digest::Digested;
use extension::{Coming, Prepared};
use live::Live;
use progress::Progress;
use promised::Promised;
use recorder::{Recorder, SAMPLE};
use watch::Watch;

pub(crate) use extension::Extension;
#[cfg(feature = "tools")]
pub(crate) use link::{Wanted as LinkWanted, link_settings};
pub(crate) use live::robot;
#[cfg(feature = "tools")]
pub(crate) use panels::Panels;
pub(crate) use progress::{Millis, Telling, of};
#[cfg(feature = "tools")]
pub(crate) use record::{Around, Record, no_recording, when};
pub(crate) use recorded::{Recorded, RecordedFile};
pub(crate) use recorder::Kept;
pub(crate) use sight::{Progress as Mission, Read};
pub(crate) use trace::{Sample, Trace};

/// How to run an application.
pub(crate) struct How {
    /// Whether to run in virtual time.
    pub(crate) lockstep: bool,
    /// End the run at this application time, ns.
    pub(crate) limit: Option<Nanos>,
    /// Seconds of application time per second of the machine; real time only.
    pub(crate) speed: f64,
    /// What is shown during the run.
    pub(crate) view: View,
    /// The stream for text output.
    pub(crate) words: Words,
    /// The file for the decisions.
    pub(crate) decisions: Option<PathBuf>,
    /// The file for the picture of the drive.
    pub(crate) picture: Option<PathBuf>,
    /// What accompanies the run.
    pub(crate) extensions: Vec<Box<dyn Extension>>,
    /// Whether schemas are reloaded when the files of their plugins change; real time only.
    pub(crate) watch: bool,
}

/// What is shown while an application runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// The oscilloscope; real time only.
    Screen,
    /// Lines.
    Lines(Telling),
}

/// What accompanies a run in real time.
struct Shown {
    view: View,
    watch: bool,
}

/// A run that has ended.
pub(crate) struct Finished {
    /// Its result.
    pub(crate) summary: Summary,
    /// The stream for text output.
    pub(crate) words: Words,
}

/// Runs an application until it ends or is stopped, and brings it to rest.
///
/// # Errors
/// The application did not start, or output could not be written.
pub(crate) fn run(loaded: Loaded, how: How, log: &Log) -> Result<Finished, Failure> {
    let Loaded {
        application, plugins, ..
    } = loaded;
    let plugins = Arc::new(plugins);
    // Opened before the start, so that a file that cannot be written is not discovered after a long run.
    let decisions = how.decisions.as_deref().map(Promised::at).transpose()?;
    let picture = how.picture.as_deref().map(Promised::at).transpose()?;
    let world = summary::world(&application);
    let trace = how.picture.is_some().then(|| Trace::new(world.is_none()));
    let telling = match how.view {
        View::Screen => Telling::Nothing,
        View::Lines(telling) => telling,
    };
    let progress = Progress::new(&application, how.words, telling);
    let digested = Digested::new(decisions);
    let (mut recorder, observer) = Recorder::new(&application, digested, trace, progress, how.lockstep);
    let coming = Coming {
        application: &application,
        lockstep: how.lockstep,
        speed: how.speed,
    };
    let mut extensions = Vec::new();
    for extension in &how.extensions {
        extensions.extend(extension.prepare(&coming)?);
    }
    let mut options = Options {
        observers: vec![observer],
        limit: how.limit,
        speed: how.speed,
        on_turn: extensions.iter().find_map(|extension| extension.on_turn()),
        apart: Some(crate::child::program()),
        ..Options::default()
    };
    options
        .observers
        .extend(extensions.iter().map(|extension| extension.observer()));
    let hooks: Vec<_> = extensions
        .iter()
        .map(|extension| extension.before_start(&plugins))
        .collect();
    options.before_start = Some(Box::new(|handle| {
        hooks.into_iter().try_for_each(|hook| hook(handle))
    }));

    let started = Instant::now();
    let ran = if how.lockstep {
        in_lockstep(application, &plugins, options, &mut recorder, log)
    } else {
        let shown = Shown {
            view: how.view,
            watch: how.watch,
        };
        in_real_time(application, &plugins, options, shown, &mut recorder, log)
    };
    let wall = started.elapsed();
    // The link ends before the recording, which it was prepared after.
    let recorded = finish(&extensions);
    log.forget();
    let (outcome, handle) = ran?;

    let (kept, digest) = recorder.finish();
    let file = how
        .decisions
        .as_deref()
        .unwrap_or_else(|| "the decisions".as_ref());
    let digest = digest.map_err(Failure::file(file))?;
    let summary = Summary::new(&handle, &kept, &outcome, wall, digest, recorded);
    if let (Some(file), Some(promised)) = (&how.picture, picture) {
        drop(promised.begin().map_err(Failure::file(file))?);
        summary::draw(&handle, &kept, world.as_deref(), file)?;
    }
    Ok(Finished {
        summary,
        words: kept.words,
    })
}

/// Ends the extensions of a run, the last first. Returns the result of its recording.
fn finish(extensions: &[Box<dyn Prepared>]) -> Option<Recorded> {
    let results = extensions.iter().rev().map(|extension| extension.finish());
    results.fold(None, Option::or)
}

/// Runs in virtual time on the calling thread.
fn in_lockstep(
    application: Application,
    plugins: &Plugins,
    options: Options,
    recorder: &mut Recorder,
    log: &Log,
) -> Result<(Outcome, Handle), Failure> {
    let mut lockstep = Lockstep::start(application, plugins, options).map_err(not_started)?;
    let handle = lockstep.handle();
    log.follow(&handle);
    let _interrupts = {
        let handle = handle.clone();
        Interrupts::call(move || handle.stop())?
    };
    recorder.watch(&handle);
    recorder.catch_up(0)?;
    let mut then = 0;
    let outcome = loop {
        then += SAMPLE;
        let outcome = lockstep.run_until(then);
        recorder.catch_up(handle.now())?;
        if let Some(outcome) = outcome {
            break outcome;
        }
    };
    drop(lockstep);
    recorder.catch_up(handle.now())?;
    Ok((outcome, handle))
}

/// Runs in real time on threads of the application. The calling thread draws the oscilloscope, if it is
/// shown.
fn in_real_time(
    application: Application,
    plugins: &Arc<Plugins>,
    options: Options,
    Shown { view, watch }: Shown,
    recorder: &mut Recorder,
    log: &Log,
) -> Result<(Outcome, Handle), Failure> {
    let wait = Duration::from_nanos((SAMPLE as f64 / options.speed) as u64);
    let title = application.name.clone();
    // Until everything is at rest, no thread that prints waits for a reader.
    let _no_waiting = terminal::wait_for_nobody();
    let running = Running::start(application, plugins, options).map_err(not_started)?;
    let handle = running.handle();
    log.follow(&handle);
    let _interrupts = {
        let handle = handle.clone();
        Interrupts::call(move || handle.stop())?
    };
    recorder.watch(&handle);
    let _watch = watch
        .then(|| Watch::begin(handle.clone(), Arc::clone(plugins)))
        .transpose()?;
    let (outcome, told, shown) = thread::scope(|scope| {
        // Stops the application on every way out of this scope, a panic included. The scope joins the other
        // threads, so the robot is at rest before a panic continues.
        let stop = StopOnDrop(&handle);
        let keeper = scope.spawn(|| recorder.keep(&handle, wait));
        let waiter = scope.spawn(move || running.wait());
        let mut shown = Ok(top::Left::Ended);
        if view == View::Screen {
            log.keep(true);
            shown = left_orderly(top::run(&Live::new(handle.clone(), log), &title));
            log.keep(false);
            handle.stop();
        }
        let outcome = waiter.join();
        let told = keeper.join();
        drop(stop);
        (outcome, told, shown)
    });
    let outcome = outcome.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    told.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    shown?;
    Ok((outcome, handle))
}

/// Treats a lost terminal as the operator leaving: the run is stopped and its results are kept.
fn left_orderly(shown: io::Result<top::Left>) -> io::Result<top::Left> {
    match shown {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(top::Left::Quit),
        shown => shown,
    }
}

/// Returns the failure of a start, unwrapped if the link or the recording caused it.
fn not_started(error: StartError) -> Failure {
    match error {
        StartError::Hindered(hindrance) => match hindrance.downcast::<Failure>() {
            Ok(failure) => *failure,
            Err(other) => StartError::Hindered(other).into(),
        },
        other => other.into(),
    }
}

struct StopOnDrop<'h>(&'h Handle);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}
