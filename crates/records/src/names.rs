//! The names of policies and deciders, as application files and records have them.

use jde_core::{Decider, Policy};

/// A policy's name in application files.
#[must_use]
pub fn policy_name(policy: Policy) -> &'static str {
    match policy {
        Policy::Priority => "priority",
        Policy::HighestUrgency => "urgency",
        Policy::Sticky { .. } => "sticky",
        Policy::RoundRobin { .. } => "round-robin",
        Policy::Father => "father",
    }
}

/// The name of what decided, in one or two words.
#[must_use]
pub fn decider_name(decider: Decider) -> &'static str {
    match decider {
        Decider::Nobody => "nobody",
        Decider::Policy(policy) => policy_name(policy),
        Decider::Father => "father",
        Decider::ArbitrationFailed => "arbitration-failed",
        Decider::AbsencePolicy => "absence-policy",
        Decider::Operator => "operator",
    }
}
