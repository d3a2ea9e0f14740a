//! False data for the observer, one kind for each of its checks. They prove that the campaign can fail.

/// A kind of false data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Tamper {
    /// A withdrawal of authority is hidden (R1, R7).
    Withdrawal,
    /// A command appears to come from a schema without authority (R7).
    Stranger,
    /// The brake of a group without a winner is hidden (R9).
    Brake,
    /// A robot at rest appears to move.
    Motion,
    /// A guarded robot appears to touch something.
    Collision,
    /// A turn is hidden.
    Turn,
    /// The turns of a schema whose faults have ended are hidden.
    Recovery,
    /// An export of a schema appears to persist after its fault.
    Value,
    /// A schema appears to be awake although an operator stops it (R14).
    Lease,
    /// A file stays open.
    Leak,
    /// A variable stays referenced after its application has ended.
    Held,
    /// Memory stays allocated.
    Memory,
}
