//! The survey of a recording, made by reading all of it once: the contents of each topic, the decisions of
//! each group, the problems, and how far the file can be read. It accepts recordings of other programs, and
//! omits what they do not state.

use std::collections::{BTreeMap, HashMap};
use std::ops::RangeInclusive;

use jde_records::RunRecord;
use jde_timeline::Timeline;
use serde::Serialize;

use crate::part::Gap;
use crate::{Damage, ReadError, RecordedMessage, RecordedVariables, Recording, record};

/// The survey of a recording. Times are in ns since 1970 unless stated otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Survey {
    /// Name of the application.
    pub application: Option<String>,
    /// The seed of its random generators.
    pub seed: Option<u64>,
    /// The version of the program that recorded it.
    pub jde: Option<String>,
    /// The time at which the application's clock was 0.
    pub application_start_ns: Option<u64>,
    /// The size of the file, or of all its parts, in bytes.
    pub bytes: u64,
    /// Its parts, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<PartsSurvey>,
    /// Messages that can be read.
    pub messages: u64,
    /// The log time of the first message.
    pub first_ns: Option<u64>,
    /// The log time of the last message.
    pub last_ns: Option<u64>,
    /// The conditions that caused the file, in their order. The first one started it.
    pub triggers: Vec<Cause>,
    /// The contents of each topic, in the order in which topics were added.
    pub topics: Vec<TopicSurvey>,
    /// The number of selections.
    pub decisions: u64,
    /// The selections of each group.
    pub groups: Vec<GroupSurvey>,
    /// Schemas that had problems.
    pub troubled: Vec<SchemaProblems>,
    /// The number of values lost during recording, by topic.
    pub lost: BTreeMap<String, u64>,
    /// The names of the attached files.
    pub attachments: Vec<String>,
    /// The times of which it has nothing: the disk did not accept it, or the file is damaged there.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<Gap>,
    /// Where the recording ends too early, if it does.
    pub damage: Option<Damaged>,
    /// What of it cannot be read: files, and of a whole survey topics and messages, each with the reason.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// The index of each topic in `topics`, by its name and type. A recording may have tens of thousands of
    /// topics.
    #[serde(skip)]
    topic_index: HashMap<(String, String), usize>,
}

/// A condition that started or prolonged a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// The text of the condition.
    pub condition: String,
    /// What became true.
    pub reason: String,
    /// The time, in s since the application's start.
    pub time_s: f64,
}

/// The contents of a topic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TopicSurvey {
    /// The name of the topic: `/pioneer/laser`.
    pub topic: String,
    /// The name of the type of its messages.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The encoding of its messages: `cdr`, `json`.
    pub encoding: String,
    /// The number of messages.
    pub messages: u64,
    /// The uncompressed size of all messages, in bytes.
    pub bytes: u64,
    /// The log time of the first message.
    pub first_ns: Option<u64>,
    /// The log time of the last message.
    pub last_ns: Option<u64>,
    /// The mean rate between the first and the last message, in Hz.
    pub rate_hz: Option<f64>,
}

/// The parts of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PartsSurvey {
    /// The existing files, in their order.
    pub files: Vec<String>,
    /// The number of the first existing file, from 1.
    pub first: u32,
    /// The numbers of the missing files between the first and the last, as ranges.
    pub missing: Vec<RangeInclusive<u32>>,
}

/// The selections of a group.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GroupSurvey {
    /// Its name.
    pub group: String,
    /// The number of selections.
    pub decisions: u64,
    /// The number of selections that changed the winner.
    pub switches: u64,
}

/// The problems of a schema.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SchemaProblems {
    /// Its name.
    pub schema: String,
    /// The number of faults, including calls that did not return.
    pub faults: u64,
    /// The number of missed deadlines.
    pub overruns: u64,
    /// The number of series of refused commands and wakes.
    pub refused: u64,
    /// The number of takeovers that took longer than their contract permits (R17).
    pub late: u64,
    /// The text of the last fault.
    pub last_fault: Option<String>,
}

/// Where a recording ends too early.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Damaged {
    /// The number of intact bytes from the beginning of the file; none for a database.
    pub offset: Option<u64>,
    /// What is wrong after them.
    pub reason: String,
}

