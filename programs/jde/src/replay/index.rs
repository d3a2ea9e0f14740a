//! The contents of a recording, found by reading it once: variables, schemas, and the values of topics that
//! seldom change. Publishes nothing. Its memory does not grow with the length of the recording. Who asks for one time opens
//! it without reading it.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use jde_abi::describe::Type;
use jde_core::Nanos;
use jde_log::{
    Channel, LeftOut, Messages, ReadError, RecordedHierarchy, RecordedMessage, RecordedVariables, Recording,
    record,
};
use jde_records::RunRecord;
use jde_records::turn::{Call, Turn, TurnKind};
use jde_ros::cdr;
use jde_timeline::{Hierarchy, Keep, Timeline};
use jde_types::Value as _;

use crate::failure::{Failure, display_path};

/// The topic of the schemas' turns.
pub(super) const TURNS_TOPIC: &str = "/jde/turns";
/// The most values of a seldom topic. The values of such a topic are all kept and are in force until the next
/// one.
const MAX_SELDOM_VALUES: usize = 1000;
/// The most bytes of a seldom topic. A topic with a few pictures is larger.
const MAX_SELDOM_BYTES: usize = 16 << 20;
/// The most bytes of all seldom topics. Those that come later count as others.
const MAX_ALL_SELDOM_BYTES: usize = 128 << 20;
/// How far before a place the newest values of all other topics are searched.
const LOOK_BACK: Nanos = 5_000_000_000;

/// A recording that can be played from any place.
pub(super) struct Index {
    recording: Recording,
    /// The time of the application's clock zero, in ns since 1970.
    pub(super) start_ns: u64,
    /// The time of the first message, in ns since the application's start. A recording that was started
    /// later, or that waited for a condition, begins in the middle of a run.
    pub(super) begin: Nanos,
    /// The time of the last message, in ns since the application's start.
    pub(super) end: Nanos,
    /// Its variables.
    pub(super) variables: Arc<RecordedVariables>,
    /// The schemas whose panels it contains, by topic.
    pub(super) panels: Arc<BTreeMap<String, String>>,
    /// Its schemas and groups, before the first event.
    pub(super) initial: Timeline,
    /// Whether it states its schemas and groups itself. Those of others are known from its records.
    pub(super) is_described: bool,
    /// The name of the application.
    pub(super) application: String,
    /// Files, topics and messages that cannot be played.
    pub(super) left_out: LeftOut,
    seldom: BTreeMap<String, Vec<RecordedValue>>,
}

/// Everything from some place on.
pub(super) type Entries = Box<dyn Iterator<Item = IndexEntry> + Send>;

/// A cycle of a schema.
#[derive(Clone, Copy)]
pub(super) struct Cycle {
    /// When it ended.
    pub(super) time: Nanos,
    /// The schema's index in the cast.
    pub(super) schema: usize,
    /// Whether the schema iterated.
    pub(super) iterated: bool,
}

/// A value of a variable, or a drawing of a panel.
#[derive(Clone)]
pub(super) struct RecordedValue {
    /// Its topic.
    pub(super) topic: String,
    /// When it was published, and when it was measured.
    pub(super) published: Nanos,
    pub(super) measured: Nanos,
    /// The message, in the encoding of its topic.
    pub(super) message: Vec<u8>,
    /// When it was retracted or its validity was over (R19), if it had ended.
    pub(super) ended: Option<Nanos>,
}

/// An entry of the recording that playback uses.
pub(super) enum IndexEntry {
    Value(RecordedValue),
    Line(Nanos, RunRecord),
    Cycle(Cycle),
}

impl IndexEntry {
    /// Returns its time.
    pub(super) fn time(&self) -> Nanos {
        match self {
            Self::Value(value) => value.published,
            Self::Line(time, _) => *time,
            Self::Cycle(cycle) => cycle.time,
        }
    }
}

impl Index {
    /// Reads a recording, up to its damage if it has any.
    pub(super) fn read(file: &Path) -> Result<Self, Failure> {
        let mut index = Self::open(file)?;
        // The last message that can be read is the end.
        index.end = 0;
        let mut hierarchy = index.initial.hierarchy().clone();
        index.scan(&mut hierarchy)?;
        index.initial = Timeline::new(hierarchy, Keep::PRESENT);
        // Possibly no message can be read.
        index.end = index.end.max(index.begin);
        Ok(index)
    }

