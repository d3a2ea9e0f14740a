//! Reads a recording once from its beginning. It returns steps in their order, and values by their time or
//! number. Only what had to be read ahead is in memory.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_app::Application;
use jde_core::Nanos;
use jde_host::replay::{RecordedRun, RecordedSource, RecordedValue, ReplayStep};
use jde_log::part::Gap;
use jde_log::{Damage, Messages, RecordedMessage, TURNS_TOPIC, record};
use jde_panel::Gesture;
use jde_records::event::{Occurrence, What};
use jde_records::turn::{INPUTS, RecordedTurn, Turn, TurnKind};
use jde_records::{Decision, RunRecord};
use jde_ros::{cdr, definition};
use jde_types::Value;
use parking_lot::Mutex;

use crate::steps::{Next, RecordingEnd, Steps};
use crate::translation::Translation;
use crate::{ReplayError, ReplayedDrive};

/// How long to wait for a missing step, in ns of the drive's time: longer than any call takes before it is
/// given up.
const STEP_TIMEOUT: Nanos = 30_000_000_000;
/// How much later than the step that saw it a value's time of publication may be, in ns. The writer
/// determines that time.
const PUBLICATION_SLACK: Nanos = 2_000_000_000;
/// At least this many values of a variable are kept for the steps in which they were written, because those
/// steps are read later than the values.
const MIN_WRITTEN_VALUES: usize = 64;
/// More values of a variable are kept while they need at most this many bytes.
const MAX_WRITTEN_BYTES: usize = 4 << 20;

/// A recording during a replay. Clones share their state.
#[derive(Clone)]
pub(super) struct ReplayReader {
    inner: Arc<Mutex<Inner>>,
}

struct Inner {
    messages: Messages,
    start: u64,
    /// The first time that cannot be read, before which the replay ends.
    gap: Option<Gap>,
    /// The time up to which the recording has been read.
    read: Nanos,
    at_end: bool,
    damage: Option<String>,
    /// The time of the last step.
    time: Nanos,
    steps: Steps,
    translation: Translation,
    turn_type: Type,
    sources: Vec<SourceQueue>,
    source_of: BTreeMap<String, usize>,
    written: BTreeMap<String, WrittenValues>,
    /// The present name of each modulation by the one that it had before.
    former_names: BTreeMap<String, String>,
    /// Further ports of the next turn of a schema, by the schema's number in the recording.
    extra_ports: BTreeMap<u32, Vec<u32>>,
    /// The number of turns with missing ports.
    partial: u64,
    /// Gestures on panels that are not yet repeated, by their numbers: the operator and the gesture.
    gestures: BTreeMap<u64, (String, Gesture)>,
    decisions: Vec<Decision>,
    /// Schemas whose builds changed, and when.
    reloads: Vec<(u32, Nanos)>,
}

/// The last values of a variable that schemas or operators write, with their numbers.
struct WrittenValues {
    value_type: Arc<Type>,
    values: VecDeque<(u32, Vec<u8>)>,
}

/// The values of a source that are not yet used.
struct SourceQueue {
    value_type: Arc<Type>,
    queue: VecDeque<RecordedValue>,
    last: u32,
}

