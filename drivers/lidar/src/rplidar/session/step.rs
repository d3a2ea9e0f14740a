//! The steps of a session: the request of each, and the meaning of its reply.

use super::model::Model;
use crate::rplidar::message::{Reply, request};
use crate::rplidar::samples::Format;

const STOP: u8 = 0x25;
const SCAN: u8 = 0x20;
const GET_INFO: u8 = 0x50;
const GET_HEALTH: u8 = 0x52;
const EXPRESS_SCAN: u8 = 0x82;
const GET_LIDAR_CONF: u8 = 0x84;
const MOTOR_SPEED: u8 = 0xa8;
const SET_PWM: u8 = 0xf0;
/// Keys of `GET_LIDAR_CONF`: the type of reply of a mode, and the mode that suits most.
const ANSWER_TYPE: u32 = 0x75;
const TYPICAL_MODE: u32 = 0x7c;
/// The mode that every lidar with several modes has beside the standard one.
const EXPRESS_MODE: u16 = 1;

/// The state of the session.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Stops a lidar that may be scanning, and waits until it has stopped.
    Stop {
        /// What follows.
        then: Box<Step>,
    },
    /// Asks for model, firmware and serial number, until two answers agree: they have no checksum.
    Info {
        /// The last answer.
        before: Option<Model>,
    },
    /// Asks a lidar that is known.
    Ask(Model, Question),
    /// Receives measurements.
    Scan,
}

/// What a lidar that is known is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Question {
    /// Whether it has stopped to protect itself.
    Health,
    /// The mode that suits most.
    Typical,
    /// How a mode sends its measurements.
    Answer { mode: u16 },
    /// To start to scan, in a mode of `EXPRESS_SCAN` or else with `SCAN`.
    Start { mode: Option<u16> },
}

/// The meaning of a reply in a step.
#[derive(Debug, PartialEq)]
pub(super) enum Meaning {
    Info(Model),
    /// The lidar, its status, and the code of an error.
    Health(Model, u8, u16),
    /// The next step.
    Next(Step),
    /// Measurements of this lidar follow.
    Stream(Model, Format),
    /// Measurements follow in a format that this driver does not read, and the lidar has no other.
    Unreadable(u8),
    /// Something that was not asked for.
    Other,
}

impl Step {
    /// Returns the requests of the step.
    pub(super) fn requests(&self) -> Vec<u8> {
        match self {
            Self::Stop { .. } => request(STOP, &[]),
            Self::Info { .. } => request(GET_INFO, &[]),
            Self::Ask(model, question) => question.requests(model),
            Self::Scan => Vec::new(),
        }
    }

    /// The refused action, for a message.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Stop { .. } | Self::Info { .. } => "say what it is",
            Self::Ask(_, Question::Health) => "say how it is",
            Self::Ask(_, Question::Typical | Question::Answer { .. }) => "say how it scans",
            Self::Ask(_, Question::Start { .. }) | Self::Scan => "start to scan: is its motor powered?",
        }
    }

    pub(super) fn meaning(&self, reply: &Reply) -> Meaning {
        match (self, reply) {
            (Self::Info { .. }, Reply::Single { kind: 0x04, data }) => {
                Model::read(data).map_or(Meaning::Other, Meaning::Info)
            }
            (Self::Ask(model, question), reply) => question.meaning(model, reply),
            _ => Meaning::Other,
        }
    }

    /// The step after one that is not answered, if the lidar can do without it.
    pub(super) fn without_answer(&self) -> Option<Self> {
        match self {
            Self::Ask(
                model,
                Question::Typical | Question::Answer { .. } | Question::Start { mode: Some(_) },
            ) => Some(Self::standard(model)),
            Self::Ask(_, Question::Health | Question::Start { mode: None })
            | Self::Stop { .. }
            | Self::Info { .. }
            | Self::Scan => None,
        }
    }

    /// The scan that every lidar has, after whatever it does is stopped.
    fn standard(model: &Model) -> Self {
        Self::Stop {
            then: Box::new(Self::Ask(model.clone(), Question::Start { mode: None })),
        }
    }
}

impl Question {
    fn requests(self, model: &Model) -> Vec<u8> {
        match self {
            Self::Health => request(GET_HEALTH, &[]),
            Self::Typical => request(GET_LIDAR_CONF, &TYPICAL_MODE.to_le_bytes()),
            Self::Answer { mode } => {
                let data = [&ANSWER_TYPE.to_le_bytes()[..], &mode.to_le_bytes()].concat();
                request(GET_LIDAR_CONF, &data)
            }
            Self::Start { mode } => {
                let scan = match mode {
                    Some(mode) => request(EXPRESS_SCAN, &[mode as u8, 0, 0, 0, 0]),
                    None => request(SCAN, &[]),
                };
                [motor(model), scan].concat()
            }
        }
    }

    fn meaning(self, model: &Model, reply: &Reply) -> Meaning {
        let next = |question| Meaning::Next(Step::Ask(model.clone(), question));
        match (self, reply) {
            (Self::Health, Reply::Single { kind: 0x06, data }) => match data[..] {
                [status, low, high] => {
                    Meaning::Health(model.clone(), status, u16::from_le_bytes([low, high]))
                }
                _ => Meaning::Other,
            },
            (Self::Typical, Reply::Single { kind: 0x20, data }) => match configuration(data, TYPICAL_MODE) {
                Some([low, high, ..]) => {
                    let mode = u16::from_le_bytes([*low, *high]);
                    next(Self::Answer { mode })
                }
                _ => Meaning::Other,
            },
            (Self::Answer { mode }, Reply::Single { kind: 0x20, data }) => {
                match configuration(data, ANSWER_TYPE) {
                    Some([kind, ..]) => next(after_answer(mode, *kind)),
                    _ => Meaning::Other,
                }
            }
            (Self::Start { mode }, Reply::Stream { kind }) => match Format::of_kind(*kind) {
                Some(format) => Meaning::Stream(model.clone(), format),
                None if mode.is_some() => Meaning::Next(Step::standard(model)),
                None => Meaning::Unreadable(*kind),
            },
            _ => Meaning::Other,
        }
    }
}

/// Stops the motor, as far as the lidar can, and the scan. The stop comes last, because a lidar misses what follows it
/// within a millisecond.
pub(super) fn closing() -> Vec<u8> {
    let still = 0_u16.to_le_bytes();
    [
        request(SET_PWM, &still),
        request(MOTOR_SPEED, &still),
        request(STOP, &[]),
    ]
    .concat()
}

/// Returns the data of a configuration, if it is that of a key.
fn configuration(data: &[u8], key: u32) -> Option<&[u8]> {
    data.strip_prefix(&key.to_le_bytes())
}

/// The question after a mode's type of reply is known.
fn after_answer(mode: u16, kind: u8) -> Question {
    match Format::of_kind(kind) {
        Some(Format::Express | Format::Dense) => Question::Start { mode: Some(mode) },
        Some(Format::Nodes) => Question::Start { mode: None },
        // A format that this driver does not read.
        None if mode != EXPRESS_MODE => Question::Answer { mode: EXPRESS_MODE },
        None => Question::Start { mode: None },
    }
}

/// Starts the motor. That of an A1 turns while DTR is off; a C1 starts its own.
fn motor(model: &Model) -> Vec<u8> {
    match model.series() {
        // The power that SLAMTEC recommends, of 1023, and turns per minute.
        2 | 3 => request(SET_PWM, &660_u16.to_le_bytes()),
        6.. => request(MOTOR_SPEED, &600_u16.to_le_bytes()),
        _ => Vec::new(),
    }
}
