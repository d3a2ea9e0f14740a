//! Lies that the observer can be told on purpose, one for each thing that it checks: a campaign that cannot fail shows nothing.

/// Something that did not happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Tamper {
    /// Authority that was withdrawn is not seen to be (R1, R7).
    Withdrawal,
    /// A command is seen to be given by somebody without authority (R7).
    Stranger,
    /// The brake of a group that has no winner is not seen to be sent (R9).
    Brake,
    /// A robot is seen to move that stands.
    Motion,
    /// A turn is not seen to be had.
    Turn,
    /// The turns of a schema whose faults are over are not seen.
    Recovery,
    /// What a schema exported before it faulted is seen to stand.
    Value,
    /// A file stays open.
    Leak,
    /// A variable of an application that has ended stays held.
    Held,
    /// Memory stays taken.
    Memory,
}

impl Tamper {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Withdrawal,
        Self::Stranger,
        Self::Brake,
        Self::Motion,
        Self::Turn,
        Self::Recovery,
        Self::Value,
        Self::Leak,
        Self::Held,
        Self::Memory,
    ];
}
