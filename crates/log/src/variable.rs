//! The variables of a recording, as its channels describe them.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_ros::definition;

use crate::turns::TOPIC;
use crate::{Channel, Recording, panel, record};

/// The largest value of a type whose capacities no recording states, bytes.
const MOST_BYTES: usize = 16 << 20;

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
        let value_type = value_type(channel).ok()?;
        Some((channel.topic.clone(), RecordedVariable::of(channel, value_type)))
    };
    recording
        .channels()
        .filter(|channel| is_variable(channel))
        .filter_map(of)
        .collect()
}

/// Describes the topics of a recording whose values cannot be decoded: each with its type and the reason.
#[must_use]
pub fn undecodable_topics(recording: &Recording) -> Vec<String> {
    let of = |channel: &Channel| {
        let reason = value_type(channel).err()?;
        Some(format!("{} ({}): {reason}", channel.topic, channel.type_name))
    };
    recording
        .channels()
        .filter(|channel| is_variable(channel))
        .filter_map(of)
        .collect()
}

/// Returns the type of the values of a channel: the one that its definition describes. If that has fields without a bound, as
/// in ROS 2, it is the standard type of the same name and fields, or one with the usual capacity of these fields.
///
/// # Errors
/// Why its values cannot be decoded.
pub fn value_type(channel: &Channel) -> Result<Type, String> {
    if channel.encoding != "cdr" {
        return Err(format!("its messages are in `{}`, not in CDR", channel.encoding));
    }
    let text = String::from_utf8_lossy(&channel.definition);
    let read = match channel.definition_encoding.as_str() {
        "ros2msg" => definition::read(&channel.type_name, &text).map_err(|error| error.to_string()),
        "" => Err("the recording contains no definition of it".to_owned()),
        other => Err(format!("its definition is in `{other}`, not in `ros2msg`")),
    };
    read.or_else(|reason| {
        let known = |name: &str| {
            let mut standard = jde_types::standard().into_iter();
            standard.find(|standard| definition::name(standard) == name)
        };
        let Some(standard) = known(&channel.type_name) else {
            if channel.definition_encoding != "ros2msg" {
                return Err(reason);
            }
            return foreign_type(&channel.type_name, &text, known);
        };
        if channel.definition_encoding == "ros2msg" && !definition::has_fields(&text, &standard) {
            return Err("its fields are not those of the standard type of this name".to_owned());
        }
        Ok(standard)
    })
}

/// Returns a type that is none of jde's, with the usual capacity of fields without a bound. What it contains is of the
/// standard type of the same name if that has the recorded fields.
fn foreign_type(name: &str, text: &str, standard: impl Fn(&str) -> Option<Type>) -> Result<Type, String> {
    let recorded = definition::split(name, text);
    let known = |inner: &str| {
        let standard = standard(inner)?;
        let find = |name: &str| Ok(recorded.get(name).cloned());
        let own = definition::gather(inner, find, |_| false).ok()?;
        definition::has_fields(&own, &standard).then(|| Arc::new(standard))
    };
    let capacity = |_: &str| definition::UNBOUNDED_CAPACITY;
    let found = definition::read_interface(name, text, capacity, known).map_err(|error| error.to_string())?;
    match found.bytes <= MOST_BYTES {
        true => Ok(found),
        false => Err(format!(
            "with room for {} elements of each field without a bound it has {} MB, and at most {} MB are played",
            definition::UNBOUNDED_CAPACITY,
            found.bytes >> 20,
            MOST_BYTES >> 20
        )),
    }
}

/// Whether a channel contains values, instead of what a run reports of itself.
fn is_variable(channel: &Channel) -> bool {
    channel.topic != TOPIC && record::kind(channel).is_none() && panel::schema(channel).is_none()
}
