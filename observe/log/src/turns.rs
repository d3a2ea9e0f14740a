//! What the topic `/jde/turns` refers to by number: the schemas and groups of a recording.

use std::collections::{BTreeMap, BTreeSet};

use jde_app::{Application, Binding, InstanceConfig};
use jde_core::{GroupContract, SchemaId, contract};
use jde_timeline::{Hierarchy, SchemaEntry};
use serde::{Deserialize, Serialize};

use crate::Recording;

/// The name of the topic with every turn of every schema, recorded like a variable, so that a replay can repeat
/// it.
pub const TURNS_TOPIC: &str = "/jde/turns";
/// The key in the topic's metadata under which the recording describes its schemas, in JSON.
const HIERARCHY_KEY: &str = "cast";

/// The schemas and groups of a recording. The numbers in turns refer to them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedHierarchy {
    /// Whether the recording was made in virtual time.
    pub lockstep: bool,
    /// Whether turns contain what schemas wrote. Those of older versions do not.
    #[serde(default)]
    pub writes: bool,
    /// The schemas, by their numbers.
    pub schemas: Vec<RecordedSchema>,
    /// The groups, by their numbers.
    pub groups: Vec<RecordedGroup>,
}

/// A schema of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedSchema {
    /// Its name.
    pub name: String,
    /// Its type: `stop/stop`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Its period at the start, in ns. `None` in recordings that do not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_ns: Option<u64>,
    /// The names of its ports, by their numbers.
    pub ports: Vec<String>,
    /// The drivers that it commands. Empty in recordings that do not state them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub commands: Vec<String>,
}

/// A group of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedGroup {
    /// Its name.
    pub name: String,
    /// The schemas that compete, in the order of priority.
    pub members: Vec<String>,
    /// The policy that settles collisions. `None` in recordings that do not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
    /// The longest takeover by contract (R17), in ns. `None` if there is no contract, or if the recording
    /// does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub takeover_ns: Option<u64>,
}

/// Returns the drivers that a schema commands.
fn commanded(application: &Application, instance: &InstanceConfig) -> Vec<String> {
    let targets = instance.bindings.iter().filter_map(|binding| match binding {
        Binding::Actuator { target } => target.map(|command| command.instance),
        _ => None,
    });
    let drivers: BTreeSet<SchemaId> = targets.collect();
    let name = |driver: SchemaId| application.instances[driver].name.clone();
    drivers.into_iter().map(name).collect()
}

impl RecordedHierarchy {
    /// Returns the schemas and groups of an application.
    #[must_use]
    pub fn of(application: &Application, lockstep: bool) -> Self {
        let instances = application.instances.iter();
        let name = |id: &SchemaId| application.instances[*id].name.clone();
        let contracts = contract(&application.spec());
        Self {
            lockstep,
            writes: true,
            schemas: instances
                .map(|instance| RecordedSchema {
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
                .map(|group| RecordedGroup {
                    name: group.name.clone(),
                    members: group.members.iter().map(name).collect(),
                    policy: Some(group.policy.name().to_owned()),
                    takeover_ns: contracts
                        .iter()
                        .find(|contract| contract.name == group.name)
                        .map(GroupContract::allowed),
                })
                .collect(),
        }
    }

    /// Returns the schemas and groups of a recording. `None` if it does not describe them, as those of other
    /// programs do not.
    #[must_use]
    pub fn of_recording(recording: &Recording) -> Option<Self> {
        let mut channels = recording.channels();
        channels
            .find_map(|channel| Self::read(&channel.metadata))
            .or_else(|| Self::read(recording.metadata("jde")?))
    }

    /// Returns them as a timeline has them, with the same places.
    #[must_use]
    pub fn hierarchy(&self) -> Hierarchy {
        let mut hierarchy = Hierarchy::default();
        for schema in &self.schemas {
            hierarchy.describe(SchemaEntry {
                name: schema.name.clone(),
                type_name: schema.type_name.clone(),
                period: schema.period_ns,
                commands: schema.commands.clone(),
                ..SchemaEntry::default()
            });
        }
        for group in &self.groups {
            let members = group.members.iter().map(String::as_str);
            let place = hierarchy.describe_group(&group.name, None, members);
            if let Some(known) = place.and_then(|place| hierarchy.group_mut(place)) {
                known.policy = group.policy.clone().unwrap_or_default();
                known.contract = group.takeover_ns;
            }
        }
        hierarchy
    }

    /// Returns the entry for a recording's metadata: key and JSON text.
    #[must_use]
    pub fn metadata_entry(&self) -> (String, String) {
        // Names and numbers can always be written as JSON.
        (
            HIERARCHY_KEY.to_owned(),
            serde_json::to_string(self).unwrap_or_default(),
        )
    }

    /// Reads the entry in the metadata of a topic of turns.
    #[must_use]
    pub fn read(metadata: &BTreeMap<String, String>) -> Option<Self> {
        serde_json::from_str(metadata.get(HIERARCHY_KEY)?).ok()
    }
}
