//! The exports of a schema in a recording, as a mock of it.

use std::collections::BTreeMap;

use jde_abi::describe::Role;
use jde_app::InstanceConfig;
use jde_host::Mock;
use jde_log::record;
use jde_records::RecordKind;
use jde_ros::{cdr, definition};

use crate::{ReplayError, ReplayedDrive};

/// Returns a mock of a schema that publishes what the exports of the schema `recorded` were, at their times since
/// the start of the recorded run. Exports that the recording does not contain have no value. The values are kept in
/// memory.
///
/// # Errors
/// [`ReplayError::Incomplete`] if the recording contains none of the exports, or one with another definition of
/// its type; [`ReplayError::Read`].
pub fn mock(drive: &ReplayedDrive, recorded: &str, instance: &InstanceConfig) -> Result<Mock, ReplayError> {
    let recording = drive.recording();
    let incomplete = |what: String| ReplayError::Incomplete {
        path: recording.path().display().to_string(),
        what,
    };
    let ports = instance.schema.ports.iter();
    let exports: BTreeMap<_, _> = ports
        .filter(|port| matches!(port.role, Role::Export { .. }))
        .map(|port| (format!("{recorded}.{}", port.name), port))
        .collect();
    let mut found = false;
    for channel in recording.channels() {
        let Some(port) = channel
            .metadata
            .get("variable")
            .and_then(|name| exports.get(name))
        else {
            continue;
        };
        found = true;
        if *channel.definition != *definition::definition(&port.value_type).as_bytes() {
            return Err(incomplete(format!(
                "the definition of `{recorded}.{}` (a {}) in it differs from that of {} in the application",
                port.name, channel.type_name, port.value_type.name
            )));
        }
    }
    if !found {
        let names: Vec<_> = exports.keys().map(String::as_str).collect();
        let names = names.join(", ");
        return Err(incomplete(format!("it has none of {names}; record one of them")));
    }
    let mut mock = Mock::default();
    for message in recording.messages()? {
        let message = message?;
        if message.channel.topic == RecordKind::Event.topic() {
            let record = record::read(&message);
            let retracted = record
                .as_ref()
                .and_then(|record| Some((record.retracted_variable()?, record)));
            if let Some((port, record)) =
                retracted.and_then(|(name, record)| Some((exports.get(name)?, record)))
            {
                mock.recorded(&port.name, record.time(), None);
            }
        } else if let Some(port) = message
            .channel
            .metadata
            .get("variable")
            .and_then(|name| exports.get(name))
            && let Ok(bytes) = cdr::decode(&port.value_type, &message.data)
        {
            let time = message.log_time.saturating_sub(drive.start());
            mock.recorded(&port.name, time, Some(bytes));
        }
    }
    Ok(mock)
}
