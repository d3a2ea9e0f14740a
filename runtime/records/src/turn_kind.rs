//! What a turn was, and the numbers by which turns state it.

use jde_core::Holder;

/// What a turn was. Numbers of groups, children and ports are those of the application that recorded it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnKind {
    /// The schema awoke.
    Awoke,
    /// The schema slept.
    Slept,
    /// The schema checked, iterated, or both.
    Cycled(Option<Permission>),
    /// The schema arbitrated a group.
    Arbitrated {
        /// The group.
        group: u64,
    },
    /// The application started.
    Started,
    /// Timers of the rules expired.
    Ticked,
    /// An operator acted.
    Operated(Operation),
    /// A call did not return, and the schema was given up.
    GivenUp,
    /// Everything was put to sleep.
    Ended,
    /// The schema acted as a father, and this had an effect.
    FatherActed(FatherOperation),
    /// A gesture was applied to the schema's panel.
    Touched {
        /// Its number, as in events.
        number: u64,
    },
    /// Another build took over.
    Reloaded(Exchange),
    /// Not a turn, but more ports of the schema's next turn.
    MorePorts {
        /// The number of the first.
        first: u64,
    },
    /// A guard refused a command of the schema (R18).
    CommandRefused,
    /// None of these: a schema that is not known any more took it, or another version of jde wrote it.
    Unknown,
}

/// How a schema requested permission to iterate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Permission {
    /// For any iteration.
    Any,
    /// Only for the first iteration as WINNER.
    First,
}

/// What an operator did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Nothing: it was refused.
    Refused,
    /// It played a schema.
    Played(Holder),
    /// It stopped a schema.
    Stopped(Holder),
    /// It forced a schema.
    Forced(Holder),
    /// It released a schema.
    Released(Holder),
    /// It wrote a value of a schema.
    Wrote(WrittenPort),
    /// It unloaded a schema.
    Unloaded(Holder),
    /// It let a schema that was unloaded or had faulted start afresh.
    Loaded,
    /// It stopped all roots.
    AllStopped(Holder),
    /// It released all roots.
    AllReleased,
    /// Its actions on a schema were undone.
    Undone(Holder),
    /// An export fails from now on.
    FailedExport {
        /// The export.
        port: u64,
    },
    /// An export fails no longer.
    RepairedExport {
        /// The export.
        port: u64,
    },
    /// A debugger holds a call of a schema from now on.
    Debugged,
    /// The call that a debugger held goes on.
    WentOn,
}

/// A value that an operator wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrittenPort {
    /// The period.
    Period,
    /// A modulation, by its number among the ports.
    Port(u64),
}

/// What a schema did as a father.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FatherOperation {
    /// It woke a child.
    Woke {
        /// The child.
        child: u64,
    },
    /// It put a child to sleep.
    PutToSleep {
        /// The child.
        child: u64,
    },
    /// It changed the policy of a group.
    ChangedPolicy {
        /// The group.
        group: u64,
    },
}

/// Which build took over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// A new one.
    New,
    /// The one before.
    Before,
}

/// The place of the period among the ports.
const PERIOD_PLACE: u64 = u32::MAX as u64;

impl TurnKind {
    /// Returns the numbers of the fields `kind`, `way` and `detail` of a turn.
    pub(crate) fn numbers(self) -> (u8, u8, u64) {
        match self {
            Self::Unknown => (0, 0, 0),
            Self::Awoke => (1, 0, 0),
            Self::Slept => (2, 0, 0),
            Self::Cycled(None) => (3, 0, 0),
            Self::Cycled(Some(Permission::Any)) => (3, 1, 0),
            Self::Cycled(Some(Permission::First)) => (3, 2, 0),
            Self::Arbitrated { group } => (4, 0, group),
            Self::Started => (5, 0, 0),
            Self::Ticked => (6, 0, 0),
            Self::Operated(operation) => {
                let (way, detail) = operation.numbers();
                (7, way, detail)
            }
            Self::GivenUp => (8, 0, 0),
            Self::Ended => (9, 0, 0),
            Self::FatherActed(FatherOperation::Woke { child }) => (10, 1, child),
            Self::FatherActed(FatherOperation::PutToSleep { child }) => (10, 2, child),
            Self::FatherActed(FatherOperation::ChangedPolicy { group }) => (10, 3, group),
            Self::Touched { number } => (11, 0, number),
            Self::Reloaded(Exchange::New) => (12, 1, 0),
            Self::Reloaded(Exchange::Before) => (12, 2, 0),
            Self::MorePorts { first } => (13, 0, first),
            Self::CommandRefused => (14, 0, 0),
        }
    }

