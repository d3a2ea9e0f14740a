//! What a recording is, found by reading all of it once: what is on which topic, who decided how often, what went wrong, and how
//! far it can be read. For recordings of anybody's: what others do not say is left out.

use std::collections::{BTreeMap, HashMap};
use std::ops::RangeInclusive;

use jde_host::story::{Happening, Kind, Line};
use serde::Serialize;

use crate::{Message, ReadError, Recording};

/// Most schemas whose trouble is told: as many as an application may have.
const MOST_TROUBLED: usize = 10_000;

/// What a recording is. Times are ns since 1970 unless they say otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Survey {
    /// Name of the application.
    pub application: Option<String>,
    /// What its randomness started from.
    pub seed: Option<u64>,
    /// Version of the program that recorded it.
    pub jde: Option<String>,
    /// When the application's clock was 0.
    pub application_start_ns: Option<u64>,
    /// Bytes of the file, or of all its parts.
    pub bytes: u64,
    /// Its parts, if it has some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<PartsSurvey>,
    /// Messages that can be read.
    pub messages: u64,
    /// Log time of the first.
    pub first_ns: Option<u64>,
    /// Log time of the last.
    pub last_ns: Option<u64>,
    /// What conditions made it, in their order; the first began it.
    pub triggers: Vec<Cause>,
    /// What is on each topic, in the order in which they were added.
    pub topics: Vec<TopicSurvey>,
    /// Selections.
    pub decisions: u64,
    /// Of which groups.
    pub groups: Vec<GroupSurvey>,
    /// Schemas that had trouble.
    pub troubled: Vec<Troubled>,
    /// Values that were lost while it was recorded, by topic.
    pub lost: BTreeMap<String, u64>,
    /// Names of the files attached to it.
    pub attachments: Vec<String>,
    /// Where it ends too soon, if it does.
    pub damage: Option<Damaged>,
    /// Where each topic is in `topics`, by its name and type: a recording may have tens of thousands.
    #[serde(skip)]
    places: HashMap<(String, String), usize>,
}

/// Why a file was begun or went on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// The condition, as it was written.
    pub condition: String,
    /// What came true.
    pub reason: String,
    /// When, s since the application's start.
    pub time_s: f64,
}

/// What is on a topic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TopicSurvey {
    /// `/pioneer/laser`.
    pub topic: String,
    /// Name of the type of its messages.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Form of its messages: `cdr`, `json`.
    pub encoding: String,
    /// Messages.
    pub messages: u64,
    /// Bytes of all of them, unpacked.
    pub bytes: u64,
    /// Log time of the first.
    pub first_ns: Option<u64>,
    /// Log time of the last.
    pub last_ns: Option<u64>,
    /// Mean rate between the first and the last.
    pub rate_hz: Option<f64>,
}

/// The parts of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PartsSurvey {
    /// The files that are there, in their order.
    pub files: Vec<String>,
    /// Number of the first of them, from 1.
    pub first: u32,
    /// Numbers of those that are missing between the first and the last, gap by gap.
    pub missing: Vec<RangeInclusive<u32>>,
}

/// What was decided in a group.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GroupSurvey {
    /// Its name.
    pub group: String,
    /// Selections.
    pub decisions: u64,
    /// Those that chose another one than before.
    pub switches: u64,
}

/// How often a schema had trouble.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Troubled {
    /// Its name.
    pub schema: String,
    /// Faults, and calls that did not return.
    pub faults: u64,
    /// Deadlines missed.
    pub overruns: u64,
    /// Rows of refused commands and wakes.
    pub refused: u64,
    /// What was said of the last fault.
    pub last_fault: Option<String>,
}

/// Where a recording ends too soon.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Damaged {
    /// Bytes from the beginning of the file that are whole.
    pub offset: u64,
    /// What is wrong behind them.
    pub reason: String,
}

impl Survey {
    /// Reads all of a recording, up to its end or to the damage.
    ///
    /// # Errors
    /// [`ReadError::File`]; damage is no error.
    pub fn of(recording: &Recording) -> Result<Self, ReadError> {
        let mut survey = Self::begin(recording)?;
        for message in recording.messages()? {
            match message {
                Ok(message) => survey.hear(&message),
                Err(error) => survey.ends(error)?,
            }
        }
        survey.finish();
        Ok(survey)
    }

    /// What is known of a recording before its messages are read. For those who read them for something else too: then come
    /// [`hear`](Self::hear) for each, and [`finish`](Self::finish).
    ///
    /// # Errors
    /// [`ReadError::File`].
    pub fn begin(recording: &Recording) -> Result<Self, ReadError> {
        let said = |key: &str| recording.metadata("jde").and_then(|jde| jde.get(key)).cloned();
        let number = |key: &str| said(key).and_then(|number| number.parse().ok());
        let bytes = recording.files().map(|path| {
            let about = std::fs::metadata(path);
            about.map(|about| about.len()).map_err(|error| ReadError::File {
                path: path.to_owned(),
                error,
            })
        });
        let topics: Vec<_> = recording.channels().map(TopicSurvey::from).collect();
        let mut places = HashMap::new();
        for (place, topic) in topics.iter().enumerate() {
            let key = (topic.topic.clone(), topic.type_name.clone());
            places.entry(key).or_insert(place);
        }
        Ok(Self {
            places,
            application: said("application"),
            seed: number("seed"),
            jde: said("jde"),
            application_start_ns: number("start_ns"),
            bytes: bytes.sum::<Result<_, _>>()?,
            parts: recording.first_part().map(|first| PartsSurvey {
                files: recording.files().map(|path| path.display().to_string()).collect(),
                first,
                missing: recording.missing().collect(),
            }),
            triggers: causes(recording),
            topics,
            lost: recording
                .metadata("jde/lost")
                .into_iter()
                .flatten()
                .filter_map(|(topic, lost)| Some((topic.clone(), lost.parse().ok()?)))
                .collect(),
            attachments: recording.attachments().map(str::to_owned).collect(),
            damage: recording.damage().map(|damage| Damaged {
                offset: damage.offset,
                reason: damage.reason.clone(),
            }),
            ..Self::default()
        })
    }

