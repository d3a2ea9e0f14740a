//! Panels in recordings: one channel for each schema, `/panels/<schema>`. A message is CBOR: a list of
//! widgets, or a text with the reason why there is none. This module draws nothing.

use jde_panel::{Broken, List};

use crate::Channel;

/// The encoding of the messages.
pub(crate) const ENCODING: &str = "cbor";
/// The name of their type.
pub(crate) const TYPE: &str = "jde/Panel";
/// The key in a channel's metadata that names the panel's schema.
pub(crate) const SCHEMA: &str = "panel";

/// Returns the topic of a schema's panel.
#[must_use]
pub fn topic(schema: &str) -> String {
    format!("/panels/{schema}")
}

/// Returns the schema whose panel a channel contains, if it contains one.
#[must_use]
pub fn schema(channel: &Channel) -> Option<&str> {
    let schema = channel.metadata.get(SCHEMA)?;
    (channel.encoding == ENCODING && channel.type_name == TYPE).then_some(schema)
}

/// Encodes the drawing of a panel, or the reason why there is none.
#[cfg(feature = "record")]
pub(crate) fn message(shown: &Result<List, String>) -> Vec<u8> {
    match shown {
        Ok(list) => jde_panel::encode(list),
        Err(reason) => jde_panel::encode(reason),
    }
}

/// Decodes the drawing of a panel, or the reason why there is none. The drawing is within all limits of
/// `jde_panel`.
///
/// # Errors
/// [`Broken`]: the message is not a panel, or one that cannot be shown.
pub fn read(message: &[u8]) -> Result<Result<List, String>, Broken> {
    if let Ok(reason) = jde_panel::decode::<String>(message) {
        return Ok(Err(reason));
    }
    let list: List = jde_panel::decode(message)?;
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
