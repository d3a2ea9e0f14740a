//! How an application ended, and its words.

use serde::{Deserialize, Serialize};

/// How an application ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Its mission is done.
    Done,
    /// Its mission failed.
    Failed,
    /// Its time limit was reached.
    TimeUp,
    /// It was asked to stop.
    Stopped,
    /// It could not continue, for this reason.
    Broken(String),
}

impl Outcome {
    /// The outcomes with fixed texts.
    const FIXED_MESSAGES: [(Self, &str); 4] = [
        (Self::Done, "the mission is done"),
        (Self::Failed, "the mission failed"),
        (Self::TimeUp, "the time was up"),
        (Self::Stopped, "it was asked to stop"),
    ];

    /// Returns the outcome as text, as records contain it.
    #[must_use]
    pub fn message(&self) -> &str {
        let fixed = Self::FIXED_MESSAGES.iter().find(|(outcome, _)| outcome == self);
        match (fixed, self) {
            (Some((_, text)), _) => text,
            (None, Self::Broken(reason)) => reason,
            (None, Self::Done | Self::Failed | Self::TimeUp | Self::Stopped) => "it ended",
        }
    }

    /// Parses the text of an outcome in a record.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let fixed = Self::FIXED_MESSAGES.into_iter().find(|(_, known)| *known == text);
        fixed.map_or_else(|| Self::Broken(text.to_owned()), |(outcome, _)| outcome)
    }
}