    /// Opens a recording without reading its messages. It knows no seldom topics then, and its end is the one that the
    /// index of the file states.
    pub(super) fn open(file: &Path) -> Result<Self, Failure> {
        let recording = Recording::open(file)?;
        let Some((first, last)) = recording.times() else {
            return Err(Failure::usage(
                format!("{} holds no messages", display_path(file)),
                "`jde run APP --record FILE` records them",
            ));
        };
        let metadata = |key: &str| recording.metadata("jde").and_then(|metadata| metadata.get(key));
        // A recording of another program begins with its first message.
        let start_ns = metadata("start_ns")
            .and_then(|start| start.parse().ok())
            .unwrap_or(first);
        let application = metadata("application").cloned().unwrap_or_else(|| {
            let stem = file.file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        });
        let recorded = RecordedHierarchy::of_recording(&recording);
        let is_described = recorded.is_some();
        let hierarchy = recorded.map_or_else(Hierarchy::default, |recorded| recorded.hierarchy());
        let variables = RecordedVariables::of(&recording);
        Ok(Self {
            left_out: variables.left_out().clone(),
            variables: Arc::new(variables),
            panels: Arc::new(panels(&recording)),
            initial: Timeline::new(hierarchy, Keep::PRESENT),
            is_described,
            start_ns,
            begin: first.saturating_sub(start_ns),
            end: last.saturating_sub(start_ns),
            application,
            seldom: BTreeMap::new(),
            recording,
        })
    }

    /// Describes the damage of the file, if it has any.
    pub(super) fn damage(&self) -> Option<String> {
        Some(self.recording.damage()?.sentence())
    }

    /// Describes what the recording has not.
    pub(super) fn gaps(&self) -> impl Iterator<Item = String> {
        self.recording.gaps().iter().map(ToString::to_string)
    }

    /// Returns everything from a place on.
    pub(super) fn entries_from(&self, place: Nanos) -> Result<Entries, Failure> {
        let messages = self
            .recording
            .messages_from(self.start_ns.saturating_add(place))?;
        let (variables, panels) = (Arc::clone(&self.variables), Arc::clone(&self.panels));
        let start = self.start_ns;
        let messages = messages.map_while(Result::ok);
        Ok(Box::new(messages.filter_map(move |message| {
            read_entry(message, start, &variables, &panels)
        })))
    }

    /// Returns what some channels have from one time to another, both included, and last the error that ends it, if any does.
    pub(super) fn entries_of(
        &self,
        times: RangeInclusive<Nanos>,
        is_wanted: impl Fn(&Channel) -> bool,
    ) -> Result<impl Iterator<Item = Result<IndexEntry, ReadError>>, Failure> {
        let [from, until] = [*times.start(), *times.end()].map(|place| self.start_ns.saturating_add(place));
        let messages = self.recording.messages_of(from..=until, is_wanted)?;
        Ok(messages.filter_map(move |message| match message {
            Ok(message) => read_entry(message, self.start_ns, &self.variables, &self.panels).map(Ok),
            Err(error) => Some(Err(error)),
        }))
    }

    /// Returns the newest value before a place, and when it had ended, if it had: of every seldom topic, and of
    /// other topics with a value in the last [`LOOK_BACK`].
    pub(super) fn latest_values(&self, place: Nanos) -> Result<Vec<RecordedValue>, Failure> {
        let mut newest = BTreeMap::new();
        for values in self.seldom.values() {
            let before = values.partition_point(|value| value.published < place);
            if let Some(value) = before.checked_sub(1).map(|last| &values[last]) {
                let value = RecordedValue {
                    ended: value.ended.filter(|ended| *ended < place),
                    ..value.clone()
                };
                newest.insert(value.topic.clone(), value);
            }
        }
        for next in self.entries_from(place.saturating_sub(LOOK_BACK))? {
            match next {
                IndexEntry::Value(value) if value.published < place => {
                    newest.insert(value.topic.clone(), value);
                }
                IndexEntry::Value(_) => break,
                IndexEntry::Line(time, line) if time < place => {
                    if let Some(topic) = self.retracted_topic(&line)
                        && let Some(value) = newest.get_mut(topic)
                    {
                        value.ended = Some(time);
                    }
                }
                IndexEntry::Line(..) | IndexEntry::Cycle(_) => {}
            }
        }
        Ok(newest.into_values().collect())
    }