    /// Returns the kind that these numbers state.
    pub(crate) fn of_numbers((kind, way, detail): (u8, u8, u64)) -> Self {
        match (kind, way) {
            (1, _) => Self::Awoke,
            (2, _) => Self::Slept,
            (3, 1) => Self::Cycled(Some(Permission::Any)),
            (3, 2) => Self::Cycled(Some(Permission::First)),
            (3, _) => Self::Cycled(None),
            (4, _) => Self::Arbitrated { group: detail },
            (5, _) => Self::Started,
            (6, _) => Self::Ticked,
            (7, way) => Operation::of_numbers(way, detail).map_or(Self::Unknown, Self::Operated),
            (8, _) => Self::GivenUp,
            (9, _) => Self::Ended,
            (10, 1) => Self::FatherActed(FatherOperation::Woke { child: detail }),
            (10, 2) => Self::FatherActed(FatherOperation::PutToSleep { child: detail }),
            (10, 3) => Self::FatherActed(FatherOperation::ChangedPolicy { group: detail }),
            (11, _) => Self::Touched { number: detail },
            (12, 1) => Self::Reloaded(Exchange::New),
            (12, 2) => Self::Reloaded(Exchange::Before),
            (13, _) => Self::MorePorts { first: detail },
            (14, _) => Self::CommandRefused,
            _ => Self::Unknown,
        }
    }
}

impl Operation {
    fn numbers(self) -> (u8, u64) {
        match self {
            Self::Refused => (0, 0),
            Self::Played(by) => (1, number(by)),
            Self::Stopped(by) => (2, number(by)),
            Self::Forced(by) => (3, number(by)),
            Self::Released(by) => (4, number(by)),
            Self::Wrote(WrittenPort::Period) => (5, PERIOD_PLACE),
            Self::Wrote(WrittenPort::Port(port)) => (5, port),
            Self::Unloaded(by) => (6, number(by)),
            Self::Loaded => (7, 0),
            Self::AllStopped(by) => (8, number(by)),
            Self::AllReleased => (9, 0),
            Self::Undone(by) => (10, number(by)),
            Self::FailedExport { port } => (11, port),
            Self::RepairedExport { port } => (12, port),
            Self::Debugged => (13, 0),
            Self::WentOn => (14, 0),
        }
    }

    fn of_numbers(way: u8, detail: u64) -> Option<Self> {
        let by = holder(detail);
        Some(match way {
            0 => Self::Refused,
            1 => Self::Played(by),
            2 => Self::Stopped(by),
            3 => Self::Forced(by),
            4 => Self::Released(by),
            5 if detail == PERIOD_PLACE => Self::Wrote(WrittenPort::Period),
            5 => Self::Wrote(WrittenPort::Port(detail)),
            6 => Self::Unloaded(by),
            7 => Self::Loaded,
            8 => Self::AllStopped(by),
            9 => Self::AllReleased,
            10 => Self::Undone(by),
            11 => Self::FailedExport { port: detail },
            12 => Self::RepairedExport { port: detail },
            13 => Self::Debugged,
            14 => Self::WentOn,
            _ => return None,
        })
    }
}

fn number(by: Holder) -> u64 {
    u64::from(by.operator) << 1 | u64::from(by.leased)
}

/// Older recordings have 0, the one that is unknown.
fn holder(detail: u64) -> Holder {
    Holder {
        operator: (detail >> 1) as u32,
        leased: detail & 1 == 1,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn what_numbers_state_is_stated_by_the_same_numbers(kind in 0_u8..16, way in 0_u8..16, detail in 0_u64..1 << 33) {
            let read = TurnKind::of_numbers((kind, way, detail));
            prop_assert_eq!(TurnKind::of_numbers(read.numbers()), read);
            let of_schema = !matches!(read, TurnKind::Unknown);
            prop_assert!(!of_schema || read.numbers().0 == kind);
        }
    }

    #[test]
    fn the_period_is_no_port() {
        let wrote = |port| TurnKind::Operated(Operation::Wrote(port));
        assert_eq!(
            TurnKind::of_numbers((7, 5, 4_294_967_295)),
            wrote(WrittenPort::Period)
        );
        assert_eq!(TurnKind::of_numbers((7, 5, 3)), wrote(WrittenPort::Port(3)));
    }
}
