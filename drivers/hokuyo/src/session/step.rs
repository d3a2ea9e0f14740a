//! The steps of a conversation: what is asked in each, and what an answer means.

use super::{Wanted, beams};
use crate::message::Message;
use crate::scan::Beams;

/// Where the conversation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Finding out at which speed it answers, by telling it to speak SCIP 2 and to stop sending.
    Meet {
        /// How many have been tried.
        speed: usize,
    },
    /// Going on at the address's speed.
    Speed,
    /// Who it is.
    Version,
    /// What it measures.
    Parameters,
    /// How it is.
    State { beams: Beams },
    /// Switching the laser on.
    Laser { beams: Beams },
    /// Asking for scans.
    Start { beams: Beams },
    /// Scans come.
    Scan { beams: Beams },
}

/// What a message means to a step.
#[derive(Debug)]
pub(super) enum Answer {
    Good(Step),
    Refused(String),
    /// It answers something else.
    Other,
}

impl Step {
    pub(super) fn question(&self, wanted: &Wanted) -> String {
        match self {
            // Old ones speak SCIP 1 until they are told; the others answer that they do not know the word.
            Self::Meet { .. } => "SCIP2.0\nQT".to_owned(),
            Self::Speed => format!("SS{:06}", wanted.baud.unwrap_or_default()),
            Self::Version => "VV".to_owned(),
            Self::Parameters => "PP".to_owned(),
            Self::State { .. } => "II".to_owned(),
            Self::Laser { .. } => "BM".to_owned(),
            Self::Start { beams } | Self::Scan { beams } => beams.question() + "00",
        }
    }

    /// What it would not do, for an error.
    pub(super) fn what(&self) -> &'static str {
        match self {
            Self::Meet { .. } => "answer as a scanner that speaks SCIP 2",
            Self::Speed => "go at the speed of its address, which not every model can",
            Self::Version => "say what it is",
            Self::Parameters => "say what it measures",
            Self::State { .. } => "say how it is",
            Self::Laser { .. } => "switch its laser on",
            Self::Start { .. } | Self::Scan { .. } => "send scans",
        }
    }

    pub(super) fn answer(&self, message: &Message, wanted: &Wanted) -> Answer {
        let question = self.question(wanted);
        let last = question.rsplit('\n').next().unwrap_or_default();
        if message.echo != last {
            return Answer::Other;
        }
        let next = match (self, &message.status) {
            (Self::Meet { .. }, _) => Ok(Self::Speed),
            // 02: it has that speed, or the laser is on already.
            (Self::Speed, b"00" | b"02") => Ok(Self::Version),
            (Self::Version, b"00") => Ok(Self::Parameters),
            (Self::Parameters, b"00") => beams(message, wanted).map(|beams| Self::State { beams }),
            // Not every model tells, and none has to.
            (Self::State { beams }, _) => Ok(Self::Laser { beams: *beams }),
            (Self::Laser { beams }, b"00" | b"02") => Ok(Self::Start { beams: *beams }),
            (Self::Start { beams }, b"00") => Ok(Self::Scan { beams: *beams }),
            (_, status) => Err(format!(
                "status {}",
                String::from_utf8_lossy(status).escape_default()
            )),
        };
        next.map_or_else(Answer::Refused, Answer::Good)
    }
}
