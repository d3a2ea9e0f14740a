//! A panel received over the link: a checked list, or the reason why there is none.

use jde_board::Nanos;
use jde_panel::List;

use crate::attachment::PanelTag;

/// The content of a schema's panel at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelSample {
    /// The list, within all limits of `jde_panel`; or the reason why there is none.
    pub list: Result<List, String>,
    /// Counts the drawings of the panel from 1; drawings beyond the requested rate are skipped.
    pub sequence: u64,
    /// When the panel was drawn, ns since the application's start.
    pub time: Nanos,
    /// The age of the drawing when it was sent, ns of the application.
    pub age: Nanos,
}

impl PanelSample {
    pub(crate) fn read(message: &[u8], attachment: Option<&[u8]>) -> Result<Self, String> {
        let PanelTag {
            sequence,
            time,
            age,
            is_error,
        } = attachment
            .and_then(PanelTag::read)
            .ok_or("a panel without its attachment")?;
        let list = if is_error {
            // A reason may be as long as any text of a panel.
            let reason = &message[..message.len().min(jde_panel::MOST_TEXT)];
            Err(String::from_utf8_lossy(reason).into_owned())
        } else {
            let list: Result<List, _> = jde_panel::decode(message);
            let checked = list.and_then(|list| jde_panel::check(&list).map(|()| list));
            checked.map_err(|error| format!("its list is not valid: {error}"))
        };
        Ok(Self {
            list,
            sequence,
            time,
            age,
        })
    }
}

#[cfg(test)]
mod tests {
    use jde_panel::{Item, Words};
    use proptest::prelude::*;

    use super::*;

    fn tag(is_error: bool) -> Vec<u8> {
        let tag = PanelTag {
            sequence: 7,
            time: 8,
            age: 9,
            is_error,
        };
        tag.bytes().to_vec()
    }

    fn value(value: f64) -> List {
        List {
            time: 8,
            items: vec![Item::Value {
                label: "speed".to_owned(),
                value,
                unit: "m/s".to_owned(),
            }],
        }
    }

    #[test]
    fn a_valid_list_arrives_unchanged_and_an_invalid_one_as_the_reason() {
        let read = |list: &List| PanelSample::read(&jde_panel::encode(list), Some(&tag(false))).unwrap();
        assert_eq!(read(&value(1.5)).list, Ok(value(1.5)));
        let reason = read(&value(f64::NAN)).list.unwrap_err();
        assert!(reason.contains("speed") && reason.contains("NaN"), "{reason}");
        let long = List {
            time: 0,
            items: vec![Item::Text {
                text: "x".repeat(jde_panel::MOST_TEXT + 1),
                words: Words::Plain,
            }],
        };
        assert!(read(&long).list.is_err());
        let huge = vec![0; jde_panel::MOST_ENCODED + 1];
        let reason = PanelSample::read(&huge, Some(&tag(false)))
            .unwrap()
            .list
            .unwrap_err();
        assert!(reason.contains("no list has more than"), "{reason}");
        let failed = PanelSample::read(b"it panicked", Some(&tag(true))).unwrap();
        assert_eq!(failed.list, Err("it panicked".to_owned()));
        assert_eq!((failed.sequence, failed.time, failed.age), (7, 8, 9));
    }

    proptest! {
        #[test]
        fn reading_panels_survives_any_bytes(
            message in proptest::collection::vec(any::<u8>(), 0..300),
            attachment in proptest::collection::vec(any::<u8>(), 0..40),
        ) {
            let _ = PanelSample::read(&message, Some(&attachment));
        }
    }
}