impl Damaged {
    /// Whether the file ends there because a recorder still writes it.
    #[must_use]
    pub fn is_unfinished(&self) -> bool {
        self.reason.ends_with(Damage::UNFINISHED)
    }
}

impl From<Damage> for Damaged {
    fn from(Damage { offset, reason }: Damage) -> Self {
        Self { offset, reason }
    }
}

impl Survey {
    /// Reads all of a recording, up to its end or to the damage.
    ///
    /// # Errors
    /// [`ReadError::File`]. Damage is not an error.
    pub fn of(recording: &Recording) -> Result<Self, ReadError> {
        let mut survey = Self::begin(recording)?;
        let variables = RecordedVariables::of(recording);
        let mut left_out = variables.left_out().clone();
        let mut value = Vec::new();
        let mut timeline = Timeline::default();
        for message in recording.messages()? {
            match message {
                Ok(message) => {
                    let record = record::read(&message);
                    if survey.add(&message, record.as_ref()) {
                        record.iter().for_each(|record| timeline.add(record));
                    }
                    variables.check(&message, &mut value, &mut left_out);
                }
                Err(error) => survey.end_with(error)?,
            }
        }
        survey.left_out = left_out.lines().collect();
        survey.finish();
        survey.groups = GroupSurvey::of(&timeline);
        survey.troubled = SchemaProblems::of(&timeline);
        Ok(survey)
    }

    /// Starts a survey before the messages are read. For callers that also read the messages for another
    /// purpose: they call [`add`](Self::add) for each message, and then [`finish`](Self::finish). Such a survey has neither
    /// groups nor problems, which a [`Timeline`] of the caller has.
    ///
    /// # Errors
    /// [`ReadError::File`].
    pub fn begin(recording: &Recording) -> Result<Self, ReadError> {
        let text = |key: &str| recording.metadata("jde").and_then(|jde| jde.get(key)).cloned();
        let number = |key: &str| text(key).and_then(|number| number.parse().ok());
        let bytes = recording.files().map(|path| {
            let metadata = std::fs::metadata(path);
            metadata
                .map(|metadata| metadata.len())
                .map_err(|error| ReadError::File {
                    path: path.to_owned(),
                    error,
                })
        });
        let topics: Vec<_> = recording.channels().map(TopicSurvey::from).collect();
        let mut topic_index = HashMap::new();
        for (index, topic) in topics.iter().enumerate() {
            let key = (topic.topic.clone(), topic.type_name.clone());
            topic_index.entry(key).or_insert(index);
        }
        Ok(Self {
            topic_index,
            application: text("application"),
            seed: number("seed"),
            jde: text("jde"),
            application_start_ns: number("start_ns"),
            bytes: bytes.sum::<Result<_, _>>()?,
            parts: recording.first_part().map(|first| PartsSurvey {
                files: recording.files().map(|path| path.display().to_string()).collect(),
                first,
                missing: recording.missing().collect(),
            }),
            triggers: read_causes(recording),
            topics,
            lost: recording
                .metadata("jde/lost")
                .into_iter()
                .flatten()
                .filter_map(|(topic, lost)| Some((topic.clone(), lost.parse().ok()?)))
                .collect(),
            attachments: recording.attachments().map(str::to_owned).collect(),
            gaps: recording.gaps().to_vec(),
            left_out: recording.left_out().lines().collect(),
            damage: recording.damage().cloned().map(Damaged::from),
            ..Self::default()
        })
    }

    /// Records that the messages end with this error.
    ///
    /// # Errors
    /// The error, unless it is damage.
    pub fn end_with(&mut self, error: ReadError) -> Result<(), ReadError> {
        match error {
            ReadError::Damaged { damage, .. } => {
                self.damage = Some(damage.into());
                Ok(())
            }
            ReadError::File { .. }
            | ReadError::NotRecording(_)
            | ReadError::Empty(_)
            | ReadError::Ambiguous { .. } => Err(error),
        }
    }

    /// Completes the survey after the last message.
    pub fn finish(&mut self) {
        for topic in &mut self.topics {
            topic.rate_hz = rate(topic);
        }
    }

