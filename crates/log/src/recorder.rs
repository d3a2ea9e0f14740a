//! A running recording. A thread of its own writes it.

mod split;
mod when;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};

use jde_abi::describe::Type;
use jde_board::{Nanos, Variable, Watch};
use jde_host::app::Application;
use jde_host::event::{Event, Observer};
use jde_host::story::{Line, Story};

use crate::lane::{Holds, Lane, Shared, Told, Topic, lock};
use crate::scribe::Scribe;
use crate::sink::{self, Begun, Disk, Plan, Sink, Triggered, Whole};
use crate::trigger::Triggers;
use crate::writer::Output;
use crate::{Error, Origin, panel, tap};

pub use split::{Every, Parts, Split};
pub use when::{Happened, OnFile, When, Written};

/// Upper limit of the notices that are not yet written: more than the busiest application sends while a disk
/// blocks for a second.
const EVENTS: usize = 4096;

/// Returns the application's time, in ns since its start. Any thread may call it.
pub type Clock = Arc<dyn Fn() -> Nanos + Send + Sync>;

/// Called with the reason when the disk does not accept more data.
pub type OnTrouble = Box<dyn FnMut(&str) + Send>;

/// How to record.
pub struct Options<'a> {
    /// The origin of the recording.
    pub origin: Origin,
    /// The application whose events are recorded. Without it no events are recorded.
    pub application: Option<&'a Application>,
    /// Whether an existing file is overwritten.
    pub overwrite: bool,
    /// Whether publishers wait instead of losing values. For virtual time only.
    pub lossless: bool,
    /// Called once, by the writing thread, when the disk does not accept more data. The run continues.
    pub on_trouble: OnTrouble,
}

/// A running recording. Any thread may call it. Dropping it finishes it.
pub struct Recorder {
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
    watches: Mutex<Vec<Watch>>,
    /// The variables that conditions name.
    named: BTreeSet<String>,
}

/// The progress of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Messages that have reached the file. After a failure, only those that the disk has confirmed.
    pub kept: u64,
    /// Values and events that have not reached the file, for any reason.
    pub lost: u64,
    /// The size of the file in bytes.
    pub bytes: u64,
    /// Why writing has stopped, or why the most recent failed file failed.
    pub trouble: Option<String>,
    /// The number of lost values of each topic that lost any.
    pub lost_of: BTreeMap<String, u64>,
    /// The files that conditions have caused.
    pub files: Vec<Written>,
    /// The files of a recording in parts.
    pub parts: Option<Parts>,
    /// Messages of the past that were removed from memory before their time ended.
    pub short: u64,
}

impl Recorder {
    /// Starts a recording in one file. Creates the folders above it.
    ///
    /// # Errors
    /// [`Error`], also if the disk is full already.
    pub fn create(path: &Path, options: Options<'_>) -> Result<Self, Error> {
        let (output, disk) = sink::create(path, options.overwrite)?;
        Self::begin(output, disk, options).map_err(|error| error.of(path))
    }

    /// Starts a recording in parts, which may continue for ever: one file after the other, with numbers that
    /// follow those of existing files of this name. If `options.overwrite` is set, existing parts of that
    /// name are deleted first. Every file except the first starts with the values in force at its beginning,
    /// stamped with that time.
    ///
    /// # Errors
    /// [`Error`], also if the disk is full already.
    pub fn split(path: &Path, options: Options<'_>, split: Split) -> Result<Self, Error> {
        let (shared, told) = shared(options.lossless);
        let (overwrite, lossless) = (options.overwrite, options.lossless);
        let (split, file) = sink::Split::begin(path, split, options.origin, overwrite, lossless)?;
        let sink = Whole::new(&shared, file, Some(split), options.on_trouble);
        Self::start(shared, told, Box::new(sink), None, options.application).map_err(|error| error.of(path))
    }

    /// Keeps the recent past in memory. When a condition becomes true, it writes a file of the time before
    /// and after that moment. For `drive.mcap`, the file has the first free name of `drive-001.mcap`,
    /// `drive-002.mcap` and so on. Each file starts with the values in force at its beginning, stamped with
    /// that time. `options.on_trouble` is not called.
    ///
    /// # Errors
    /// [`Error`], also if no file can be created in the folder.
    pub fn wait(path: &Path, options: Options<'_>, when: When) -> Result<Self, Error> {
        let plan = Plan {
            path: path.to_owned(),
            overwrite: options.overwrite,
            before: when.before,
            after: when.after,
            memory: when.memory,
        };
        let (shared, told) = shared(options.lossless);
        let origin = options.origin;
        let sink = Triggered::new(&shared, origin, plan, when.on_file)?;
        Self::start(
            shared,
            told,
            Box::new(sink),
            Some(when.triggers),
            options.application,
        )
        .map_err(|error| error.of(path))
    }

    pub(crate) fn begin(output: Output, disk: Option<Disk>, options: Options<'_>) -> Result<Self, Failed> {
        let file = Begun::new(output, disk, &options.origin, None).map_err(Failed::Write)?;
        let (shared, told) = shared(options.lossless);
        let sink = Whole::new(&shared, file, None, options.on_trouble);
        Self::start(shared, told, Box::new(sink), None, options.application)
    }