    /// It ends with this error.
    ///
    /// # Errors
    /// The error, unless it is damage.
    pub fn ends(&mut self, error: ReadError) -> Result<(), ReadError> {
        match error {
            ReadError::Damaged { offset, reason, .. } => {
                self.damage = Some(Damaged { offset, reason });
                Ok(())
            }
            ReadError::File { .. }
            | ReadError::NotMcap(_)
            | ReadError::Nothing(_)
            | ReadError::Several { .. } => Err(error),
        }
    }

    /// All messages have been heard.
    pub fn finish(&mut self) {
        for topic in &mut self.topics {
            topic.rate_hz = rate(topic);
        }
    }

    /// From the first message to the last, s; 0 without any.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let times = self.first_ns.zip(self.last_ns);
        times.map_or(0.0, |(first, last)| last.saturating_sub(first) as f64 / 1e9)
    }

    /// Takes in the next message.
    pub fn hear(&mut self, message: &Message) {
        self.messages += 1;
        let first = *self.first_ns.get_or_insert(message.log_time);
        self.last_ns = Some(message.log_time);
        let about = &message.channel;
        let key = (about.topic.clone(), about.type_name.clone());
        if let Some(place) = self.places.get(&key) {
            let topic = &mut self.topics[*place];
            topic.messages += 1;
            topic.bytes += message.data.len() as u64;
            topic.first_ns.get_or_insert(message.log_time);
            topic.last_ns = Some(message.log_time);
        }
        // What was in force at the beginning happened before it.
        if message.publish_time < first {
            return;
        }
        let kind = Kind::ALL.into_iter().find(|kind| kind.topic() == about.topic);
        match kind.and_then(|kind| Line::read(kind, &message.data).ok()) {
            Some(Line::Decision(decision)) => {
                self.decisions += 1;
                let of = |known: &&mut GroupSurvey| known.group == decision.group;
                let group = match self.groups.iter_mut().find(of) {
                    Some(group) => group,
                    None => self.groups.push_mut(GroupSurvey {
                        group: decision.group.clone(),
                        ..GroupSurvey::default()
                    }),
                };
                group.decisions += 1;
                group.switches += u64::from(decision.changed);
            }
            Some(Line::Happening(happening)) => Troubled::count(&mut self.troubled, &happening),
            Some(Line::Change(_)) | None => {}
        }
    }
}

impl PartsSurvey {
    /// What is not there, in words; none if all of it is.
    #[must_use]
    pub fn lacks(&self) -> Option<String> {
        let before = match self.first {
            0 | 1 => None,
            2 => Some("the first part is not there any more".to_owned()),
            first => Some(format!("the first {} parts are not there any more", first - 1)),
        };
        let between = match self.missing.as_slice() {
            [] => None,
            [one] if one.start() == one.end() => Some(format!("part {} is missing", one.start())),
            [first, ..] => {
                let count = |gap: &RangeInclusive<u32>| u64::from(gap.end() - gap.start()) + 1;
                let (from, count) = (first.start(), self.missing.iter().map(count).sum::<u64>());
                let to = self.missing.last().map_or(from, RangeInclusive::end);
                Some(format!("{count} parts from {from} to {to} are missing"))
            }
        };
        let lacks: Vec<_> = before.into_iter().chain(between).collect();
        (!lacks.is_empty()).then(|| lacks.join(", and "))
    }
}

impl Troubled {
    /// Counts what happened if it was trouble of a schema, which is added to those that had trouble.
    pub fn count(all: &mut Vec<Self>, happening: &Happening) {
        let Some(schema) = &happening.schema else {
            return;
        };
        if !matches!(
            happening.kind.as_str(),
            "faulted" | "hung" | "overrun" | "refused"
        ) {
            return;
        }
        let full = all.len() == MOST_TROUBLED;
        let troubled = match all.iter_mut().find(|known| known.schema == *schema) {
            Some(troubled) => troubled,
            None if full => return,
            None => all.push_mut(Self {
                schema: schema.clone(),
                ..Self::default()
            }),
        };
        match happening.kind.as_str() {
            // Told twice each: as what it took, and as what it is now.
            "overrun" => troubled.overruns += u64::from(happening.text.starts_with("took")),
            "refused" => troubled.refused += 1,
            _ => {
                troubled.faults += 1;
                troubled.last_fault = Some(happening.text.clone());
            }
        }
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

/// `jde/trigger`, `jde/trigger/2` and so on.
fn causes(recording: &Recording) -> Vec<Cause> {
    let name = |number: u32| match number {
        1 => "jde/trigger".to_owned(),
        more => format!("jde/trigger/{more}"),
    };
    (1..)
        .map_while(|number| recording.metadata(&name(number)))
        .map(|why| {
            let said = |key: &str| why.get(key).cloned().unwrap_or_default();
            Cause {
                condition: said("condition"),
                reason: said("reason"),
                time_s: said("time_s").parse().unwrap_or_default(),
            }
        })
        .collect()
}
