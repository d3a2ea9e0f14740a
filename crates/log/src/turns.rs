//! Every turn of every schema, kept so that it can be taken again: the topic `/jde/turns`, on the same way as variables.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_core::{GroupContract, contract};
use jde_host::app::{Application, Binding, Instance};
use jde_host::policy_name;
use jde_host::turn::{OnTurn, Turn};
use jde_types::Value;
use serde::{Deserialize, Serialize};

use crate::{Recorder, Recording, Stamps};

/// Where turns are found.
pub(crate) const TOPIC: &str = "/jde/turns";
/// What the recording says of its schemas, in JSON, among what it says of that topic.
const CAST: &str = "cast";

/// Who takes turns in a recording: what the numbers in them mean.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cast {
    /// Whether it was made in virtual time.
    pub lockstep: bool,
    /// Whether turns tell what schemas wrote; recordings of older versions do not.
    #[serde(default)]
    pub writes: bool,
    /// The schemas, by their numbers.
    pub schemas: Vec<Member>,
    /// The groups, by theirs.
    pub groups: Vec<Troupe>,
}

/// A schema of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its type: `stop/stop`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Its period at the start, ns; none in recordings that do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_ns: Option<u64>,
    /// The names of its ports, by their numbers.
    pub ports: Vec<String>,
    /// The drivers that it commands; none in recordings that do not say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub commands: Vec<String>,
}

/// A group of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Troupe {
    /// Its name.
    pub name: String,
    /// Who competes, in the order of priority.
    pub members: Vec<String>,
    /// How collisions are settled; none in recordings that do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
    /// The longest takeover by contract (R17), ns; none where there is none, or nobody says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub takeover_ns: Option<u64>,
}

/// The drivers that a schema commands.
fn commanded(application: &Application, instance: &Instance) -> Vec<String> {
    let targets = instance.bindings.iter().filter_map(|binding| match binding {
        Binding::Actuator { target } => target.map(|(driver, _)| driver),
        _ => None,
    });
    let drivers: BTreeSet<usize> = targets.collect();
    let name = |driver: usize| application.instances[driver].name.clone();
    drivers.into_iter().map(name).collect()
}

/// Keeps every turn of an application in a recording, for [`crate::replay`]. `lockstep` if it runs in virtual time.
#[must_use]
pub fn turns(recorder: &Recorder, application: &Application, lockstep: bool) -> OnTurn {
    let cast = Cast::of(application, lockstep);
    let about = BTreeMap::from([
        (
            "doc".to_owned(),
            "What every schema did, and what it saw.".to_owned(),
        ),
        cast.told(),
    ]);
    let topic = recorder.topic(TOPIC, Arc::new(Turn::describe()), about);
    let count = AtomicU64::new(0);
    Arc::new(move |turn: &Turn| {
        let time = turn.time();
        let stamps = Stamps {
            published: time,
            measured: time,
            sequence: count.fetch_add(1, Ordering::Relaxed) + 1,
        };
        // What finds no room is counted with the topic.
        topic.put(turn.as_bytes(), stamps);
    })
}

impl Cast {
    /// Who takes turns in an application.
    #[must_use]
    pub fn of(application: &Application, lockstep: bool) -> Self {
        let instances = application.instances.iter();
        let name = |number: &usize| application.instances[*number].name.clone();
        let contracts = contract(&application.spec());
        Self {
            lockstep,
            writes: true,
            schemas: instances
                .map(|instance| Member {
                    name: instance.name.clone(),
                    type_name: format!(
                        "{}/{}",
                        application.plugins[instance.plugin].name, instance.schema.name
                    ),
                    period_ns: Some(instance.period_ns),
                    ports: instance
                        .schema
                        .ports
                        .iter()
                        .map(|port| port.name.clone())
                        .collect(),
                    commands: commanded(application, instance),
                })
                .collect(),
            groups: application
                .groups
                .iter()
                .map(|group| Troupe {
                    name: group.name.clone(),
                    members: group.members.iter().map(name).collect(),
                    policy: Some(policy_name(group.policy).to_owned()),
                    takeover_ns: contracts
                        .iter()
                        .find(|contract| contract.name == group.name)
                        .map(GroupContract::allowed),
                })
                .collect(),
        }
    }

    /// What a recording says of those that are in it; none if it says nothing, as others' recordings do.
    #[must_use]
    pub fn of_recording(recording: &Recording) -> Option<Self> {
        let mut channels = recording.channels();
        channels
            .find_map(|channel| Self::read(&channel.about))
            .or_else(|| Self::read(recording.metadata("jde")?))
    }

    /// It as recordings say it: a name and a text.
    pub(crate) fn told(&self) -> (String, String) {
        // Names and numbers always have a form in JSON.
        (CAST.to_owned(), serde_json::to_string(self).unwrap_or_default())
    }

    /// What a recording says of its topic of turns.
    #[must_use]
    pub fn read(about: &BTreeMap<String, String>) -> Option<Self> {
        serde_json::from_str(about.get(CAST)?).ok()
    }
}
