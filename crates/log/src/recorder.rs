//! A recording under way: what a program holds in its hands. The writing is done by a thread of its own.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};

use jde_abi::describe::Type;
use jde_board::{Nanos, Variable, Watch};
use jde_host::app::Application;
use jde_host::event::{Event, Observer};
use jde_host::story::Story;

use crate::lane::{Lane, Shared, Told, Topic, lock};
use crate::scribe::{Scribe, Syncer};
use crate::tap;
use crate::writer::{self, Output, Writer};
use crate::{Error, Origin};

/// Events on their way: more than the busiest application tells while a disk stands still for a second.
const EVENTS: usize = 4096;

/// Tells the application's time, ns since its start, from any thread.
pub type Clock = Arc<dyn Fn() -> Nanos + Send + Sync>;

/// Is told why the disk takes no more.
pub type OnTrouble = Box<dyn FnOnce(&str) + Send>;

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
}

/// How a recording is doing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Messages that have reached the file.
    pub kept: u64,
    /// Values and events that did not, whatever the reason.
    pub lost: u64,
    /// Bytes of the file.
    pub bytes: u64,
    /// Why nothing is written any more.
    pub trouble: Option<String>,
    /// Topics of which values were lost, and how many.
    pub lost_of: BTreeMap<String, u64>,
}

impl Recorder {
    /// Begins a recording in a file of its own, and makes the folders above it.
    ///
    /// # Errors
    /// [`Error`]; a disk that is full already is one.
    pub fn create(path: &Path, options: Options<'_>) -> Result<Self, Error> {
        let file = writer::create(path, options.overwrite)?;
        let disk = file
            .metadata()
            .is_ok_and(|file| file.is_file())
            .then(|| file.try_clone().ok())
            .flatten();
        Self::begin(Box::new(file), disk, options).map_err(|error| match error {
            Failed::Write(error) => Error::Create {
                path: path.to_owned(),
                error,
            },
            Failed::Thread(error) => Error::Thread(error),
        })
    }

    pub(crate) fn begin(output: Output, disk: Option<File>, options: Options<'_>) -> Result<Self, Failed> {
        let writer = Writer::begin(output, &options.origin).map_err(Failed::Write)?;
        let (tell, told): (_, Receiver<Told>) = sync_channel(EVENTS);
        let shared = Arc::new(Shared::new(tell, options.lossless));
        let syncer = disk.map(Syncer::start).transpose().map_err(Failed::Thread)?;
        let story = options.application.map(Story::new);
        let scribe = Scribe::new(&shared, writer, story, told, syncer, options.on_trouble);
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
        })
    }

    /// Keeps every value of a variable from now on, the present one included, until the recording is finished.
    pub fn watch(&self, variable: &Arc<Variable>, clock: Clock) {
        let (topic, watch) = tap::watch(variable, &self.shared, clock);
        lock(&self.watches).push(watch);
        lock(&self.shared.lanes).push(topic.lane);
    }

    /// Adds a topic whose values come from elsewhere. `about` is what the recording says of it.
    pub fn topic(&self, name: &str, value_type: Arc<Type>, about: BTreeMap<String, String>) -> Topic {
        let lane = Arc::new(Lane::new(name.to_owned(), value_type, about, None));
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

    /// How it is doing.
    #[must_use]
    pub fn status(&self) -> Status {
        let shared = &*self.shared;
        let lanes = lock(&shared.lanes);
        let lost_of: BTreeMap<_, _> = lanes
            .iter()
            .map(|lane| (lane.name.clone(), lane.lost.load(Ordering::Relaxed)))
            .filter(|(_, lost)| *lost > 0)
            .collect();
        let others = shared.lost_events.load(Ordering::Relaxed) + shared.dropped.load(Ordering::Relaxed);
        Status {
            kept: shared.kept.load(Ordering::Acquire),
            lost: others + lost_of.values().sum::<u64>(),
            bytes: shared.bytes.load(Ordering::Relaxed),
            trouble: lock(&shared.trouble).clone(),
            lost_of,
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

#[cfg(test)]
mod tests;
