//! What a port of an instance is bound to, what it shows, and why it cannot be used. Values only; `ports` uses
//! them.

use std::sync::Arc;

use jde_board::{Reader, Refused, Writer};
use jde_core::Nanos;
use jde_loader::AlignedBytes;

use super::command_limits::CommandLimits;
use super::guard::{PortGuard, Refusal, UnjudgedCommand};
use super::measurement::NoValue;
use crate::history::{HistoricValue, History};

/// The binding of a port.
pub(crate) enum BoundPort {
    /// Nothing.
    Unbound,
    /// An import or a modulation.
    Input(Reader),
    /// A modulation that shows its value at the schema's awakening (R8).
    Fixed(Reader),
    /// An import or a modulation that shows recorded values, in a replay.
    Recorded(RecordedInput),
    /// A driver's command, with the neutral value that it shows while no command is in force.
    Command {
        reader: Reader,
        neutral: AlignedBytes,
        /// Whether the latched command was in force when it was first read. This does not change until
        /// the release (R8).
        in_force: Option<bool>,
        /// The guards of the schemas that command it.
        guards: Arc<[PortGuard]>,
        /// Its driver, which is the writer when the command is reset (R9): then none is in force.
        driver: u32,
    },
    /// An export.
    Output(Writer),
    /// A driver's command or a child's modulation.
    ForeignOutput {
        writer: Writer,
        /// Why the last write was refused. Only the first of consecutive refusals for one reason is reported.
        refused: Option<Refused>,
        /// The guards of the schema; none for a modulation.
        guards: Arc<[PortGuard]>,
        /// The limits of the driver's command, if the driver states some.
        limits: Option<Arc<CommandLimits>>,
        /// When a command of this port was last limited, by these or by a guard.
        limited_at: Option<Nanos>,
    },
}

/// An input that shows recorded values.
pub(crate) struct RecordedInput {
    pub(super) history: Arc<History>,
    /// Whether it is an import.
    pub(super) is_import: bool,
    /// The number of the value, as turns encode it.
    pub(super) number: u32,
    /// The value that it found since the last release.
    pub(super) resolved: Option<Option<Arc<HistoricValue>>>,
}

/// A write to a port.
pub(crate) struct PortWrite {
    pub(crate) port: usize,
    /// The number of the value.
    pub(crate) number: u64,
    /// `None` if the previous value was retracted.
    pub(crate) bytes: Option<Vec<u8>>,
}

/// The value that an input has shown since the last release.
#[derive(Clone)]
pub(crate) enum ShownValue {
    /// It was not read.
    NotRead,
    /// There was no value.
    NoValue,
    /// This value.
    Value(Arc<HistoricValue>),
}

/// Why a command that guards judge is not published.
pub(crate) enum Guarded {
    /// They judge it first.
    Unjudged(UnjudgedCommand),
    /// One of them refused it.
    Refused(Refusal),
}

/// Why a port cannot be read or written. It is small and easily dropped, because it is a result of every read.
pub(crate) enum PortError {
    Unbound,
    NoValue,
    WrongPort,
    NothingLoaned,
    Refused {
        why: Refused,
        first: bool,
    },
    Guarded(Box<Guarded>),
    /// What an export publishes is no value, and the value before it was retracted. Only the first of consecutive ones
    /// is reported.
    NotAValue {
        why: NoValue,
        first: bool,
    },
}
