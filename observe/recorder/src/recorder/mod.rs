//! A running recording. A thread of its own writes it.

mod split;
mod trigger_options;
mod trouble;
mod turns;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{Builder, JoinHandle};

use jde_abi::describe::Type;
use jde_app::Application;
use jde_board::{Nanos, Variable, Watch};
use jde_conditions::Triggers;
use jde_log::{log_line, panel};
use jde_records::event::{Event, Observer};
use jde_records::{RecordBuilder, RunRecord};
use parking_lot::Mutex;

use crate::sink::{self, ContinuousSink, OpenFile, Plan, Sink, TriggeredSink};
use crate::topic::{Notice, Shared, Topic, TopicContent, TopicQueue};
use crate::writer_thread::WriterThread;
use crate::{Error, Origin, subscriber};

pub use split::{PartSize, Parts, SplitOptions};
pub use trigger_options::{FileEvent, OnFile, TriggerOptions, TriggeredFile};
pub use trouble::{OnTrouble, Trouble};
pub use turns::turns;

/// Upper limit of the notices that are not yet written: more than the busiest application sends while a disk
/// blocks for a second.
const MAX_NOTICES: usize = 4096;

/// Returns the application's time, in ns since its start. Any thread may call it.
pub type Clock = Arc<dyn Fn() -> Nanos + Send + Sync>;

/// How to record.
pub struct RecorderOptions<'a> {
    /// The origin of the recording.
    pub origin: Origin,
    /// The application whose events are recorded. Without it no events are recorded.
    pub application: Option<&'a Application>,
    /// Whether an existing file is overwritten.
    pub overwrite: bool,
    /// Whether publishers wait instead of losing values. For virtual time only.
    pub lossless: bool,
    /// Called when the disk does not accept more data, or again, and when a part cannot be deleted. The run continues. Of what
    /// repeats, few are reported.
    pub on_trouble: OnTrouble,
}

/// A running recording. Any thread may call it. Dropping it finishes it.
pub struct Recorder {
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
    watches: Mutex<Vec<Watch>>,
    /// The variables that conditions name.
    condition_variables: BTreeSet<String>,
}

/// The progress of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Messages that have reached the file. After a failure, only those that the disk has confirmed.
    pub written: u64,
    /// Values and events that have not reached the file, for any reason.
    pub lost: u64,
    /// The size of the file in bytes.
    pub bytes: u64,
    /// Why the recording has ended too early, or why the last failed file failed.
    pub error: Option<String>,
    /// The number of lost values of each topic that lost any.
    pub lost_by_topic: BTreeMap<String, u64>,
    /// The files that conditions have caused.
    pub files: Vec<TriggeredFile>,
    /// The files of a recording in parts, or of one that went on in others after the disk had failed.
    pub parts: Option<Parts>,
    /// Messages of the past that were removed from memory before their time ended.
    pub evicted: u64,
}

impl Recorder {
    /// Starts a recording in one file. Creates the folders above it. Where the disk fails or is full, the recording goes on
    /// as [`Self::create_split`] does: for `drive.mcap` in `drive-001.mcap`, or the first free name after it. If
    /// `options.overwrite` is set, such parts of the overwritten recording are deleted. A recording into a pipe or a device
    /// ends with its first error.
    ///
    /// # Errors
    /// [`Error`], also if the disk is full already.
    pub fn create(path: &Path, options: RecorderOptions<'_>) -> Result<Self, Error> {
        let (overwrite, lossless) = (options.overwrite, options.lossless);
        Self::create_continuous(options, |origin| {
            sink::PartSequence::begin_whole(path, origin, overwrite, lossless)
        })
    }

    /// Starts a recording in parts, which may continue forever: one file after the other, with numbers that
    /// follow those of existing files of this name. If `options.overwrite` is set, existing parts of that
    /// name are deleted first. Every file except the first starts with the values in force at its beginning,
    /// stamped with that time.
    ///
    /// # Errors
    /// [`Error`], also if the disk is full already.
    pub fn create_split(
        path: &Path,
        options: RecorderOptions<'_>,
        split: SplitOptions,
    ) -> Result<Self, Error> {
        let (overwrite, lossless) = (options.overwrite, options.lossless);
        Self::create_continuous(options, |origin| {
            let (split, file) = sink::PartSequence::begin(path, split, origin, overwrite, lossless)?;
            Ok((Some(split), file))
        })
    }

