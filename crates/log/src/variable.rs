//! The variables of a recording, as its channels describe them.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_ros::definition;

use crate::turns::TOPIC;
use crate::{Channel, Recording};

/// A variable of a recording.
pub struct RecordedVariable {
    /// Its full name.
    pub name: String,
    /// `export`, `modulation` or `command`.
    pub access: String,
    /// Its type.
    pub value_type: Arc<Type>,
    /// What it means.
    pub doc: String,
    /// Unit of a plain number.
    pub unit: String,
}

impl RecordedVariable {
    /// Reads a channel's metadata. `value_type` is the type of its values.
    #[must_use]
    pub fn of(channel: &Channel, value_type: Type) -> Self {
        let metadata = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
        let name = match metadata("variable") {
            // Recordings of other programs have topics instead of variables.
            name if name.is_empty() => channel.topic.trim_start_matches('/').replace('/', "."),
            name => name,
        };
        let access = match metadata("access") {
            access if access.is_empty() => "export".to_owned(),
            access => access,
        };
        Self {
            name,
            access,
            value_type: Arc::new(value_type),
            doc: metadata("doc"),
            unit: metadata("unit"),
        }
    }
}

/// Returns the variables of a recording whose values can be decoded, by topic.
#[must_use]
pub fn recorded_variables(recording: &Recording) -> BTreeMap<String, RecordedVariable> {
    let of = |channel: &Channel| {
        let text = std::str::from_utf8(&channel.definition).ok()?;
        if channel.encoding != "cdr" || channel.definition_encoding != "ros2msg" || channel.topic == TOPIC {
            return None;
        }
        let value_type = definition::read(&channel.type_name, text).ok()?;
        Some((channel.topic.clone(), RecordedVariable::of(channel, value_type)))
    };
    recording.channels().filter_map(of).collect()
}