impl ReplayReader {
    /// Opens a drive, for an application that repeats it.
    ///
    /// # Errors
    /// [`crate::ReplayError::Incomplete`] if a variable that schemas import is missing.
    pub(super) fn new(
        drive: &ReplayedDrive,
        application: &Application,
        sources: &[RecordedSource],
    ) -> Result<Self, ReplayError> {
        let recording = drive.recording();
        let incomplete = |what: String| ReplayError::Incomplete {
            path: recording.path().display().to_string(),
            what,
        };
        for source in sources.iter().filter(|source| source.imported) {
            let channel = recording
                .channels()
                .find(|channel| channel.metadata.get("variable") == Some(&source.name))
                .ok_or_else(|| {
                    incomplete(format!(
                        "`{}` is not in it, and schemas import it; record it too",
                        source.name
                    ))
                })?;
            if *channel.definition != *definition::definition(&source.value_type).as_bytes() {
                return Err(incomplete(format!(
                    "the definition of `{}` (a {}) in it differs from that of {} in the application",
                    source.name, channel.type_name, source.value_type.name
                )));
            }
        }
        let modulations = application.instances.iter().flat_map(|instance| {
            let ports = instance.schema.ports.iter();
            let period = (format!("{}.period", instance.name), Arc::new(f64::describe()));
            ports
                .map(|port| {
                    (
                        format!("{}.{}", instance.name, port.name),
                        Arc::clone(&port.value_type),
                    )
                })
                .chain([period])
        });
        let former_names = application.instances.iter().flat_map(|instance| {
            instance.schema.ports.iter().filter_map(|port| {
                let variable = |name| format!("{}.{name}", instance.name);
                Some((variable(port.former_name.as_ref()?), variable(&port.name)))
            })
        });
        let numbered = sources.iter().enumerate();
        Ok(Self {
            inner: Arc::new(Mutex::new(Inner {
                messages: recording.messages()?,
                start: drive.start(),
                gap: recording.gaps().iter().min_by_key(|gap| gap.from).cloned(),
                read: 0,
                at_end: false,
                damage: recording.damage().map(Damage::sentence),
                time: 0,
                steps: Steps::new(),
                translation: Translation::new(drive, application),
                turn_type: Turn::describe(),
                source_of: numbered
                    .map(|(index, source)| (source.name.clone(), index))
                    .collect(),
                written: modulations
                    .map(|(name, value_type)| {
                        let values = VecDeque::new();
                        (name, WrittenValues { value_type, values })
                    })
                    .collect(),
                former_names: former_names.collect(),
                sources: sources
                    .iter()
                    .map(|source| SourceQueue {
                        value_type: Arc::clone(&source.value_type),
                        queue: VecDeque::new(),
                        last: 0,
                    })
                    .collect(),
                extra_ports: BTreeMap::new(),
                partial: 0,
                gestures: BTreeMap::new(),
                decisions: Vec::new(),
                reloads: Vec::new(),
            })),
        })
    }

    /// Returns the time of the last step.
    pub(super) fn time(&self) -> Nanos {
        self.inner.lock().time
    }

    /// Returns the selections that have been read since the last call.
    pub(super) fn decisions(&self) -> Vec<Decision> {
        std::mem::take(&mut self.inner.lock().decisions)
    }

    /// Returns the remaining selections, at the end of the replay.
    pub(super) fn remaining_decisions(&self) -> Vec<Decision> {
        let mut inner = self.inner.lock();
        let until = inner.time;
        inner.read_to(until);
        std::mem::take(&mut inner.decisions)
    }

    /// Returns the schemas whose builds changed, and when, as far as the recording has been read.
    pub(super) fn reloads(&self) -> Vec<(u32, Nanos)> {
        self.inner.lock().reloads.clone()
    }

    pub(super) fn lost_steps(&self) -> u64 {
        let inner = self.inner.lock();
        inner.steps.lost() + inner.partial
    }

    pub(super) fn damage(&self) -> Option<String> {
        self.inner.lock().damage.clone()
    }
}

impl RecordedRun for ReplayReader {
    fn next(&mut self) -> Option<ReplayStep> {
        self.inner.lock().next()
    }

    fn value_until(&mut self, source: usize, time: Nanos) -> Option<RecordedValue> {
        let mut inner = self.inner.lock();
        inner.read_to(time);
        inner.sources[source]
            .queue
            .pop_front_if(|old| old.published <= time)
    }

    fn value_up_to(&mut self, source: usize, number: u32) -> Option<RecordedValue> {
        let mut inner = self.inner.lock();
        let limit = inner.time.saturating_add(PUBLICATION_SLACK);
        while inner.sources[source].queue.is_empty()
            && is_before(inner.sources[source].last, number)
            && inner.read <= limit
            && inner.read_one()
        {}
        inner.sources[source]
            .queue
            .pop_front_if(|old| old.number == number || is_before(old.number, number))
    }

    fn gesture(&mut self, number: u64) -> Option<(String, Gesture)> {
        let mut inner = self.inner.lock();
        let limit = inner.time.saturating_add(PUBLICATION_SLACK);
        loop {
            if let Some(gesture) = inner.gestures.remove(&number) {
                return Some(gesture);
            }
            if inner.read > limit || !inner.read_one() {
                return None;
            }
        }
    }

    fn written_value(&mut self, variable: &str, number: u32) -> Option<Vec<u8>> {
        let mut inner = self.inner.lock();
        let limit = inner.time.saturating_add(PUBLICATION_SLACK);
        loop {
            let written = inner.written.get(variable)?;
            if let Some((_, bytes)) = written.values.iter().rev().find(|(other, _)| *other == number) {
                return Some(bytes.clone());
            }
            if inner.read > limit || !inner.read_one() {
                return None;
            }
        }
    }
}

