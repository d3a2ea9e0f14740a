//! The steps of a conversation: what is said in each, how long an answer may take, and what an answer means.

use core::time::Duration;

use super::{Line, Wanted};
use crate::telegram::Telegram;

/// Switches the operating mode: measurements on request alone, so that nothing is sent meanwhile.
pub(super) const ON_REQUEST: [u8; 2] = [MODE, 0x25];
const MODE: u8 = 0x20;
const CONTINUOUS: u8 = 0x24;
/// The installation mode, in which it may be configured, with the password that all have.
const INSTALLATION: &[u8] = b"\x20\x00SICK_LMS";
const TYPE: u8 = 0x3a;
const VARIANT: u8 = 0x3b;
const READ: u8 = 0x74;
const WRITE: u8 = 0x77;
/// Places in its configuration.
const MEASURING_MODE: usize = 5;
const UNIT: usize = 6;

/// Where the conversation is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Finding out at which speed it answers, by telling it to stop sending.
    Meet {
        /// How many have been tried.
        speed: usize,
    },
    /// What it calls itself.
    Name,
    /// Going on at the working speed.
    Speed,
    /// Asking leave to configure.
    Install,
    /// Which beams.
    Variant,
    /// What is configured.
    Read,
    /// Configuring otherwise; the whole block, changed in two places.
    Write { block: Vec<u8> },
    /// Telling it to send.
    Start,
    /// Scans come.
    Scan,
}

/// What a telegram means to a step.
#[derive(Debug)]
pub(super) enum Answer {
    Good(Step),
    Refused(String),
    /// It answers something else.
    Other,
}

impl Step {
    /// Command and data.
    pub(super) fn payload(&self, wanted: &Wanted) -> Vec<u8> {
        match self {
            Self::Meet { .. } | Self::Scan => ON_REQUEST.to_vec(),
            Self::Name => vec![TYPE],
            Self::Speed => vec![MODE, speed(wanted.line)],
            Self::Install => INSTALLATION.to_vec(),
            Self::Variant => {
                let ([view, _], [step, _]) =
                    (wanted.beams.view.to_le_bytes(), wanted.beams.step.to_le_bytes());
                vec![VARIANT, view, 0, step, 0]
            }
            Self::Read => vec![READ],
            Self::Write { block } => [&[WRITE], &block[..]].concat(),
            Self::Start => vec![MODE, CONTINUOUS],
        }
    }

    /// How long the answer may take.
    pub(super) fn patience(&self) -> Duration {
        Duration::from_secs(match self {
            // Two telegrams of scans at 9600 baud may be on their way.
            Self::Meet { .. } => 2,
            Self::Name | Self::Read | Self::Scan => 1,
            Self::Speed | Self::Install | Self::Variant | Self::Start => 3,
            // It writes to its memory: 7 s by the manual.
            Self::Write { .. } => 15,
        })
    }

    /// What it would not do, for an error.
    pub(super) fn what(&self) -> &'static str {
        match self {
            Self::Meet { .. } => "answer",
            Self::Name => "say what it is",
            Self::Speed => "go at the speed `baud`, which not every model can",
            Self::Install => "let itself be configured, which a changed password prevents",
            Self::Variant => "measure as many `beams`, which not every model can",
            Self::Read => "tell its configuration",
            Self::Write { .. } => "take another `reach`",
            Self::Start | Self::Scan => "send scans",
        }
    }

    pub(super) fn answer(&self, telegram: &Telegram, wanted: &Wanted) -> Answer {
        let data = &*telegram.data;
        match (self, telegram.command & 0x7f) {
            (Self::Meet { .. }, MODE) => Answer::Good(Self::Name),
            (Self::Name, TYPE) => Answer::Good(Self::Speed),
            (Self::Speed, MODE) => switched(data, Self::Install),
            (Self::Install, MODE) => switched(data, Self::Variant),
            (Self::Variant, VARIANT) => match data {
                [1, ..] => Answer::Good(Self::Read),
                _ => Answer::Refused("it says that this failed".to_owned()),
            },
            (Self::Read, READ) => match (data.get(MEASURING_MODE), data.get(UNIT)) {
                (Some(mode), Some(unit)) if (*mode, *unit) == (wanted.reach.mode, wanted.reach.unit) => {
                    // Its memory bears only so many writes.
                    Answer::Good(Self::Start)
                }
                (Some(_), Some(_)) => {
                    let mut block = data.to_vec();
                    block[MEASURING_MODE] = wanted.reach.mode;
                    block[UNIT] = wanted.reach.unit;
                    Answer::Good(Self::Write { block })
                }
                _ => Answer::Refused("its configuration is too short".to_owned()),
            },
            (Self::Write { .. }, WRITE) => match data {
                [1, ..] => Answer::Good(Self::Start),
                _ => Answer::Refused("it did not accept it".to_owned()),
            },
            (Self::Start, MODE) => switched(data, Self::Scan),
            _ => Answer::Other,
        }
    }
}

/// The answer to a change of mode.
fn switched(data: &[u8], next: Step) -> Answer {
    match data {
        [0, ..] => Answer::Good(next),
        [1, ..] => Answer::Refused("wrong password".to_owned()),
        [2, ..] => Answer::Refused("it has a fault".to_owned()),
        _ => Answer::Refused("not possible".to_owned()),
    }
}

fn speed(line: Line) -> u8 {
    match line {
        Line::Serial { working: 19_200, .. } => 0x41,
        Line::Serial { working: 38_400, .. } => 0x40,
        Line::Serial { working: 500_000, .. } => 0x48,
        Line::Serial { .. } | Line::Fixed => 0x42,
    }
}

/// What it calls itself, like `LMS200;30106;V02.10`.
pub(super) fn name(data: &[u8]) -> String {
    let text: String = data
        .iter()
        .map(|byte| char::from(*byte))
        .filter(char::is_ascii_graphic)
        .collect();
    if text.is_empty() { "LMS".to_owned() } else { text }
}
