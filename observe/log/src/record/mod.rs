//! Selections, states and events in recordings: messages of `jde_msgs` in CDR, whose texts and lists have any
//! length.

mod fields;
mod gesture;

use jde_records::wire::{EventMessage, Nonsense, StateMessage};
use jde_records::{RecordKind, RunRecord};
use jde_ros::cdr::{Error, Reader};

use crate::{Channel, RecordedMessage};
use fields::{Cdr, Fields, no_name};

/// Returns the kind of the records of a channel, if it contains records.
#[must_use]
pub fn kind(channel: &Channel) -> Option<RecordKind> {
    RecordKind::ALL
        .into_iter()
        .find(|kind| kind.topic() == channel.topic)
}

/// Reads a message. `None` if it is no record, or one that cannot be read.
#[must_use]
pub fn read(message: &RecordedMessage) -> Option<RunRecord> {
    let kind = kind(&message.channel)?;
    match message.channel.encoding.as_str() {
        // Recordings of earlier versions.
        "json" => RunRecord::parse(kind, &message.data).ok(),
        _ => decode(kind, &message.data).ok(),
    }
}

/// Decodes a record of a kind.
///
/// # Errors
/// [`Error`]. For any input, it does not panic, and what it allocates is in proportion to the message.
pub fn decode(kind: RecordKind, message: &[u8]) -> Result<RunRecord, Error> {
    fn fields<T: Fields + Default>(message: &[u8]) -> Result<T, Error> {
        let mut record = T::default();
        let mut reader = Reader::new(message)?;
        record.fields(&mut Cdr::Read(&mut reader))?;
        reader.finish()?;
        Ok(record)
    }
    let nonsense = |why: Nonsense| no_name("record", why.to_string());
    Ok(match kind {
        RecordKind::Decision => RunRecord::Decision(fields(message)?),
        RecordKind::State => RunRecord::State(fields::<StateMessage>(message)?.try_into().map_err(nonsense)?),
        RecordKind::Event => RunRecord::Other(fields::<EventMessage>(message)?.try_into().map_err(nonsense)?),
    })
}

/// The name of the type of records of a kind, and its definition.
#[must_use]
pub fn schema(kind: RecordKind) -> (&'static str, &'static str) {
    match kind {
        RecordKind::Decision => ("jde_msgs/msg/Decision", include_str!("decision.msg")),
        RecordKind::State => ("jde_msgs/msg/State", include_str!("state.msg")),
        RecordKind::Event => ("jde_msgs/msg/Event", include_str!("event.msg")),
    }
}

/// Replaces the contents of `message` by the message of a record.
pub fn encode(record: RunRecord, message: &mut Vec<u8>) {
    let mut writer = jde_ros::cdr::Writer::new(message);
    let cdr = &mut Cdr::Write(&mut writer);
    let written = match record {
        RunRecord::Decision(mut decision) => decision.fields(cdr),
        RunRecord::State(change) => StateMessage::from(&change).fields(cdr),
        RunRecord::Other(event) => EventMessage::from(&event).fields(cdr),
    };
    debug_assert_eq!(written, Ok(()), "only reading fails");
}

#[cfg(test)]
mod tests;
