//! Panels in recordings: one channel for each schema, `/panels/<schema>`. A message contains CBOR: a list of
//! widgets, or a text with the reason why there is none. This module draws nothing.

use jde_panel::{Broken, List};
use jde_ros::cdr::{self, Reader};

use crate::Channel;

/// The name of the type of the messages.
pub const TYPE: &str = "jde_msgs/msg/Panel";
/// Their definition.
pub const DEFINITION: &str = "\
# The drawing of a schema's panel.

# The list of widgets, or a text with the reason why there is none, in CBOR.
uint8[] cbor
";
/// The key in a channel's metadata that names the panel's schema.
pub const SCHEMA: &str = "panel";

/// Returns the topic of a schema's panel.
#[must_use]
pub fn topic(schema: &str) -> String {
    format!("/panels/{schema}")
}

/// Returns the schema whose panel a channel contains, if it contains one.
#[must_use]
pub fn schema(channel: &Channel) -> Option<&str> {
    let schema = channel.metadata.get(SCHEMA)?;
    (channel.type_name == TYPE).then_some(schema)
}

/// Encodes the drawing of a panel, or the reason why there is none.
#[must_use]
pub fn message(shown: &Result<List, String>) -> Vec<u8> {
    let cbor = match shown {
        Ok(list) => jde_panel::encode(list),
        Err(reason) => jde_panel::encode(reason),
    };
    let mut message = Vec::new();
    let mut writer = cdr::Writer::new(&mut message);
    writer.length(cbor.len());
    writer.bytes(&cbor);
    message
}

/// Why a message is not a panel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PanelError {
    /// It is of another type, or was cut.
    #[error(transparent)]
    Message(#[from] cdr::Error),
    /// It contains no panel, or one that cannot be shown.
    #[error(transparent)]
    Broken(#[from] Broken),
}

/// Decodes the drawing of a panel, or the reason why there is none. The drawing is within all limits of
/// `jde_panel`.
///
/// # Errors
/// [`PanelError`].
pub fn read(message: &[u8]) -> Result<Result<List, String>, PanelError> {
    let mut reader = Reader::new(message)?;
    let length = reader.length("cbor")?;
    let cbor = reader.take(1, length, "cbor")?;
    reader.finish()?;
    if let Ok(reason) = jde_panel::decode::<String>(cbor) {
        return Ok(Err(reason));
    }
    let list: List = jde_panel::decode(cbor)?;
    jde_panel::check(&list)?;
    Ok(Ok(list))
}

#[cfg(test)]
mod tests {
    use jde_panel::Item;

    use super::*;

    #[test]
    fn a_panel_is_encoded_and_decoded_and_a_broken_one_is_refused() {
        let item = |value| Item::Value {
            label: "speed".to_owned(),
            value,
            unit: "m/s".to_owned(),
        };
        let list = |value| List {
            time: 3,
            items: vec![item(value)],
        };
        for shown in [Ok(list(0.5)), Err("it panicked".to_owned())] {
            assert_eq!(read(&message(&shown)), Ok(shown));
        }
        assert!(read(&message(&Ok(list(f64::NAN)))).is_err());
        assert!(read(&[0xff, 1, 2]).is_err() && read(&[]).is_err());
    }
}