    fn start(
        shared: Arc<Shared>,
        told: Receiver<(u64, Told)>,
        sink: Box<dyn Sink>,
        triggers: Option<Triggers>,
        application: Option<&Application>,
    ) -> Result<Self, Failed> {
        let story = application.map(Story::whole);
        let named = triggers.as_ref().map(Triggers::variables).unwrap_or_default();
        let named = named.into_iter().map(str::to_owned).collect();
        let scribe = Scribe::new(&shared, sink, triggers, story, told);
        let thread = Builder::new()
            .name("recording".to_owned())
            .spawn(move || scribe.run())
            .map_err(Failed::Thread)?;
        // This is the only place that sets it.
        let _ = shared.scribe.set(thread.thread().clone());
        Ok(Self {
            shared,
            thread: Mutex::new(Some(thread)),
            watches: Mutex::default(),
            named,
        })
    }

    /// Records every value of a variable from now on, including the present one, until the recording is
    /// finished.
    pub fn watch(&self, variable: &Arc<Variable>, clock: Clock) {
        self.tap(variable, clock, true);
    }

    /// Lets the conditions that name a variable read it, without recording its values.
    pub fn look(&self, variable: &Arc<Variable>, clock: Clock) {
        if self.named.contains(&variable.describe().full_name()) {
            self.tap(variable, clock, false);
        }
    }

    fn tap(&self, variable: &Arc<Variable>, clock: Clock, kept: bool) {
        self.shared.clock.get_or_init(|| Arc::clone(&clock));
        let (topic, watch) = tap::watch(variable, &self.shared, clock, kept);
        lock(&self.watches).push(watch);
        lock(&self.shared.lanes).push(topic.lane);
    }

    /// Adds a topic whose values come from elsewhere. `about` is the metadata of its channel. The entry
    /// `variable` in it is the name by which conditions refer to the topic.
    pub fn topic(&self, name: &str, value_type: Arc<Type>, about: BTreeMap<String, String>) -> Topic {
        self.lane(name, Holds::Values(value_type), about, true)
    }

    /// Adds the topic of a schema's panel, `/panels/<schema>`. [`Topic::put_panel`] fills it.
    pub fn panel(&self, schema: &str) -> Topic {
        let about = BTreeMap::from([(panel::SCHEMA.to_owned(), schema.to_owned())]);
        self.lane(&panel::topic(schema), Holds::Panel, about, true)
    }

    /// Adds a topic that conditions read and no file contains. `None` if no condition names the variable.
    pub fn topic_to_look_at(&self, variable: &str, value_type: Arc<Type>) -> Option<Topic> {
        let about = BTreeMap::from([("variable".to_owned(), variable.to_owned())]);
        self.named.contains(variable).then(|| {
            self.lane(
                &tap::topic_name(variable),
                Holds::Values(value_type),
                about,
                false,
            )
        })
    }

    fn lane(&self, name: &str, holds: Holds, about: BTreeMap<String, String>, kept: bool) -> Topic {
        let lane = Arc::new(Lane::new(name.to_owned(), holds, about, None, kept));
        lock(&self.shared.lanes).push(Arc::clone(&lane));
        Topic {
            lane,
            shared: Arc::clone(&self.shared),
        }
    }

    /// Returns an observer that records the events of the application with which the recording was started.
    #[must_use]
    pub fn observer(&self) -> Box<dyn Observer> {
        let shared = Arc::clone(&self.shared);
        Box::new(move |event: &Event| shared.tell(Told::Event(event.clone())))
    }

    /// Records a message of the story of an application elsewhere.
    pub fn line(&self, line: Line) {
        self.shared.tell(Told::Line(line));
    }

    /// Records a message about something that occurred elsewhere before the recording began, at `beginning`
    /// of the application's clock. Its log time is `beginning` and its publish time is the time of the
    /// occurrence. No condition becomes true by it.
    pub fn earlier(&self, line: Line, beginning: Nanos) {
        self.shared.tell(Told::Earlier(line, beginning));
    }

    /// Returns the progress of the recording.
    #[must_use]
    pub fn status(&self) -> Status {
        let shared = &*self.shared;
        let lost_of = shared.lost_of();
        let others = shared.lost_events.load(Ordering::Relaxed) + shared.dropped.load(Ordering::Relaxed);
        Status {
            kept: shared.kept.load(Ordering::Acquire),
            lost: others + lost_of.values().sum::<u64>(),
            bytes: shared.bytes.load(Ordering::Relaxed),
            trouble: lock(&shared.trouble).clone(),
            lost_of,
            files: lock(&shared.files).clone(),
            parts: Some(lock(&shared.parts).clone()).filter(|parts| parts.count > 0),
            short: shared.short.load(Ordering::Relaxed),
        }
    }

    /// Writes the values that are not yet written, the index and the end of the file. Later values are not
    /// recorded.
    pub fn finish(&self) -> Status {
        self.shared.closed.store(true, Ordering::Release);
        if let Some(thread) = lock(&self.thread).take() {
            thread.thread().unpark();
            // The panic hook has reported a panic of that thread. The file then ends where it was.
            let _ = thread.join();
        }
        lock(&self.watches).clear();
        self.status()
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Why a recording did not start.
pub(crate) enum Failed {
    Write(std::io::Error),
    Thread(std::io::Error),
}

impl Failed {
    fn of(self, path: &Path) -> Error {
        match self {
            Self::Write(error) => Error::Create {
                path: path.to_owned(),
                error,
            },
            Self::Thread(error) => Error::Thread(error),
        }
    }
}

fn shared(lossless: bool) -> (Arc<Shared>, Receiver<(u64, Told)>) {
    let (tell, told) = sync_channel(EVENTS);
    (Arc::new(Shared::new(tell, lossless)), told)
}

#[cfg(test)]
mod tests;
