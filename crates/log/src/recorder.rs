//! A recording under way: what a program holds in its hands. The writing is done by a thread of its own.

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

/// Events on their way: more than the busiest application tells while a disk stands still for a second.
const EVENTS: usize = 4096;

/// Tells the application's time, ns since its start, from any thread.
pub type Clock = Arc<dyn Fn() -> Nanos + Send + Sync>;

/// Is told why the disk takes no more.
pub type OnTrouble = Box<dyn FnMut(&str) + Send>;

/// How to record.
pub struct Options<'a> {
    /// Where the recording comes from.
    pub origin: Origin,
    /// The application whose events are kept; without one there are none.
    pub application: Option<&'a Application>,
    /// Write over what is there.
    pub overwrite: bool,
    /// Whoever publishes waits rather than lose a value: for virtual time only.
    pub lossless: bool,
    /// Told once, by the writing thread, when the disk takes no more; the run goes on.
    pub on_trouble: OnTrouble,
}

/// A recording under way. Any thread may call it. Dropped, it is finished.
pub struct Recorder {
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
    watches: Mutex<Vec<Watch>>,
    /// The variables that conditions name.
    named: BTreeSet<String>,
}

/// How a recording is doing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Messages that have reached the file; after a failure those of them that the disk has said to have.
    pub kept: u64,
    /// Values and events that did not, whatever the reason.
    pub lost: u64,
    /// Bytes of the file.
    pub bytes: u64,
    /// Why nothing is written any more, or why the last file that failed did.
    pub trouble: Option<String>,
    /// Topics of which values were lost, and how many.
    pub lost_of: BTreeMap<String, u64>,
    /// The files that conditions asked for.
    pub files: Vec<Written>,
    /// The files of a recording in parts.
    pub parts: Option<Parts>,
    /// Messages of the past that had to go from memory before their time was up.
    pub short: u64,
}

impl Recorder {
    /// Begins a recording in a file of its own, and makes the folders above it.
    ///
    /// # Errors
    /// [`Error`]; a disk that is full already is one.
    pub fn create(path: &Path, options: Options<'_>) -> Result<Self, Error> {
        let (output, disk) = sink::create(path, options.overwrite)?;
        Self::begin(output, disk, options).map_err(|error| error.of(path))
    }

    /// Begins a recording in parts, which may go on for ever: one file after the other, numbered behind those that are there under
    /// this name. With `options.overwrite` parts of that name are deleted first. In all files but the first the values in force at
    /// their beginning come first, stamped with that time.
    ///
    /// # Errors
    /// [`Error`]; a disk that is full already is one.
    pub fn split(path: &Path, options: Options<'_>, split: Split) -> Result<Self, Error> {
        let (shared, told) = shared(options.lossless);
        let (overwrite, lossless) = (options.overwrite, options.lossless);
        let (split, file) = sink::Split::begin(path, split, options.origin, overwrite, lossless)?;
        let sink = Whole::new(&shared, file, Some(split), options.on_trouble);
        Self::start(shared, told, Box::new(sink), None, options.application).map_err(|error| error.of(path))
    }

    /// Keeps the recent past in memory, and whenever a condition comes true writes a file of what was before and comes after:
    /// of `drive.mcap`, the first whose name is free of `drive-001.mcap`, `drive-002.mcap`. In the files, the values in force at
    /// their beginning come first, stamped with that time. `options.on_trouble` is not called.
    ///
    /// # Errors
    /// [`Error`]; a folder where no file can be made is one.
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
        // Set here only.
        let _ = shared.scribe.set(thread.thread().clone());
        Ok(Self {
            shared,
            thread: Mutex::new(Some(thread)),
            watches: Mutex::default(),
            named,
        })
    }

    /// Keeps every value of a variable from now on, the present one included, until the recording is finished.
    pub fn watch(&self, variable: &Arc<Variable>, clock: Clock) {
        self.tap(variable, clock, true);
    }

    /// Has a variable looked at by the conditions that name it, without keeping its values.
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

    /// Adds a topic whose values come from elsewhere. `about` is what the recording says of it; `variable` in it is the name by
    /// which conditions know it.
    pub fn topic(&self, name: &str, value_type: Arc<Type>, about: BTreeMap<String, String>) -> Topic {
        self.lane(name, Holds::Values(value_type), about, true)
    }

    /// Adds the topic of a schema's panel, `/panels/<schema>`: filled by [`Topic::put_panel`].
    pub fn panel(&self, schema: &str) -> Topic {
        let about = BTreeMap::from([(panel::SCHEMA.to_owned(), schema.to_owned())]);
        self.lane(&panel::topic(schema), Holds::Panel, about, true)
    }

    /// A topic whose values the conditions look at and no file keeps; none if no condition names the variable.
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

    /// Hears the events of the application that the recording was begun with.
    #[must_use]
    pub fn observer(&self) -> Box<dyn Observer> {
        let shared = Arc::clone(&self.shared);
        Box::new(move |event: &Event| shared.tell(Told::Event(event.clone())))
    }

    /// Keeps a message of the story of an application elsewhere.
    pub fn line(&self, line: Line) {
        self.shared.tell(Told::Line(line));
    }

    /// Keeps a message of what had happened elsewhere before the recording began, at `beginning` of the application's clock: it
    /// is stamped with that, its publish time tells when it was, and no condition comes true by it.
    pub fn earlier(&self, line: Line, beginning: Nanos) {
        self.shared.tell(Told::Earlier(line, beginning));
    }

    /// How it is doing.
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

    /// Writes what is on its way, the index and the end. What is published later is not kept.
    pub fn finish(&self) -> Status {
        self.shared.closed.store(true, Ordering::Release);
        if let Some(thread) = lock(&self.thread).take() {
            thread.thread().unpark();
            // A panic of that thread has been told by its hook, and the file ends where it was.
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

/// Why a recording did not begin.
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
