//! What a page may say. Whatever else it says is answered with a refusal, and ends nothing.

use jde_panel::Gesture;
use serde::Deserialize;

use crate::feeds::Topic;

/// The longest name of a person, in characters.
const MAX_NAME: usize = 32;

/// A message of a page.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Order {
    /// The first message: it shows a token, and names the person.
    Enter {
        token: String,
        #[serde(default)]
        name: String,
    },
    /// The page is there, and a person can see it.
    Alive {},
    /// Stop everything.
    StopAll {
        id: u64,
    },
    /// Let what was stopped with everything go on.
    ReleaseAll {
        id: u64,
    },
    Play {
        id: u64,
        schema: String,
    },
    Stop {
        id: u64,
        schema: String,
    },
    Release {
        id: u64,
        schema: String,
    },
    /// A gesture on a schema's panel.
    Touch {
        id: u64,
        schema: String,
        gesture: Gesture,
    },
    /// Show this and nothing else beside the state.
    Look {
        at: Vec<Topic>,
    },
    /// What was shown last has arrived.
    Taken {},
    /// The pad is held. Repeated for as long as it is.
    Drive(DriveOrder),
    /// The pad was let go.
    LetGo {},
}

/// Where the pad is held.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DriveOrder {
    /// The teleoperator.
    pub(crate) schema: String,
    /// From -1, back, to 1.
    pub(crate) ahead: f64,
    /// From -1, right, to 1.
    pub(crate) left: f64,
    /// The speed at full deflection, m/s.
    pub(crate) speed: f64,
    /// The newest tick that the page received: how old the picture is by which the person drives.
    pub(crate) tick: u64,
}

impl Order {
    /// Reads a message.
    ///
    /// # Errors
    /// It is none, in words.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| format!("the message is none of this page: {error}"))
    }

    /// Returns the number under which the page waits for an answer.
    pub(crate) const fn id(&self) -> Option<u64> {
        match self {
            Self::StopAll { id }
            | Self::ReleaseAll { id }
            | Self::Play { id, .. }
            | Self::Stop { id, .. }
            | Self::Release { id, .. }
            | Self::Touch { id, .. } => Some(*id),
            Self::Enter { .. }
            | Self::Alive {}
            | Self::Look { .. }
            | Self::Taken {}
            | Self::Drive(_)
            | Self::LetGo {} => None,
        }
    }
}

/// Returns the name of a person as others see it, from what the page sent and the address that it has: `ana@10.0.0.7`.
pub(crate) fn operator(name: &str, address: &str) -> String {
    let is_shown = |letter: &char| letter.is_alphanumeric() || matches!(letter, ' ' | '-' | '.' | '_');
    let name: String = name.chars().filter(is_shown).take(MAX_NAME).collect();
    let name = name.trim();
    let name = if name.is_empty() { "page" } else { name };
    format!("{name}@{address}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_whole_or_not_at_all() {
        let stop = Order::Stop {
            id: 3,
            schema: "goon".to_owned(),
        };
        assert_eq!(
            Order::read(r#"{"do": "stop", "id": 3, "schema": "goon"}"#),
            Ok(stop)
        );
        assert_eq!(Order::read(r#"{"do": "let-go"}"#), Ok(Order::LetGo {}));
        let drive =
            r#"{"do": "drive", "schema": "teleop", "ahead": 0.5, "left": 0, "speed": 0.3, "tick": 7}"#;
        assert!(matches!(Order::read(drive), Ok(Order::Drive(order)) if order.tick == 7));
        for wrong in [
            "",
            "null",
            "[]",
            "{}",
            "7",
            r#"{"do": "unload", "id": 1, "schema": "goon"}"#,
            r#"{"do": "stop", "schema": "goon"}"#,
            r#"{"do": "stop-all", "id": 1, "lease_ms": 100}"#,
            r#"{"do": "drive", "schema": "teleop", "ahead": null, "left": 0, "speed": 0.3, "tick": 7}"#,
            r#"{"do": "drive", "schema": "teleop", "ahead": 0, "left": 0, "speed": 0.3, "tick": 7, "by": "eva"}"#,
        ] {
            assert!(Order::read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn whatever_a_page_sends_as_a_name_an_operator_has_one() {
        assert_eq!(operator("ana", "10.0.0.7"), "ana@10.0.0.7");
        assert_eq!(operator(" \u{202e}\n", "::1"), "page@::1");
        assert_eq!(operator("ana@laptop (lease 1)", "::1"), "analaptop lease 1@::1");
        assert_eq!(operator(&"a".repeat(1000), "::1").len(), MAX_NAME + 4);
    }
}