impl Inner {
    fn next(&mut self) -> Option<ReplayStep> {
        loop {
            let late = self.read.checked_sub(STEP_TIMEOUT);
            let end = match (self.at_end, self.damage.is_some()) {
                (false, _) => RecordingEnd::More(late),
                (true, false) => RecordingEnd::Complete,
                (true, true) => RecordingEnd::CutOff,
            };
            match self.steps.next(end) {
                Next::Step(step) => {
                    if step.is_transaction() {
                        self.time = self.time.max(step.time);
                    }
                    return Some(step);
                }
                Next::Done => return None,
                Next::Wait => drop(self.read_one()),
            }
        }
    }

    /// Reads all messages up to that time.
    fn read_to(&mut self, time: Nanos) {
        while self.read <= time && self.read_one() {}
    }

    /// Reads one message. Returns false at the end.
    fn read_one(&mut self) -> bool {
        match self.messages.next() {
            Some(Ok(message)) => {
                let time = message.log_time.saturating_sub(self.start);
                if let Some(gap) = self.gap.as_ref().filter(|gap| time >= gap.from) {
                    self.damage = Some(gap.to_string());
                    self.at_end = true;
                    return false;
                }
                self.read = time;
                self.process(&message);
                true
            }
            Some(Err(error)) => {
                self.damage = Some(error.to_string());
                self.at_end = true;
                false
            }
            None => {
                self.at_end = true;
                false
            }
        }
    }

    fn process(&mut self, message: &RecordedMessage) {
        let topic = message.channel.topic.as_str();
        if topic == TURNS_TOPIC {
            self.process_turn(&message.data);
        } else if record::kind(&message.channel).is_some() {
            match record::read(message) {
                Some(RunRecord::Decision(decision)) => self.decisions.push(decision),
                Some(RunRecord::Other(event)) => self.process_event(&event),
                Some(RunRecord::State(_)) | None => {}
            }
        } else if let Some(variable) = message.channel.metadata.get("variable") {
            self.process_value(variable, message);
        }
    }

    fn process_turn(&mut self, data: &[u8]) {
        let Ok(bytes) = cdr::decode(&self.turn_type, data) else {
            return;
        };
        let Some(turn) = Turn::from_bytes(&bytes) else {
            return;
        };
        if let TurnKind::MorePorts { first } = turn.kind() {
            // A series that starts again belongs to another turn.
            let ports = self.extra_ports.entry(turn.schema).or_default();
            ports.truncate((first as usize).saturating_sub(INPUTS));
            ports.extend_from_slice(&turn.inputs);
            return;
        }
        let mut ports = turn.inputs.to_vec();
        ports.extend(self.extra_ports.remove(&turn.schema).into_iter().flatten());
        let has_ports = turn.inputs.len() == INPUTS;
        self.partial += u64::from(has_ports && ports.len() != self.translation.recorded_ports(turn.schema));
        let turn = self.translation.of(RecordedTurn { turn, ports });
        if matches!(turn.kind(), TurnKind::Reloaded(_)) {
            self.reloads.push((turn.schema, turn.time()));
        }
        self.steps.put(&Arc::new(turn));
    }

    fn process_event(&mut self, Occurrence { time, what }: &Occurrence<String>) {
        if let Some((number, gesture)) = what.gesture() {
            let by = what.by().unwrap_or_default().to_owned();
            self.gestures.insert(number, (by, gesture.clone()));
        }
        if let What::Retracted { variable } = what
            && let Some(index) = self.source_of.get(variable)
        {
            let source = &mut self.sources[*index];
            source.queue.push_back(RecordedValue {
                published: *time,
                measured: *time,
                number: source.last,
                bytes: None,
            });
        }
    }

    fn process_value(&mut self, variable: &str, message: &RecordedMessage) {
        let variable = self.former_names.get(variable).map_or(variable, String::as_str);
        if let Some(index) = self.source_of.get(variable) {
            let source = &mut self.sources[*index];
            if let Ok(bytes) = cdr::decode(&source.value_type, &message.data) {
                source.last = message.sequence;
                source.queue.push_back(RecordedValue {
                    published: message.log_time.saturating_sub(self.start),
                    measured: message.publish_time.saturating_sub(self.start),
                    number: message.sequence,
                    bytes: Some(bytes),
                });
            }
        } else if let Some(WrittenValues { value_type, values }) = self.written.get_mut(variable)
            && let Ok(bytes) = cdr::decode(value_type, &message.data)
        {
            if values.len() >= MIN_WRITTEN_VALUES.max(MAX_WRITTEN_BYTES / value_type.bytes.max(1)) {
                values.pop_front();
            }
            values.push_back((message.sequence, bytes));
        }
    }
}

/// Returns whether a number precedes another. Numbers restart at 0 after the largest.
fn is_before(number: u32, other: u32) -> bool {
    number != other && other.wrapping_sub(number) < u32::MAX / 2
}