    /// Starts a recording of everything. `begin` creates its first file.
    pub(crate) fn create_continuous(
        options: RecorderOptions<'_>,
        begin: impl FnOnce(Origin) -> Result<(Option<sink::PartSequence>, OpenFile), Error>,
    ) -> Result<Self, Error> {
        let (split, file) = begin(options.origin)?;
        let (shared, notices) = new_shared(options.lossless);
        let sink = ContinuousSink::new(&shared, file, split, options.on_trouble);
        Self::start(shared, notices, Box::new(sink), None, options.application)
    }

    /// Keeps the recent past in memory. When a condition becomes true, it writes a file of the time before
    /// and after that moment. For `drive.mcap`, the file has the first free name of `drive-001.mcap`,
    /// `drive-002.mcap` and so on. Each file starts with the values in force at its beginning, stamped with
    /// that time. `options.on_trouble` is not called.
    ///
    /// # Errors
    /// [`Error`], also if no file can be created in the folder.
    pub fn create_triggered(
        path: &Path,
        options: RecorderOptions<'_>,
        when: TriggerOptions,
    ) -> Result<Self, Error> {
        let plan = Plan {
            path: path.to_owned(),
            overwrite: options.overwrite,
            before: when.before,
            after: when.after,
            memory: when.memory,
        };
        let (shared, notices) = new_shared(options.lossless);
        let origin = options.origin;
        let sink = TriggeredSink::new(&shared, origin, plan, when.on_file)?;
        Self::start(
            shared,
            notices,
            Box::new(sink),
            Some(when.triggers),
            options.application,
        )
    }

    fn start(
        shared: Arc<Shared>,
        notices: Receiver<(u64, Notice)>,
        sink: Box<dyn Sink>,
        triggers: Option<Triggers>,
        application: Option<&Application>,
    ) -> Result<Self, Error> {
        let records = application.map(RecordBuilder::with_all_drags);
        let variables = triggers.as_ref().map(Triggers::variables).unwrap_or_default();
        let variables = variables.into_iter().map(str::to_owned).collect();
        let writer_thread = WriterThread::new(&shared, sink, triggers, records, notices);
        let thread = Builder::new()
            .name("recording".to_owned())
            .spawn(move || writer_thread.run())
            .map_err(Error::Thread)?;
        // This is the only place that sets it.
        let _ = shared.writer_thread.set(thread.thread().clone());
        Ok(Self {
            shared,
            thread: Mutex::new(Some(thread)),
            watches: Mutex::default(),
            condition_variables: variables,
        })
    }

    /// Records every value of a variable from now on, including the present one, until the recording is
    /// finished.
    pub fn watch(&self, variable: &Arc<Variable>, clock: Clock) {
        self.subscribe(variable, clock, true);
    }

    /// Lets the conditions that name a variable read it, without recording its values.
    pub fn watch_for_conditions(&self, variable: &Arc<Variable>, clock: Clock) {
        if self
            .condition_variables
            .contains(&variable.describe().full_name())
        {
            self.subscribe(variable, clock, false);
        }
    }

    fn subscribe(&self, variable: &Arc<Variable>, clock: Clock, is_recorded: bool) {
        self.shared.clock.get_or_init(|| Arc::clone(&clock));
        let (topic, watch) = subscriber::watch(variable, &self.shared, clock, is_recorded);
        self.watches.lock().push(watch);
        self.shared.topics.lock().push(topic.queue);
    }

    /// Adds a topic for values of another process. `metadata` is that of its channel. Conditions refer to the
    /// topic by the entry `variable` in it.
    pub fn topic(&self, name: &str, value_type: Arc<Type>, metadata: BTreeMap<String, String>) -> Topic {
        self.add_topic(name, TopicContent::Values(value_type), metadata, true)
    }

