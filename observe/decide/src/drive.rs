//! A recorded drive: what it states of its application, and whether it contains everything that a replay
//! needs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jde_app::{Application, Binding};
use jde_core::Nanos;
use jde_host::replay::format_value;
use jde_log::{RecordedHierarchy, Recording, TURNS_TOPIC};
use jde_records::turn::{Turn, TurnKind};
use jde_ros::cdr;
use jde_types::Value;

use crate::ReplayError;
use crate::diff;

/// The number of turns among which the start must occur: threads that the start wakes may report before it.
const FIRST_TURNS: usize = 64;

/// A recorded drive.
pub struct ReplayedDrive {
    recording: Recording,
    hierarchy: RecordedHierarchy,
    start: u64,
    initial_values: BTreeMap<String, Vec<u8>>,
}

/// The file of an application, as a recording contains it. Its contents are those of the recording's author
/// and not trusted, including the name of the folder.
pub struct AttachedApplication {
    /// The name of the file, without a folder.
    pub name: String,
    /// The text of the file.
    pub text: String,
    /// The folder of the file, if it exists on this machine.
    pub folder: Option<PathBuf>,
}

impl ReplayedDrive {
    /// Opens a recording of a whole run, from its start.
    ///
    /// # Errors
    /// [`ReplayError::Read`]; [`ReplayError::Incomplete`] if the recording does not contain the turns of its
    /// schemas.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let recording = Recording::open(path)?;
        let incomplete = |what: &str| ReplayError::Incomplete {
            path: path.display().to_string(),
            what: what.to_owned(),
        };
        // Up to a time that cannot be read, it is replayed.
        if let Some(gap) = recording.gaps().iter().find(|gap| !gap.damaged) {
            return Err(incomplete(&format!("it has a gap: {gap}")));
        }
        let start = recording
            .metadata("jde")
            .and_then(|metadata| metadata.get("start_ns")?.parse().ok())
            .ok_or_else(|| {
                incomplete("the start of its application is not recorded; record it with `jde run --record`")
            })?;
        let turns = recording.channels().find(|channel| channel.topic == TURNS_TOPIC);
        let hierarchy = turns
            .and_then(|channel| RecordedHierarchy::read(&channel.metadata))
            .ok_or_else(|| {
                incomplete(
                    "it has no turns of schemas (`/jde/turns`); record the whole run with `jde run --record`",
                )
            })?;
        let mut drive = Self {
            recording,
            hierarchy,
            start,
            initial_values: BTreeMap::new(),
        };
        drive.initial_values = drive.read_initial_values()?.ok_or_else(|| {
            incomplete("it does not begin with the start of its application, so the memory of the schemas is unknown")
        })?;
        Ok(drive)
    }

    /// Returns the recording.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Returns the schemas and groups of the recording.
    #[must_use]
    pub fn hierarchy(&self) -> &RecordedHierarchy {
        &self.hierarchy
    }

    /// Returns the name of the application.
    #[must_use]
    pub fn name(&self) -> &str {
        self.metadata_value("application").unwrap_or_default()
    }

    /// Returns the seed of the application's random generators.
    #[must_use]
    pub fn seed(&self) -> Option<u64> {
        self.metadata_value("seed")?.parse().ok()
    }

    /// Returns the time at which the application's clock was 0, in ns since 1970.
    #[must_use]
    pub fn start(&self) -> u64 {
        self.start
    }

    /// Returns the file of the application: its name, its text and its folder.
    ///
    /// # Errors
    /// [`ReplayError::Read`]; [`ReplayError::Incomplete`] if the recording does not contain it.
    pub fn application(&self) -> Result<AttachedApplication, ReplayError> {
        let incomplete = || ReplayError::Incomplete {
            path: self.recording.path().display().to_string(),
            what: "the file of its application is not in it; name one with --app".to_owned(),
        };
        let name = self
            .recording
            .attachments()
            .next()
            .ok_or_else(incomplete)?
            .to_owned();
        let text = self.recording.attachment(&name)?.ok_or_else(incomplete)?;
        let text = String::from_utf8(text).map_err(|_| incomplete())?;
        let folder = self.metadata_value("folder").map(PathBuf::from);
        let folder = folder.filter(|folder| folder.is_dir());
        Ok(AttachedApplication { name, text, folder })
    }

    /// Sets every modulation and period of an application to the value with which the recording starts,
    /// except those for which `keep` returns true, given `schema.variable`.
    pub fn restore(&self, application: &mut Application, keep: impl Fn(&str) -> bool) {
        for instance in application.instances.iter_mut() {
            let owner = instance.name.clone();
            let first = |variable: &str| {
                let name = format!("{owner}.{variable}");
                self.initial_values.get(&name).filter(|_| !keep(&name))
            };
            for (port, binding) in instance.schema.ports.iter().zip(&mut instance.bindings) {
                let Binding::Modulation { initial, .. } = binding else {
                    continue;
                };
                let message = first(&port.name).or_else(|| first(port.former_name.as_deref()?));
                let value = message.and_then(|message| cdr::decode(&port.value_type, message).ok());
                if let Some(value) = value {
                    *initial = value;
                }
            }
            if let Some(period) = first("period").and_then(|message| decode_period(message)) {
                instance.period_ns = period;
            }
        }
    }

    /// Describes how an application differs from the recorded one: schemas, groups, initial values of
    /// modulations, and periods.
    #[must_use]
    pub fn differences(&self, application: &Application) -> Vec<String> {
        let mut differences = diff::diff_hierarchies(
            &self.hierarchy,
            &RecordedHierarchy::of(application, self.hierarchy.lockstep),
        );
        for instance in &application.instances {
            for (port, binding) in instance.schema.ports.iter().zip(&instance.bindings) {
                let Binding::Modulation { initial, .. } = binding else {
                    continue;
                };
                let name = format!("{}.{}", instance.name, port.name);
                let then = self.initial_values.get(&name);
                let Some(then) = then.and_then(|message| cdr::decode(&port.value_type, message).ok()) else {
                    continue;
                };
                let mut now = Vec::new();
                cdr::encode(&port.value_type, initial, &mut now);
                if self.initial_values.get(&name) != Some(&now) {
                    let (now, then) = (
                        format_value(&port.value_type, initial),
                        format_value(&port.value_type, &then),
                    );
                    differences.push(format!("{name} starts with {now} instead of {then}"));
                }
            }
            let period = self.initial_values.get(&format!("{}.period", instance.name));
            if let Some(then) = period.and_then(|message| decode_period(message))
                && then != instance.period_ns
            {
                differences.push(format!(
                    "{}.period starts with {} s instead of {} s",
                    instance.name,
                    instance.period_ns as f64 / 1e9,
                    then as f64 / 1e9
                ));
            }
        }
        differences
    }

    fn metadata_value(&self, key: &str) -> Option<&str> {
        self.recording.metadata("jde")?.get(key).map(String::as_str)
    }

    /// Reads the values from before the start, which have the sequence number 0. `None` if the recording does
    /// not begin with the start.
    fn read_initial_values(&self) -> Result<Option<BTreeMap<String, Vec<u8>>>, ReplayError> {
        let turn_type = Turn::describe();
        let (mut first, mut turns, mut since) = (BTreeMap::new(), 0, None);
        let mut started = false;
        for message in self.recording.messages()? {
            let Ok(message) = message else { break };
            if started && since.is_some_and(|since| message.log_time > since) {
                break;
            }
            if message.channel.topic == TURNS_TOPIC {
                since.get_or_insert(message.log_time);
                turns += 1;
                let turn = cdr::decode(&turn_type, &message.data).ok();
                let turn = turn.and_then(|bytes| Turn::from_bytes(&bytes));
                started |= turn.is_some_and(|turn| turn.kind() == TurnKind::Started);
                if !started && turns == FIRST_TURNS {
                    break;
                }
            } else if message.sequence == 0
                && message.channel.encoding == "cdr"
                && let Some(variable) = message.channel.metadata.get("variable")
            {
                first.entry(variable.clone()).or_insert(message.data);
            }
        }
        Ok(started.then_some(first))
    }
}

/// Decodes a message of a period, in ns.
fn decode_period(message: &[u8]) -> Option<Nanos> {
    let bytes = message.get(message.len().checked_sub(8)?..)?;
    let seconds = f64::from_le_bytes(bytes.try_into().ok()?);
    (seconds.is_finite() && seconds > 0.0).then(|| (seconds * 1e9).round() as Nanos)
}
