//! Panels in recordings: a channel for each schema's, `/panels/<schema>`, whose messages are CBOR: a list of widgets, or a text that
//! says why there was none. Draws nothing.

use jde_panel::{Broken, List};

use crate::Channel;

/// Form of the messages.
pub(crate) const ENCODING: &str = "cbor";
/// Name of their type.
pub(crate) const TYPE: &str = "jde/Panel";
/// What a channel says of whose panel it is.
pub(crate) const SCHEMA: &str = "panel";

/// The topic of a schema's panel.
#[must_use]
pub fn topic(schema: &str) -> String {
    format!("/panels/{schema}")
}

/// The schema whose panel a channel holds, if it holds one.
#[must_use]
pub fn schema(channel: &Channel) -> Option<&str> {
    let schema = channel.about.get(SCHEMA)?;
    (channel.encoding == ENCODING && channel.type_name == TYPE).then_some(schema)
}

/// What a panel showed, or why it showed nothing, as a message.
pub(crate) fn message(shown: &Result<List, String>) -> Vec<u8> {
    match shown {
        Ok(list) => jde_panel::encode(list),
        Err(reason) => jde_panel::encode(reason),
    }
}

/// What a panel showed, from a message: within all limits of `jde_panel`; or why it showed nothing.
///
/// # Errors
/// [`Broken`]: no panel, or one that cannot be shown.
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
    fn a_panel_comes_back_as_it_was_and_a_broken_one_is_refused() {
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