    /// Adds the topic of a schema's panel, `/panels/<schema>`. [`Topic::put_panel`] fills it.
    pub fn panel(&self, schema: &str) -> Topic {
        let metadata = BTreeMap::from([(panel::SCHEMA.to_owned(), schema.to_owned())]);
        self.add_topic(&panel::topic(schema), TopicContent::PANEL, metadata, true)
    }

    /// Adds the topic of the log of schemas, `/rosout`. [`Topic::put_message`] with [`log_line::message`] fills it.
    pub fn log(&self) -> Topic {
        let metadata = BTreeMap::from([(log_line::LOG.to_owned(), "schemas".to_owned())]);
        self.add_topic(log_line::TOPIC, TopicContent::LOG, metadata, true)
    }

    /// Adds a topic that conditions read and no file contains. `None` if no condition names the variable.
    pub fn condition_topic(&self, variable: &str, value_type: Arc<Type>) -> Option<Topic> {
        let metadata = BTreeMap::from([("variable".to_owned(), variable.to_owned())]);
        self.condition_variables.contains(variable).then(|| {
            self.add_topic(
                &jde_log::topic_name(variable),
                TopicContent::Values(value_type),
                metadata,
                false,
            )
        })
    }

    fn add_topic(
        &self,
        name: &str,
        content: TopicContent,
        metadata: BTreeMap<String, String>,
        is_recorded: bool,
    ) -> Topic {
        let queue = Arc::new(TopicQueue::new(
            name.to_owned(),
            content,
            metadata,
            None,
            is_recorded,
        ));
        self.shared.topics.lock().push(Arc::clone(&queue));
        Topic {
            queue,
            shared: Arc::clone(&self.shared),
        }
    }

    /// Returns an observer that records the events of the application with which the recording was started.
    #[must_use]
    pub fn observer(&self) -> Box<dyn Observer> {
        let shared = Arc::clone(&self.shared);
        Box::new(move |event: &Event| shared.push_notice(Notice::Event(event.clone())))
    }

    /// Records a record of an application in another process.
    pub fn push_record(&self, record: RunRecord) {
        self.shared.push_notice(Notice::Record(record));
    }

    /// Records a record of another process from before the recording, which began at `beginning` of the
    /// application's clock. Its log time is `beginning`, and its publish time is its own time. It does not
    /// fire conditions.
    pub fn push_earlier_record(&self, record: RunRecord, beginning: Nanos) {
        self.shared.push_notice(Notice::EarlierRecord(record, beginning));
    }

    /// Returns the progress of the recording.
    #[must_use]
    pub fn status(&self) -> Status {
        let shared = &*self.shared;
        let lost_by_topic = shared.lost_by_topic();
        let others = shared.lost_events.load(Ordering::Relaxed) + shared.dropped.load(Ordering::Relaxed);
        Status {
            written: shared.written.load(Ordering::Acquire),
            lost: others + lost_by_topic.values().sum::<u64>(),
            bytes: shared.bytes.load(Ordering::Relaxed),
            error: shared.error.lock().clone(),
            lost_by_topic,
            files: shared.files.lock().clone(),
            parts: Some(shared.parts.lock().clone()).filter(|parts| parts.count > 0),
            evicted: shared.evicted.load(Ordering::Relaxed),
        }
    }

    /// Writes the values that are not yet written, the index and the end of the file. Later values are not
    /// recorded.
    pub fn finish(&self) -> Status {
        self.shared.closed.store(true, Ordering::Release);
        if let Some(thread) = self.thread.lock().take() {
            thread.thread().unpark();
            // The panic hook has reported a panic of that thread. The file then ends where it was.
            let _ = thread.join();
        }
        self.watches.lock().clear();
        self.status()
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.finish();
    }
}

fn new_shared(lossless: bool) -> (Arc<Shared>, Receiver<(u64, Notice)>) {
    let (sender, receiver) = sync_channel(MAX_NOTICES);
    (Arc::new(Shared::new(sender, lossless)), receiver)
}

#[cfg(test)]
pub(crate) mod tests;