    /// Returns the time from the first message to the last, in s. 0 if there are no messages.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let times = self.first_ns.zip(self.last_ns);
        times.map_or(0.0, |(first, last)| last.saturating_sub(first) as f64 / 1e9)
    }

    /// Adds the next message, and the record in it. Returns whether it is of the time of the file: what was in force at its
    /// beginning is older.
    pub fn add(&mut self, message: &RecordedMessage, record: Option<&RunRecord>) -> bool {
        self.messages += 1;
        let first = *self.first_ns.get_or_insert(message.log_time);
        self.last_ns = Some(message.log_time);
        let channel = &message.channel;
        let key = (channel.topic.clone(), channel.type_name.clone());
        if let Some(index) = self.topic_index.get(&key) {
            let topic = &mut self.topics[*index];
            topic.messages += 1;
            topic.bytes += message.data.len() as u64;
            topic.first_ns.get_or_insert(message.log_time);
            topic.last_ns = Some(message.log_time);
        }
        let is_of_file = message.publish_time >= first;
        let is_decision = matches!(record, Some(RunRecord::Decision(_)));
        self.decisions += u64::from(is_of_file && is_decision);
        is_of_file
    }
}

impl PartsSurvey {
    /// Describes the parts that are missing. `None` if none is.
    #[must_use]
    pub fn describe_missing(&self) -> Option<String> {
        let before = match self.first {
            0 | 1 => None,
            2 => Some("the first part no longer exists".to_owned()),
            first => Some(format!("the first {} parts no longer exist", first - 1)),
        };
        let between = match self.missing.as_slice() {
            [] => None,
            [gap] if gap.start() == gap.end() => Some(format!("part {} is missing", gap.start())),
            [first, ..] => {
                let count = |gap: &RangeInclusive<u32>| u64::from(gap.end() - gap.start()) + 1;
                let (from, count) = (first.start(), self.missing.iter().map(count).sum::<u64>());
                let to = self.missing.last().map_or(from, RangeInclusive::end);
                Some(format!("{count} parts from {from} to {to} are missing"))
            }
        };
        let descriptions: Vec<_> = before.into_iter().chain(between).collect();
        (!descriptions.is_empty()).then(|| descriptions.join(", and "))
    }
}

impl SchemaProblems {
    /// Returns the problems of each schema that had any.
    fn of(timeline: &Timeline) -> Vec<Self> {
        let schemas = timeline.hierarchy().schemas().iter().zip(timeline.schemas());
        let problems = schemas.map(|(schema, known)| Self {
            schema: schema.name.clone(),
            faults: known.counts.faults,
            overruns: known.counts.overruns,
            refused: known.counts.refused,
            late: known.counts.late,
            last_fault: known.last_fault.clone(),
        });
        let has_any = |of: &Self| of.faults + of.overruns + of.refused + of.late > 0;
        problems.filter(has_any).collect()
    }
}

impl GroupSurvey {
    /// Returns the selections of each group that made any.
    fn of(timeline: &Timeline) -> Vec<Self> {
        let groups = timeline.hierarchy().groups().iter().zip(timeline.groups());
        let groups = groups.map(|(group, known)| Self {
            group: group.name.clone(),
            decisions: known.counts.selections,
            switches: known.counts.switches,
        });
        groups.filter(|group| group.decisions > 0).collect()
    }
}

impl From<&crate::Channel> for TopicSurvey {
    fn from(channel: &crate::Channel) -> Self {
        Self {
            topic: channel.topic.clone(),
            type_name: channel.type_name.clone(),
            encoding: channel.encoding.clone(),
            messages: 0,
            bytes: 0,
            first_ns: None,
            last_ns: None,
            rate_hz: None,
        }
    }
}

fn rate(topic: &TopicSurvey) -> Option<f64> {
    let seconds = topic.last_ns?.checked_sub(topic.first_ns?)? as f64 / 1e9;
    (seconds > 0.0).then(|| (topic.messages - 1) as f64 / seconds)
}

/// Reads the metadata `jde/trigger`, `jde/trigger/2` and so on.
fn read_causes(recording: &Recording) -> Vec<Cause> {
    let name = |number: u32| match number {
        1 => "jde/trigger".to_owned(),
        more => format!("jde/trigger/{more}"),
    };
    (1..)
        .map_while(|number| recording.metadata(&name(number)))
        .map(|metadata| {
            let text = |key: &str| metadata.get(key).cloned().unwrap_or_default();
            Cause {
                condition: text("condition"),
                reason: text("reason"),
                time_s: text("time_s").parse().unwrap_or_default(),
            }
        })
        .collect()
}
