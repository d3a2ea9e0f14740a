//! How a run ended, and the case of a selection, in the words that people read.

use jde_core::Case;
use jde_records::Decision;
use jde_records::event::Outcome;

use crate::mark::Severity;
use crate::timeline::Timeline;

/// Returns the case of a selection in the word that people read: "alone", "conflict", "absence", "forced".
#[must_use]
pub fn case_word(case: Case) -> &'static str {
    match case {
        // Elsewhere, a collision is one with an obstacle.
        Case::Collision => "conflict",
        Case::Alone | Case::Absence | Case::Forced => case.name(),
    }
}

/// How a run ended, as far as somebody knows who watches it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The application ended like this.
    Known(Outcome),
    /// The application is no longer there, and did not say why.
    Lost,
}

impl Ending {
    /// Returns the ending in one of five words: "done", "failed", "stopped", "ended", "lost".
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Known(Outcome::Done) => "done",
            Self::Known(Outcome::Failed | Outcome::Broken(_)) => "failed",
            Self::Known(Outcome::Stopped) => "stopped",
            Self::Known(Outcome::TimeUp) => "ended",
            Self::Lost => "lost",
        }
    }

    /// Returns the reason in words: "the mission is done".
    #[must_use]
    pub fn reason(&self) -> &str {
        match self {
            Self::Known(outcome) => outcome.message(),
            Self::Lost => "it was killed, or the network to it is cut",
        }
    }

    /// Returns how bad it is.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::Known(Outcome::Done) => Severity::Good,
            Self::Known(Outcome::Stopped | Outcome::TimeUp) => Severity::Warning,
            Self::Known(Outcome::Failed | Outcome::Broken(_)) | Self::Lost => Severity::Bad,
        }
    }
}

impl Timeline {
    /// Returns how the run ended; `None` while it goes on, and if that is not known.
    #[must_use]
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref().map(|(_, ending)| ending)
    }

    /// Returns whether a selection is the arrival of a robot: it left its group without a winner, and the mission is done.
    #[must_use]
    pub fn is_arrival(&self, decision: &Decision) -> bool {
        let is_done = self.ending() == Some(&Ending::Known(Outcome::Done));
        let last = self
            .group(&decision.group)
            .and_then(|group| group.switches.back());
        is_done && decision.choice.is_none() && last.is_some_and(|last| last.number == Some(decision.number))
    }

    /// Returns the case of a selection in the word that people read; that of an arrival is "done".
    #[must_use]
    pub fn case_word(&self, decision: &Decision) -> &'static str {
        match self.ending() {
            Some(ending) if self.is_arrival(decision) => ending.word(),
            Some(_) | None => case_word(decision.case),
        }
    }
}
