//! Every turn of every schema, kept so that it can be taken again: the topic `/jde/turns`, on the same way as variables.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_host::app::Application;
use jde_host::turn::{OnTurn, Turn};
use jde_types::Value;
use serde::{Deserialize, Serialize};

use crate::{Recorder, Stamps};

/// Where turns are found.
pub(crate) const TOPIC: &str = "/jde/turns";
/// What the recording says of its schemas, in JSON, among what it says of that topic.
const CAST: &str = "cast";

/// Who takes turns in a recording: what the numbers in them mean.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cast {
    /// Whether it was made in virtual time.
    pub lockstep: bool,
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
    /// The names of its ports, by their numbers.
    pub ports: Vec<String>,
}

/// A group of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Troupe {
    /// Its name.
    pub name: String,
    /// Who competes, in the order of priority.
    pub members: Vec<String>,
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
        // Names and numbers always have a form in JSON.
        (CAST.to_owned(), serde_json::to_string(&cast).unwrap_or_default()),
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
        Self {
            lockstep,
            schemas: instances
                .map(|instance| Member {
                    name: instance.name.clone(),
                    type_name: format!(
                        "{}/{}",
                        application.plugins[instance.plugin].name, instance.schema.name
                    ),
                    ports: instance
                        .schema
                        .ports
                        .iter()
                        .map(|port| port.name.clone())
                        .collect(),
                })
                .collect(),
            groups: application
                .groups
                .iter()
                .map(|group| Troupe {
                    name: group.name.clone(),
                    members: group.members.iter().map(name).collect(),
                })
                .collect(),
        }
    }

    /// What a recording says of its topic of turns.
    #[must_use]
    pub fn read(about: &BTreeMap<String, String>) -> Option<Self> {
        serde_json::from_str(about.get(CAST)?).ok()
    }
}
