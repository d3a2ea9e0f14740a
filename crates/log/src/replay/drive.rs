//! A recorded drive: whether everything is there that taking it again needs, and what it says of its application.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jde_core::Nanos;
use jde_host::app::{Application, Binding};
use jde_host::replay::words;
use jde_host::turn::Turn;
use jde_ros::cdr;
use jde_types::Value;

use super::ReplayError;
use super::differ;
use crate::turns::TOPIC;
use crate::{Cast, Recording};

/// Turns among which the start is told: threads that it wakes may tell of themselves first.
const FIRST_TURNS: usize = 64;

/// A recorded drive.
pub struct Drive {
    recording: Recording,
    cast: Cast,
    start: u64,
    first: BTreeMap<String, Vec<u8>>,
}

/// The file of an application as a recording has it. Whoever made the recording wrote it, the names of folders included.
pub struct Attached {
    /// Its name, without a folder.
    pub name: String,
    /// What stood in it.
    pub text: String,
    /// Where it stood, if there is such a folder here.
    pub folder: Option<PathBuf>,
}

impl Drive {
    /// Opens a recording of a whole run, from its start on.
    ///
    /// # Errors
    /// [`ReplayError::Read`]; [`ReplayError::Lacks`] for one without the turns of its schemas.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let recording = Recording::open(path)?;
        let lacks = |what: &str| ReplayError::Lacks {
            path: path.display().to_string(),
            what: what.to_owned(),
        };
        let start = recording
            .metadata("jde")
            .and_then(|known| known.get("start_ns")?.parse().ok())
            .ok_or_else(|| {
                lacks("it does not say when its application started; record it with `jde run --record`")
            })?;
        let turns = recording.channels().find(|channel| channel.topic == TOPIC);
        let cast = turns
            .and_then(|channel| Cast::read(&channel.about))
            .ok_or_else(|| {
                lacks(
                    "it has no turns of schemas (`/jde/turns`); record the whole run with `jde run --record`",
                )
            })?;
        let mut drive = Self {
            recording,
            cast,
            start,
            first: BTreeMap::new(),
        };
        drive.first = drive.first_values()?.ok_or_else(|| {
            lacks("it does not begin with the start of its application, and schemas remember what was before")
        })?;
        Ok(drive)
    }

    /// The recording.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Who took turns in it.
    #[must_use]
    pub fn cast(&self) -> &Cast {
        &self.cast
    }

    /// The name of its application.
    #[must_use]
    pub fn name(&self) -> &str {
        self.said("application").unwrap_or_default()
    }

    /// What its randomness started from.
    #[must_use]
    pub fn seed(&self) -> Option<u64> {
        self.said("seed")?.parse().ok()
    }

    /// When its clock was 0, ns since 1970.
    #[must_use]
    pub fn start(&self) -> u64 {
        self.start
    }

    /// The file of its application: where it was, and its text.
    ///
    /// # Errors
    /// [`ReplayError::Read`]; [`ReplayError::Lacks`] if it is not in the recording.
    pub fn application(&self) -> Result<Attached, ReplayError> {
        let lacks = || ReplayError::Lacks {
            path: self.recording.path().display().to_string(),
            what: "the file of its application is not in it; name one with --app".to_owned(),
        };
        let name = self.recording.attachments().next().ok_or_else(lacks)?.to_owned();
        let text = self.recording.attachment(&name)?.ok_or_else(lacks)?;
        let text = String::from_utf8(text).map_err(|_| lacks())?;
        let folder = self.said("folder").map(PathBuf::from);
        let folder = folder.filter(|folder| folder.is_dir());
        Ok(Attached { name, text, folder })
    }

    /// Gives every modulation and period of an application the value with which the recording starts, but those that `keep` names
    /// as `schema.variable`.
    pub fn restore(&self, application: &mut Application, keep: impl Fn(&str) -> bool) {
        for instance in &mut application.instances {
            let owner = instance.name.clone();
            let first = |variable: &str| {
                let name = format!("{owner}.{variable}");
                self.first.get(&name).filter(|_| !keep(&name))
            };
            for (port, binding) in instance.schema.ports.iter().zip(&mut instance.bindings) {
                let Binding::Modulation { initial, .. } = binding else {
                    continue;
                };
                let value = first(&port.name).and_then(|message| cdr::decode(&port.value_type, message).ok());
                if let Some(value) = value {
                    *initial = value;
                }
            }
            if let Some(period) = first("period").and_then(|message| seconds(message)) {
                instance.period_ns = period;
            }
        }
    }

    /// In what an application differs from the recorded one, in words: schemas, groups, what modulations start with.
    #[must_use]
    pub fn differences(&self, application: &Application) -> Vec<String> {
        let mut differences = differ::casts(&self.cast, &Cast::of(application, self.cast.lockstep));
        for instance in &application.instances {
            for (port, binding) in instance.schema.ports.iter().zip(&instance.bindings) {
                let Binding::Modulation { initial, .. } = binding else {
                    continue;
                };
                let name = format!("{}.{}", instance.name, port.name);
                let then = self.first.get(&name);
                let Some(then) = then.and_then(|message| cdr::decode(&port.value_type, message).ok()) else {
                    continue;
                };
                let mut now = Vec::new();
                cdr::encode(&port.value_type, initial, &mut now);
                if self.first.get(&name) != Some(&now) {
                    let (now, then) = (words(&port.value_type, initial), words(&port.value_type, &then));
                    differences.push(format!("{name} starts with {now}, and did with {then}"));
                }
            }
            let period = self.first.get(&format!("{}.period", instance.name));
            if let Some(then) = period.and_then(|message| seconds(message))
                && then != instance.period_ns
            {
                differences.push(format!(
                    "{}.period starts with {} s, and did with {} s",
                    instance.name,
                    instance.period_ns as f64 / 1e9,
                    then as f64 / 1e9
                ));
            }
        }
        differences
    }

    fn said(&self, what: &str) -> Option<&str> {
        self.recording.metadata("jde")?.get(what).map(String::as_str)
    }

    /// The values that were there before anything was: they have the number 0. None if it does not begin with the start.
    fn first_values(&self) -> Result<Option<BTreeMap<String, Vec<u8>>>, ReplayError> {
        let turn_type = Turn::describe();
        let (mut first, mut turns, mut since) = (BTreeMap::new(), 0, None);
        let mut started = false;
        for message in self.recording.messages()? {
            let Ok(message) = message else { break };
            if started && since.is_some_and(|since| message.log_time > since) {
                break;
            }
            if message.channel.topic == TOPIC {
                since.get_or_insert(message.log_time);
                turns += 1;
                let turn = cdr::decode(&turn_type, &message.data).ok();
                let turn = turn.and_then(|bytes| Turn::from_bytes(&bytes));
                started |= turn.is_some_and(|turn| turn.kind == Turn::STARTED);
                if !started && turns == FIRST_TURNS {
                    break;
                }
            } else if message.sequence == 0
                && message.channel.encoding == "cdr"
                && let Some(variable) = message.channel.about.get("variable")
            {
                first.entry(variable.clone()).or_insert(message.data);
            }
        }
        Ok(started.then_some(first))
    }
}

/// The ns that a message of a period says.
fn seconds(message: &[u8]) -> Option<Nanos> {
    let bytes = message.get(message.len().checked_sub(8)?..)?;
    let seconds = f64::from_le_bytes(bytes.try_into().ok()?);
    (seconds.is_finite() && seconds > 0.0).then(|| (seconds * 1e9).round() as Nanos)
}