    /// Returns the topic of the variable whose value ended, if a line says so.
    pub(super) fn retracted_topic(&self, line: &RunRecord) -> Option<&str> {
        let name = line.retracted_variable()?;
        let variable = self.variables.iter().find(|variable| variable.name == name)?;
        Some(&variable.topic)
    }

    fn scan(&mut self, hierarchy: &mut Hierarchy) -> Result<(), Failure> {
        let mut often: BTreeMap<String, (usize, usize)> = BTreeMap::new();
        let messages: Messages = self.recording.messages()?;
        let (mut all_bytes, mut buffer) = (0, Vec::new());
        // The first unreadable message is the place of the damage, which has been reported.
        for message in messages.map_while(Result::ok) {
            self.end = self.end.max(message.log_time.saturating_sub(self.start_ns));
            self.variables.check(&message, &mut buffer, &mut self.left_out);
            match read_entry(message, self.start_ns, &self.variables, &self.panels) {
                Some(IndexEntry::Line(time, line)) => {
                    hierarchy.add_names(&line);
                    if let Some(topic) = self.retracted_topic(&line).map(str::to_owned)
                        && let Some(values) = self.seldom.get_mut(&topic)
                        && let Some(value) = values.last_mut()
                    {
                        value.ended = value.ended.or(Some(time));
                    }
                }
                Some(IndexEntry::Cycle(_)) | None => {}
                Some(IndexEntry::Value(value)) => {
                    let (count, bytes) = often.entry(value.topic.clone()).or_default();
                    *count += 1;
                    *bytes += value.message.len();
                    let is_kept = *count == 1 || self.seldom.contains_key(&value.topic);
                    let is_full = all_bytes + value.message.len() > MAX_ALL_SELDOM_BYTES;
                    if *count > MAX_SELDOM_VALUES || *bytes > MAX_SELDOM_BYTES || is_full || !is_kept {
                        let kept = self.seldom.remove(&value.topic).unwrap_or_default();
                        all_bytes -= kept.iter().map(|value| value.message.len()).sum::<usize>();
                    } else {
                        all_bytes += value.message.len();
                        self.seldom.entry(value.topic.clone()).or_default().push(value);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Converts a message. Returns `None` if playback does not use it.
fn read_entry(
    message: RecordedMessage,
    start: u64,
    variables: &RecordedVariables,
    panels: &BTreeMap<String, String>,
) -> Option<IndexEntry> {
    let published = message.log_time.saturating_sub(start);
    let topic = &message.channel.topic;
    if record::kind(&message.channel).is_some() {
        // Skip a line of a newer version that cannot be read.
        return Some(IndexEntry::Line(published, record::read(&message)?));
    }
    if topic == TURNS_TOPIC {
        // A description is built by each call, which would cost more than the turn.
        static TURN: LazyLock<Type> = LazyLock::new(Turn::describe);
        let bytes = cdr::decode(&TURN, &message.data).ok()?;
        let turn = Turn::from_bytes(&bytes)?;
        return matches!(turn.kind(), TurnKind::Cycled(_)).then_some(IndexEntry::Cycle(Cycle {
            time: published,
            schema: turn.schema as usize,
            iterated: turn.acted != Call::default(),
        }));
    }
    if variables.get(&message.channel).is_none() && !panels.contains_key(topic) {
        return None;
    }
    Some(IndexEntry::Value(RecordedValue {
        topic: topic.clone(),
        published,
        measured: message.publish_time.saturating_sub(start),
        message: message.data,
        ended: None,
    }))
}

/// The topics of all panels, with their schemas.
fn panels(recording: &Recording) -> BTreeMap<String, String> {
    let of = |channel: &Channel| {
        let schema = jde_log::panel::schema(channel)?;
        Some((channel.topic.clone(), schema.to_owned()))
    };
    recording.channels().filter_map(of).collect()
}
