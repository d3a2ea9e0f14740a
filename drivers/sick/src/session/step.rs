//! The steps of a session: the telegram of each, the time limit of its reply, and the meaning of the reply.

use core::time::Duration;

use super::{ScannerConfig, SerialSpeed};
use crate::telegram::Telegram;

/// Selects the operating mode with measurements on request only, so that the scanner sends nothing by itself.
pub(super) const ON_REQUEST: [u8; 2] = [MODE, 0x25];
const MODE: u8 = 0x20;
const CONTINUOUS_MODE: u8 = 0x24;
/// The installation mode, which permits configuration, with the default password.
const INSTALLATION: &[u8] = b"\x20\x00SICK_LMS";
const TYPE: u8 = 0x3a;
const VARIANT: u8 = 0x3b;
const READ_MODE: u8 = 0x74;
const WRITE: u8 = 0x77;
/// Offsets in the configuration.
const MEASURING_MODE: usize = 5;
const UNIT: usize = 6;

/// The state of the session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Finds the speed at which the scanner replies, by a command to stop sending.
    Connect {
        /// Number of speeds tried before.
        speed: usize,
    },
    /// Requests its type.
    Name,
    /// Switches to the working speed.
    Speed,
    /// Enters the installation mode.
    Install,
    /// Selects the beams.
    Variant,
    /// Reads the configuration.
    Read,
    /// Writes the configuration: the whole block, changed in two bytes.
    Write { block: Vec<u8> },
    /// Starts continuous scans.
    Start,
    /// Receives scans.
    Scan,
}

/// The meaning of a telegram in a step.
#[derive(Debug)]
pub(super) enum StepResult {
    Good(Step),
    Refused(String),
    /// The telegram is a reply to another request.
    Other,
}

impl Step {
    /// The command and its data.
    pub(super) fn payload(&self, config: &ScannerConfig) -> Vec<u8> {
        match self {
            Self::Connect { .. } | Self::Scan => ON_REQUEST.to_vec(),
            Self::Name => vec![TYPE],
            Self::Speed => vec![MODE, speed(config.speed)],
            Self::Install => INSTALLATION.to_vec(),
            Self::Variant => {
                let ([view, _], [step, _]) =
                    (config.beams.view.to_le_bytes(), config.beams.step.to_le_bytes());
                vec![VARIANT, view, 0, step, 0]
            }
            Self::Read => vec![READ_MODE],
            Self::Write { block } => [&[WRITE], &block[..]].concat(),
            Self::Start => vec![MODE, CONTINUOUS_MODE],
        }
    }

    /// The time limit of the reply.
    pub(super) fn reply_timeout(&self) -> Duration {
        Duration::from_secs(match self {
            // Two telegrams of scans at 9600 baud may still be in transit.
            Self::Connect { .. } => 2,
            Self::Name | Self::Read | Self::Scan => 1,
            Self::Speed | Self::Install | Self::Variant | Self::Start => 3,
            // The scanner writes to its memory, which takes 7 s by the manual.
            Self::Write { .. } => 15,
        })
    }

    /// The refused action, for an error message.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Connect { .. } => "answer",
            Self::Name => "say what it is",
            Self::Speed => "go at the speed `baud`, which not every model can",
            Self::Install => "let itself be configured, which a changed password prevents",
            Self::Variant => "measure as many `beams`, which not every model can",
            Self::Read => "report its configuration",
            Self::Write { .. } => "take another `reach`",
            Self::Start | Self::Scan => "send scans",
        }
    }

    pub(super) fn handle_reply(&self, telegram: &Telegram, config: &ScannerConfig) -> StepResult {
        let data = &*telegram.data;
        match (self, telegram.command & 0x7f) {
            (Self::Connect { .. }, MODE) => StepResult::Good(Self::Name),
            (Self::Name, TYPE) => StepResult::Good(Self::Speed),
            (Self::Speed, MODE) => switched(data, Self::Install),
            (Self::Install, MODE) => switched(data, Self::Variant),
            (Self::Variant, VARIANT) => match data {
                [1, ..] => StepResult::Good(Self::Read),
                _ => StepResult::Refused("it says that this failed".to_owned()),
            },
            (Self::Read, READ_MODE) => match (data.get(MEASURING_MODE), data.get(UNIT)) {
                (Some(mode), Some(unit)) if (*mode, *unit) == (config.reach.mode, config.reach.unit) => {
                    // No write without need: the memory endures a limited number of writes.
                    StepResult::Good(Self::Start)
                }
                (Some(_), Some(_)) => {
                    let mut block = data.to_vec();
                    block[MEASURING_MODE] = config.reach.mode;
                    block[UNIT] = config.reach.unit;
                    StepResult::Good(Self::Write { block })
                }
                _ => StepResult::Refused("its configuration is too short".to_owned()),
            },
            (Self::Write { .. }, WRITE) => match data {
                [1, ..] => StepResult::Good(Self::Start),
                _ => StepResult::Refused("it did not accept it".to_owned()),
            },
            (Self::Start, MODE) => switched(data, Self::Scan),
            _ => StepResult::Other,
        }
    }
}

/// Interprets the reply to a change of mode.
fn switched(data: &[u8], next: Step) -> StepResult {
    match data {
        [0, ..] => StepResult::Good(next),
        [1, ..] => StepResult::Refused("wrong password".to_owned()),
        [2, ..] => StepResult::Refused("it has a fault".to_owned()),
        _ => StepResult::Refused("not possible".to_owned()),
    }
}

fn speed(speed: SerialSpeed) -> u8 {
    match speed {
        SerialSpeed::Serial { working: 19_200, .. } => 0x41,
        SerialSpeed::Serial { working: 38_400, .. } => 0x40,
        SerialSpeed::Serial { working: 500_000, .. } => 0x48,
        SerialSpeed::Serial { .. } | SerialSpeed::Fixed => 0x42,
    }
}

/// Returns its type, such as `LMS200;30106;V02.10`.
pub(super) fn name(data: &[u8]) -> String {
    let text: String = data
        .iter()
        .map(|byte| char::from(*byte))
        .filter(char::is_ascii_graphic)
        .collect();
    if text.is_empty() { "LMS".to_owned() } else { text }
}
