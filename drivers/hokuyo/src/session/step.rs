//! The steps of a session: the request of each, and the meaning of its reply.

use super::{ScannerConfig, beams};
use crate::message::Message;
use crate::scan::Beams;

/// The state of the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Finds the speed at which the scanner replies, by commands to use SCIP 2 and to stop scanning.
    Connect {
        /// Number of speeds tried before.
        speed: usize,
    },
    /// Switches to the address's speed.
    Speed,
    /// Requests the version.
    Version,
    /// Requests the parameters of its measurement.
    Parameters,
    /// Requests its state.
    State { beams: Beams },
    /// Switches the laser on.
    Laser { beams: Beams },
    /// Requests scans.
    Start { beams: Beams },
    /// Receives scans.
    Scan { beams: Beams },
}

/// The meaning of a message in a step.
#[derive(Debug)]
pub(super) enum StepResult {
    Good(Step),
    Refused(String),
    /// The message is a reply to another request.
    Other,
}

impl Step {
    pub(super) fn request(&self, config: &ScannerConfig) -> String {
        match self {
            // Old scanners use SCIP 1 until this command; the others reject it as unknown.
            Self::Connect { .. } => "SCIP2.0\nQT".to_owned(),
            Self::Speed => format!("SS{:06}", config.baud.unwrap_or_default()),
            Self::Version => "VV".to_owned(),
            Self::Parameters => "PP".to_owned(),
            Self::State { .. } => "II".to_owned(),
            Self::Laser { .. } => "BM".to_owned(),
            Self::Start { beams } | Self::Scan { beams } => beams.request() + "00",
        }
    }

    /// The refused action, for an error message.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Connect { .. } => "answer as a SCIP 2 scanner",
            Self::Speed => "go at the speed of its address, which not every model can",
            Self::Version => "say what it is",
            Self::Parameters => "say what it measures",
            Self::State { .. } => "say how it is",
            Self::Laser { .. } => "switch its laser on",
            Self::Start { .. } | Self::Scan { .. } => "send scans",
        }
    }

    pub(super) fn handle_reply(&self, message: &Message, config: &ScannerConfig) -> StepResult {
        let request = self.request(config);
        let last = request.rsplit('\n').next().unwrap_or_default();
        if message.echo != last {
            return StepResult::Other;
        }
        let next = match (self, &message.status) {
            (Self::Connect { .. }, _) => Ok(Self::Speed),
            // Status 02: the scanner already has that speed, or the laser is already on.
            (Self::Speed, b"00" | b"02") => Ok(Self::Version),
            (Self::Version, b"00") => Ok(Self::Parameters),
            (Self::Parameters, b"00") => beams(message, config).map(|beams| Self::State { beams }),
            // Some models do not report their state, which is optional.
            (Self::State { beams }, _) => Ok(Self::Laser { beams: *beams }),
            (Self::Laser { beams }, b"00" | b"02") => Ok(Self::Start { beams: *beams }),
            (Self::Start { beams }, b"00") => Ok(Self::Scan { beams: *beams }),
            (_, status) => Err(format!(
                "status {}",
                String::from_utf8_lossy(status).escape_default()
            )),
        };
        next.map_or_else(StepResult::Refused, StepResult::Good)
    }
}
